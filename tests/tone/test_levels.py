"""Levels of a device: counts, text forms, equal neighbours, middles, bits, saved codes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halftone import UsageError
from halftone.tone import Levels, encoding, log_ladder
from halftone.tone.levels import CLOSEST
from tests.oracle import tone as oracle
from tests.strategies import ladders


def singles(values) -> list[float]:
    return [oracle.single(v) for v in values]


# --- counts


@pytest.mark.parametrize("response", [None, "srgb", "bt709", "linear", "gamma:2.2", "gamma:1.8"])
def test_a_count_means_the_codes_of_the_encoding(response):
    decode = oracle.decoder(response or "srgb")
    for n in range(2, 257):
        levels = Levels.of(n, response)
        assert levels.luminance.dtype == np.float32
        assert levels.luminance.tolist() == singles(decode(k / (n - 1)) for k in range(n))
        assert len(levels) == len(levels.distinct) == n
        assert levels.index.tolist() == list(range(n))
        assert levels.text == str(n)
        assert levels.encoding == encoding(response or "srgb")
        assert (levels.darkest, levels.lightest) == (0, 1)


@pytest.mark.parametrize("spec", [4, np.int64(4), np.uint8(4), "4", " 4 "])
def test_all_forms_of_a_count(spec):
    assert Levels.of(spec).luminance.tolist() == Levels.of(4).luminance.tolist()
    assert Levels.of(spec).encoding.name == "srgb"


def test_levels_pass_through():
    levels = Levels.of("lstar:5")
    assert Levels.of(levels) is levels


# --- text forms and sequences


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("uniform-linear:2", [0, 1]),
        ("uniform-linear:5", [0, 0.25, 0.5, 0.75, 1]),
        ("Uniform_Linear:5", [0, 0.25, 0.5, 0.75, 1]),
        ("uniform:3", [0, 0.5, 1]),
        ("linear:3", [0, 0.5, 1]),
        ("lstar:2", [0, 1]),
        ("log:0.25:3", [0.25, 0.5, 1]),
        ("log:0.125:4", [0.125, 0.25, 0.5, 1]),
        ("LOG:1e-2:3", [0.01, 0.1, 1]),
        ("0,1", [0, 1]),
        ("0.02, 0.3,0.9", [0.02, 0.3, 0.9]),
        ("1e-3,1", [0.001, 1]),
        ("0,2.5", [0, 2.5]),
    ],
)
def test_text_forms(text, values):
    levels = Levels.of(text)
    assert levels.luminance.tolist() == singles(values)
    assert levels.encoding is None


@given(st.integers(2, 256), st.floats(0.001, 0.9))
def test_named_ladders_have_as_many_levels_as_they_say(n, i0):
    for text, expected in (
        (f"uniform-linear:{n}", oracle.uniform_ladder(n - 1)),
        (f"lstar:{n}", oracle.lstar_ladder(n - 1)),
        (f"L*:{n}", oracle.lstar_ladder(n - 1)),
        (f"log:{i0!r}:{n}", oracle.log_ladder(i0, n - 1)),
    ):
        levels = Levels.of(text)
        assert len(levels) == n
        assert levels.lightest == 1
        # one rounding to float32; where the twin's float64 rounds the other way, one ulp
        np.testing.assert_allclose(levels.luminance, expected, rtol=2.0**-23, atol=0)


def test_a_log_ladder_is_that_of_the_display():
    expected = log_ladder(0.01, 255).astype(np.float32)
    np.testing.assert_array_equal(Levels.of("log:0.01:256").luminance, expected)


def test_a_log_ladder_warns_of_a_black_no_display_has():
    with pytest.warns(UserWarning, match="I0=0.0001 is darker than displays are"):
        Levels.of("log:0.0001:4")


@pytest.mark.parametrize("spec", [[0, 0.5, 1], (0, 0.5, 1), np.array([0, 0.5, 1], np.float32)])
def test_sequences_are_luminances(spec):
    levels = Levels.of(spec)
    assert levels.luminance.tolist() == [0, 0.5, 1]
    assert levels.text == "0,0.5,1"
    assert Levels.of(levels.text).luminance.tolist() == [0, 0.5, 1]


# --- equal neighbours


def test_equal_neighbours_collapse_to_the_lowest_index():
    levels = Levels.of([0, 0, 0.5, 0.5, 0.5, 1, 1])
    assert levels.distinct.tolist() == [0, 0.5, 1]
    assert levels.index.tolist() == [0, 2, 5]
    assert len(levels) == 7
    assert levels.bits == 4  # the indices remain those of the device


@given(ladders())
def test_distinct_levels_ascend_and_know_their_lowest_index(values):
    levels = Levels.of(values)
    rounded = singles(values)
    assert levels.luminance.tolist() == rounded
    assert levels.distinct.tolist() == sorted(set(rounded))
    assert levels.index.tolist() == [rounded.index(v) for v in sorted(set(rounded))]
    assert (levels.darkest, levels.lightest) == (rounded[0], rounded[-1])


# --- what follows from levels


@st.composite
def neighbours(draw: st.DrawFn) -> list[float]:
    """A ladder in which each level is a few float32 ulps above the one before."""
    value = np.float32(draw(st.floats(0, 2, width=32)))
    values = [value]
    for ulps in draw(st.lists(st.integers(1, 3), min_size=1, max_size=10)):
        for _ in range(ulps):
            value = np.nextafter(value, np.float32(np.inf))
        values.append(value)
    return [float(v) for v in values]


@given(st.one_of(ladders(), neighbours()))
def test_a_middle_is_above_the_lower_level_and_halfway(values):
    gaps = np.diff(np.unique(np.float32(values)))
    if gaps.size and gaps.min() < CLOSEST:
        with pytest.raises(UsageError, match="differ by"):
            Levels.of(values)
        return
    levels = Levels.of(values)
    low, high = levels.distinct[:-1], levels.distinct[1:]
    middles = levels.middles()
    assert middles.dtype == np.float32
    assert (middles > low).all()
    assert (middles <= high).all()
    half = (low.astype(np.float64) + high) / 2
    # rounded once to float32, or moved up by half an ulp where the levels are neighbours
    assert (np.abs(middles - half) <= np.spacing(half.astype(np.float32)).astype(float) / 2).all()


@pytest.mark.parametrize(
    ("n", "bits"), [(2, 1), (3, 2), (4, 2), (5, 4), (16, 4), (17, 8), (255, 8), (256, 8)]
)
def test_bits_that_hold_an_index(n, bits):
    assert Levels.of(n).bits == bits


@pytest.mark.parametrize("n", [2, 4, 6, 16, 18, 52, 86, 256])
def test_srgb_codes_of_counts_that_divide_255_are_even_steps(n):
    codes = Levels.of(n).srgb()
    assert codes.dtype == np.uint8
    assert codes.tolist() == list(range(0, 256, 255 // (n - 1)))


@given(st.integers(2, 256))
def test_srgb_codes_are_the_nearest(n):
    # float32 luminance is off by 2^-24 of itself, at most 2^-24 · 255 of a code
    away = np.abs(Levels.of(n).srgb() - 255 * np.arange(n) / (n - 1))
    assert away.max() <= 0.5 + 255 * 2.0**-24


def test_srgb_of_levels_above_white_is_white():
    assert Levels.of([0, 1, 1.5, 1e6]).srgb().tolist() == [0, 255, 255, 255]


def test_levels_share_nothing_and_cannot_be_changed():
    values = np.array([0, 0.5, 1], np.float32)
    levels = Levels.of(values)
    values[1] = 0.9
    assert levels.luminance.tolist() == [0, 0.5, 1]
    for array in (levels.luminance, levels.distinct, levels.index):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
