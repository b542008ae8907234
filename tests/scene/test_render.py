"""Layers, detail polygons, edge samples, channels and reports of a rendering."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from halftone.errors import InputError, UsageError
from halftone.scene import shapes
from halftone.scene.model import Camera, Light, Material, Mesh, Scene
from halftone.scene.plan import LUMINANCE, Target
from halftone.scene.render import Renderer, plan, render

FRONT = Camera((0, 0, 5), projection="parallel", height=2.0)
SUN = Light(kind="distant", direction=(-1, -2, -3.0))
SHADINGS = ("flat", "gouraud", "phong", "fast-phong")


def sheet(z: float, material: int = 0, half: float = 2.0, detail: int | None = None) -> Mesh:
    corners = np.array([[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]])
    on = None if detail is None else np.full(2, detail)
    return Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]]), np.full(2, material), detail=on)


def glow(*colour: float, transparency: float = 0.0, **options) -> Material:
    return Material(ambient=colour, diffuse=(0.0,) * 3, transparency=transparency, **options)


def joined(*meshes: Mesh, detail=None) -> Mesh:
    at = np.cumsum([0] + [len(m.vertices) for m in meshes])
    return Mesh(
        np.concatenate([m.vertices for m in meshes]),
        np.concatenate([m.faces + a for m, a in zip(meshes, at, strict=False)]),
        np.concatenate([m.material for m in meshes]),
        detail=detail,
    )


@pytest.mark.parametrize("shading", SHADINGS)
def test_layers_from_back_to_front(shading):
    """I = (1 − k_t)·I_refl + k_t·I_trans, whatever the order of the meshes."""
    materials = (
        glow(0.8, 0.4, 0.2),
        glow(0.1, 0.9, 0.3, transparency=0.25),
        glow(0.5, 0.0, 1.0, transparency=0.75),
    )
    want = np.array([0.8, 0.4, 0.2])
    want = 0.75 * np.array([0.1, 0.9, 0.3]) + 0.25 * want
    want = 0.25 * np.array([0.5, 0.0, 1.0]) + 0.75 * want
    sheets = [sheet(0.0, 0), sheet(1.0, 1), sheet(2.0, 2), sheet(-1.0, 2)]
    for order in ((0, 1, 2, 3), (3, 2, 1, 0), (1, 3, 0, 2)):
        made = Scene([sheets[i] for i in order], materials, (), FRONT)
        picture = render(made, 12, 9, shading=shading)
        np.testing.assert_allclose(picture.radiance, np.broadcast_to(want, (9, 12, 3)), atol=1e-6)
        assert picture.report["counts"]["layers"] == 2


@pytest.mark.parametrize("count", [1, 5, 12])
def test_layers_of_k_t_let_through_its_power(count):
    materials = (glow(0.0, 0.0, 0.0, transparency=0.9),)
    made = Scene(
        [sheet(0.1 * i) for i in range(count)], materials, (), FRONT, background=(1.0, 1.0, 1.0)
    )
    picture = render(made, 6, 5)
    np.testing.assert_allclose(picture.radiance, 0.9**count, atol=1e-6)
    assert (picture.coverage == 1).all()
    assert (picture.ids == -1).all()


def test_k_t_of_1_and_0_are_exact():
    for k_t, want in ((1.0, 0.625), (0.0, 0.25)):
        materials = (glow(0.625, 0.625, 0.625), glow(0.25, 0.25, 0.25, transparency=k_t))
        picture = render(Scene((sheet(0), sheet(1, 1)), materials, (), FRONT), 5, 5)
        assert (picture.radiance == np.float32(want)).all()


def test_layers_that_cross_are_sorted_pixel_by_pixel():
    materials = (glow(1, 0, 0, transparency=0.5), glow(0, 1, 0, transparency=0.5))
    left = np.array([[-2, -2, 1.0], [2, -2, -1.0], [2, 2, -1.0], [-2, 2, 1.0]])
    cross = (replace(sheet(0, 0), vertices=left), replace(sheet(0, 1), vertices=left * [1, 1, -1]))
    picture = render(Scene(cross, materials, (), FRONT), 20, 20)
    np.testing.assert_allclose(
        picture.radiance[:, :10], np.broadcast_to([0.5, 0.25, 0], (20, 10, 3)), atol=1e-6
    )
    np.testing.assert_allclose(
        picture.radiance[:, 10:], np.broadcast_to([0.25, 0.5, 0], (20, 10, 3)), atol=1e-6
    )


def test_a_rim_is_less_clear_than_the_middle():
    glass = glow(0.0, 0.0, 0.0, transparency=0.9, rim=0.2, rim_exponent=2.0)
    ball = Scene((shapes.icosphere(4),), (glass,), (), FRONT, background=(1.0,) * 3)
    picture = render(ball, 101, 101)
    assert picture.radiance[50, 50, 0] == pytest.approx(0.81, abs=1e-3)
    row = picture.radiance[50, :, 0]
    assert row[1] < 0.3
    assert (np.diff(row[1:51]) > -1e-4).all()


def detailed(scale: float, tilt: float, order=(0, 1)) -> Scene:
    """A square with a smaller one drawn on it, a little off its plane as numbers are."""
    base, mark = sheet(0.0, 0), sheet(1e-13, 1, half=0.5)
    mesh = joined(base, mark, detail=np.array([-1, -1, 0, 1]))
    turn = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    camera = replace(FRONT, eye=(0, 0, 50 * scale), height=2.0 * scale)
    mesh = replace(mesh, vertices=mesh.vertices @ turn * scale)
    return Scene((mesh,), (glow(0.25, 0.25, 0.25), glow(1.0, 0.5, 0.0)), (), camera)


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e9])
@pytest.mark.parametrize("tilt", [0.0, 0.7, 1.5])
def test_details_win_where_their_face_is_seen_at_every_scale_and_angle(scale, tilt):
    made = detailed(scale, tilt)
    picture = render(made, 200, 100)
    mark = picture.radiance[..., 0] == 1.0
    rows, columns = np.nonzero(mark)
    assert (rows.min(), rows.max()) == (25, 74)
    half = 25 * np.cos(tilt)
    assert abs(columns.min() - (100 - half)) <= 1
    assert abs(columns.max() + 1 - (100 + half)) <= 1
    assert mark[25:75, columns.min() : columns.max() + 1].all()  # both halves, no gap and no fight


def test_details_are_hidden_with_their_face_and_do_not_show_on_others():
    made = detailed(1.0, 0.0)
    cover = replace(sheet(1.0, 0), vertices=sheet(1.0).vertices * [0.5, 1, 1] + [-1.0, 0, 0])
    picture = render(replace(made, meshes=(*made.meshes, cover)), 100, 100)
    mark = picture.radiance[..., 0] == 1.0
    assert not mark[:, :50].any()
    assert mark[25:75, 50:75].all()
    behind = render(replace(made, camera=replace(FRONT, eye=(0, 0, -50))), 100, 100)
    assert not (behind.radiance[..., 0] == 1.0).any() or (behind.ids >= 2).any()


def test_of_two_details_the_first_wins_and_a_detail_on_a_detail_wins_over_it():
    mesh = joined(
        sheet(0.0, 0), sheet(0.0, 1, 0.5), sheet(0.0, 2, 0.75), sheet(0.0, 3, 0.25),
        detail=np.array([-1, -1, 0, 0, 0, 0, 2, 3]),
    )  # fmt: skip
    materials = tuple(glow(*(v,) * 3) for v in (0.1, 0.2, 0.3, 0.4))
    gray = render(Scene((mesh,), materials, (), FRONT), 80, 80).radiance[..., 0]
    assert gray[40, 40] == np.float32(0.4)
    assert gray[40, 25] == np.float32(0.2)
    assert gray[40, 12] == np.float32(0.3)
    assert gray[40, 5] == np.float32(0.1)


def test_faces_that_are_not_details_are_seen_without_the_stage():
    picture = render(Scene((sheet(0.0),), (glow(1, 1, 1),), (), FRONT), 4, 4)
    assert "detail polygons" in picture.report["left_out"]


@pytest.mark.parametrize("samples", [1, 2, 3, 4, 8])
def test_coverage_of_edges(samples):
    """A half-plane: the share of samples; its error falls with their number (§4.2)."""
    errors = []
    for angle in np.linspace(0.1, 1.4, 9):
        turn = np.array(
            [[np.cos(angle), np.sin(angle), 0], [-np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
        )
        half = Mesh(
            np.array([[0, -9, 0], [9, -9, 0], [9, 9, 0], [0, 9, 0.0]]) @ turn,
            sheet(0).faces,
            np.zeros(2, int),
        )
        picture = render(Scene((half,), (glow(1, 1, 1),), (), FRONT), 30, 30, samples=samples)
        np.testing.assert_allclose(picture.radiance[..., 0], picture.coverage, atol=1e-6)
        fine = render(Scene((half,), (glow(1, 1, 1),), (), FRONT), 480, 480).coverage
        errors.append(picture.coverage - fine.reshape(30, 16, 30, 16).mean(axis=(1, 3)))
    edges = np.abs(errors) > 0
    assert (
        np.sqrt(np.mean(np.square(errors)[edges])) < 0.5 * samples**-1.3 if samples > 1 else edges.any()
    )


def test_inner_pixels_are_shaded_once_and_are_the_same_with_any_samples():
    made = Scene((shapes.icosphere(2),), (Material(),), (SUN,), replace(FRONT, height=2.2))
    for shading in SHADINGS:
        one = render(made, 60, 60, shading=shading, samples=1)
        three = render(made, 60, 60, shading=shading, samples=3)
        fine = render(made, 180, 180, shading=shading).ids.reshape(60, 3, 60, 3).transpose(0, 2, 1, 3)
        same = (fine == fine[:, :, :1, :1]).all(axis=(2, 3))
        assert 0.3 < same.mean() < 1
        np.testing.assert_allclose(three.radiance[same], one.radiance[same], atol=1e-4)


def test_samples_of_an_edge_are_the_mean_of_the_fine_picture():
    made = Scene((shapes.icosphere(1),), (Material(),), (SUN,), FRONT)
    coarse = render(made, 40, 40, samples=2, shading="flat").radiance
    fine = render(made, 80, 80, shading="flat").radiance.reshape(40, 2, 40, 2, 3)
    np.testing.assert_allclose(coarse, fine.mean(axis=(1, 3)), atol=1e-6)


def test_one_channel_is_the_luminance():
    materials = (Material(ambient=(0.1, 0.2, 0.3), diffuse=(0.9, 0.3, 0.2), specular=(0.2, 0.3, 0.1)),)
    made = Scene((shapes.torus(24, 12),), materials, (replace(SUN, intensity=(1.0, 0.7, 0.2)),),
                 background=(0.5, 0.25, 0.125))  # fmt: skip
    for overflow in ("none", "clamp", "divide", "scale"):
        scene = replace(made, overflow=overflow)
        three = render(scene, 50, 40).radiance
        one = render(scene, 50, 40, channels=1).radiance
        assert one.shape == (40, 50, 1)
        np.testing.assert_allclose(one[..., 0], three @ np.array(LUMINANCE), atol=1e-6)


def test_the_range_of_the_whole_picture():
    bright = (Material(ambient=(0.1,) * 3, diffuse=(4.0,) * 3),)
    made = Scene((shapes.icosphere(2),), bright, (SUN,), FRONT, overflow="scale")
    picture = render(made, 40, 40).radiance
    assert picture.max() == 1
    assert picture.min() == 0
    plain = render(replace(made, overflow="none"), 40, 40).radiance
    assert (np.diff(picture.ravel()[np.argsort(plain.ravel(), kind="stable")]) >= 0).all()


def test_out_is_written_to_and_must_fit():
    renderer = Renderer(Scene((sheet(0),), (glow(0.5, 0.25, 1),), (), FRONT))
    out = np.full((4, 6, 3), np.nan, np.float32)
    assert renderer.render(6, 4, out=out).radiance is out
    assert (out == np.array([0.5, 0.25, 1], np.float32)).all()
    with pytest.raises(InputError, match="out is"):
        renderer.render(4, 6, out=out)


def test_options_that_do_not_exist():
    made = Scene((sheet(0),), camera=FRONT)
    with pytest.raises(UsageError, match="phong"):
        render(made, 4, 4, shading="pong")
    with pytest.raises(UsageError, match="samples"):
        render(made, 4, 4, samples=0)
    with pytest.raises(UsageError, match="channels=2"):
        render(made, 4, 4, channels=2)
    with pytest.raises(UsageError, match="width"):
        render(made, 0, 4)


@pytest.mark.parametrize("size", [(1, 1), (1, 50), (50, 1), (65000, 2)])
def test_sizes(size):
    for shading in SHADINGS:
        picture = render(Scene((sheet(0),), camera=FRONT), *size, shading=shading)
        assert picture.radiance.shape == (size[1], size[0], 3)


def test_inputs_are_not_changed():
    mesh = shapes.torus(12, 8)
    held = mesh.vertices.copy(), mesh.faces.copy()
    render(Scene((mesh,), lights=(SUN,)), 20, 20, shading="gouraud")
    np.testing.assert_array_equal(mesh.vertices, held[0])
    np.testing.assert_array_equal(mesh.faces, held[1])


def test_the_report_counts():
    mesh = shapes.torus(12, 8)
    broken = replace(
        mesh, vertices=np.where(np.arange(len(mesh.vertices))[:, None] == 5, np.nan, mesh.vertices)
    )
    picture = render(Scene((broken,), lights=(SUN,)), 20, 20)
    counts = picture.report["counts"]
    assert counts["nonfinite_faces"] > 0
    assert np.isfinite(picture.radiance).all()
    assert {"projection", "visibility", "shading"} <= set(picture.report["seconds"])
    assert str(plan(Scene((mesh,), lights=(SUN,)), Target(20, 20, 1, "bilevel")))
