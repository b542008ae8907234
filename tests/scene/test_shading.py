"""Flat, Gouraud, Phong and fast Phong against their definitions (P1, P3, P5–P8 of scenes.md)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from halftone.scene import _fast_kernels, shapes
from halftone.scene.model import Camera, Light, Material, Mesh, Scene
from halftone.scene.render import Renderer, render

SHADINGS = ("flat", "gouraud", "phong", "fast-phong")
SUN = Light(kind="distant", direction=(-0.4, -0.7, -1.0), intensity=(0.9, 0.8, 0.7))
SHINY = Material(ambient=(0.1,) * 3, diffuse=(0.6, 0.5, 0.4), specular=(0.3,) * 3, exponent=20)
PARALLEL = Camera((0, 0, 5), projection="parallel", height=2.2)


def ball(divisions: int = 3) -> Mesh:
    return shapes.icosphere(divisions)


def scene(
    mesh: Mesh, light: Light = SUN, material: Material = SHINY, camera: Camera = PARALLEL
) -> Scene:
    return Scene(meshes=(mesh,), materials=(material,), lights=(light,), camera=camera)


def triangle(vertices, normals=None) -> Mesh:
    index = np.array([[0, 1, 2]])
    given = None if normals is None else np.asarray(normals, np.float64)
    return Mesh(
        np.asarray(vertices, np.float64),
        index,
        np.zeros(1, np.int64),
        given,
        None if given is None else index,
    )


def test_flat_has_one_colour_a_face():
    lamp = replace(SUN, kind="point", position=(3, 4, 5), direction=(0, 0, -1))
    picture = render(scene(ball(1), lamp), 90, 90, shading="flat")
    for face in np.unique(picture.ids[picture.ids >= 0]):
        assert len(np.unique(picture.radiance[picture.ids == face], axis=0)) == 1


def test_flat_is_exact_for_a_polyhedron_under_light_and_viewer_at_infinity():
    picture = render(
        scene(shapes.box(), camera=Camera((2, 3, 4), projection="parallel")), 64, 64, shading="flat"
    )
    toward = -np.array(SUN.direction) / np.linalg.norm(SUN.direction)
    view = np.array((2, 3, 4)) / np.sqrt(29)
    half = (toward + view) / np.linalg.norm(toward + view)
    box = shapes.box()
    for face in np.unique(picture.ids[picture.ids >= 0]):
        a, b, c = box.vertices[box.faces[face]]
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal)
        lit = max(normal @ toward, 0)
        shine = max(normal @ half, 0) ** 20 if lit > 0 else 0
        want = 0.1 + np.array(SUN.intensity) * (np.array(SHINY.diffuse) * lit + 0.3 * shine)
        assert np.abs(picture.radiance[picture.ids == face] - want).max() < 2e-6


def test_gouraud_is_a_plane_over_each_face_in_a_parallel_view():
    picture = render(scene(ball(1)), 128, 128, shading="gouraud")
    y, x = np.mgrid[:128, :128]
    faces, sizes = np.unique(picture.ids[picture.ids >= 0], return_counts=True)
    assert (sizes > 30).any()
    for face in faces[sizes > 30]:
        seen = picture.ids == face
        table = np.column_stack([x[seen], y[seen], np.ones(seen.sum())])
        values = picture.radiance[seen].astype(np.float64)
        fit = table @ np.linalg.lstsq(table, values, rcond=None)[0]
        assert np.abs(fit - values).max() < 1e-6


def test_gouraud_and_phong_are_the_same_under_ambient_light_alone():
    dark = scene(ball(2), material=replace(SHINY, diffuse=(0.0,) * 3, specular=(0.0,) * 3))
    pictures = [render(dark, 60, 60, shading=shading).radiance for shading in SHADINGS]
    for other in pictures[1:]:
        np.testing.assert_allclose(other, pictures[0], atol=1e-7)


def test_phong_shows_the_highlight_inside_a_face_that_gouraud_misses():
    """Normals lean outwards at the corners and face the viewer in the middle only."""
    corners = np.array([[-1.0, -1, 0], [1, -1, 0], [0, 1.2, 0]])
    mesh = triangle(corners, corners * [0.5, 0.5, 0] + [0, 0, 1.0])
    light = Light(kind="distant", direction=(0, 0, -1))
    glossy = replace(SHINY, exponent=200.0, ambient=(0.0,) * 3, diffuse=(0.0,) * 3, specular=(1.0,) * 3)
    phong = render(scene(mesh, light, glossy), 64, 64).radiance
    gouraud = render(scene(mesh, light, glossy), 64, 64, shading="gouraud").radiance
    assert phong.max() > 0.9
    assert gouraud.max() < 0.01


def test_attributes_are_correct_in_perspective():
    """Each pixel's normal equals that of a ray tracer within 1e-5; shown by lights along the axes."""
    corners = np.array([[-1.0, -0.6, 1.4], [1.2, -0.4, -2.0], [0.1, 0.9, -0.3]])
    normals = np.array([[0.3, 0.1, 1.0], [0.0, 0.5, 1.0], [-0.2, 0.2, 1.0]])
    camera = Camera((0.0, 0.1, 3.0), fov=45.0, target=(0.0, 0.1, 0.0))
    plain = Material(ambient=(0.0,) * 3, diffuse=(1.0,) * 3)
    lights = tuple(
        Light(
            kind="distant", direction=tuple(-v for v in axis), intensity=tuple(map(float, np.eye(3)[i]))
        )
        for i, axis in enumerate([(1, 0, 0.5), (0, 1, 0.5), (0, 0, 1)])
    )
    made = Scene(meshes=(triangle(corners, normals),), materials=(plain,), lights=lights, camera=camera)
    picture = render(made, 200, 200)
    y, x = np.nonzero(picture.ids == 0)
    assert len(y) > 2000
    scale = 100 / np.tan(np.radians(22.5))
    rays = np.column_stack([(x + 0.5 - 100) / scale, (100 - y - 0.5) / scale, -np.ones(len(x))])
    solved = np.linalg.solve((corners - camera.eye).T[None], rays[:, :, None])[..., 0]
    normal = (solved / solved.sum(axis=1, keepdims=True)) @ (
        normals / np.linalg.norm(normals, axis=1, keepdims=True)
    )
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    axes = np.array([(1, 0, 0.5), (0, 1, 0.5), (0, 0, 1.0)])
    want = np.maximum(normal @ (axes / np.linalg.norm(axes, axis=1, keepdims=True)).T, 0)
    inside = (solved > 0).all(axis=1)  # a snapped corner may show a centre just outside the true face
    assert inside.mean() > 0.99
    np.testing.assert_allclose(picture.radiance[y, x][inside], want[inside], atol=1e-5)


