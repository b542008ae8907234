"""W(θ): published values, the table's error, and the kernel that interpolates it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from halftone.scene import _light_kernels as kernels
from halftone.scene import fresnel
from halftone.scene.illumination import Illumination
from halftone.scene.model import Fresnel, Light, Material
from tests.oracle import scene_light as oracle

COSINES = np.concatenate([np.linspace(0, 1, 20_001), np.geomspace(1e-9, 1, 10_001)])


def at(degrees):
    return np.cos(np.radians(np.asarray(degrees, np.float64)))


def interpolated(kind, cosines=COSINES):
    row = np.ones(len(cosines), np.float32)
    material = np.zeros(len(cosines), np.int32)
    kernels.reflect(0, cosines.astype(np.float32), material, fresnel.nodes(kind), row)
    return row


def test_glass_by_the_book():
    angles = [0, 45, 60, 75, 80, 85]
    shares = [0.04, 0.050240, 0.089187, 0.253061, 0.387704, 0.612800]
    np.testing.assert_allclose(fresnel.dielectric(at(angles), 1.5), shares, atol=5e-7)
    assert fresnel.dielectric(np.array(0.0), 1.5) == 1
    # Four percent at upright light, and below ten percent for most angles: up to 62.006°.
    assert fresnel.dielectric(at(62.005), 1.5) < 0.1 < fresnel.dielectric(at(62.007), 1.5)


def test_at_brewsters_angle_only_one_polarisation_is_reflected():
    n = 1.5
    angle = math.degrees(math.atan(n))
    assert angle == pytest.approx(56.3099, abs=5e-5)
    s = (n * n - 1) / (n * n + 1)
    assert fresnel.dielectric(at(angle), n) == pytest.approx(s * s / 2, abs=1e-15)


def test_the_mean_share_of_diffuse_light():
    c = (np.arange(200_000) + 0.5) / 200_000
    assert (2 * c * fresnel.dielectric(c, 1.5)).mean() == pytest.approx(0.091778, abs=1e-6)


def test_schlicks_largest_error():
    c = np.linspace(0, 1, 20_001)
    off = np.abs(fresnel.schlick(c, 0.04) - fresnel.dielectric(c, 1.5)).max()
    assert off == pytest.approx(0.0357, abs=5e-5)


@pytest.mark.parametrize(("n", "k"), [(1.5, 0), (2.4, 0), (0.2, 3.4), (1.5, 7.6), (0.05, 1), (2.9, 3.1)])
def test_both_polarisations_by_complex_angles(n, k):
    kind = Fresnel("conductor", n=n, k=k)
    for c in np.linspace(0.001, 1, 200):
        assert fresnel.share(kind, np.array(c)) == pytest.approx(oracle.reflectance(c, n, k), abs=1e-13)


def test_total_reflection_beyond_the_critical_angle():
    critical = math.degrees(math.asin(1 / 1.5))
    assert critical == pytest.approx(41.8103, abs=5e-5)
    shares = fresnel.dielectric(at([critical + 1e-9, 60, 90]), 1 / 1.5)
    np.testing.assert_array_equal(shares, 1)
    assert fresnel.dielectric(at(critical - 1), 1 / 1.5) < 0.5


@pytest.mark.parametrize(
    "kind",
    [
        *(Fresnel(n=n) for n in (1.0, 1.01, 1.2, 1.5, 2.4, 10)),
        *(Fresnel("conductor", n=n, k=k) for n, k in ((0.05, 1), (0.2, 3.4), (1.5, 7.6), (1, 0.001))),
        Fresnel("schlick"),
        Fresnel("schlick", f0=0.0),
    ],
    ids=str,
)
def test_the_error_of_the_table(kind):
    exact = fresnel.share(kind, COSINES.astype(np.float32).astype(np.float64))
    assert np.abs(interpolated(kind) - exact).max() <= 4e-7


def test_the_ends_of_the_table_are_exact():
    assert interpolated(Fresnel(), np.array([0.0, 1.0])).tolist() == [1.0, np.float32(0.04)]
    np.testing.assert_array_equal(interpolated(None), 1)


def test_a_table_of_the_user():
    kind = Fresnel("table", angles=(0.0, 60.0, 90.0), shares=(0.5, 0.7, 1.0))
    np.testing.assert_allclose(fresnel.share(kind, at([0, 60, 90])), [0.5, 0.7, 1.0], atol=1e-15)
    middle = math.degrees(math.acos(0.75))  # half-way, by the cosine, between 0° and 60°
    assert fresnel.share(kind, at(middle)) == pytest.approx(0.6)
    assert np.abs(interpolated(kind) - fresnel.share(kind, COSINES)).max() < 1e-4  # at the bends


@pytest.mark.parametrize("kind", [Fresnel(n=1e-3), Fresnel(n=1e6), Fresnel("conductor", n=1e-6, k=1e3)])
def test_never_outside_0_to_1(kind):
    shares = interpolated(kind)
    assert (shares >= 0).all()
    assert (shares <= 1).all()


def test_w_goes_by_the_light_and_the_highlight_by_the_viewer():
    """E2: the lobe's peak stays at V = R while W grows with the angle of incidence."""
    views = np.radians(np.linspace(-89, 89, 1781))
    peaks = []
    for incidence in (20, 50, 70, 85):
        light = Light("distant", direction=(math.sin(math.radians(incidence)), 0, -at(incidence)))
        shine = Material(diffuse=(0,) * 3, specular=(1.0,) * 3, exponent=200, fresnel=Fresnel())
        seen = []
        for view in views:
            lit = Illumination(
                [shine], [light], (0,) * 3, reflection="phong", view=(math.sin(view), 0, math.cos(view))
            )
            out = np.empty((3, 1), np.float32)
            up = np.array([[0], [0], [1]], np.float32)
            lit.shade(np.zeros_like(up), up, np.zeros(1, np.int32), out)
            seen.append(out[0, 0])
        assert math.degrees(views[int(np.argmax(seen))]) == pytest.approx(incidence, abs=0.06)
        peaks.append(max(seen))
    np.testing.assert_allclose(peaks, fresnel.dielectric(at([20, 50, 70, 85]), 1.5), rtol=1e-5)
