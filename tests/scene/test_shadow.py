"""Shadows by a hidden-surface pass at the light (I21 of scenes.md)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from halftone.scene import shapes
from halftone.scene.model import Camera, Light, Material, Mesh, Scene
from halftone.scene.render import render
from halftone.scene.shadow import looks

FLOOR = shapes.plane(8.0, 8.0)
GROUND = Material(ambient=(0.25,) * 3, diffuse=(0.5,) * 3)
ABOVE = Camera((0, 10, 0), (0, 0, 0), up=(0, 0, -1), projection="parallel", height=8.0)


def square(height: float, half: float) -> Mesh:
    made = shapes.plane(2 * half, 2 * half)
    return replace(made, vertices=made.vertices + np.array([0, height, 0]))


def scene(light: Light, *meshes: Mesh, camera: Camera = ABOVE) -> Scene:
    return Scene((FLOOR, *meshes), (GROUND,), (light,), camera)


def box_of(mask) -> np.ndarray:
    y, x = np.nonzero(mask)
    return np.array([x.min(), x.max() + 1, y.min(), y.max() + 1])


def shadow_of(light: Light, **options) -> np.ndarray:
    """Pixels that get ambient light only; the occluder is so small and high that it hides none."""
    picture = render(scene(light, square(2.0, 0.5)), 400, 400, **options)
    floor = picture.ids < 2
    gray = picture.radiance[..., 0]
    dark = np.abs(gray - 0.25) < 1e-6
    assert (gray[floor & ~dark] > 0.26).all()
    return dark & floor


@pytest.mark.parametrize("kind", ["point", "spot", "warn"])
def test_corners_of_a_square_lie_where_similar_triangles_say(kind):
    """The light at height 4, the square of half-side 0.5 at height 2, off the axis."""
    light = Light(kind=kind, position=(2.0, 4.0, 1.0), direction=(-2.0, -4.0, -1.0), shadows=True)
    if kind == "spot":
        light = replace(light, cutoff=50.0)
    dark = shadow_of(light)
    if kind == "spot":  # the rim of the cone is dark too: look at the square's shadow alone
        dark = dark[:330, :330]
    want = [(-2 + sign * 1.0 + 4) * 50 for sign in (-1, 1)] + [
        (-1 + sign * 1.0 + 4) * 50 for sign in (-1, 1)
    ]
    # The square itself covers 175 … 225 in both directions and hides part of the floor.
    got = box_of(dark)
    assert np.abs(got[[0, 2]] - np.array(want)[[0, 2]]).max() <= 1
    if want[1] < 175:
        assert abs(got[1] - want[1]) <= 1


def test_a_distant_light_moves_the_square():
    light = Light(kind="distant", direction=(1.0, -1.0, 0.5), shadows=True)
    dark = shadow_of(light)
    got = box_of(dark)
    want = np.array([(2 - 0.5 + 4) * 50, (2 + 0.5 + 4) * 50, (1 - 0.5 + 4) * 50, (1 + 0.5 + 4) * 50])
    assert np.abs(got - want).max() <= 1
    hole = dark[
        want[2].astype(int) + 2 : want[3].astype(int) - 2,
        want[0].astype(int) + 2 : want[1].astype(int) - 2,
    ]
    assert hole.all()


def test_six_maps_around_a_light_in_the_middle():
    """A lamp in a room, a square between it and the floor: the border by similar triangles."""
    room = shapes.box(8, 8, 8)
    inside = replace(room, faces=room.faces[:, ::-1], vertices=room.vertices + np.array([0, 4, 0]))
    light = Light(position=(0.0, 4.0, 0.0), shadows=True)
    camera = Camera((0, 6.5, 0.01), (0, 0, 0), up=(0, 0, -1), fov=70.0)
    assert len(looks(light, np.array([0.0, 4, 0]), 7.0)) == 6
    picture = render(Scene((inside, square(2.0, 0.5)), (GROUND,), (light,), camera), 300, 300)
    dark = np.abs(picture.radiance[..., 0] - 0.25) < 1e-6
    assert dark.any()
    assert (picture.ids >= 0).all()
    scale = 150 / np.tan(np.radians(35)) / 6.5
    got = box_of(dark & (picture.ids < 12))
    want = 150 + np.array([-1, 1, -1, 1]) * scale * 1.0
    assert np.abs(got - want).max() <= 2


@pytest.mark.parametrize("kind", ["point", "distant"])
@pytest.mark.parametrize("shading", ["flat", "gouraud", "phong", "fast-phong"])
def test_a_convex_body_does_not_shade_itself(kind, shading):
    options = {"position": (3.0, 4.0, 5.0)} if kind == "point" else {"direction": (-3.0, -4.0, -5.0)}
    light = Light(kind=kind, shadows=True, **options)
    ball = Scene((shapes.icosphere(4),), (GROUND,), (light,), Camera((0, 0, 4), fov=35.0))
    free = replace(ball, lights=(replace(light, shadows=False),))
    shaded, plain = (render(s, 120, 120, shading=shading).radiance for s in (ball, free))
    np.testing.assert_allclose(shaded, plain, atol=0.02)


def test_disagreement_with_shadow_rays_falls_with_the_resolution():
    light = Light(position=(2.0, 4.0, 1.0), shadows=True)
    wrong = []
    for resolution in (128, 512, 2048):
        dark = shadow_of(light, shadow_resolution=resolution)
        y, x = np.mgrid[:400, :400]
        point = np.stack([(x + 0.5) / 50 - 4, np.zeros((400, 400)), (y + 0.5) / 50 - 4], axis=-1)
        at = point + (np.array([2.0, 4.0, 1.0]) - point) * 0.5  # half-way up, in the square's plane
        want = (np.abs(at[..., 0]) < 0.5) & (np.abs(at[..., 2]) < 0.5)
        seen = (np.abs(x - 199.5) > 26) | (np.abs(y - 199.5) > 26)
        wrong.append(((dark != want) & seen).sum() / want.sum())
    assert wrong[2] < wrong[1] < wrong[0]
    assert wrong[1] < 0.1
    assert wrong[2] < 0.03


def test_shadows_change_nothing_else_and_see_through_faces_cast_none():
    light = Light(position=(2.0, 4.0, 1.0), shadows=True)
    glass = Material(transparency=0.5)
    pane = replace(square(2.0, 0.5), material=np.ones(2, np.int64))
    made = Scene((FLOOR, pane), (GROUND, glass), (light,), ABOVE)
    free = replace(made, lights=(replace(light, shadows=False),))
    np.testing.assert_array_equal(render(made, 90, 90).radiance, render(free, 90, 90).radiance)


def test_a_light_on_a_surface_and_in_an_empty_scene():
    light = Light(position=(0.0, 0.0, 0.0), shadows=True)
    assert np.isfinite(render(scene(light), 50, 50).radiance).all()
    empty = Scene((), (GROUND,), (light,), ABOVE, background=(0.1, 0.2, 0.3))
    picture = render(empty, 5, 4)
    np.testing.assert_allclose(picture.radiance, np.broadcast_to([0.1, 0.2, 0.3], (4, 5, 3)), atol=1e-7)
