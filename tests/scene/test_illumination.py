"""Terms, highlights, channels, many lights; impossible geometry; and the plan of stages."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from halftone._arrays import LUMINANCE
from halftone.errors import InputError
from halftone.scene.illumination import Illumination
from halftone.scene.model import Fresnel, Light, Material
from tests.oracle import scene_light as oracle
from tests.scene.samples import LAMP, MATT, SEEDS, SHINY, SUN, UP, one, samples, shade


def sphere_disc(rows=400):
    """Normals of the unit sphere at the pixels of the disc that a viewer at +z sees."""
    axis = (np.arange(rows) + 0.5) / rows * 2 - 1
    x, y = (a.ravel() for a in np.meshgrid(axis, axis))
    inside = x * x + y * y < 1
    x, y = x[inside], y[inside]
    return np.stack([x, y, np.sqrt(1 - x * x - y * y)])


# I1–I3: ambient and diffuse ------------------------------------------------------------------------


@given(seed=SEEDS)
@settings(max_examples=10, deadline=None)
def test_ambient_light_is_the_same_everywhere(seed):
    position, normal, _ = samples(seed)
    out = shade(Illumination([MATT], (), (0.5, 0.5, 2.0), eye=(1, 2, 3)), position, normal)
    expected = np.array([0.05, 0.1, 0.6], np.float32)
    np.testing.assert_array_equal(out, np.repeat(expected[:, None], 200, axis=1))


def test_the_mean_over_a_sphere_lit_from_the_viewer_is_two_thirds():
    lit = Illumination(
        [replace(MATT, diffuse=(0.9,) * 3)], [Light("distant", intensity=(0.5,) * 3)], (0,) * 3
    )
    normal = sphere_disc()
    out = shade(lit, normal, normal)
    assert out.astype(np.float64).mean() == pytest.approx(2 / 3 * 0.9 * 0.5, abs=2e-4)


def test_a_surface_turned_away_has_ambient_light_only():
    lit = Illumination([SHINY], [LAMP, SUN], eye=(0, 0, 5))
    np.testing.assert_array_equal(one(lit, normal=(0, 0, -1)), np.float32([0.1, 0.2, 0.3]))


def test_a_white_furnace_returns_k_d():
    """∫ k_d cos θ / π over the hemisphere = k_d, by distant lights in rings."""
    theta = (np.arange(60) + 0.5) / 60 * math.pi / 2
    weight = 2 * math.pi * np.sin(theta) * (math.pi / 2 / 60) / math.pi
    lights = [
        Light("distant", (w,) * 3, direction=(-math.sin(t), 0, -math.cos(t)))
        for t, w in zip(theta, weight, strict=True)
    ]
    seen = one(Illumination([MATT], lights, (0,) * 3))
    np.testing.assert_allclose(seen, MATT.diffuse, rtol=2e-4)


@given(seed=SEEDS)
@settings(max_examples=10, deadline=None)
def test_diffuse_light_does_not_depend_on_the_viewer(seed):
    position, normal, _ = samples(seed)
    lights = [LAMP, SUN]
    first = shade(Illumination([MATT], lights, eye=(1, 2, 3)), position, normal)
    second = shade(Illumination([MATT], lights, view=(0, 1, 0)), position, normal)
    np.testing.assert_array_equal(first, second)


# I4–I7: highlights ---------------------------------------------------------------------------------


def cosine_of_highlight(reflection, normal, toward, viewer):
    """What exponent 1 shows of a light towards *toward*: V·R or N·H."""
    mirror = Material(diffuse=(0,) * 3, specular=(1,) * 3, exponent=1)
    light = Light("distant", direction=tuple(-np.asarray(toward)))
    lit = Illumination([mirror], [light], (0,) * 3, reflection=reflection, view=tuple(viewer))
    return one(lit, normal=normal)[0]


def test_the_reflection_vector():
    random = np.random.default_rng(5)
    for _ in range(50):
        n, toward = oracle.unit(random.normal(size=3)), oracle.unit(random.normal(size=3))
        if n @ toward < 0.01:
            continue
        r = 2 * (n @ toward) * n - toward
        assert np.linalg.norm(r) == pytest.approx(1, abs=1e-12)
        assert r @ n == pytest.approx(toward @ n, abs=1e-12)
        assert np.linalg.det([r, n, toward]) == pytest.approx(0, abs=1e-12)
        assert cosine_of_highlight("phong", n, toward, r) == pytest.approx(1, abs=3e-7)
        v = oracle.unit(random.normal(size=3))
        assert cosine_of_highlight("phong", n, toward, v) == pytest.approx(max(0, r @ v), abs=5e-7)
        half = oracle.unit(v + toward)
        assert cosine_of_highlight("blinn", n, toward, v) == pytest.approx(max(0, n @ half), abs=5e-7)


@pytest.mark.parametrize(("n", "angle"), [(1, 60), (10, 21.1), (100, 6.7), (1000, 2.1)])
def test_phongs_highlight_falls_to_half_at_its_half_power_angle(n, angle):
    half = math.acos(2 ** (-1 / n))
    assert math.degrees(half) == pytest.approx(angle, abs=0.05)
    mirror = Material(diffuse=(0,) * 3, specular=(1,) * 3, exponent=n)
    view = (math.sin(half), 0, math.cos(half))
    light = Light("distant", direction=(0, 0, -1))
    lit = Illumination([mirror], [light], (0,) * 3, reflection="phong", view=view)
    assert one(lit)[0] == pytest.approx(0.5, abs=1e-7 * n + 1e-6)


def test_the_halfway_angle_is_half_the_mirror_angle_in_one_plane_and_never_less():
    for incidence, view in itertools.product((-60, -20, 10, 45), (-70, -30, 0, 50)):
        toward, viewer = (
            (math.sin(math.radians(a)), 0, math.cos(math.radians(a))) for a in (incidence, view)
        )
        alpha = abs(incidence + view) / 2
        expected = math.cos(math.radians(alpha))
        assert cosine_of_highlight("blinn", UP, toward, viewer) == pytest.approx(expected, abs=3e-7)
        expected = max(0, math.cos(math.radians(2 * alpha)))
        assert cosine_of_highlight("phong", UP, toward, viewer) == pytest.approx(expected, abs=3e-7)
    random = np.random.default_rng(6)
    for _ in range(50):
        toward, viewer = (oracle.unit([*random.normal(size=2), 0.5]) for _ in range(2))
        a = math.acos(min(1, cosine_of_highlight("blinn", UP, toward, viewer)))
        phi = math.acos(min(1, cosine_of_highlight("phong", UP, toward, viewer)))
        assert phi == pytest.approx(math.pi / 2) or 2 * a >= phi - 2e-3


@given(seed=SEEDS)
@settings(max_examples=20, deadline=None)
def test_a_constant_halfway_vector_gives_the_same_bits(seed):
    position, normal, _ = samples(seed)
    view = tuple(np.random.default_rng(seed).normal(size=3))
    lit = Illumination([SHINY], [SUN], view=view)
    assert lit.constant_halfway == (True,)
    each = Illumination([SHINY], [SUN], view=view, force_all=True)
    np.testing.assert_array_equal(shade(lit, position, normal), shade(each, position, normal))


# I9: the whole formula -----------------------------------------------------------------------------


def test_a_pixel_by_hand():
    """Light and viewer upright at distance 2, f = 1/(0.5 + 0.25·4): every cosine is 1."""
    light = Light(position=(0, 0, 2), intensity=(0.5, 1.0, 2.0), attenuation=(0.5, 0, 0.25))
    lit = Illumination([SHINY], [light], (1.0, 0.5, 0.0), eye=(0, 0, 2))
    f = 1 / 1.5
    expected = [0.1 + f * 0.5 * 1.3, 0.1 + f * 0.9, 0 + f * 2 * 0.45]
    np.testing.assert_allclose(one(lit), expected, rtol=3e-7)


@pytest.mark.parametrize("reflection", ["blinn", "phong"])
@given(seed=SEEDS)
@settings(max_examples=15, deadline=None)
def test_the_formula_in_float64(reflection, seed):
    position, normal, _ = samples(seed, 40)
    eye = np.array([0.5, -1.0, 6.0])
    glass = replace(SHINY, fresnel=Fresnel())
    lights = [replace(LAMP, attenuation=(0.5, 0.2, 0.1)), SUN]
    ambient = (0.3, 0.2, 0.1)
    seen = shade(
        Illumination([glass], lights, ambient, reflection=reflection, eye=tuple(eye)), position, normal
    )
    for k in range(40):
        p, n = position[:, k].astype(np.float64), normal[:, k].astype(np.float64)
        viewer = oracle.unit(eye - p)
        expected = oracle.illuminate(
            glass, lights, ambient, p, n, viewer, reflection, lambda c: oracle.reflectance(c, 1.5)
        )
        np.testing.assert_allclose(seen[:, k], expected, atol=6e-6)


@given(seed=SEEDS)
@settings(max_examples=15, deadline=None)
def test_lights_add_up(seed):
    position, normal, material = samples(seed)
    materials = [MATT, SHINY, replace(SHINY, exponent=3.0)]
    both, first, second, none = (
        shade(Illumination(materials, lights, eye=(0, 0, 6)), position, normal, material)
        for lights in ([LAMP, SUN], [LAMP], [SUN], [])
    )
    np.testing.assert_allclose(both, first + second - none, atol=4e-7)


def test_the_order_of_the_lights_does_not_matter():
    position, normal, _ = samples(7)
    lights = [LAMP, SUN, Light(position=(-3, 0, 1)), Light("spot", position=(0, 0, 3), cutoff=60)]
    results = [
        shade(Illumination([SHINY], order, eye=(0, 0, 6)), position, normal)
        for order in itertools.permutations(lights)
    ]
    for other in results[1:]:
        np.testing.assert_array_equal(other, results[0])


# I16, I17: channels --------------------------------------------------------------------------------


def test_a_blue_surface_under_red_light_is_black():
    blue = Material(ambient=(0, 0, 0.1), diffuse=(0, 0, 1), specular=(0, 0, 0.5))
    lit = Illumination([blue], [replace(SUN, intensity=(1, 0, 0))], (1, 0, 0))
    np.testing.assert_array_equal(one(lit, normal=oracle.unit((1, 2, 3))), 0)


def test_a_gray_material_is_gray_to_the_bit():
    gray = Material("gray", (0.13,) * 3, (0.57,) * 3, (0.31,) * 3, 12.3)
    position, normal, _ = samples(8)
    out = shade(Illumination([gray], [SUN, replace(LAMP, intensity=(0.7,) * 3)]), position, normal)
    np.testing.assert_array_equal(out[0], out[1])
    np.testing.assert_array_equal(out[0], out[2])


def test_channels_are_independent():
    position, normal, _ = samples(9)
    whole = shade(Illumination([SHINY], [LAMP], eye=(0, 0, 6)), position, normal)
    for c in range(3):
        single = Material("c", *([v[c]] for v in (SHINY.ambient, SHINY.diffuse, SHINY.specular)), 20.0)
        lights = [replace(LAMP, intensity=(LAMP.intensity[c],))]
        out = shade(Illumination([single], lights, (1.0,), eye=(0, 0, 6)), position, normal)
        np.testing.assert_array_equal(out[0], whole[c])


def test_plastic_shines_in_the_colour_of_the_light_and_metal_in_its_own():
    mirror = {"ambient": (0,) * 3, "exponent": 500.0, "diffuse": (0, 0, 0.0)}
    light = replace(SUN, direction=(0, 0, -1), intensity=(1.0, 0.8, 0.6))
    plastic = one(Illumination([Material(specular=(0.5,) * 3, **mirror)], [light], view=UP))
    metal = one(Illumination([Material(specular=(0.9, 0.6, 0.1), **mirror)], [light], view=UP))
    np.testing.assert_allclose(plastic, [0.5, 0.4, 0.3], rtol=1e-6)
    np.testing.assert_allclose(metal, [0.9, 0.48, 0.06], rtol=1e-6)


def test_31_channels_and_their_sum():
    """A spectrum shaded band by band, then summed by weights; or the sum shaded as one channel."""
    random = np.random.default_rng(10)
    ambient, diffuse, specular, light, weights = random.uniform(0, 1, (5, 31))
    material = Material("s", tuple(ambient), tuple(diffuse), tuple(specular), 9.0)
    lights = [replace(LAMP, intensity=tuple(light))]
    position, normal, _ = samples(11)
    white = (1.0,) * 31
    out = shade(Illumination([material], lights, white, eye=(0, 0, 6)), position, normal)
    assert out.shape == (31, 200)
    summed = shade(
        Illumination([material], lights, white, eye=(0, 0, 6), weights=weights), position, normal
    )
    np.testing.assert_allclose(summed[0], weights @ out.astype(np.float64), rtol=1e-6)


def test_luminance_alone_is_the_luminance_of_the_colours():
    position, normal, material = samples(12)
    materials = [MATT, SHINY, replace(SHINY, fresnel=Fresnel())]
    options = {"ambient": (0.2, 0.5, 0.1), "eye": (0, 0, 6)}
    out = shade(Illumination(materials, [LAMP, SUN], **options), position, normal, material)
    gray = Illumination(materials, [LAMP, SUN], weights=LUMINANCE, **options)
    assert gray.channels == 1
    assert gray.stages()[0][1:] == (False, "one channel, the weighted sum of 3")
    seen = shade(gray, position, normal, material)
    np.testing.assert_allclose(seen[0], np.array(LUMINANCE) @ out.astype(np.float64), rtol=1e-6)
    with pytest.raises(InputError, match="overflow='none'"):
        Illumination(materials, weights=LUMINANCE, overflow="clamp")


# I21: shadows --------------------------------------------------------------------------------------


def test_a_shadow_leaves_ambient_light_and_the_other_lights():
    position, normal, _ = samples(13)
    casting = replace(LAMP, shadows=True)
    lit = np.random.default_rng(14).integers(0, 2, (2, 200)).astype(np.uint8)
    out = shade(Illumination([SHINY], [casting, SUN], eye=(0, 0, 6)), position, normal, lit=lit)
    bright = shade(Illumination([SHINY], [LAMP, SUN], eye=(0, 0, 6)), position, normal)
    dark = shade(Illumination([SHINY], [SUN], eye=(0, 0, 6)), position, normal)
    expected = np.where(lit[0] != 0, bright, dark)
    np.testing.assert_allclose(out, expected, atol=2e-7)
    np.testing.assert_array_equal(out[:, lit[0] != 0], bright[:, lit[0] != 0])


# §5.1: stability -----------------------------------------------------------------------------------


@pytest.mark.parametrize("reflection", ["blinn", "phong"])
@pytest.mark.parametrize("exponent", [0.0, 1.0, 30.5, 1e6, 1e12, math.inf])
def test_impossible_geometry_stays_finite(reflection, exponent):
    """Light on the surface, viewer on the surface, V = −L, grazing light, N·L at and below 0."""
    material = replace(SHINY, exponent=exponent, fresnel=Fresnel())
    directions = [UP, (1, 0, 0), (1, 0, 1e-8), (1, 0, -1e-8), (0, 0, -1), (1e-30, 0, 1), (0, 0, 0)]
    for where in [(0, 0, 0), (0, 0, 1), (0, 0, -1), (1, 0, 1e-8), (1e-30, 0, 0), (1e30, 0, 1)]:
        for eye in [(0, 0, 0), (0, 0, -1), (0, 0, 1), (-1, 0, 0)]:
            light = Light(position=where, attenuation=(0, 0, 1))
            lit = Illumination([material], [light], reflection=reflection, eye=eye)
            for normal in directions:
                seen = one(lit, normal=normal)
                assert (seen >= np.float32(MATT.ambient)).all()
                assert (seen <= 3).all()


def test_no_highlight_without_light_or_behind_the_mirror():
    flat = replace(SHINY, exponent=0.0, diffuse=(0,) * 3)  # cos⁰ = 1 wherever there is a highlight
    back = Illumination([flat], [Light("distant", direction=(0, 0, 1))])
    np.testing.assert_array_equal(one(back), np.float32(flat.ambient))
    behind = Illumination(
        [flat], [Light("distant", direction=(-1, 0, -0.1))], reflection="phong", view=(1, 0, 0)
    )
    np.testing.assert_array_equal(one(behind), np.float32(flat.ambient))
    seen = one(Illumination([flat], [Light("distant", direction=(-1, 0, -0.1))], view=UP))
    np.testing.assert_allclose(seen, np.add(flat.ambient, flat.specular), rtol=1e-6)


def test_the_viewer_opposite_to_the_light_sees_no_highlight():
    lit = Illumination([SHINY], [Light("distant", direction=(-1, 0, 0))], view=(-1, 0, 0))
    slanted = oracle.unit((1, 0, 1))
    np.testing.assert_allclose(
        one(lit, normal=slanted), np.add(MATT.ambient, np.multiply(MATT.diffuse, slanted[0])), rtol=1e-6
    )


def test_a_perfect_mirror_shows_the_light_only_where_the_cosine_is_1():
    mirror = Material(ambient=(0,) * 3, diffuse=(0,) * 3, specular=(1,) * 3, exponent=math.inf)
    lit = Illumination([mirror], [Light("distant")], view=UP)
    np.testing.assert_array_equal(one(lit), 1)
    np.testing.assert_array_equal(one(lit, normal=oracle.unit((0.01, 0, 1))), 0)
