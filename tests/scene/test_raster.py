"""Hidden surfaces against brute force on the snapped corners; independence of bands and workers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halftone.scene import raster
from halftone.scene.geometry import geometry_of
from halftone.scene.model import Camera, Mesh, Scene
from halftone.scene.raster import GUARD, Visibility, projected
from halftone.scene.view import view_of
from tests.oracle import scene_raster

CAMERA = Camera(eye=(0.1, 0.2, 3.0), fov=50.0)


def scene_of(vertices, faces, camera=CAMERA) -> Scene:
    faces = np.asarray(faces, np.int64).reshape(-1, 3)
    mesh = Mesh(np.asarray(vertices, np.float64), faces, np.zeros(len(faces), np.int64))
    return Scene(meshes=(mesh,), camera=camera)


def shown(scene: Scene, width: int, height: int) -> np.ndarray:
    geometry = geometry_of(scene)
    return Visibility(projected(geometry, view_of(scene.camera, width, height)), geometry).all()


def check(scene: Scene, width: int, height: int) -> np.ndarray:
    """The ids of *scene*, after they were found equal to the oracle's."""
    geometry = geometry_of(scene)
    view = view_of(scene.camera, width, height)
    made = projected(geometry, view)
    ids = Visibility(made, geometry).all()
    h = view.homogeneous(geometry.vertices)
    outside = (h[:, 3] < view.near) | (np.abs(h[:, :2]) > GUARD * h[:, 2:3]).any(axis=1)
    used = np.ones(len(made.faces), bool)
    used[: len(geometry.faces)] = ~outside[geometry.faces].any(axis=1)
    want, depths = scene_raster.visible(
        made.faces[used], made.snapped, made.key, made.owner[used], width, height
    )
    np.testing.assert_array_equal(ids >= 0, want >= 0)
    for y, x in zip(*np.nonzero(ids != want), strict=True):  # only where float64 cannot tell them apart
        found = {me: z for z, me in sorted(depths[y, x])}
        best = max(found.values())
        assert ids[y, x] in found
        assert abs(float((found[ids[y, x]] - best) / best)) < 1e-13
    return ids


place = st.floats(-2, 2, width=32)
point = st.tuples(place, place, place)
wild = st.one_of(
    place,
    st.sampled_from([0.0, 0.1, 0.2, 3.0, 2.9997, 1e3, -1e3, 1e6, -1e6, 1e9, -1e9, 1e-9]),
)


@given(points=st.lists(point, min_size=3, max_size=12), data=st.data())
@settings(max_examples=60, deadline=None)
def test_soups(points, data):
    corner = st.integers(0, len(points) - 1)
    faces = data.draw(st.lists(st.tuples(corner, corner, corner), min_size=1, max_size=16))
    width, height = data.draw(st.sampled_from([(17, 13), (1, 9), (9, 1), (1, 1), (40, 5)]))
    check(scene_of(points, faces), width, height)


@given(points=st.lists(st.tuples(wild, wild, wild), min_size=3, max_size=9), data=st.data())
@settings(max_examples=80, deadline=None)
def test_soups_off_the_picture_huge_behind_and_at_the_eye(points, data):
    corner = st.integers(0, len(points) - 1)
    faces = data.draw(st.lists(st.tuples(corner, corner, corner), min_size=1, max_size=8))
    projection = data.draw(st.sampled_from(["perspective", "parallel"]))
    near = data.draw(st.sampled_from([None, 0.5, 3.0]))
    check(scene_of(points, faces, Camera((0.1, 0.2, 3.0), projection=projection, near=near)), 15, 12)


@given(
    across=st.integers(1, 6),
    down=st.integers(1, 6),
    shift=st.floats(-1, 1, width=32),
    rotation=st.floats(0, 7),
    data=st.data(),
)
@settings(max_examples=40, deadline=None)
def test_a_net_leaves_no_gap_and_no_centre_twice(across, down, shift, rotation, data):
    """Counted by the oracle: every centre in the net of triangles is in exactly one of them."""
    rng = np.random.default_rng(data.draw(st.integers(0, 99)))
    grid = np.stack(np.meshgrid(np.linspace(-1, 1, across + 1), np.linspace(-1, 1, down + 1)), -1)
    grid[1:-1, 1:-1] += rng.uniform(-0.3, 0.3, grid[1:-1, 1:-1].shape) / max(across, down)
    flat = grid.reshape(-1, 2) + shift * 1e-3
    turn = np.array([[np.cos(rotation), -np.sin(rotation)], [np.sin(rotation), np.cos(rotation)]])
    vertices = np.column_stack([flat @ turn, np.zeros(len(flat))])
    faces = []
    for y in range(down):
        for x in range(across):
            a = y * (across + 1) + x
            b, c, d = a + 1, a + across + 1, a + across + 2
            faces += [(a, b, d), (a, d, c)] if rng.random() < 0.5 else [(a, b, c), (b, d, c)]
    scene = scene_of(vertices, faces, Camera((0, 0, 3), projection="parallel", height=1.3))
    geometry = geometry_of(scene)
    view = view_of(scene.camera, 16, 16)
    made = projected(geometry, view)
    _, depths = scene_raster.visible(made.faces, made.snapped, made.key, made.owner, 16, 16)
    assert all(len(found) == 1 for found in depths.values())
    ids = check(scene, 16, 16)
    middle = ids[6:10, 6:10]  # within ±0.17, far from the border however the net is turned
    assert (middle >= 0).all()


