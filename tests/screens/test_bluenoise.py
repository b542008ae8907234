"""Void-and-cluster against its slow twin, the mask that ships, and its quality."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halftone import Ordered, UsageError, dither
from halftone.screens import _screen_kernels
from halftone.screens.bluenoise import (
    SHIPPED,
    SIGMA,
    blue_noise,
    blue_noise_ranks,
    digest,
    gaussian,
    shipped,
    shuffled,
)
from tests.oracle import screens as oracle
from tests.strategies import ladders

GOLDEN = {
    (64, 64, 0, 1.5): "0eebdbf375145d8fc873dc7e1afd13f21a9cc25965d44a8df797d8016bb76d6e",
    (23, 40, 7, 1.9): "ed63afdb8ba3b4bf793c1233cd89303c07fbd578dd0be4000d7f557635ed7004",
    (256, 256, 0, 1.5): "f4462f8fcaad299b685d116e4f9bca94fb8572d40b97f4870e411b4d98b32417",
}

sizes = st.tuples(st.integers(1, 9), st.integers(1, 9))
sigmas = st.sampled_from([0.5, 1.0, 1.5, 1.9, 4.0])


@settings(max_examples=30)
@given(sizes, st.integers(0, 2**64 - 1), sigmas)
def test_equals_its_twin(size, seed, sigma):
    assert blue_noise_ranks(*size, seed, sigma).tolist() == oracle.blue_noise(*size, seed, sigma)


@pytest.mark.parametrize("size", [(1, 1), (1, 2), (2, 1), (1, 40), (37, 1), (13, 21), (40, 5)])
def test_every_rank_once_at_any_size(size):
    ranks = blue_noise_ranks(*size, seed=1)
    assert ranks.shape == size
    assert np.sort(ranks.ravel()).tolist() == list(range(ranks.size))


def test_wide_tiles_equal_their_twin():
    """A reach shorter than the tile on one side, longer on the other."""
    assert blue_noise_ranks(2, 60, 3, 0.6).tolist() == oracle.blue_noise(2, 60, 3, 0.6)
    assert blue_noise_ranks(61, 2, 3, 0.6).tolist() == oracle.blue_noise(61, 2, 3, 0.6)


def test_the_plain_kernel_equals_the_compiled_one(monkeypatch):
    compiled = blue_noise_ranks(17, 12, 5)
    monkeypatch.setattr(_screen_kernels, "toggle_extremes", _screen_kernels.toggle_extremes.python)
    np.testing.assert_array_equal(blue_noise_ranks(17, 12, 5), compiled)


def test_phases_two_and_three_are_one():
    """Holes as the minority, as Ulichney has it, come in the order in which voids are filled."""
    ranks = blue_noise_ranks(9, 8, 2)
    expected = np.argsort(ranks.ravel())[ranks.size // 2 :].tolist()
    assert oracle.holes_as_minority(ranks, SIGMA) == expected


def test_gaussian_equals_its_twin():
    table, reach = gaussian(20, 70, 1.5)
    for (y, x), value in np.ndenumerate(table):
        assert value == oracle.gauss(y, x, 20, 70, 1.5)
        if value:
            assert min(y, 20 - y) <= reach[0]
            assert min(x, 70 - x) <= reach[1]
    assert shuffled(50, 9).tolist() == oracle.first_pattern(50, 9)


@pytest.mark.parametrize("made", GOLDEN, ids=str)
def test_golden(made):
    assert digest(blue_noise_ranks(*made)) == GOLDEN[made]


def test_the_mask_that_ships():
    with np.load(SHIPPED) as stored:
        assert stored["ranks"].dtype == np.uint16
        assert int(stored["seed"]) == 0
        assert float(stored["sigma"]) == SIGMA
        assert str(stored["sha256"]) == digest(stored["ranks"]) == GOLDEN[256, 256, 0, 1.5]
    screen = blue_noise()
    assert (screen.name, screen.tones, screen.thresholds.shape) == ("blue-noise", 65537, (256, 256))
    np.testing.assert_array_equal(np.floor(screen.thresholds * 65536), shipped())


def test_names():
    assert blue_noise(8, 6).name == "blue-noise:6x8"
    assert blue_noise(8, 8, 3, 1.9).name == "blue-noise:8x8:seed=3:sigma=1.9"
    assert blue_noise(8, 8, 3) != blue_noise(8, 8, 4)


@pytest.mark.parametrize("levels", [2, [0.1, 0.35, 0.5, 0.9]])
def test_codes_equal_their_light(levels):
    """65,536 thresholds are all told apart, also where a table of codes stands in for the light."""
    codes = np.tile(np.arange(256, dtype=np.uint8), (64, 4))
    light = (np.arange(256) / 255).astype(np.float32)[codes]
    by_code = dither(codes, Ordered(blue_noise()), levels=levels, encoding="linear")
    by_light = dither(light, Ordered(blue_noise()), levels=levels)
    np.testing.assert_array_equal(by_code, by_light)
    assert (np.asarray(by_code)[:, 255] == np.asarray(by_code).max()).all()


@pytest.fixture(scope="module")
def patches():
    """Flat patches of 512² at the levels 4 … 251 of 255, in steps that keep the test short."""
    tile = np.tile(blue_noise().thresholds, (2, 2))
    return {level: level / 255 > tile for level in (*range(4, 252, 9), 127, 128, 200, 251)}


def test_tonal_peak(patches):
    """Largest mean periodogram of 16 windows of 128², over g(1 − g): no line stands out."""
    for level, patch in patches.items():
        g = level / 255
        windows = patch.astype(float).reshape(4, 128, 4, 128).swapaxes(1, 2).reshape(16, 128, 128)
        windows = windows - windows.mean(axis=(1, 2), keepdims=True)
        power = (np.abs(np.fft.fft2(windows)) ** 2 / 128**2).mean(axis=0) / (g * (1 - g))
        assert power.max() < 10, level


def test_little_power_at_low_frequencies(patches):
    """Below a quarter of the principal frequency √g there is a tenth of white noise's power."""
    f = np.hypot(*np.meshgrid(np.fft.fftfreq(512), np.fft.fftfreq(512)))
    for level in (13, 31, 67, 128, 200):
        patch, g = patches[level], level / 255
        power = np.abs(np.fft.fft2(patch - patch.mean())) ** 2 / patch.size / (g * (1 - g))
        assert power[(f > 0) & (f < np.sqrt(min(g, 1 - g)) / 4)].mean() < 0.1


