"""Kinds of lights, attenuation, cones, Warn's lights and flaps, and what is refused."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from halftone.errors import InputError
from halftone.scene import _light_kernels as kernels
from halftone.scene.illumination import Illumination
from halftone.scene.lights import lamp
from halftone.scene.model import Light, Material

WHITE = Material(ambient=(0.0,) * 3, diffuse=(1.0,) * 3)
DARK = (0.0,) * 3


def shown(light, position, normal=(0.0, 0.0, 1.0), material=WHITE, **options):
    """What samples at *position* (K, 3) show, float32 (K, 3)."""
    position = np.ascontiguousarray(np.atleast_2d(np.array(position, np.float64)).T, np.float32)
    count = position.shape[1]
    normals = np.ascontiguousarray(np.broadcast_to(np.array(normal, np.float32)[:, None], (3, count)))
    out = np.empty((3, count), np.float32)
    Illumination([material], [light], DARK, **options).shade(
        position, normals, np.zeros(count, np.int32), out
    )
    assert np.isfinite(out).all()
    return out.T


def test_a_point_light_far_away_is_a_distant_light():
    toward = np.array([1.0, 2.0, 3.0]) / math.sqrt(14)
    samples = np.random.default_rng(0).normal(size=(200, 3))
    shine = replace(WHITE, specular=(0.5,) * 3, exponent=20)
    sun = shown(Light("distant", direction=tuple(-toward)), samples, material=shine)
    for distance in (1e9, 1e15, 1e30, 1e100):  # within float32, and far beyond it
        far = shown(Light(position=tuple(toward * distance)), samples, material=shine)
        np.testing.assert_allclose(far, sun, atol=4e-7)


def test_attenuation_by_the_book():
    def at(distance, a):
        return shown(Light(position=(0, 0, distance), attenuation=a), [0, 0, 0])[0, 0]

    assert at(7.0, (1, 0, 0)) == 1
    assert at(2.0, (0, 0, 1)) == 0.25
    assert at(0.1, (0, 0, 1)) == 1  # never brighter than the light
    assert at(2.0, (1, 0.5, 0.25)) == np.float32(1 / 3)
    assert at(3.0, (2, 0, 0)) == 0.5
    for distance in (1e-30, 1e-10, 1e-3):
        assert at(distance, (0, 0, 1)) in (0, 1)  # 0 where even the direction is lost
    assert at(1e200, (1, 1, 1)) == 0


def test_attenuation_never_rises_with_the_distance():
    z = np.linspace(0.01, 30, 4000)
    samples = np.stack([0 * z, 0 * z, -z], axis=1)
    for a in ((0, 1, 0), (0.3, 0.1, 0.7), (1, 0, 1e-4)):
        factor = np.ones(len(z), np.float32)
        made = lamp(Light(attenuation=a))
        position = np.ascontiguousarray(samples.T, np.float32)
        kernels.attenuate(0, position, made.place, made.attenuation, factor)
        assert (np.diff(factor) <= 0).all()
        seen = shown(Light(attenuation=a), samples)[:, 0]
        np.testing.assert_allclose(seen, np.minimum(1, 1 / (a[0] + a[1] * z + a[2] * z * z)), rtol=1e-6)


def test_parallel_planes_differ_only_by_attenuation():
    planes = [[0.0, 0.0, 0.0], [0.0, 0.0, -1.0]]
    near, far = shown(Light(position=(0, 0, 2)), planes)
    np.testing.assert_array_equal(near, far)
    near, far = shown(Light(position=(0, 0, 2), attenuation=(0, 0, 1)), planes)
    assert (near > far).all()


@pytest.mark.parametrize("cutoff", [10.0, 30.0, 60.0])
def test_a_spot_lights_a_disc_of_radius_h_tan_cutoff(cutoff):
    height, pixel = 2.0, 0.01
    x = np.arange(0, 6, pixel)
    samples = np.stack([x, 0 * x, 0 * x], axis=1)
    light = Light("spot", position=(0, 0, height), direction=(0, 0, -1), cutoff=cutoff)
    lit = shown(light, samples)[:, 0] > 0
    radius = x[lit].max()
    assert radius == pytest.approx(height * math.tan(math.radians(cutoff)), abs=pixel)
    assert lit[x < radius].all()


def test_a_spot_fades_from_its_inner_angle_on():
    angles = np.radians([0, 10, 20, 24, 28, 30, 35])
    samples = np.stack([np.sin(angles), 0 * angles, -np.cos(angles)], axis=1)
    light = Light("spot", cutoff=30, inner=20)
    factor = shown(light, samples)[:, 0] / shown(Light(), samples)[:, 0]
    t = (np.cos(angles) - np.cos(np.radians(30))) / (np.cos(np.radians(20)) - np.cos(np.radians(30)))
    t = np.clip(t, 0, 1)
    np.testing.assert_allclose(factor, t * t * (3 - 2 * t), atol=2e-6)
    assert factor[0] == factor[1] == 1
    assert factor[-1] == 0


@pytest.mark.parametrize("p", [1, 10, 100, 1000])
def test_warns_light_falls_to_half_at_its_half_power_angle(p):
    half = math.acos(2 ** (-1 / p))
    samples = [[math.sin(half), 0, -math.cos(half)]]
    light = Light("warn", direction=(0, 0, -1), exponent=p)
    factor = shown(light, samples)[0, 0] / shown(Light(), samples)[0, 0]
    assert factor == pytest.approx(0.5, abs=2e-7 * max(1, p / 10) + 2e-6)


@pytest.mark.parametrize("p", [1, 5, 40])
def test_the_flux_of_warns_light(p):
    """2πI/(p + 1): rings of a sphere about the light, facing it."""
    gamma = (np.arange(2000) + 0.5) / 2000 * math.pi
    away = np.stack([np.sin(gamma), 0 * gamma, -np.cos(gamma)], axis=1)
    total = 0.0
    for g, position in zip(gamma[::20], away[::20], strict=True):
        normal = tuple(-position)
        seen = shown(Light("warn", exponent=p), position, normal)[0, 0]
        total += seen * 2 * math.pi * math.sin(g) * (math.pi / 100)
    assert total == pytest.approx(2 * math.pi / (p + 1), rel=0.02)


def test_warns_light_without_exponent_is_a_point_light():
    samples = np.random.default_rng(1).normal(size=(300, 3))
    np.testing.assert_array_equal(shown(Light("warn"), samples), shown(Light(), samples))
    spread = shown(Light("warn", exponent=0.01), samples)
    np.testing.assert_array_equal(spread[samples[:, 2] > 0], 0)


def test_flaps_are_a_box_about_the_surface():
    samples = np.random.default_rng(2).uniform(-2, 2, size=(5000, 3)).astype(np.float32)
    flaps = ((-1.0, 0.5), (-np.inf, 0.25), (-1.5, np.inf))
    light = Light("warn", position=(0, 0, 9), flaps=flaps)
    inside = np.all(
        [(a <= samples[:, i]) & (samples[:, i] <= b) for i, (a, b) in enumerate(flaps)], axis=0
    )
    seen, whole = shown(light, samples), shown(replace(light, flaps=Light().flaps), samples)
    np.testing.assert_array_equal(seen, np.where(inside[:, None], whole, 0))
    assert 0 < inside.sum() < len(samples)


def test_open_flaps_are_no_flaps():
    plain = Light("warn", position=(0, 0, 9), exponent=3)
    assert not lamp(plain).flaps
    samples = np.random.default_rng(3).normal(size=(300, 3))
    wide = replace(plain, flaps=((-1e300, 1e300),) * 3)
    assert lamp(wide).flaps
    np.testing.assert_array_equal(shown(plain, samples), shown(wide, samples))


def test_which_stages_a_light_needs():
    assert not lamp(Light()).attenuated
    assert not lamp(Light(attenuation=(0.5, 0, 0))).attenuated  # min(1, 2) is 1
    assert lamp(Light(attenuation=(2, 0, 0))).attenuated
    assert lamp(Light("spot")).cone
    assert not lamp(Light("warn")).cone
    assert lamp(Light("warn", cutoff=40)).cone
    assert not lamp(Light("warn")).lobe
    assert lamp(Light("distant")).distant


@pytest.mark.parametrize(
    ("light", "words"),
    [
        (Light(attenuation=(0, 0, 0)), r"lights\[0\].*not all of them 0.*\(1, 0, 0\)"),
        (Light(attenuation=(1, -1, 0)), "attenuation.*0 or more"),
        (Light(attenuation=(1, math.nan, 0)), "attenuation"),
        (Light(intensity=(1, -1, 1)), "intensity.*0 or more"),
        (Light(intensity=(1, math.inf, 1)), "intensity"),
        (Light(intensity=(1, 1)), "channels"),
        (Light(position=(0, math.nan, 0)), "position"),
        (Light("distant", direction=(0, 0, 0)), "direction"),
        (Light("distant", attenuation=(1, 1, 0)), "distant light has no attenuation"),
        (Light("point", exponent=3), "point light has no exponent"),
        (Light("point", cutoff=30), "point light has no cutoff"),
        (Light("spot", cutoff=0), "cutoff"),
        (Light("spot", cutoff=20, inner=30), "inner"),
        (Light("warn", exponent=-1), "exponent"),
        (Light("warn", flaps=((1, 0), (0, 1), (0, 1))), "flaps"),
        (Light("sopt"), "spot"),
    ],
)
def test_what_is_refused(light, words):
    with pytest.raises(InputError, match=words):
        Illumination([Material()], [light])
