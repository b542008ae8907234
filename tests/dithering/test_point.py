"""Ordered dither, noise, threshold and nearest level against their slow twins."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halftone import Ordered, Screen, UsageError, dither
from halftone._arrays import Source
from halftone.dithering.base import Job
from halftone.dithering.noise import uniform_noise
from halftone.dithering.threshold import otsu
from halftone.screens import bayer, from_ranks
from halftone.screens.bayer import bayer_ranks
from halftone.screens.order import Tiling
from halftone.tone.levels import Levels
from tests.oracle import point as oracle
from tests.strategies import ladders, light


@pytest.mark.parametrize("n", [2, 4, 8, 16, 32])
def test_bayer_ranks(n):
    assert bayer_ranks(n).tolist() == oracle.bayer(n)


def test_bayer_2_and_4_as_printed():
    assert bayer_ranks(2).tolist() == [[3, 1], [0, 2]]
    assert bayer_ranks(4).tolist() == [[15, 7, 13, 5], [3, 11, 1, 9], [12, 4, 14, 6], [0, 8, 2, 10]]


def test_thresholds_are_between_the_tones():
    for n in (2, 4, 8, 16):
        array = np.sort(bayer(n).thresholds.ravel())
        np.testing.assert_array_equal(array, ((np.arange(n * n) + 0.5) / (n * n)).astype(np.float32))
        assert bayer(n).tones == n * n + 1


@given(light(-0.2, 1.2), ladders(), st.sampled_from([2, 4, 8, 16]))
def test_ordered_equals_its_twin(picture, levels, n):
    expected = oracle.step_up(picture, bayer(n).thresholds, np.float32(levels))
    np.testing.assert_array_equal(dither(picture, f"bayer{n}", levels=levels), expected)


@given(light(), ladders(), st.integers(1, 7), st.integers(1, 7), st.integers(0, 99))
def test_any_screen(picture, levels, h, w, seed):
    tile = np.random.default_rng(seed).uniform(0.001, 0.999, (h, w)).astype(np.float32)
    frame = dither(picture, Ordered(Screen(tile, "own")), levels=levels)
    np.testing.assert_array_equal(frame, oracle.step_up(picture, tile, np.float32(levels)))


@given(
    st.integers(0, 2**32 - 1),
    ladders(),
    st.sampled_from(["bayer2", "bayer8", "bayer4:strength=0.5", "none", "random:seed=3"]),
    st.sampled_from(["srgb", "linear", "gamma:2.2", "bt709", "gamma:0.1", "gamma:10"]),
    st.sampled_from([np.uint8, np.uint16]),
)
def test_codes_equal_their_light(seed, levels, method, encoding, dtype):
    """Thresholds encoded as codes give what the decoded picture gives, bit for bit."""
    random = np.random.default_rng(seed)
    codes = random.integers(0, np.iinfo(dtype).max, (24, 31), dtype, endpoint=True)
    table = dither_table(encoding, np.iinfo(dtype).max + 1)
    by_code = dither(codes, method, levels=levels, encoding=encoding)
    by_light = dither(table[codes], method, levels=levels)
    np.testing.assert_array_equal(by_code, by_light)


def dither_table(encoding: str, size: int) -> np.ndarray:
    from halftone.tone import encoding as find

    return find(encoding).table(size)


def test_all_codes_of_two_levels(camera):
    codes = np.tile(np.arange(256, dtype=np.uint8), (32, 2))
    for encoding in ("srgb", "linear"):
        for levels in (2, [0.02, 0.9], [0.3, 0.3, 0.7]):
            by_light = dither(dither_table(encoding, 256)[codes], "bayer16", levels=levels)
            by_code = dither(codes, "bayer16", levels=levels, encoding=encoding)
            np.testing.assert_array_equal(by_code, by_light)


@given(light(), ladders(), st.sampled_from(["uniform", "triangular"]), st.integers(0, 2**64 - 1))
def test_random_equals_its_twin(picture, levels, shape, seed):
    height, width = picture.shape
    threshold = np.array(
        [[oracle.noise(seed, y, x) for x in range(width)] for y in range(height)], np.float32
    )
    if shape == "triangular":
        other = seed ^ (2**64 - 1)
        second = [[oracle.noise(other, y, x) for x in range(width)] for y in range(height)]
        threshold = (threshold + np.float32(second)) / np.float32(2)
    expected = oracle.step_up(picture, threshold, np.float32(levels))
    frame = dither(picture, f"random:{shape}", levels=levels, seed=seed)
    np.testing.assert_array_equal(frame, expected)


@pytest.mark.parametrize("shape", [(1, 1), (5, 9000), (2, 33000), (40000, 1)])
def test_noise_is_the_same_in_parts(shape):
    """Rows are mixed some at a time: at the seams too, the numbers are those of the twin."""
    noise = uniform_noise(2**64 - 1, 3, 3 + shape[0], shape[1])
    assert noise.shape == shape
    rows = {0, shape[0] // 2, shape[0] - 1}
    for y in rows:
        for x in {*range(0, shape[1], 61), shape[1] - 1}:
            assert noise[y, x] == np.float32(oracle.noise(2**64 - 1, 3 + y, x))


@given(
    st.integers(0, 2**32 - 1), st.sampled_from([np.uint8, np.uint16]), st.integers(1, 9),
    st.sampled_from([1.0, 0.3, 0.0]), st.sampled_from(["rising", "falling", "any", "bright"]),
)  # fmt: skip
def test_any_table_of_light(seed, dtype, height, strength, kind):
    """Also one that falls with the code, and one whose darkest light passes thresholds."""
    random = np.random.default_rng(seed)
    size = np.iinfo(dtype).max + 1
    table = np.sort(random.random(size, np.float32))
    if kind == "falling":
        table = table[::-1].copy()
    elif kind == "any":
        random.shuffle(table)
    elif kind == "bright":
        table = (table + 1) / 2
    codes = random.integers(0, size, (3 * height, random.integers(1, 40)), dtype)
    tile = random.uniform(0.001, 0.999, random.integers(1, 9, 2)).astype(np.float32)
    for levels in ([0, 1], [0, 0, 1], [0, 0.2, 0.3, 1]):
        ladder = Levels.of(levels)
        halftoner = Ordered(Screen(tile, "own"), strength).halftoner(Job(Source(codes, table), ladder))
        out = np.empty(codes.shape, np.uint8)
        for start in range(0, len(codes), height):
            halftoner.band(start, start + height, out[start : start + height])
        half = np.float32(0.5)
        drawn = half + np.float32(strength) * (tile - half)
        np.testing.assert_array_equal(out, oracle.step_up(table[codes], drawn, np.float32(levels)))


@given(st.integers(1, 9), st.integers(1, 9), st.integers(1, 3), st.integers(0, 99))
def test_ranks_of_a_screen(h, w, times, seed):
    """Known from the start or found by sorting: the same, and it gives the thresholds again."""
    ranks = np.random.default_rng(seed).permutation(np.arange(h * w * times) // times)
    known = from_ranks(ranks.reshape(h * times, w), "known")
    sorted_ = Screen(known.thresholds, "sorted")
    for found in (known.ranked, sorted_.ranked):
        np.testing.assert_array_equal(found[0], np.unique(known.thresholds))
        np.testing.assert_array_equal(found[0][found[1]], known.thresholds)
    assert known.tones == sorted_.tones == h * w + 1


@given(st.integers(1, 300), st.integers(1, 12), st.integers(1, 12), st.integers(1, 99), st.data())
def test_tiling_repeats_its_tile(height, h, w, width, data):
    tile = np.arange(h * w, dtype=np.uint32).reshape(h, w)
    made = Tiling(tile, height, width)
    y = data.draw(st.integers(0, height - 1))
    count = data.draw(st.integers(1, height - y))
    expected = [[(r % h) * w + c % w for c in range(width)] for r in range(y, y + count)]
    assert made.rows(y, count).tolist() == expected


def test_a_tiling_of_any_size():
    """Beyond 16 MiB it is made band by band."""
    tile = np.arange(4096, dtype=np.uint32).reshape(1024, 4)
    small, large = Tiling(tile, 2000, 8), Tiling(tile, 2000, 5000)
    assert small.block.size > 0
    assert large.block.size == 0
    for start, count in ((0, 3), (1020, 9), (1990, 10)):
        np.testing.assert_array_equal(large.rows(start, count)[:, :8], small.rows(start, count))


def test_noise_is_uniform_and_uncorrelated():
    noise = uniform_noise(7, 0, 512, 512)
    assert noise.min() > 0
    assert noise.max() < 1
    counts = np.bincount((noise * 64).astype(int).ravel(), minlength=64)
    expected = noise.size / 64
    chi2 = ((counts - expected) ** 2 / expected).sum()
    assert chi2 < 126  # 63 degrees of freedom, p = 4e-6
    centred = noise - noise.mean()
    for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
        product = (centred * np.roll(centred, (dy, dx), (0, 1))).mean() / centred.var()
        assert abs(product) < 5 / 512  # five standard deviations
    other = uniform_noise(8, 0, 512, 512)
    assert abs(((other - 0.5) * (noise - 0.5)).mean() / noise.var()) < 5 / 512


def test_noise_softens_contours_and_keeps_the_mean():
    """Rows of a ramp on 4 levels: without noise 3 sharp contours, with it none."""
    ramp = np.tile(np.linspace(0, 1, 1024, dtype=np.float32), (256, 1))
    levels = "uniform-linear:4"
    steps = np.abs(np.diff(dither(ramp, "none", levels=levels).luminance.mean(axis=0)))
    softened = np.abs(np.diff(dither(ramp, "random", levels=levels).luminance.mean(axis=0)))
    assert np.sum(steps > 0.3) == 3
    assert softened.max() < 0.1
    assert abs(dither(ramp, "random", levels=levels).luminance.mean() - 0.5) < 0.003


@given(light(), ladders())
def test_none_is_the_nearest_level(picture, levels):
    chosen = dither(picture, "none", levels=levels).luminance.astype(np.float64)
    values = np.float32(levels).astype(np.float64)
    clipped = np.clip(picture, values.min(), values.max()).astype(np.float64)
    best = np.abs(clipped[..., None] - values).min(axis=-1)
    assert (np.abs(clipped - chosen) <= best + 6e-8).all()


def test_none_by_ratio():
    levels = [0.01, 0.1, 1.0]
    picture = np.float32([[0.0315, 0.0317, 0.315, 0.317, 0.04, 0.5]])
    # borders at the geometric means 0.0316… and 0.316…
    assert dither(picture, "none:ratio", levels=levels).indices.tolist() == [[0, 1, 1, 2, 1, 2]]
    assert dither(picture, "none", levels=levels).indices.tolist() == [[0, 0, 1, 1, 0, 1]]
    with pytest.raises(UsageError, match="above 0"):
        dither(picture, "none:ratio", levels=2)


def test_threshold_is_a_share_of_the_step():
    picture = np.float32([[0.2, 0.3, 0.5, 0.55, 0.8]])
    assert dither(picture, "threshold:0.5", levels=[0.2, 0.8]).indices.tolist() == [[0, 0, 0, 1, 1]]
    codes = np.arange(256, dtype=np.uint8)[None]
    assert dither(codes, "threshold").indices.sum() == 128  # codes 128 … 255
    with pytest.raises(UsageError, match="two levels"):
        dither(picture, "threshold", levels=3)
    for bad in ("threshold:0", "threshold:1", "threshold:x", "threshold:-1"):
        with pytest.raises(UsageError):
            dither(picture, bad)


@given(st.lists(st.integers(0, 50), min_size=8, max_size=8))
def test_otsu_equals_its_twin(counts):
    if sum(counts):
        assert otsu(np.array(counts)) == oracle.otsu(counts)


@pytest.mark.parametrize("name", ["camera", "coins", "page", "text", "moon"])
def test_otsu_agrees_with_scikit_image(name):
    from skimage import data, filters

    picture = np.asarray(getattr(data, name)())
    expected = picture > filters.threshold_otsu(picture)
    np.testing.assert_array_equal(dither(picture, "otsu").indices, expected)
    assert dither(picture, "threshold:otsu").method == "threshold:otsu"


def test_screens_that_are_none():
    for bad in ([[0.0, 0.5]], [[0.5, 1.0]], [[np.nan]], [0.5], np.zeros((0, 2))):
        with pytest.raises(UsageError):
            Screen(np.array(bad, np.float32), "bad")
    for bad in ([[0, 1], [2, 4]], [[0, 0], [1, 2]], [[1, 2], [3, 4]], [1, 2]):
        with pytest.raises(UsageError, match="rank"):
            from_ranks(np.array(bad), "bad")
    for n in (0, 1, 3, 512):
        with pytest.raises(UsageError):
            bayer_ranks(n)