def test_dots_keep_apart():
    """Nearest dots at sparse tones, as a share of the mean distance: none touches another."""
    ranks = shipped().astype(int)
    for count in (65, 257, 1028):
        y, x = np.nonzero(ranks < count)
        dy = np.abs(y[:, None] - y)
        dx = np.abs(x[:, None] - x)
        apart = np.hypot(np.minimum(dy, 256 - dy), np.minimum(dx, 256 - dx))
        np.fill_diagonal(apart, 999)
        assert apart.min() > 0.6 * 256 / np.sqrt(count)


EYE = np.array([
    [-0.001743412, 0.001445723, 0.007113962, 0.008826460, 0.006254165, -0.000353216, -0.003116813],
    [0.000833244, 0.009929635, 0.023728512, 0.029311034, 0.022933593, 0.009711988, 0.000118289],
    [0.005842017, 0.023691596, 0.048267152, 0.059043883, 0.046412889, 0.023315857, 0.005651780],
    [0.009138026, 0.032894130, 0.064200407, 0.078773930, 0.060303292, 0.029523382, 0.007565880],
    [0.007942508, 0.028669495, 0.053826022, 0.065024427, 0.050496807, 0.023933323, 0.005585837],
    [0.002404652, 0.014542416, 0.029730907, 0.035492112, 0.027318902, 0.011351292, 0.001239805],
    [-0.001666554, 0.002380156, 0.009867343, 0.012292728, 0.009216210, 0.002268413, -0.001534185],
])  # fmt: skip
"""The 7 × 7 least-mean-squares filter of the papers of Guo and Liu (2009), customary for HPSNR."""


def test_photograph(camera):
    """At least 31.4 dB HPSNR: codes taken as light, the error correlated, borders mirrored."""
    light = (camera / np.float32(255)).astype(np.float32)
    error = np.pad(dither(light, Ordered(blue_noise())).luminance - camera / 255, 3, mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(error, (7, 7))
    seen = np.einsum("yxij,ij->yx", windows, EYE)
    assert -10 * np.log10((seen**2).mean()) > 31.4


@pytest.mark.parametrize(
    "bad",
    [(0, 4), (4, 513), (2.5, 4), (True, 4), (4, 4, -1), (4, 4, 2**64), (4, 4, 0, 0.4), (4, 4, 0, 9)],
    ids=str,
)
def test_refused(bad):
    with pytest.raises(UsageError, match="allowed"):
        blue_noise_ranks(*bad)
    with pytest.raises(UsageError, match="allowed"):
        blue_noise(*bad)


@given(
    st.sampled_from([(16, 16, 0), (5, 9, 3), (1, 7, 0), (1, 1, 0)]), ladders(), st.integers(0, 2**32 - 1)
)
def test_tones_are_exact_on_whole_tiles(made, levels, seed):
    """k pixels of n show the upper of two neighbouring levels where the light is k/n between them."""
    screen = blue_noise(*made)
    n = screen.thresholds.size
    random = np.random.default_rng(seed)
    distinct = np.unique(np.float32(levels)).astype(np.float64)
    i, k = int(random.integers(distinct.size - 1)), int(random.integers(n + 1))
    light = np.float32(distinct[i] + (distinct[i + 1] - distinct[i]) * k / n)
    if distinct[i + 1] - distinct[i] > 1e-3:  # closer levels leave float32 no room for the tones
        patch = np.full(screen.thresholds.shape, light, np.float32)
        shown = dither(patch, Ordered(screen), levels=levels).luminance.astype(np.float64)
        assert (shown > distinct[i]).sum() == k
        assert set(np.unique(shown)) <= set(distinct[i : i + 2])


def test_the_shipped_mask_has_all_its_tones():
    light = np.repeat(np.float32([0, 1, 2, 32767, 32768, 65535, 65536]) / np.float32(65536), 256)
    patches = np.tile(light, (256, 1))
    lit = np.asarray(dither(patches, Ordered(blue_noise()))).reshape(256, 7, 256).sum(axis=(0, 2))
    assert lit.tolist() == [0, 1, 2, 32767, 32768, 65535, 65536]
