"""Every kernel of illumination is its slow twin, to the bit, on good and on impossible samples."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halftone.scene import _light_kernels as kernels
from tests.oracle import scene_light as oracle

SEEDS = st.integers(0, 2**32 - 1)
MATERIALS = 3
EXPONENTS = [0.0, 0.3, 1.0, 2.0, 10.0, 77.5, 1e3, 1e6, 1e12, 3.4e38]
ODD = [np.nan, np.inf, -np.inf, 0.0, 1e30, -1e30, 1e-30]


class Samples:
    """Random rows for every argument that a kernel may have."""

    def __init__(self, seed: int) -> None:
        random = np.random.default_rng(seed)
        self.start = int(random.integers(0, 5))
        count = int(random.choice([1, 2, 17, 130, 300]))
        total = self.start + count
        self.position = random.normal(size=(3, total)).astype(np.float32)
        normal = random.normal(size=(3, total))
        self.normal = (normal / np.sqrt((normal**2).sum(0))).astype(np.float32)
        w, scale = random.choice([0, 1, 2.0**-20]), random.choice([1, 2.0**20])
        self.light = np.array([*random.normal(size=3), w, scale], np.float32)
        self.eye = np.array([*random.normal(size=3), random.choice([0, 1]), 1], np.float32)
        odd = random.integers(0, total, 4)
        self.position[:, odd[0]] = self.light[:3]  # the light on the surface
        self.position[:, odd[1]] = random.choice(ODD, 3)
        self.position[:, odd[2]] = (self.light + self.eye)[:3] / 2  # V = −L
        self.normal[:, odd[3]] = random.choice([np.nan, 0.0, 1.0000001], 3)
        outer = random.uniform(0, 1)
        inner = random.choice([outer, random.uniform(outer, 1)])
        exponent = random.choice(EXPONENTS)
        self.axis = np.array([*oracle.unit(random.normal(size=3)), outer, inner, exponent], np.float32)
        self.direction = np.array([*random.normal(size=3), random.uniform(0.2, 3)], np.float32)
        self.a = random.choice([0, 1e-30, 0.3, 1, 5, 1e30], 3).astype(np.float32)
        self.limits = np.sort(random.choice([-3.4e38, -0.5, 0, 0.2, 3.4e38], (3, 2))).astype(np.float32)
        self.incidence = random.uniform(0, 1, count).astype(np.float32)
        self.incidence[random.integers(0, count, 2)] = random.choice([0.0, 1.0, 1e-8], 2)
        self.cosine = random.uniform(-0.2, 1.0001, count).astype(np.float32)
        self.cosine[random.integers(0, count)] = random.choice([np.nan, 0.0, 1.0, 1e-39])
        self.exponent = random.choice(EXPONENTS, count).astype(np.float32)
        self.share = random.uniform(0, 1, MATERIALS * 4097).astype(np.float32)
        run = int(random.choice([1, 100, 500]))
        self.material = np.repeat(random.integers(0, MATERIALS, total), run)[:total].astype(np.int32)
        self.colour = random.uniform(0, 2, (int(random.integers(1, 5)), MATERIALS)).astype(np.float32)
        self.peak = self.colour.max(axis=0)
        self.row = self.factor = random.uniform(0, 1, count).astype(np.float32)
        self.out = random.uniform(0, 1, (len(self.colour), total)).astype(np.float32)
        self.top = random.uniform(0, 1, count).astype(np.float32)


ARGUMENTS = {
    "sharpen": "incidence cosine exponent row",
    "facing": "start normal direction cosine",
    "incidence": "start position normal light cosine",
    "halfway": "start position normal light eye cosine",
    "mirrored": "start position normal light eye cosine",
    "reflect": "start incidence material share row",
    "attenuate": "start position light a factor",
    "cone": "start position light axis factor",
    "off_axis": "start position light axis cosine",
    "flaps": "start position limits factor",
    "add": "start material colour row out",
    "add_clamped": "start material colour row out",
    "largest": "start material peak row top",
}


@pytest.mark.parametrize("name", ARGUMENTS)
@given(seed=SEEDS)
@settings(max_examples=40, deadline=None)
def test_a_kernel_is_its_twin(name, seed):
    samples = Samples(seed)
    arguments = [getattr(samples, key) for key in ARGUMENTS[name].split()]
    ours, twins = arguments[-1].copy(), arguments[-1].copy()
    before = [np.copy(a) for a in arguments[:-1]]
    with np.errstate(all="ignore"):
        getattr(kernels, name)(*arguments[:-1], ours)
        getattr(oracle, name)(*arguments[:-1], twins)
    np.testing.assert_array_equal(ours.view(np.int32), twins.view(np.int32))
    assert np.isfinite(ours).all()
    for now, then in zip(arguments[:-1], before, strict=True):
        np.testing.assert_array_equal(now, then)


def test_every_kernel_has_a_twin():
    made = {name for name, value in vars(kernels).items() if type(value).__name__ == "Kernel"}
    assert made == set(ARGUMENTS)


@pytest.mark.parametrize("name", ARGUMENTS)
def test_a_kernel_needs_no_numba_at_run_time(name):
    assert getattr(kernels, name).prepare() in ("cache", "compiled", "python")


def sharpened(cosine, exponent):
    cosine = np.asarray(cosine, np.float32)
    row = np.empty_like(cosine)
    exponents = np.full_like(cosine, min(exponent, 3.4e38))
    with np.errstate(all="ignore"):
        kernels.sharpen(np.ones_like(cosine), cosine, exponents, row)
    return row


@pytest.mark.parametrize("n", [0, 1e-6, 0.1, 0.5, 1, 2, 3.7, 10, 50, 333, 1e3, 1e4, 1e6, 1e9, 1e12])
def test_the_power_is_within_its_bound(n):
    # Where x^n is seen at all: near 1 in steps of float32, and over all magnitudes.
    near = (np.float32(1).view(np.int32) - np.arange(100_000, dtype=np.int32)).view(np.float32)
    cosines = np.concatenate([near, np.linspace(1e-7, 1, 100_001), np.geomspace(1e-37, 1, 50_000)])
    cosines = cosines.astype(np.float32)
    exact = cosines.astype(np.float64) ** np.float64(n)
    assert np.abs(sharpened(cosines, n) - exact).max() <= 1e-7


def test_powers_that_are_exact():
    assert sharpened([1.0], 1e12) == 1
    assert sharpened([np.nextafter(np.float32(1), np.float32(0))], 1e12) == 0
    np.testing.assert_array_equal(sharpened([1.0, 0.9999999, 0.5, 0.0], np.inf), [1, 0, 0, 0])
    # 0⁰: no cosine, no highlight; and a cosine that rounding has put above 1 is 1.
    np.testing.assert_array_equal(sharpened([1e-30, 0.5, 0.0, -0.5, np.nan], 0), [1, 1, 0, 0, 0])
    np.testing.assert_array_equal(sharpened([1.0000001, 1.5], 1e12), [1, 1])
    np.testing.assert_array_equal(sharpened([-1e-9, -1.0], 30.5), [0, 0])


def test_the_power_never_rises_with_a_smaller_cosine():
    cosines = np.sort(np.random.default_rng(4).uniform(0, 1, 20_000).astype(np.float32))
    for n in (0.5, 7, 100):  # up to the rounding of one place
        assert (np.diff(sharpened(cosines, n)) >= -1.2e-7).all()
