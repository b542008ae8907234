"""Normals of vertices (P4 of scenes.md)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from halftone.errors import UsageError
from halftone.scene import shapes
from halftone.scene.geometry import geometry_of
from halftone.scene.model import Mesh, Scene
from halftone.scene.normals import WEIGHTINGS, corner_angles, face_normals, unit, vertex_normals


def geometry(mesh: Mesh, normals: str = "angle"):
    return geometry_of(Scene(meshes=(mesh,), normals=normals))


def test_the_corner_of_a_cube():
    box = shapes.box(2, 2, 2)
    found = vertex_normals(box.vertices, box.faces, "angle")
    np.testing.assert_allclose(found, box.vertices / np.sqrt(3), atol=1e-12)


@pytest.mark.parametrize("weighting", WEIGHTINGS)
def test_normals_of_a_ball_are_its_places(weighting):
    mesh = shapes.icosphere(4)
    found = vertex_normals(mesh.vertices, mesh.faces, weighting)
    assert np.linalg.norm(found - unit(mesh.vertices), axis=1).max() < 0.01


def test_the_error_of_normals_by_angle_falls_with_the_square_of_the_edges():
    errors = []
    for size in (32, 64, 128):
        mesh = shapes.torus(size, size // 2, exact=True)
        found = vertex_normals(mesh.vertices, mesh.faces, "angle")
        assert mesh.normals is not None
        errors.append(np.linalg.norm(found - mesh.normals, axis=1).max())
    assert 3.4 < errors[0] / errors[1] < 4.6
    assert 3.4 < errors[1] / errors[2] < 4.6


def test_weightings_differ_where_areas_and_angles_do():
    """Two faces in the plane z = 0 and one in x = 0 meet at the origin."""
    vertices = np.array([[0, 0, 0], [3, 0, 0], [3, 3, 0], [0, 3, 0], [0, 0, -1.0]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4]])
    uniform, angle, area = (vertex_normals(vertices, faces, w)[0] for w in ("uniform", "angle", "area"))
    np.testing.assert_allclose(uniform, np.array([-1, 0, 2]) / np.sqrt(5), atol=1e-12)
    np.testing.assert_allclose(angle, np.array([-1, 0, 1]) / np.sqrt(2), atol=1e-12)
    np.testing.assert_allclose(area, np.array([-3, 0, 18]) / np.sqrt(333), atol=1e-12)


def test_angles_of_a_face_sum_to_pi_also_in_slivers():
    rng = np.random.default_rng(0)
    vertices = rng.normal(size=(300, 3))
    vertices[200:] *= [1, 1e-8, 0]
    faces = np.arange(300).reshape(100, 3)
    np.testing.assert_allclose(corner_angles(vertices, faces).sum(axis=1), np.pi, atol=1e-7)


def test_normals_that_cancel_are_zero_and_replaced_by_the_faces():
    """A sheet with two sides that share their corners."""
    mesh = Mesh(
        np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]]),
        np.array([[0, 1, 2], [0, 2, 1]]),
        np.zeros(2, np.int64),
    )
    assert (vertex_normals(mesh.vertices, mesh.faces) == 0).all()
    made = geometry(mesh)
    assert made.zero_normals == 6
    np.testing.assert_allclose(made.attributes[made.corners[0], 3:], [[0, 0, 1]] * 3)
    np.testing.assert_allclose(made.attributes[made.corners[1], 3:], [[0, 0, -1]] * 3)


def test_given_normals_are_kept_and_zero_ones_replaced():
    mesh = shapes.box(2, 2, 2)
    given = np.array([[0, 3.0, 4.0], [0, 0, 0]])
    index = np.full(mesh.faces.shape, -1)
    index[0] = [0, 1, -1]
    made = geometry(replace(mesh, normals=given, normal_index=index, smooth=None))
    face = unit(face_normals(mesh.vertices, mesh.faces))[0]
    rows = made.attributes[made.corners[0]]
    np.testing.assert_allclose(rows[0, 3:], [0, 0.6, 0.8], atol=1e-7)
    np.testing.assert_allclose(rows[1, 3:], face, atol=1e-7)
    np.testing.assert_allclose(rows[2, 3:], unit(mesh.vertices)[mesh.faces[0, 2]], atol=1e-7)
    assert made.zero_normals == 1


def test_faces_that_are_not_smooth_have_their_own_normals():
    mesh = shapes.box(2, 2, 2)
    smooth = np.arange(len(mesh.faces)) >= 2
    made = geometry(replace(mesh, smooth=smooth))
    faces = unit(face_normals(mesh.vertices, mesh.faces))
    for face in range(2):
        np.testing.assert_allclose(made.attributes[made.corners[face], 3:], [faces[face]] * 3, atol=1e-7)
    assert not np.allclose(made.attributes[made.corners[2], 3:], faces[2])


def test_corners_keep_their_places_and_materials():
    mesh = shapes.torus(8, 6)
    material = np.arange(len(mesh.faces)) % 3
    made = geometry(replace(mesh, material=material, smooth=material > 0))
    np.testing.assert_allclose(
        made.attributes[made.corners][..., :3], mesh.vertices[mesh.faces], atol=1e-6
    )
    np.testing.assert_array_equal(made.attribute_material[made.corners], material[:, None].repeat(3, 1))


def test_an_unknown_way():
    with pytest.raises(UsageError, match="uniform"):
        vertex_normals(np.zeros((3, 3)), np.array([[0, 1, 2]]), "mean")
