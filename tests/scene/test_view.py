"""Views and clipping (P1, P2 and §5.2 of scenes.md)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from halftone.errors import InputError, UsageError
from halftone.scene import shapes
from halftone.scene.clip import clipped, cut
from halftone.scene.model import Camera, Light, Material, Mesh, Scene
from halftone.scene.render import render
from halftone.scene.view import view_of


def test_known_points_in_perspective():
    view = view_of(Camera((0, 0, 5), fov=90.0), 200, 100)
    h = view.homogeneous(np.array([[0, 0, 0], [5, 0, 0], [0, 5, 0], [1, 1, 3], [0, 0, 6.0]]))
    np.testing.assert_allclose(h[:, 2], [5, 5, 5, 2, -1], atol=1e-12)
    want = [[0, 0], [50, 0], [0, -50], [25, -25]]
    np.testing.assert_allclose(h[:4, :2] / h[:4, 2:3], want, atol=1e-12)


def test_known_points_in_parallel():
    view = view_of(Camera((0, 0, 5), projection="parallel", height=4.0), 200, 100)
    h = view.homogeneous(np.array([[0, 0, 0], [1, 0, -7], [0, 1, 4], [0, 0, 9.0]]))
    np.testing.assert_allclose(h[:, :3], [[0, 0, 1], [25, 0, 1], [0, -25, 1], [0, 0, 1]], atol=1e-12)
    assert view.near == -np.inf


@pytest.mark.parametrize("up", [(0, 1, 0), (0, 0, 0), (1, 2, 3), (float("nan"), 0, 1), (0, 1e300, 0)])
def test_axes_are_upright_whatever_up_is(up):
    view = view_of(Camera((3, 6, 9), (2, 4, 6), up=up), 10, 10)
    np.testing.assert_allclose(view.axes @ view.axes.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(view.forwards, -np.array([1, 2, 3]) / np.sqrt(14), atol=1e-12)
    assert np.linalg.det(view.axes) == pytest.approx(1)


def test_what_makes_no_view():
    with pytest.raises(InputError, match="direction of view"):
        view_of(Camera((1, 2, 3), (1, 2, 3)), 10, 10)
    with pytest.raises(UsageError, match="fov"):
        view_of(Camera(fov=180.0), 10, 10)
    with pytest.raises(UsageError, match="height"):
        view_of(Camera(projection="parallel", height=0.0), 10, 10)
    with pytest.raises(UsageError, match="near"):
        view_of(Camera(near=-1.0), 10, 10)
    with pytest.raises(UsageError, match="perspective"):
        view_of(Camera(projection="perspectiv"), 10, 10)


def lit(mesh: Mesh, camera: Camera, width: int = 64, height: int = 64, **options):
    return render(Scene((mesh,), (Material(),), (), camera), width, height, **options)


def test_a_floor_that_passes_below_the_eye_is_seen_up_to_the_horizon():
    """No gap at the near plane: every pixel below the horizon shows the floor."""
    floor = shapes.plane(2000.0, 2000.0)
    for tilt in (0.0, -0.3):
        ids = lit(floor, Camera((0, 1, 0), (0, 1 + tilt, -1), fov=60.0, near=0.01)).ids
        row = np.arange(64) + 0.5 - 32
        slope = tilt - row * np.tan(np.radians(30)) / 32 * np.hypot(1, tilt) if tilt == 0 else None
        if slope is not None:
            reach = 1 / np.maximum(-slope, 1e-9)  # how far away each row meets the floor
            assert (ids[reach < 900] >= 0).all()
            assert (ids[slope > 0] < 0).all()
        else:
            assert (ids[32:] >= 0).all()


def test_a_camera_inside_a_mesh_sees_it_everywhere():
    for mesh in (shapes.box(2, 2, 2), shapes.icosphere(3), shapes.torus(24, 12)):
        eye = (1.0, 0.0, 0.0) if mesh.name == "torus" else (0.1, 0.2, 0.3)
        for target in ((0, 0, -9), (9, 1, 0), (-3, 8, 1)):
            picture = lit(mesh, Camera(eye, target, fov=100.0))
            assert (picture.ids >= 0).all()
            assert np.isfinite(picture.radiance).all()


def test_a_corner_at_the_eye():
    mesh = Mesh(
        np.array([[0, 0, 3], [-1, -1, 0], [1, -1, 0], [0, 1, 0.0]]),
        np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 2, 3]]),
        np.zeros(4, np.int64),
    )
    for shading in ("flat", "gouraud", "phong", "fast-phong"):
        picture = lit(mesh, Camera((0, 0, 3)), shading=shading)
        assert np.isfinite(picture.radiance).all()
        assert picture.ids[32, 32] >= 0


def test_nothing_changes_with_scale_and_offset():
    base = Scene(
        (shapes.torus(20, 10),),
        (Material(specular=(0.4,) * 3),),
        (Light(position=(3, 4, 5)),),
        Camera((0, 2, 3)),
    )
    want = render(base, 40, 40)

    def placed(scale: float, offset: float) -> Scene:
        mesh = base.meshes[0]
        camera, light = base.camera, base.lights[0]
        assert camera is not None

        def move(point):
            return tuple(float(v) * scale + offset for v in point)

        return replace(
            base,
            meshes=(replace(mesh, vertices=mesh.vertices * scale + offset),),
            camera=replace(camera, eye=move(camera.eye), target=move(camera.target)),
            lights=(replace(light, position=move(light.position)),),
        )

    for exponent in (-30, -12, 12, 30):
        got = render(placed(10.0**exponent, 0.0), 40, 40)
        np.testing.assert_array_equal(got.ids, want.ids)
        np.testing.assert_allclose(got.radiance, want.radiance, atol=1e-5)
    got = render(placed(1.0, 1e7), 40, 40)  # float64 has 2e-9 left there
    assert (got.ids != want.ids).mean() < 1e-3
    assert np.median(np.abs(got.radiance - want.radiance)) < 1e-5


def test_cut_keeps_the_right_side_and_its_area():
    rng = np.random.default_rng(0)
    corners = rng.normal(size=(200, 3, 4))
    plane = np.array([0.3, -0.7, 0.2, 0.1, 0.05])
    inside, names = cut(corners, np.arange(200), plane)
    outside, others = cut(corners, np.arange(200), -plane)
    assert (inside @ plane[:4] + plane[4] > -1e-12).all()

    def area(triangles):
        u, v = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
        gram = (u * u).sum(1) * (v * v).sum(1) - (u * v).sum(1) ** 2
        return np.sqrt(np.maximum(gram, 0)) / 2

    total = np.bincount(names, area(inside), 200) + np.bincount(others, area(outside), 200)
    np.testing.assert_allclose(total, area(corners), rtol=1e-9)


def test_faces_that_share_an_edge_get_the_same_new_corners():
    rng = np.random.default_rng(1)
    for _ in range(50):
        a, b, c, d = rng.normal(size=(4, 4))
        pair, names = clipped(np.stack([[a, b, c], [d, c, b]]), np.arange(2), -0.1, 0.5)
        mine = {tuple(p) for p in pair[names == 0].reshape(-1, 4)}
        others = {tuple(p) for p in pair[names == 1].reshape(-1, 4)}
        along = (c - b) / np.linalg.norm(c - b)

        def on_edge(p, b=b, along=along):
            offset = np.array(p) - b
            return np.linalg.norm(offset - along * (offset @ along)) < 1e-9

        assert {p for p in mine if on_edge(p)} == {p for p in others if on_edge(p)}
