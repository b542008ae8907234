"""The dot model against other integrations, published numbers and a loop over neighbours."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halftone.errors import UsageError
from halftone.tone.dotgain import DotModel
from tests.oracle import dotgain as slow

inks = st.tuples(st.integers(1, 7), st.integers(1, 7)).flatmap(
    lambda shape: st.lists(
        st.lists(st.integers(0, 1), min_size=shape[1], max_size=shape[1]),
        min_size=shape[0],
        max_size=shape[0],
    )
)
diameters = st.floats(0.1, 3)


@pytest.mark.parametrize(("across", "down"), [(math.sqrt(2), math.sqrt(2)), (1.25, 2.75)])
def test_every_area_is_that_of_another_integration(across, down):
    exact = [slow.area(code, across, down) for code in range(512)]
    np.testing.assert_allclose(DotModel(across, down).table, exact, atol=1e-4)


@given(st.integers(0, 511), diameters, diameters)
@settings(max_examples=60, deadline=None)
def test_an_area_of_any_ellipse(code, across, down):
    found = float(DotModel(across, down).table[code])
    assert found == pytest.approx(slow.area(code, across, down, 2000), abs=1e-4)


@pytest.mark.parametrize(
    ("rho", "alpha", "beta", "gamma"),
    [(1.0, 0.1427, 0.0, 0.0), (1.25, 0.3342, 0.0294, 0.0983), (1.414, 0.4565, 0.0787, 0.2065)],
)
def test_published_areas(rho, alpha, beta, gamma):
    assert slow.parts(rho) == pytest.approx((alpha, beta, gamma), abs=6e-5)
    table = DotModel(math.sqrt(2) * rho, math.sqrt(2) * rho).table
    assert table[1 << 1] == pytest.approx(alpha, abs=1e-4)
    assert table[1 << 0] == pytest.approx(beta, abs=1e-4)
    assert table[1 << 1 | 1 << 3] == pytest.approx(2 * alpha - gamma, abs=1e-4)


@pytest.mark.parametrize("rho", [1.0, 1.1, 1.25, 1.414])
def test_pappas_and_neuhoff_of_all_neighbourhoods(rho):
    expected = [slow.overlap(code, rho) for code in range(512)]
    np.testing.assert_allclose(
        DotModel(math.sqrt(2) * rho, math.sqrt(2) * rho).table, expected, atol=1e-4
    )


@given(inks, diameters, diameters)
@settings(max_examples=60, deadline=None)
def test_covered_is_the_loop_over_neighbours(ink, across, down):
    dot = DotModel(across, down)
    array = np.array(ink, np.uint8)
    expected = np.array(slow.covered(ink, dot.table.tolist()), np.float32)
    np.testing.assert_array_equal(dot.covered(array), expected)
    for cut in range(1, len(ink)):  # bands with the rows about them are the whole
        upper = dot.covered(array[:cut], below=array[cut])
        lower = dot.covered(array[cut:], above=array[cut - 1])
        np.testing.assert_array_equal(np.vstack((upper, lower)), expected)


@given(st.integers(0, 511), st.integers(0, 8), diameters, diameters)
@settings(max_examples=100, deadline=None)
def test_more_ink_never_covers_less(code, bit, across, down):
    table = DotModel(across, down).table
    assert table[0] == 0
    assert table[code] <= table[code | 1 << bit] <= 1


def test_solid_ink():
    assert DotModel(math.sqrt(2) + 1e-6, math.sqrt(2) + 1e-6).solid == pytest.approx(1, abs=1e-6)
    assert DotModel(1, 1).solid == pytest.approx(math.pi / 4, abs=1e-5)


@pytest.mark.parametrize("wrong", [0, 0.09, 3.1, -1, float("nan"), "1", True, None])
def test_what_is_no_diameter(wrong):
    with pytest.raises(UsageError, match=r"dot across = .*allowed: 0\.1 … 3"):
        DotModel(wrong, 1)
