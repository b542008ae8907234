"""The instruments against closed forms, independent computations and published figures."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from halftone import InputError, dither
from halftone.metrics import hpsnr, periodogram, psnr, tonal_peak
from halftone.vision import lms7, seen


def test_lms_sums_to_one():
    assert lms7().shape == (7, 7)
    assert lms7().sum() == pytest.approx(1, abs=2e-9)


@pytest.mark.parametrize("shape", [(9, 40), (4, 4), (64, 51)])
def test_seen_is_correlation_with_a_mirrored_border(shape):
    picture = np.random.default_rng(2).random(shape)
    kernel = lms7()
    np.testing.assert_allclose(seen(picture, kernel), ndimage.correlate(picture, kernel, mode="mirror"))


def test_psnr_of_a_known_error():
    assert psnr(np.full((5, 5), 0.6), np.full((5, 5), 0.5)) == pytest.approx(20)
    assert psnr(np.ones((2, 2)), np.ones((2, 2))) == float("inf")
    with pytest.raises(InputError):
        psnr(np.ones((2, 2)), np.ones((2, 3)))


def test_a_flat_error_passes_the_eye():
    assert hpsnr(np.full((20, 20), 0.6), np.full((20, 20), 0.5)) == pytest.approx(20, abs=1e-6)


def test_published_figures(camera):
    """display.md's table: float Floyd–Steinberg raster 36.7, serpentine 36.1, Bayer 31.5 dB."""
    codes = camera / 255
    for name, decibels in (("fs:raster", 36.7), ("fs", 36.1), ("bayer8", 31.5), ("atkinson", 23.4)):
        frame = dither(codes, name)
        assert hpsnr(frame.luminance, codes) == pytest.approx(decibels, abs=0.1), name


def test_white_noise_is_flat_and_a_checkerboard_is_one_line():
    noise = dither(np.full((512, 512), 0.5), "random").indices
    assert tonal_peak(noise, 0.5) < 4
    assert periodogram(noise).mean() == pytest.approx(0.25, rel=0.02)
    board = np.indices((512, 512)).sum(axis=0) % 2
    # all the power, 0.25 for each of 128² frequencies, in one of them
    assert tonal_peak(board, 0.5) == pytest.approx(128 * 128)


@pytest.mark.parametrize(
    ("name", "tone", "peak"),
    [
        ("fs:raster", 127, 13096),
        ("ostromoukhov", 127, 557),
        ("zhou-fang", 127, 3.9),
        ("fs:raster", 85, 3852),
    ],
)
def test_published_peaks(name, tone, peak):
    """display.md: measured with another implementation of the same definition."""
    dots = dither(np.full((512, 512), tone / 255), name).indices
    assert tonal_peak(dots, tone / 255) == pytest.approx(peak, rel=0.2)


def test_patches_that_are_too_small():
    with pytest.raises(InputError):
        periodogram(np.zeros((64, 512)))
    with pytest.raises(InputError):
        tonal_peak(np.zeros((128, 128)), 0)


def test_gates_of_our_own_screen_and_class_matrix(camera):
    """Every level is in the benchmark; here the worst ones found there, and some others."""
    codes = camera / 255
    assert hpsnr(dither(codes, "blue-noise").luminance, codes) >= 31.4
    assert hpsnr(dither(codes, "dots:64").luminance, codes) >= 34.5
    for tone in (4, 8, 32, 64, 85, 100, 127, 128, 170, 200, 247, 251):
        patch = np.full((512, 512), tone / 255, np.float32)
        assert tonal_peak(dither(patch, "blue-noise").indices, tone / 255) < 10, tone
        assert tonal_peak(dither(patch, "dots:64").indices, tone / 255) < 100, tone
