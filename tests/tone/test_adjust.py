"""Brightness, contrast, negative, auto-levels: twins, fixed points, bounds, extremes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from halftone._arrays import BAND_ROWS, Source
from halftone.errors import UsageError
from halftone.tone import encoding
from halftone.tone.adjust import auto_levels, brightness, contrast, invert, light_histogram
from tests.oracle import tone as oracle
from tests.strategies import light

ROUNDED = 2.0**-24 * (1 + 2.0**-20)
"""Relative error of one rounding to float32 of a value that is right to many more bits."""

LEAST = 2.0**-149
"""The smallest float32 above 0: results below 2^-126 are rounded to its multiples."""

TOP = np.finfo(np.float32).max
SRGB = encoding("srgb").table(256)

amounts = st.one_of(st.sampled_from([-1.0, -0.5, 0.0, 0.5, 1.0]), st.floats(-1, 1))
lights = arrays(
    np.float32, st.integers(1, 60), elements=st.floats(-4, 2.0**99, width=32), fill=st.nothing()
)


def applied(step, values) -> np.ndarray:
    """The step's result, of an array that it cannot write to."""
    array = np.array(values, np.float32)
    array.flags.writeable = False
    result = step(array)
    assert result.dtype == np.float32
    assert result.shape == array.shape
    return result


# --- brightness, contrast, invert


@given(lights, amounts)
def test_brightness_equals_its_twin(values, amount):
    expected = [oracle.brightness(float(v), amount) for v in values]
    # the factor may be rounded to float32 before the product is
    np.testing.assert_allclose(
        applied(brightness(amount), values), expected, rtol=2 * ROUNDED, atol=LEAST
    )


@given(lights, amounts)
def test_contrast_equals_its_twin(values, amount):
    expected = [min(oracle.contrast(float(v), amount), float(TOP)) for v in values]
    np.testing.assert_allclose(applied(contrast(amount), values), expected, rtol=ROUNDED, atol=LEAST / 2)


@given(lights)
def test_invert_equals_its_twin(values):
    expected = [oracle.single(1 - float(v)) for v in values]
    np.testing.assert_array_equal(applied(invert(), values), expected)


def test_known_points():
    assert applied(brightness(1), [0, 0.1, 0.25]).tolist() == [0, np.float32(0.1) * 4, 1]
    assert applied(brightness(-0.5), [0, 0.5, 1]).tolist() == [0, 0.25, 0.5]
    # 0.18 · (0.36/0.18)^4 = 2.88 and 0.18 · (0.72/0.18)^(1/2) = 0.36
    hard, flat = applied(contrast(1), [0.18, 0.36]), applied(contrast(-0.5), [0.18, 0.72])
    np.testing.assert_allclose(hard, [0.18, 2.88], rtol=5 * ROUNDED)  # the input is rounded, ^4
    np.testing.assert_allclose(flat, [0.18, 0.36], rtol=2 * ROUNDED)
    assert applied(invert(), [0, 0.25, 1, 2]).tolist() == [1, 0.75, 0, -1]


@given(amounts)
def test_black_stays_black(amount):
    for step in (brightness(amount), contrast(amount)):
        assert applied(step, [0, 0]).tolist() == [0, 0]


@given(lights)
def test_an_amount_of_0_changes_nothing(values):
    np.testing.assert_array_equal(applied(brightness(0), values), values)
    values = np.maximum(values, 0)
    np.testing.assert_array_equal(applied(contrast(0), values), values)


@given(lights, amounts)
def test_brighter_light_never_becomes_darker(values, amount):
    values = np.sort(values)
    assert (np.diff(applied(brightness(amount), values)) >= 0).all()
    assert (np.diff(applied(contrast(amount), values)) >= 0).all()
    assert (np.diff(applied(invert(), values)) <= 0).all()


@given(st.floats(0, 1, width=32))
def test_inverting_twice_gives_the_light_back(value):
    twice = applied(invert(), applied(invert(), [value]))
    # 1 − v is at most 1, so it is rounded to 2^-25; the second difference rounds no more
    assert abs(float(twice[0]) - value) <= 2.0**-25


@pytest.mark.parametrize("step", [brightness, contrast])
@pytest.mark.parametrize("amount", [-1.0001, 1.0001, 2, math.nan, math.inf, -math.inf])
def test_amounts_out_of_bounds_are_refused(step, amount):
    message = rf"{step.__name__}={amount!r}; allowed: -1 … 1, where 0 changes nothing"
    with pytest.raises(UsageError, match=message):
        step(amount)


@pytest.mark.parametrize(
    "step",
    [brightness(1), brightness(-1), contrast(1), contrast(-1), invert()],
    ids=["brighter", "darker", "hard", "flat", "negative"],
)
def test_the_largest_light_stays_finite(step):
    # nonfinite="clip" puts this light in the place of infinity
    assert np.isfinite(applied(step, [-TOP, -1, 0, LEAST, 1, TOP])).all()


# --- histogram


