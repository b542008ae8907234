"""Encodings and display responses: round trips, known points, other people's curves, tables."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halftone.errors import UsageError
from halftone.tone import Encoding, encoding, intensity, voltage
from tests.oracle import tone as oracle

EPS = 2.0**-52
NAMES = ["srgb", "bt709", "gamma:2.2", "linear"]

names = st.sampled_from([*NAMES, "gamma:0.5", "gamma:3"])
unit = st.floats(0, 1)
gammas = st.floats(0.1, 10)
scales = st.floats(0.01, 100).filter(lambda a: a != 1)


# --- display response


def there_and_back(gamma: float, value: float) -> float:
    """Bound on the relative error of x^γ·a and back: the first result's errors (a power, a product,
    the quotient) count 1/γ times, the rounded exponents |ln x| and |ln x|·γ/γ times."""
    return EPS * (4 / gamma + 3 * abs(math.log(value)) + 2)


@given(st.floats(1e-6, 4), gammas, scales)
def test_voltage_undoes_intensity(v, gamma, a):
    back = voltage(intensity(v, gamma, a), gamma, a)
    assert abs(back - v) <= there_and_back(gamma, v) * v


@given(st.floats(1e-6, 4), gammas, scales)
def test_intensity_undoes_voltage(light, gamma, a):
    back = intensity(voltage(light, gamma, a), gamma, a)
    bound = there_and_back(1 / gamma, light / a)
    assert abs(back - light) <= bound * light


def test_response_of_known_points():
    assert intensity(0.5, 2, a=3) == 0.75
    assert voltage(0.75, 2, a=3) == 0.5
    assert intensity([0, 1], 2.2, a=0.8).tolist() == [0, 0.8]
    assert voltage([0, 0.8], 2.2, a=0.8).tolist() == [0, 1]
    # NTSC: half the voltage gives 22 % of the light
    assert intensity(0.5, 2.2) == pytest.approx(0.217638, abs=5e-7)


@pytest.mark.parametrize("gamma", [0, -2.2, 0.0099, 100.1, math.nan, math.inf, "x", None])
def test_gamma_out_of_range_is_refused(gamma):
    for call in (intensity, voltage):
        with pytest.raises(UsageError, match=r"gamma=.*allowed: 0\.01 … 100"):
            call(0.5, gamma)


@pytest.mark.parametrize("a", [0, -1, math.nan, math.inf])
def test_scale_out_of_range_is_refused(a):
    for call in (intensity, voltage):
        with pytest.raises(UsageError, match=r"a=.*allowed: finite and above 0"):
            call(0.5, 2.2, a)


@pytest.mark.parametrize("value", [-1e-9, math.nan, [0.5, -1]])
def test_negative_light_has_no_voltage(value):
    with pytest.raises(UsageError, match="intensity below 0 or NaN"):
        voltage(value, 2.2)
    with pytest.raises(UsageError, match="voltage below 0 or NaN"):
        intensity(value, 2.2)


# --- encodings against other sources


def test_srgb_agrees_with_colour_science():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from colour.models import eotf_inverse_sRGB, eotf_sRGB

        v = np.linspace(0, 1, 65536)  # none of these lies between the two versions of the knee
        light, code = eotf_sRGB(v), eotf_inverse_sRGB(v)
    # the same two powers, and a difference of 0.055 from at most 1.055
    np.testing.assert_allclose(encoding("srgb").decode(v), light, rtol=4 * EPS, atol=0)
    np.testing.assert_allclose(encoding("srgb").encode(v), code, rtol=0, atol=4 * EPS)


def test_bt709_branches_meet_in_value_and_slope():
    alpha, beta = oracle.bt709_constants()
    bt709 = encoding("bt709")
    # light of the knee by the line below and by the power above
    below, above = beta * (1 - 1e-9), beta * (1 + 1e-9)
    np.testing.assert_allclose(bt709.encode(below), 4.5 * below, rtol=4 * EPS)
    # the knee is printed with 14 digits and α with 15: 1e-14 of each, and 1e-18 of curvature
    expected = alpha * above**0.45 - (alpha - 1)
    np.testing.assert_allclose(bt709.encode(above), expected, rtol=0, atol=3e-14)
    np.testing.assert_allclose(bt709.encode(above), 4.5 * above, rtol=0, atol=3e-14)


def test_bt709_known_points():
    bt709 = encoding("bt709")
    assert bt709.encode([0, 0.018, 1]) == pytest.approx([0, 0.081, 1], abs=2 * EPS)
    # with BT.709's rounded 1.099 in place of 1.0993 nothing differs by more than 3e-4
    light = np.linspace(0.0181, 1, 1000)
    np.testing.assert_allclose(bt709.encode(light), 1.099 * light**0.45 - 0.099, atol=3e-4)


@given(names, st.floats(-4, 4))
def test_both_curves_are_odd(name, value):
    curves = encoding(name)
    assert curves.decode(-value) == -curves.decode(value)
    assert curves.encode(-value) == -curves.encode(value)


@given(names, unit)
def test_encode_undoes_decode(name, code):
    curves = encoding(name)
    # The standard's two knees of sRGB miss each other by 3.0e-8 in code, next to 0.04045 only.
    # Else four roundings count 1/γ ≤ 2 times; those of the exponents, x·|ln x| < 0.4 of them.
    bound = 3e-8 if name == "srgb" and abs(code - 0.04045) < 1e-7 else 8 * EPS
    assert abs(curves.encode(curves.decode(code)) - code) <= bound


@given(names, unit, unit)
def test_curves_rise_from_black_to_white(name, one, two):
    curves = encoding(name)
    low, high = sorted([one, two])
    for curve in (curves.decode, curves.encode):
        assert curve(0) == 0
        assert abs(curve(1) - 1) <= EPS
        if name != "srgb" or not low <= 0.04045 <= high:  # sRGB steps back by 3e-8 at its knee
            assert curve(low) <= curve(high) + EPS
        assert curve(low) <= curve(high) + 3e-8


# --- tables


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("size", [256, 65536])
def test_tables_are_the_scalar_curve_rounded_once(name, size):
    decode = oracle.decoder(name)
    expected = [oracle.single(decode(k / (size - 1))) for k in range(size)]
    table = encoding(name).table(size)
    assert table.dtype == np.float32
    # float64 powers differ between CPUs by an ulp, which the rounding to float32 removes: equal
    np.testing.assert_array_equal(table, expected)


def test_a_table_is_made_once_and_cannot_be_changed():
    table = encoding("srgb").table(256)
    assert encoding("sRGB").table(256) is table
    with pytest.raises(ValueError, match="read-only"):
        table[0] = 1


def test_tables_of_nearly_equal_gammas_are_their_own():
    first = encoding("gamma:2.2").table(256)
    second = encoding("gamma:2.2000004").table(256)
    expected = [oracle.single(math.pow(k / 255, 2.2000004)) for k in range(256)]
    assert first.tolist() != expected
    np.testing.assert_array_equal(second, expected)


# --- names


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("srgb", "srgb"),
        (" sRGB ", "srgb"),
        ("s-rgb", "srgb"),
        ("S_RGB", "srgb"),
        ("bt709", "bt709"),
        ("BT-709", "bt709"),
        ("rec709", "bt709"),
        ("Rec_709", "bt709"),
        ("709", "bt709"),
        ("linear", "linear"),
        ("lin", "linear"),
        ("light", "linear"),
        ("gamma:2.2", "gamma:2.2"),
        ("Gamma:2.20", "gamma:2.2"),
        ("gamma2.4", "gamma:2.4"),
        ("1.8", "gamma:1.8"),
        (2.6, "gamma:2.6"),
        ("gamma:0.01", "gamma:0.01"),
        ("gamma:100", "gamma:100"),
        (encoding("bt709"), "bt709"),
    ],
)
def test_names_and_aliases(text, name):
    found = encoding(text)
    assert isinstance(found, Encoding)
    assert found.name == name
    assert encoding(found.name) == found


@pytest.mark.parametrize(
    ("text", "meant"), [("srgv", "srgb"), ("rgb", "srgb"), ("bt7o9", "bt709"), ("lineer", "linear")]
)
def test_an_unknown_name_lists_near_matches(text, meant):
    message = rf"encoding '{text}'\. Did you mean {meant}\? Allowed: bt709, gamma:G, linear, srgb"
    with pytest.raises(UsageError, match=message):
        encoding(text)


@pytest.mark.parametrize("text", ["", "xyzzy", "nan", "0", "101"])
def test_what_resembles_nothing_lists_all_names(text):
    with pytest.raises(UsageError, match=rf"'{text}'\. Allowed: bt709, gamma:G, linear, srgb"):
        encoding(text)


@pytest.mark.parametrize("text", ["gamma:0", "gamma:0.009", "gamma:101", "gamma:nan", "gamma:x"])
def test_a_gamma_out_of_range_says_what_is_allowed(text):
    with pytest.raises(UsageError, match=r"gamma=.*allowed: 0\.01 … 100"):
        encoding(text)


@pytest.mark.parametrize("text", ["gamma:-2.2", "gamma:-1", "-2.2", -2.2])
def test_a_negative_gamma_is_refused(text):
    with pytest.raises(UsageError, match=r"allowed: 0\.01 … 100|unknown encoding"):
        encoding(text)


@pytest.mark.parametrize(("text", "gamma"), [("gamma:5e-1", 0.5), ("gamma:2.5e+0", 2.5)])
def test_a_gamma_in_scientific_notation_keeps_its_sign(text, gamma):
    assert encoding(text).name == f"gamma:{gamma:g}"


def test_curves_leave_their_arguments_alone():
    values = np.linspace(-1, 1, 11)
    kept = values.copy()
    values.flags.writeable = False
    for name in NAMES:
        for result in (encoding(name).decode(values), encoding(name).encode(values)):
            assert not np.shares_memory(result, values)
    intensity(np.abs(values), 2.2)
    np.testing.assert_array_equal(values, kept)
