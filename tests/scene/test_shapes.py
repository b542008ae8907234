"""Generated meshes are closed, turn outward and have the volumes of the bodies that they stand for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halftone.errors import UsageError
from halftone.scene import shapes


def corners(mesh):
    return (mesh.vertices[mesh.faces[:, k]] for k in range(3))


def volume(mesh):
    a, b, c = corners(mesh)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def is_closed(mesh):
    """Every edge is used once in each direction."""
    edges = [tuple(e) for e in mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).tolist()]
    return len(set(edges)) == len(edges) and {(b, a) for a, b in edges} == set(edges)


@given(st.integers(3, 20), st.integers(3, 20))
def test_closed_bodies_turn_outward(u, v):
    for mesh in (shapes.torus(u, v), shapes.sphere(u, v), shapes.cone(u), shapes.box(1, 2, 3)):
        assert is_closed(mesh), mesh.name
        assert volume(mesh) > 0, mesh.name


def test_volumes():
    assert volume(shapes.box(2, 3, 4)) == pytest.approx(24)
    assert volume(shapes.cone(256, 2, 3)) == pytest.approx(np.pi * 4, rel=1e-3)
    assert volume(shapes.sphere(256, 128, 2)) == pytest.approx(32 / 3 * np.pi, rel=1e-3)
    assert volume(shapes.icosphere(6)) == pytest.approx(4 / 3 * np.pi, rel=1e-3)
    assert volume(shapes.torus(256, 128, 2, 0.5)) == pytest.approx(np.pi**2, rel=1e-3)


def test_numbers_of_triangles():
    assert len(shapes.torus(64, 32).faces) == 4096
    assert len(shapes.sphere(8, 5).faces) == 2 * 8 * 4
    assert [len(shapes.icosphere(d).faces) for d in range(3)] == [20, 80, 320]
    assert len(shapes.icosphere(2).vertices) == 162
    assert len(shapes.plane(1, 1, 3, 5).faces) == 30


def test_exact_normals_point_out_of_their_faces():
    made = (shapes.torus(9, 7, exact=True), shapes.sphere(9, 7, exact=True), shapes.cone(9))
    for mesh in (*made, shapes.icosphere(1, exact=True)):
        a, b, c = corners(mesh)
        out = np.cross(b - a, c - a)
        normals = mesh.normals[mesh.normal_index]
        assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1)
        assert (np.einsum("fx,fkx->fk", out, normals) > 0).all(), mesh.name


def test_the_front_of_a_plane_looks_up():
    a, b, c = corners(shapes.plane(2, 3, 2, 2))
    assert (np.cross(b - a, c - a) @ [0, 1, 0] > 0).all()


@pytest.mark.parametrize("u", [2, 2.5, True, 1 << 20])
def test_a_wrong_number_of_divisions_is_refused(u):
    with pytest.raises(UsageError, match="u="):
        shapes.torus(u, 8)


@pytest.mark.parametrize("radius", [0, -1, np.inf, np.nan])
def test_a_wrong_length_is_refused(radius):
    with pytest.raises(UsageError, match="radius="):
        shapes.sphere(8, 8, radius)


def test_more_faces_than_memory_holds_are_refused():
    with pytest.raises(UsageError, match="v=16384"):
        shapes.sphere(16384, 16384)
