"""halftone.render: files and scenes alike; pictures do not depend on a scene's scale and place."""

from dataclasses import replace

import numpy as np
import pytest

import halftone
from halftone.errors import InputError, UsageError
from halftone.scene import shapes
from halftone.scene.load import load
from halftone.scene.model import Camera, Light, Material, Mesh, Scene
from tests.scene.test_sanitise import scaled

SIZE = 48
GLOSS = Material(diffuse=(0.6, 0.5, 0.4), specular=(0.4,) * 3)
LAMP = Light(
    "warn", position=(2, 3, 4), direction=(-2, -3, -4), attenuation=(0.2, 0.1, 0.01), exponent=2
)
SCENE = Scene(
    (shapes.torus(24, 12), shapes.box(0.5, 1.6, 0.5)),
    (GLOSS,),
    (
        replace(LAMP, flaps=((-np.inf, 0.7), (-9, np.inf), (-np.inf, np.inf))),
        Light("distant", (0.3,) * 3),
    ),
    Camera((0.5, 2, 4), (0, 0.1, 0.05), fov=40, near=0.05),
)


def rendered(scene, **options):
    return halftone.render(scene, SIZE, SIZE, **options).radiance


def test_a_file_and_its_scene_give_the_same_picture(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text('[[lights]]\nkind = "distant"\n[[meshes]]\nshape = "torus"\nu = 12\nv = 8\n')
    assert np.array_equal(rendered(path), rendered(load(path)))
    assert np.array_equal(rendered(str(path)), rendered(replace(load(path), camera=None)))
    assert rendered(path).std() > 0.05


@pytest.mark.parametrize("power", [-100, -40, 3, 40, 100])
def test_a_power_of_two_gives_the_same_bits(power):
    assert np.array_equal(rendered(scaled(SCENE, 2.0**power)), rendered(SCENE))


@pytest.mark.parametrize("factor", [1e-30, 1e-12, 1e-3, 1e12, 1e30])
def test_any_scale_gives_the_same_picture(factor):
    light, wanted = rendered(scaled(SCENE, factor)), rendered(SCENE)
    off = np.abs(light - wanted).max(axis=2) > 1e-5
    assert off.sum() <= 2  # a snapped edge may fall to the other side of a pixel's centre
    assert wanted.std() > 0.05


@pytest.mark.parametrize("shift", [1e3, 1e7])
def test_far_from_the_origin_is_the_same_picture(shift):
    light, wanted = rendered(scaled(SCENE, 1.0, shift)), rendered(SCENE)
    assert (np.abs(light - wanted).max(axis=2) > 1e-4).sum() <= 2


def test_nan_and_infinity_never_leave_the_renderer():
    rng = np.random.default_rng(5)
    for _ in range(20):
        points = rng.normal(size=(30, 3))
        faces = rng.integers(-2, 32, (40, 3))
        normals = rng.normal(size=(30, 3))
        for array in (points, normals):
            where = rng.integers(0, 30, 6), rng.integers(0, 3, 6)
            array[where] = rng.choice([np.nan, np.inf, -np.inf, 1e300, 0.0, -1e-300], 6)
        mesh = Mesh(points, faces, rng.integers(-1, 3, 40), normals, rng.integers(-1, 33, (40, 3)))
        assert np.isfinite(rendered(Scene((mesh,), lights=(Light(position=(0, 0, 2)),)))).all()


def test_nothing_to_see_is_the_background():
    picture = halftone.render(Scene(background=(0.1, 0.2, 0.3)), 5, 4)
    assert np.array_equal(picture.radiance, np.full((4, 5, 3), np.float32([0.1, 0.2, 0.3])))
    assert any("nothing is visible" in note for note in picture.report["notes"])


def test_what_was_mended_is_in_the_report():
    torus = shapes.torus(8, 6)
    points = torus.vertices.copy()
    points[3] = np.nan
    report = halftone.render(Scene((replace(torus, vertices=points),)), 8, 8).report
    assert report["counts"]["nonfinite_faces"] == 6
    assert any("NaN" in note for note in report["notes"])


@pytest.mark.parametrize("size", [(0, 5), (5, 2.5), (1 << 20, 5), (True, 5)])
def test_wrong_sizes(size):
    with pytest.raises(UsageError, match="allowed"):
        halftone.render(SCENE, *size)


def test_a_wrong_scene():
    with pytest.raises(InputError):
        halftone.render(replace(SCENE, camera=replace(SCENE.camera, fov=0.0)), 8, 8)
