"""Ladders of intensities: the published numbers, equal ratios, L*, nearest levels, contours."""

from __future__ import annotations

import math
import warnings
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halftone.errors import UsageError
from halftone.tone import (
    lightness,
    log_ladder,
    lstar_ladder,
    luminance,
    nearest,
    ratio,
    uniform_ladder,
    visible_steps,
)
from tests.oracle import tone as oracle

EPS = 2.0**-52
"""One unit in the last place of a float64 just above 1: at least two roundings."""

blacks = st.floats(0.001, 0.99)
steps = st.integers(1, 255)


def drift(i0: float, k: int) -> float:
    """Relative error of r^k·I0: k times that of r, and two powers whose exponents are rounded."""
    return EPS * (k + 3 * abs(math.log(i0)) + 4)


def test_four_intensities_as_printed():
    assert ratio(1 / 8, 3) == pytest.approx(2, rel=drift(1 / 8, 1), abs=0)
    np.testing.assert_allclose(log_ladder(1 / 8, 3), [1 / 8, 1 / 4, 1 / 2, 1], rtol=drift(1 / 8, 3))


def test_256_intensities_as_printed():
    ladder = log_ladder(0.01, 255)
    assert ladder.shape == (256,)
    assert f"{ratio(0.01, 255):.4f}" == "1.0182"
    shown = [f"{v:.4f}" for v in ladder]
    assert shown[:6] == ["0.0100", "0.0102", "0.0104", "0.0106", "0.0107", "0.0109"]
    assert shown[-2:] == ["0.9821", "1.0000"]


@given(blacks, steps)
def test_log_ladder_equals_its_twin(i0, n):
    ladder = log_ladder(i0, n)
    assert ladder.dtype == np.float64
    assert ladder[-1] == 1
    assert ladder[0] == i0
    np.testing.assert_allclose(ladder, oracle.log_ladder(i0, n), rtol=drift(i0, n), atol=0)


@given(blacks, steps)
def test_all_ratios_are_equal(i0, n):
    ladder = log_ladder(i0, n)
    # two powers and a quotient against one power: no rounding accumulates over the ladder
    bound = EPS * (3 * abs(math.log(i0)) + 4)
    np.testing.assert_allclose(ladder[1:] / ladder[:-1], ratio(i0, n), rtol=bound, atol=0)


@given(st.lists(blacks, min_size=1, max_size=4), steps)
def test_one_ladder_per_component(i0, n):
    ladders = log_ladder(i0, n)
    assert ladders.shape == (n + 1, len(i0))
    for c, black in enumerate(i0):
        # the same formula, only its powers may come from another routine of NumPy: 1 ulp each
        np.testing.assert_allclose(ladders[:, c], log_ladder(black, n), rtol=2 * EPS, atol=0)


@pytest.mark.parametrize("i0", [0, -0.01, 1, 1.5, math.nan, math.inf, -math.inf, [0.02, 0.0]])
def test_black_out_of_range_is_refused(i0):
    with pytest.raises(UsageError, match=r"I0=.*allowed: above 0 and below 1"):
        log_ladder(i0, 4)
    if not isinstance(i0, list):
        with pytest.raises(UsageError, match="I0="):
            ratio(i0, 4)


@pytest.mark.parametrize("i0", [1e-12, 0.00099, [0.02, 1e-4]])
def test_a_black_darker_than_displays_warns(i0):
    with pytest.warns(UserWarning, match="darker than displays are"):
        ladder = log_ladder(i0, 4)
    assert (ladder > 0).all()


@pytest.mark.parametrize("i0", [0.001, 0.005, 0.025, 0.999])
def test_a_usual_black_does_not_warn(i0):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        log_ladder(i0, 4)


@pytest.mark.parametrize("make", [lambda n: log_ladder(0.02, n), uniform_ladder, lstar_ladder])
@pytest.mark.parametrize("n", [0, -1, 1.5, True])
def test_a_count_of_steps_that_is_none_is_refused(make, n):
    with pytest.raises(UsageError, match=r"n=.* steps; allowed: 1, 2, 3"):
        make(n)


@pytest.mark.parametrize("n", [1, 2, 3, 7, 100, 255])
def test_uniform_and_lstar_ladders_equal_their_twins(n):
    np.testing.assert_array_equal(uniform_ladder(n), oracle.uniform_ladder(n))
    # a cube of a value with three roundings, 4 · 3 halves of an ulp; 0 and 1 are exact
    np.testing.assert_allclose(lstar_ladder(n), oracle.lstar_ladder(n), rtol=16 * EPS, atol=EPS)
    assert lstar_ladder(n)[0] == 0
    assert lstar_ladder(n)[-1] == 1


def test_lightness_agrees_with_colour_science():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from colour.colorimetry import lightness_CIE1976
    y = np.linspace(0, 1, 10_001)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        expected = lightness_CIE1976(y * 100)
    # 116·f with f rounded, less 16: a few units in the last place of 116
    np.testing.assert_allclose(lightness(y), expected, rtol=0, atol=4 * 116 * EPS)


