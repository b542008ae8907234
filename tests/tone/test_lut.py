"""Video tables: gamma, combined with a ladder, for amplifiers that correct, and wrong codes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halftone.errors import UsageError
from halftone.tone import (
    combined_table,
    gamma_table,
    hardware_table,
    intensity,
    log_ladder,
    lstar_ladder,
    nearest,
    to_dac,
    voltage,
    wrong_codes,
)
from tests.oracle import tone as oracle

EPS = 2.0**-52

sizes = st.integers(2, 300)
gammas = st.floats(0.1, 10)
scales = st.sampled_from([1.0, 0.5, 0.9, 2.0, 80.0])
by = st.sampled_from(["arithmetic", "ratio"])


@given(sizes, gammas, scales)
def test_gamma_table_equals_its_twin(size, gamma, a):
    # two libraries' powers of equal arguments: an ulp each
    np.testing.assert_allclose(
        gamma_table(size, gamma, a), oracle.gamma_table(size, gamma, a), rtol=2 * EPS, atol=0
    )


@given(sizes, gammas)
def test_a_linear_pixel_value_becomes_its_light(size, gamma):
    shown = intensity(gamma_table(size, gamma), gamma)
    light = np.arange(size) / (size - 1)
    # the voltage's last half place counts γ times; the exponents' |ln light| ≤ ln 299 times
    np.testing.assert_allclose(shown, light, rtol=EPS * (2 * gamma + 3 * math.log(300)), atol=0)


@given(sizes, st.floats(0.001, 0.5), st.integers(1, 40), gammas, scales, by)
def test_combined_table_is_the_two_steps_one_after_the_other(size, i0, n, gamma, a, rule):
    levels = log_ladder(i0, n)
    values = np.arange(size) / (size - 1)
    found = nearest(values, levels, rule)
    expected = voltage([levels[k] for k in found], gamma, a)
    np.testing.assert_array_equal(combined_table(size, levels, gamma, a, rule), expected)


@pytest.mark.parametrize("size", [2, 17, 256])
@pytest.mark.parametrize("rule", ["arithmetic", "ratio"])
def test_combined_table_equals_its_twin(size, rule):
    ladder = log_ladder(0.02, 15)
    expected = oracle.combined_table(size, ladder.tolist(), 2.2, 0.9, rule)
    np.testing.assert_allclose(
        combined_table(size, ladder, 2.2, 0.9, rule), expected, rtol=2 * EPS, atol=0
    )


def test_combined_table_goes_by_ratio_unless_told():
    ladder = log_ladder(0.02, 3)
    given_none = combined_table(256, ladder, 2.2)
    np.testing.assert_array_equal(given_none, combined_table(256, ladder, 2.2, by="ratio"))
    assert (given_none != combined_table(256, ladder, 2.2, by="arithmetic")).any()


def test_combined_table_shows_only_the_levels_and_each_of_them():
    ladder = log_ladder(0.02, 15)
    shown = intensity(combined_table(4096, ladder, 2.2), 2.2)
    place = nearest(shown, ladder)
    np.testing.assert_array_equal(np.unique(place), np.arange(16))
    bound = EPS * (2 * 2.2 + 3 * math.log(50))  # there and back: see the gamma table
    np.testing.assert_allclose(shown, ladder[place], rtol=bound, atol=0)


def test_combined_table_by_ratio_refuses_a_black_of_zero():
    with pytest.raises(UsageError, match="a ratio needs levels above 0"):
        combined_table(256, lstar_ladder(4), 2.2)


def test_hardware_table_holds_the_intensities_themselves():
    ladder = log_ladder(0.01, 255)
    table = hardware_table(ladder)
    np.testing.assert_array_equal(table, ladder)
    assert not np.shares_memory(table, ladder)
    # The amplifiers turn it into these intensities. Through a gamma table they would be
    # corrected twice, and much too light: 0.01 would be stored as 0.12.
    twice = voltage(ladder, 2.2)
    assert (twice[:-1] > table[:-1]).all()
    assert twice[0] == pytest.approx(0.1233, abs=5e-5)


# --- converter codes


@given(st.lists(st.floats(-1, 2), min_size=1, max_size=50), st.integers(1, 16))
def test_dac_codes_equal_their_twin(volts, bits):
    codes = to_dac(volts, bits)
    assert codes.dtype == np.uint16
    assert codes.tolist() == [oracle.to_dac(v, bits) for v in volts]


@pytest.mark.parametrize("bits", [1, 8, 10, 12, 16])
def test_every_dac_code_is_reached_by_its_own_voltage(bits):
    top = 2**bits - 1
    np.testing.assert_array_equal(to_dac(np.arange(top + 1) / top, bits), np.arange(top + 1))
    assert to_dac([-0.5, 0, 1, 7], bits).tolist() == [0, 0, top, top]


@pytest.mark.parametrize("bits", [0, -1, 17])
def test_dac_bits_out_of_range_are_refused(bits):
    with pytest.raises(UsageError, match=rf"bits={bits}; allowed: 1 … 16"):
        to_dac(0.5, bits)


@pytest.mark.parametrize("size", [0, 1, -4, 65537, 2.5, True])
def test_table_sizes_out_of_range_are_refused(size):
    for call in (
        lambda: gamma_table(size, 2.2),
        lambda: combined_table(size, [0.1, 1], 2.2),
        lambda: wrong_codes(size, 2.2),
    ):
        with pytest.raises(UsageError, match=r"a table of size .*; allowed: 2 … 65536"):
            call()


# --- wrong codes against table size


@pytest.mark.parametrize("gamma", [0.45, 1.8, 2.2, 2.6])
@pytest.mark.parametrize("size", [2, 16, 100, 256, 1000, 1024])
def test_wrong_codes_equal_their_twin(gamma, size):
    assert wrong_codes(size, gamma, 8, 10) == oracle.wrong_codes(size, gamma, 8, 10)


@pytest.mark.parametrize("gamma", [1.8, 2.2, 2.6])
def test_wrong_codes_fall_to_none_as_the_table_grows(gamma):
    counts = [wrong_codes(size, gamma) for size in (16, 64, 256, 1024, 2048, 4096)]
    assert counts == sorted(counts, reverse=True)
    assert len(set(counts)) == len(counts)
    assert counts[-1] == 0
    assert counts[0] > 4096 // 2


@pytest.mark.parametrize("bits", [6, 8, 10, 16])
@pytest.mark.parametrize("pixel_bits", [1, 8, 12])
@given(gamma=gammas)
def test_a_full_table_sends_none_wrong(bits, pixel_bits, gamma):
    assert wrong_codes(2**pixel_bits, gamma, bits, pixel_bits) == 0


def test_tables_leave_the_ladder_alone():
    ladder = log_ladder(0.02, 7)
    kept = ladder.copy()
    ladder.flags.writeable = False
    combined_table(64, ladder, 2.2)
    hardware_table(ladder)[0] = 5
    to_dac(ladder, 8)
    np.testing.assert_array_equal(ladder, kept)