def test_a_fan_of_slivers():
    count = 3000
    angles = 2 * np.pi * np.arange(count) / count
    rim = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(count)])
    vertices = np.concatenate([[[0.003, 0.001, 0.0]], rim])
    index = np.arange(count)
    faces = np.column_stack([np.zeros(count, int), 1 + index, 1 + (index + 1) % count])
    scene = scene_of(vertices, faces, Camera((0, 0, 3), projection="parallel", height=2.2))
    ids = check(scene, 48, 48)
    y, x = np.mgrid[:48, :48] - 23.5
    radius = np.hypot(x, y) * 2.2 / 48
    assert (ids[radius < 0.999] >= 0).all()
    assert (ids[radius > 1.001] < 0).all()


def soup(count: int, seed: int = 0) -> Scene:
    rng = np.random.default_rng(seed)
    vertices = rng.normal(0, 1, (count, 3))
    return scene_of(vertices, rng.integers(0, count, (2 * count, 3)))


@pytest.mark.parametrize("rows", [1, 7, 32, 100])
@pytest.mark.parametrize("workers", [1, 3])
def test_bands_and_workers_do_not_matter(rows, workers):
    scene = soup(300)
    geometry, view = geometry_of(scene), view_of(scene.camera, 75, 61)
    want = Visibility(projected(geometry, view), geometry).all()
    made = projected(geometry, view, workers=workers, rows=rows)
    np.testing.assert_array_equal(Visibility(made, geometry).all(workers), want)


def test_stretches_of_faces_do_not_matter(monkeypatch):
    scene = soup(300)
    geometry, view = geometry_of(scene), view_of(scene.camera, 75, 61)
    want = projected(geometry, view)
    monkeypatch.setattr(raster, "stretch", lambda count: 37)
    got = projected(geometry, view, workers=2)
    np.testing.assert_array_equal(got.solid.faces, want.solid.faces)
    np.testing.assert_array_equal(Visibility(got, geometry).all(), Visibility(want, geometry).all())


def test_of_two_equal_faces_the_first_is_seen_however_its_corners_are_named():
    vertices = np.array([[-1, -1, 0.1], [1, -0.9, 0.3], [0.2, 1, -0.4]])
    for faces in ([(0, 1, 2), (2, 0, 1)], [(1, 2, 0), (0, 2, 1)], [(2, 1, 0), (0, 1, 2), (1, 0, 2)]):
        ids = check(scene_of(vertices, faces), 33, 31)
        assert set(np.unique(ids)) == {-1, 0}


def test_the_order_of_faces_changes_nothing_but_their_numbers():
    scene = soup(200, 3)
    mesh = scene.meshes[0]
    order = np.random.default_rng(1).permutation(len(mesh.faces))
    other = scene_of(mesh.vertices, mesh.faces[order])
    a, b = shown(scene, 64, 64), shown(other, 64, 64)
    np.testing.assert_array_equal(np.where(b >= 0, order[b], -1), a)


def test_nothing_to_see():
    scene = scene_of(np.zeros((0, 3)), np.zeros((0, 3)))
    assert (shown(scene, 5, 4) == -1).all()


def test_a_picture_wider_than_16_bits():
    vertices = [[-1, -1, 0], [1, -1, 0], [0, 1, 0]]
    camera = Camera((0, 0, 3), projection="parallel", height=2 * 3 / 70000)
    ids = shown(scene_of(vertices, [(0, 1, 2)], camera), 70000, 3)
    half = 70000 / 4  # at y = 0 the triangle is half as wide as its base, which fills the picture
    assert abs(int((ids[1] >= 0).sum()) - 2 * half) <= 1
