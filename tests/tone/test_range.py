"""Range rules: within the levels always, the identity inside, monotone, ratios kept."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from halftone._arrays import BAND_ROWS, Source
from halftone.errors import UsageError
from halftone.tone import Levels, encoding
from halftone.tone.range import RULES, bring_into_range, clip, compress, extremes, scale
from tests.oracle import tone as oracle

ROUNDED = 2.0**-24 * (1 + 2.0**-20)
"""Relative error of one rounding to float32 of a value that is right to many more bits."""

LEAST = 2.0**-149
"""The smallest float32 above 0: results below 2^-126 are rounded to its multiples."""

rules = st.sampled_from(sorted(RULES))
ends = st.tuples(st.sampled_from([0.0, 0.001, 0.02, 0.3]), st.sampled_from([0.5, 0.9, 1.0, 3.0])).map(
    lambda pair: (oracle.single(pair[0]), oracle.single(pair[1]))
)
everything = st.floats(-(2.0**99), 2.0**99, width=32)  # ±6e29
usual = st.floats(-0.5, 4, width=32)


def pictures(values: st.SearchStrategy) -> st.SearchStrategy:
    shapes = st.tuples(st.integers(1, 8), st.integers(1, 8))
    return arrays(np.float32, shapes, elements=values, fill=st.nothing())


def ranged(picture: np.ndarray, darkest: float, lightest: float, rule: str) -> np.ndarray:
    picture.flags.writeable = False  # a rule that wrote into it would fail
    return bring_into_range(Source(picture), darkest, lightest, rule).band(0, picture.shape[0])


@given(st.one_of(pictures(everything), pictures(usual)), ends, rules)
def test_the_result_is_within_the_levels(picture, levels, rule):
    result = ranged(picture, *levels, rule)
    assert result.dtype == np.float32
    assert result.shape == picture.shape
    assert result.min() >= levels[0]
    assert result.max() <= levels[1]


@given(ends, rules)
def test_the_largest_float32_is_within_the_levels(levels, rule):
    top = np.finfo(np.float32).max
    result = ranged(np.float32([[-top, 0, 1, top]]), *levels, rule)
    assert result[0, 0] == levels[0]
    assert result[0, -1] == levels[1]


@given(st.one_of(pictures(everything), pictures(usual)), ends, rules)
def test_every_rule_is_monotone(picture, levels, rule):
    result = ranged(np.sort(picture, axis=None)[None], *levels, rule)
    assert (np.diff(result) >= 0).all()


@given(pictures(usual), ends, rules)
def test_light_inside_stays_as_it_is(picture, levels, rule):
    low, high = levels
    picture = np.clip(picture, low, 0.8 * high if rule == "compress" else high)
    np.testing.assert_array_equal(ranged(picture, low, high, rule), picture)


@given(st.one_of(pictures(everything), pictures(usual)), ends)
def test_clip_equals_its_twin(picture, levels):
    expected = [oracle.clip(float(v), *levels) for v in picture.ravel()]
    np.testing.assert_array_equal(ranged(picture, *levels, "clip").ravel(), expected)


@given(st.one_of(pictures(everything), pictures(usual)), ends)
def test_scale_equals_its_twin(picture, levels):
    high = levels[1]
    brightest = max(float(picture.max()), high)
    expected = [oracle.clip(oracle.scale(float(v), brightest, high), *levels) for v in picture.flat]
    result = ranged(picture, *levels, "scale").ravel()
    np.testing.assert_allclose(result, expected, rtol=ROUNDED, atol=LEAST / 2)


@given(pictures(usual), ends)
def test_scale_brings_the_brightest_light_to_the_lightest_level(picture, levels):
    assume(picture.max() > levels[1])
    result = ranged(picture, *levels, "scale")
    assert (result[picture == picture.max()] == np.float32(levels[1])).all()


@given(pictures(st.floats(2.0**-10, 2.0**66, width=32)), ends)
def test_scale_keeps_ratios(picture, levels):
    result = ranged(picture, *levels, "scale").astype(np.float64)
    kept = (result > levels[0]) & (result > 2.0**-126)
    assume(kept.any())
    # each result is rounded once, and so is the one it is compared with
    ratios = result[kept] / result[kept].max()
    expected = picture[kept].astype(np.float64) / picture[kept].max()
    np.testing.assert_allclose(ratios, expected, rtol=2 * ROUNDED, atol=0)


@pytest.mark.parametrize("lightest", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("brightest", [0.9, 1.0, 1.1])
def test_scale_begins_just_above_the_lightest_level(lightest, brightest):
    picture = np.float32([[0.25, 0.5, brightest]]) * np.float32(lightest)
    result = ranged(picture, 0, lightest, "scale")
    expected = picture / max(1, float(np.float32(brightest)))
    np.testing.assert_allclose(result, expected, rtol=3 * ROUNDED)  # of picture, twin and result
    assert (result.max() == lightest) == (brightest >= 1)


def test_scale_looks_at_every_band():
    picture = np.full((3 * BAND_ROWS + 1, 2), 0.5, np.float32)
    picture[-1, 1] = 4
    assert extremes(Source(picture)) == (0.5, 4)
    result = bring_into_range(Source(picture), 0, 1, "scale").band(0, 1)
    assert result.tolist() == [[0.125, 0.125]]


def test_scale_looks_at_the_pixels_and_not_at_unused_codes():
    table = encoding("linear").table(256) * np.float32(4)
    codes = np.full((2, 2), 51, np.uint8)  # light 0.8; the unused codes reach 4
    result = bring_into_range(Source(codes, table), 0, 1, "scale").band(0, 2)
    assert (result == np.float32(0.8)).all()


@given(st.one_of(pictures(everything), pictures(usual)), ends)
def test_compress_equals_its_twin(picture, levels):
    low, high = levels
    expected = [oracle.clip(oracle.compress(float(v), high), low, high) for v in picture.flat]
    result = ranged(picture, *levels, "compress").ravel()
    np.testing.assert_allclose(result, expected, rtol=ROUNDED, atol=0)


@pytest.mark.parametrize("lightest", [0.9, 1.0, 2.0])
def test_compress_leaves_the_knee_smoothly_and_only_darkens(lightest):
    light = np.linspace(0, 3 * lightest, 4001, dtype=np.float32)
    result = compress(lightest)(light)
    assert (result <= light).all()
    # just above the knee, at t = 2^-9, the secant's slope is 1/(1 + t)
    light = np.float32([0.8 * lightest, 0.8 * lightest + 0.2 * lightest / 512])
    rise = np.diff(compress(lightest)(light).astype(float)) / np.diff(light.astype(float))
    # each end of the step, 4e-4 of the lightest, is rounded to 2^-24: 2e-4 each
    assert rise == pytest.approx(1 / (1 + 2.0**-9), abs=4e-4)


def test_compress_of_known_points():
    light = np.float32([-1, 0, 0.5, 0.8, 1, 1.2, 1.4, np.inf])
    expected = [-1, 0, 0.5, 0.8, 0.9, 0.8 + 0.2 * 2 / 3, 0.95, 1]
    np.testing.assert_allclose(compress(1)(light), expected, rtol=2 * ROUNDED)
    assert compress(1)(light)[-1] == 1


def test_steps_of_known_points():
    light = np.float32([-1, 0.25, 0.5, 2])
    assert clip(0.3, 0.9)(light).tolist() == [*np.float32([0.3, 0.3, 0.5, 0.9])]
    assert scale(0.5)(light).tolist() == [-0.5, 0.125, 0.25, 1]


@pytest.mark.parametrize("rule", sorted(RULES))
@pytest.mark.parametrize("levels", ["log:0.02:4", "2", "0.05,0.4,0.85"])
def test_codes_and_light_are_brought_alike(rule, levels):
    ladder = Levels.of(levels)
    low, high = float(ladder.darkest), float(ladder.lightest)
    codes = np.arange(256, dtype=np.uint8).reshape(16, 16)
    table = encoding("srgb").table(256)
    coded = bring_into_range(Source(codes, table), low, high, rule)
    light = bring_into_range(Source(table[codes]), low, high, rule)
    assert coded.codes() is not None
    np.testing.assert_array_equal(coded.band(0, 16), light.band(0, 16))
    assert codes.ravel().tolist() == list(range(256))
    np.testing.assert_array_equal(table, encoding("srgb").table(256))


@pytest.mark.parametrize(
    ("rule", "hint"), [("clp", " Did you mean clip"), ("Scale", " Did you mean scale"), ("xyz", "")]
)
def test_an_unknown_rule_lists_those_there_are(rule, hint):
    with pytest.raises(UsageError) as error:
        bring_into_range(Source(np.zeros((1, 1), np.float32)), 0, 1, rule)
    assert str(error.value).startswith(f"unknown range rule '{rule}'.{hint}")
    assert str(error.value).endswith(" Allowed: clip, compress, scale")