def test_backs_of_two_sided_materials_are_lit_and_of_others_show_ambient_light():
    corners = [[-1, -1, 0], [1, -1, 0], [0, 1, 0]]
    light = Light(kind="distant", direction=(0, 0, -1))
    for shading in SHADINGS:
        front = render(scene(triangle(corners), light), 20, 20, shading=shading).radiance
        away = scene(triangle(np.array(corners)[[1, 0, 2]]), light)
        back = render(away, 20, 20, shading=shading).radiance
        np.testing.assert_allclose(back, front, atol=1e-6)
        dark = replace(away, materials=(replace(SHINY, two_sided=False),))
        picture = render(dark, 20, 20, shading=shading)
        np.testing.assert_allclose(picture.radiance[picture.ids >= 0], np.float32(0.1), atol=1e-7)


def test_error_against_the_analytic_ball_falls_as_it_should():
    """§4.1: flat with h, Gouraud and Phong about with h²; Phong is the best at every size."""
    size = 128
    y, x = (np.mgrid[:size, :size] + 0.5 - size / 2) * 2.2 / size
    inside = x * x + y * y < 0.9
    normal = np.stack([x, -y, np.sqrt(np.maximum(1 - x * x - y * y, 0))], axis=-1)
    toward = -np.array(SUN.direction) / np.linalg.norm(SUN.direction)
    half = toward + np.array([0, 0, 1])
    half /= np.linalg.norm(half)
    lit = np.maximum(normal @ toward, 0)[..., None]
    shine = np.where(lit > 0, np.maximum(normal @ half, 0)[..., None] ** 20, 0)
    want = 0.1 + np.array(SUN.intensity) * (np.array(SHINY.diffuse) * lit + 0.3 * shine)
    errors = {}
    for shading in SHADINGS:
        for divisions in (2, 3, 4):
            got = render(scene(shapes.icosphere(divisions)), size, size, shading=shading).radiance
            errors[shading, divisions] = np.sqrt(np.mean((got - want)[inside] ** 2))
    for divisions in (2, 3, 4):
        assert errors["phong", divisions] < errors["gouraud", divisions] < errors["flat", divisions]
        assert errors["fast-phong", divisions] < 1.5 * errors["phong", divisions]
    slopes = {s: np.log2(errors[s, 2] / errors[s, 4]) / 2 for s in SHADINGS}
    assert 0.8 < slopes["flat"] < 1.3
    assert 1.4 < slopes["gouraud"] < 2.3
    assert 1.5 < slopes["phong"] < 2.3


def test_taylor_is_the_second_degree_expansion():
    """Against central differences of the function itself."""
    rng = np.random.default_rng(0)
    for _ in range(50):
        p, q, r, light = rng.normal(size=(4, 3))
        p *= 3 / np.linalg.norm(p)
        q, r = q * 0.2, r * 0.2

        def value(x, y, p=p, q=q, r=r, light=light):
            n = p + q * x + r * y
            return n @ light / np.linalg.norm(n)

        t0, t1, t2, t3, t4, t5 = _fast_kernels.taylor(
            light @ q, light @ r, light @ p, q @ q, 2 * q @ r, r @ r, 2 * p @ q, 2 * p @ r, p @ p
        )
        e = 1e-3
        assert t0 == pytest.approx(value(0, 0), abs=1e-12)
        assert t1 == pytest.approx((value(0, e) - value(0, -e)) / (2 * e), abs=1e-6)
        assert t2 == pytest.approx((value(e, 0) - value(-e, 0)) / (2 * e), abs=1e-6)
        assert t3 == pytest.approx(
            (value(0, e) - 2 * value(0, 0) + value(0, -e)) / (2 * e * e), abs=1e-6
        )
        assert t5 == pytest.approx(
            (value(e, 0) - 2 * value(0, 0) + value(-e, 0)) / (2 * e * e), abs=1e-6
        )
        mixed = value(e, e) - value(e, -e) - value(-e, e) + value(-e, -e)
        assert t4 == pytest.approx(mixed / (4 * e * e), abs=1e-6)


