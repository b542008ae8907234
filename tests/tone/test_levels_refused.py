"""What is refused as the levels of a device, and that each refusal says what is allowed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from halftone.errors import UsageError
from halftone.tone import Levels, encoding

ALLOWED = r"allowed: N, uniform-linear:N, lstar:N, log:I0:N, Y0,Y1,… \(N = 2 … 256\)"


@pytest.mark.parametrize(
    "spec",
    [0, 1, -3, 257, "1", "257", "-3", "lstar:1", "uniform-linear:257", "log:0.02:1", "log:0.02:300"],
)
def test_a_count_out_of_range_is_refused(spec):
    with pytest.raises(UsageError, match=rf"levels.*{ALLOWED}"):
        Levels.of(spec)


@pytest.mark.parametrize(
    "text",
    ["", "x", "4.5", "foo:3", "lstar", "lstar:", "lstar:x", "log:0.02", "log:x:4", "0,", "0;1", ","],
)
def test_text_that_is_not_understood_is_refused(text):
    with pytest.raises(UsageError, match=rf"levels='{text}' is not understood; {ALLOWED}"):
        Levels.of(text)


@pytest.mark.parametrize("spec", [None, True, 4.0, math.nan, ["a", "b"], object()])
def test_what_is_no_row_of_numbers_is_refused(spec):
    with pytest.raises(UsageError, match=rf"levels=.*; {ALLOWED}"):
        Levels.of(spec)


@pytest.mark.parametrize("spec", [[], [0.5], [[0, 1]], np.linspace(0, 1, 257)])
def test_a_shape_that_holds_no_levels_is_refused(spec):
    with pytest.raises(UsageError, match=rf"levels of shape \(.*\); {ALLOWED}"):
        Levels.of(spec)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, -1e-9])
@pytest.mark.parametrize("place", [0, 1, 2])
def test_a_luminance_that_cannot_be_is_refused(bad, place):
    values = [0.1, 0.5, 1.0]
    values[place] = bad
    for spec in (values, ",".join(str(v) for v in values)):
        with pytest.raises(UsageError, match=rf"negative luminance, NaN or infinity; {ALLOWED}"):
            Levels.of(spec)


@pytest.mark.parametrize("spec", [[0, 0.5, 0.25, 1], "0,0.5,0.25,1"])
def test_falling_levels_are_refused_and_named(spec):
    message = r"fall from 0\.5 \(level 1\) to 0\.25 \(level 2\); .* Sort them, darkest first"
    with pytest.raises(UsageError, match=message):
        Levels.of(spec)


@pytest.mark.parametrize("spec", [[0, 0], [0.5] * 5, "1,1,1", [0.5, 0.5 + 1e-12]])
def test_levels_that_are_all_equal_are_refused(spec):
    with pytest.raises(UsageError, match=r"all levels have the luminance .*: no picture can be"):
        Levels.of(spec)


def test_a_luminance_no_device_has_is_refused():
    with pytest.raises(UsageError, match=r"a level of luminance 1e\+07; allowed: up to 1e6"):
        Levels.of([0, 1e7])


@pytest.mark.parametrize(
    "spec", ["lstar:4", "uniform-linear:4", "log:0.02:4", "0,1", [0, 0.5, 1], Levels.of(4)]
)
@pytest.mark.parametrize("response", ["gamma:2.2", "srgb", encoding("linear")])
def test_gamma_does_not_apply_to_luminances_that_are_given(spec, response):
    with pytest.raises(UsageError, match=r"gamma does not apply to levels '.+', whose luminances"):
        Levels.of(spec, response)