def test_lightness_of_known_points():
    y, lstar = [0, 216 / 24389, 0.125, 1], [0, 8, 42, 100]
    np.testing.assert_allclose(lightness(y), lstar, rtol=0, atol=116 * EPS)
    np.testing.assert_allclose(luminance(lstar), y, rtol=0, atol=2 * EPS)


@given(st.floats(0, 1))
def test_lightness_and_back(y):
    # L* is off by up to 4 ulps of 116; dY/dL* is at most 3/116, at white
    assert abs(luminance(lightness(y)) - y) <= 4 * 116 * EPS * 3 / 116
    assert abs(lightness(y) - oracle.lightness(y)) <= 4 * 116 * EPS


grid = st.integers(1, 64)
ascending = st.lists(grid, min_size=1, max_size=12, unique=True).map(sorted)


@given(ascending, st.lists(st.integers(-8, 160), min_size=1, max_size=40))
def test_nearest_by_arithmetic_equals_its_twin(ladder, light):
    # halves of the grid: every border is met exactly, so that ties occur
    levels = [k / 64 for k in ladder]
    values = [v / 128 for v in light]
    expected = [oracle.nearest_arithmetic(v, levels) for v in values]
    found = nearest(values, levels)
    assert found.dtype == np.uint8
    np.testing.assert_array_equal(found, expected)


@given(ascending, st.lists(st.floats(0, 2), min_size=1, max_size=40))
def test_nearest_by_ratio_equals_its_twin_away_from_ties(ladder, light):
    levels = [k / 64 for k in ladder]
    middles = [math.sqrt(a * b) for a, b in pairwise(levels)]
    values = [v for v in light if all(abs(v - m) > 4 * EPS * m for m in middles)]
    expected = [oracle.nearest_ratio(v, levels) for v in values]
    np.testing.assert_array_equal(nearest(values, levels, by="ratio"), expected)


def test_a_tie_of_ratios_goes_to_the_darker_level():
    wrong = []
    for low in range(1, 65):
        for high in range(low + 1, 65):
            middle = math.isqrt(low * high)
            if middle**2 == low * high:  # low : middle = middle : high, all exact in float64
                found = nearest(middle / 64, [low / 64, high / 64], by="ratio")
                wrong += [(low, middle, high)] if found != 0 else []
    assert wrong == []


def test_ratio_and_arithmetic_disagree_between_the_two_means():
    assert nearest(0.4, [0.1, 1], by="ratio") == 1
    assert nearest(0.4, [0.1, 1]) == 0


@given(ascending, st.sampled_from(["arithmetic", "ratio"]))
def test_every_level_is_nearest_to_itself(ladder, by):
    levels = np.array(ladder) / 64
    np.testing.assert_array_equal(nearest(levels, levels, by), np.arange(len(ladder)))


def test_nearest_keeps_the_shape_and_takes_256_levels():
    levels = uniform_ladder(255)
    found = nearest(levels.reshape(4, 64), levels)
    np.testing.assert_array_equal(found, np.arange(256).reshape(4, 64))


@pytest.mark.parametrize(
    "levels", [[0.5, 0.5], [1, 0], [], [[0, 1]], np.arange(257.0), [0, math.nan], [math.nan, 1]]
)
def test_levels_that_do_not_ascend_are_refused(levels):
    with pytest.raises(UsageError, match=r"1 … 256 ascending luminances"):
        nearest(0.5, levels)


def test_nearest_by_ratio_needs_a_black_above_zero():
    with pytest.raises(UsageError, match=r"needs levels above 0.*by='arithmetic'"):
        nearest(0.5, [0, 1], by="ratio")
    with pytest.raises(UsageError, match=r"by='log'; allowed: arithmetic, ratio"):
        nearest(0.5, [0.1, 1], by="log")


@pytest.mark.parametrize(
    ("count", "shown"), [(2, 1), (4, 3), (8, 7), (16, 15), (32, 0), (64, 0), (128, 0), (256, 0)]
)
def test_contours_by_the_number_of_levels(count, shown):
    assert visible_steps(lstar_ladder(count - 1)) == shown


@given(ascending, st.floats(0, 60))
def test_visible_steps_equal_their_twin(ladder, threshold):
    levels = np.array(ladder) / 64
    apart = np.abs(np.diff(lightness(levels / levels[-1])) - threshold)
    if (apart > 8 * 116 * EPS).all():  # no step so near the threshold that rounding decides
        assert visible_steps(levels, threshold) == oracle.visible_steps(levels.tolist(), threshold)


def test_visible_steps_do_not_depend_on_the_unit_of_luminance():
    assert visible_steps(lstar_ladder(10) * 64) == visible_steps(lstar_ladder(10)) == 10


def test_ladders_leave_their_arguments_alone():
    i0, levels = np.array([0.01, 0.02]), np.array([0.1, 0.4, 1])
    for array in (i0, levels):
        array.flags.writeable = False
    log_ladder(i0, 5)
    nearest(levels, levels, by="ratio")
    visible_steps(levels)
    assert levels.tolist() == [0.1, 0.4, 1]