def test_forward_differences_are_the_polynomial():
    rng = np.random.default_rng(1)
    ids = np.zeros((3, 40), np.int32)
    ids[1, 10:20] = -1
    table = rng.normal(size=(1, 13))
    table[:, [1, 2, 7, 8]] *= 1e-2
    table[:, [3, 4, 5, 9, 10, 11]] *= 1e-4
    centre = np.array([[3.3, -2.2]])
    count = int((ids >= 0).sum())
    for mirror in (0, 1):
        first, second = np.empty((2, count), np.float32)
        _fast_kernels.forward(
            ids, -5.5, 2.5, 1.0, np.zeros(1, np.int32), centre, table, mirror, first, second
        )
        y, x = np.nonzero(ids >= 0)
        x, y = x - 5.5 - 3.3, y + 2.5 + 2.2
        powers = np.stack([np.ones_like(x), y, x, y * y, x * y, x * x])
        lit, other = table[0, :6] @ powers, table[0, 6:12] @ powers
        np.testing.assert_allclose(first, lit, atol=3e-7)
        np.testing.assert_allclose(
            second, 2 * lit * other - table[0, 12] if mirror else other, atol=1e-6
        )


@pytest.mark.parametrize("reflection", ["blinn", "phong"])
@pytest.mark.parametrize("projection", ["parallel", "perspective"])
def test_fast_phong_is_near_phong_on_fine_meshes(reflection, projection):
    camera = Camera((0, 0, 5), projection=projection, fov=26.0, height=2.2)
    made = replace(scene(shapes.icosphere(4), camera=camera), reflection=reflection)
    exact, fast = (render(made, 150, 150, shading=s).radiance for s in ("phong", "fast-phong"))
    assert np.abs(exact - fast).max() < 0.02
    assert np.sqrt(np.mean((exact - fast) ** 2)) < 1e-3


def test_fast_phong_falls_back_where_normals_differ_too_much_and_says_how_often():
    coarse = scene(shapes.icosphere(1))
    picture = render(coarse, 80, 80, shading="fast-phong")
    counts = picture.report["counts"]
    assert counts["fallen_back"] == counts["visible"] > 0
    np.testing.assert_array_equal(picture.radiance, render(coarse, 80, 80).radiance)
    wide = render(coarse, 80, 80, shading="fast-phong", angle=180.0)
    assert wide.report["counts"]["fallen_back"] == 0
    assert np.abs(wide.radiance - picture.radiance).max() > 1e-3
    mixed = render(scene(shapes.torus(10, 60)), 80, 80, shading="fast-phong", angle=37.0)
    assert np.isfinite(mixed.radiance).all()


@pytest.mark.parametrize("shading", SHADINGS)
def test_one_channel_and_seven(shading):
    for channels in (1, 7):
        colour = tuple(np.linspace(0.2, 0.9, channels))
        material = Material(ambient=colour, diffuse=colour, specular=colour, exponent=9)
        light = replace(SUN, intensity=(1.0,) * channels)
        made = Scene((ball(1),), (material,), (light,), PARALLEL, (1.0,) * channels, (0.5,) * channels)
        picture = render(made, 31, 17, shading=shading)
        assert picture.radiance.shape == (17, 31, channels)
        assert (picture.radiance[picture.ids < 0] == 0.5).all()
        wide = replace(
            made, materials=(Material(ambient=colour[:1] * 3, diffuse=colour[:1] * 3,
                                      specular=colour[:1] * 3, exponent=9),),
            lights=(replace(light, intensity=(1.0,) * 3),), ambient=(1.0,) * 3, background=(0.5,) * 3,
        )  # fmt: skip
        first = render(wide, 31, 17, shading=shading).radiance[..., 0]
        np.testing.assert_allclose(picture.radiance[..., 0], first, atol=1e-6)


@pytest.mark.parametrize("shading", SHADINGS)
def test_bands_and_workers_do_not_matter(shading):
    renderer = Renderer(scene(ball(2), camera=Camera((0.3, 0.4, 3.0))))
    want = renderer.render(70, 53, shading=shading, samples=2).radiance
    for workers, band in ((1, 1), (3, 8), (2, 64)):
        got = renderer.render(70, 53, shading=shading, samples=2, workers=workers, band=band).radiance
        np.testing.assert_array_equal(got, want)