@pytest.mark.parametrize("name", ["srgb", "bt709", "linear", "gamma:2.2"])
@given(st.integers(0, 2**32 - 1))
def test_histograms_of_codes_and_of_light_agree(name, seed):
    codes = np.random.default_rng(seed).integers(0, 256, (BAND_ROWS + 7, 5)).astype(np.uint8)
    table = encoding(name).table(256)
    coded, plain = Source(codes, table), Source(table[codes])
    counts = light_histogram(coded)
    assert counts.shape == (256,)
    assert counts.sum() == codes.size
    np.testing.assert_array_equal(counts, light_histogram(plain))
    if name == "srgb":
        np.testing.assert_array_equal(counts, np.bincount(codes.ravel(), minlength=256))
    steps = (brightness(0.3), contrast(-0.2), invert())
    np.testing.assert_array_equal(
        light_histogram(coded.then(*steps)), light_histogram(plain.then(*steps))
    )


def test_histograms_of_16_bit_codes_and_of_neutral_colour_agree():
    codes = np.arange(65536, dtype=np.uint16).reshape(256, 256)
    table = encoding("srgb").table(65536)
    counts = light_histogram(Source(codes, table))
    np.testing.assert_array_equal(counts, light_histogram(Source(table[codes])))
    # 257 16-bit codes lie nearest to an 8-bit one, half as many to the ends
    assert counts.tolist() == [129, *[257] * 254, 129]
    grey = np.arange(256, dtype=np.uint8).reshape(16, 16)
    colour = Source(np.repeat(grey[:, :, None], 3, axis=2), SRGB)
    assert light_histogram(colour).tolist() == [1] * 256


@given(light(-0.5, 1.5))
def test_histogram_equals_its_twin(picture):
    assert light_histogram(Source(picture)).tolist() == oracle.histogram(picture.ravel().tolist())


def test_histogram_borders_are_halfway_between_codes():
    for k in range(255):
        border = np.float32(oracle.srgb_to_light((k + 0.5) / 255))
        for factor, code in ((1 - 2.0**-22, k), (1 + 2.0**-22, k + 1)):
            counts = light_histogram(Source(np.full((1, 1), border * np.float32(factor))))
            assert np.flatnonzero(counts).tolist() == [code]


# --- auto-levels


@given(light(-0.1, 1.3))
def test_auto_levels_equal_their_twin(picture):
    picture.flags.writeable = False
    source = Source(picture)
    result = source.then(auto_levels(source)).band(0, picture.shape[0])
    # differences and a quotient of float64, rounded once: the same on every machine
    np.testing.assert_array_equal(result.ravel(), oracle.auto_levels(picture.ravel().tolist()))


@given(st.floats(-1, 4, width=32), st.integers(1, 100), st.integers(1, 5))
def test_a_single_tone_is_left_as_it_is(value, height, width):
    picture = np.full((height, width), value, np.float32)
    source = Source(picture)
    np.testing.assert_array_equal(source.then(auto_levels(source)).band(0, height), picture)


def outliers(count: int) -> np.ndarray:
    """1000 codes, 40 … 200 and plenty of both, but *count* of 10 and as many of 250."""
    codes = np.linspace(40, 200, 1000).round().astype(np.uint8)
    codes[:20], codes[-20:] = 40, 200
    codes[:count], codes[1000 - count :] = 10, 250
    return codes.reshape(100, 10)


@pytest.mark.parametrize(("count", "black", "white"), [(0, 40, 200), (5, 40, 200), (6, 10, 250)])
def test_half_a_percent_at_either_end_is_given_up(count, black, white):
    codes = outliers(count)
    source = Source(codes, SRGB)
    result = source.then(auto_levels(source)).band(0, 100)
    assert (result[codes == black] == 0).all()
    assert (result[codes == white] == 1).all()
    assert (result < 0).sum() == (codes < black).sum()
    assert (result > 1).sum() == (codes > white).sum()
    np.testing.assert_array_equal(source.then(auto_levels(Source(SRGB[codes]))).band(0, 100), result)


@given(st.integers(0, 2**32 - 1), st.integers(1, 900), st.integers(1, 256))
def test_the_ends_are_order_statistics_of_the_picture(seed, pixels, tones):
    codes = np.random.default_rng(seed).integers(0, tones, (pixels, 1)).astype(np.uint8)
    source = Source(codes, SRGB)
    result = source.then(auto_levels(source)).band(0, pixels)
    cut = pixels // 200  # 0.5 % of the pixels, at most, become darker than black
    ascending = np.sort(codes, axis=None)
    black, white = SRGB[ascending[cut]].astype(float), SRGB[ascending[-1 - cut]].astype(float)
    expected = SRGB[codes] if black == white else (SRGB[codes] - black) / (white - black)
    np.testing.assert_array_equal(result, expected.astype(np.float32))
    assert (np.diff(result.ravel()[np.argsort(codes, axis=None)]) >= 0).all()


def test_auto_levels_of_the_largest_light_stay_finite():
    picture = np.zeros((400, 1), np.float32)
    picture[:200] = SRGB[1]  # black is code 0, white code 1: a stretch by 3294
    picture[0], picture[1] = TOP, -TOP
    source = Source(picture)
    assert np.isfinite(source.then(auto_levels(source)).band(0, 400)).all()
