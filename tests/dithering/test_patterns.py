"""Pattern replacement against its slow twin, and what it promises."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import halftone.stages
from halftone import UsageError, convert, dither
from halftone.dithering.patterns import Patterns, borders
from halftone.screens.family import PatternFamily
from halftone.screens.growth import classic2, classic3, grow
from halftone.tone.levels import Levels
from tests.oracle import growth as oracle
from tests.strategies import ladders, light

FAMILIES = {
    "classic2": classic2(),
    "classic3": classic3(),
    "4": grow(4),
    "5:clustered": grow(5, clustered=True),
    "4:isolated=3": grow(4, isolated_from=3),
    "8": grow(8),
}
families = st.sampled_from(list(FAMILIES.values()))


@settings(max_examples=25)
@given(light(), ladders(), st.sampled_from([classic2(), classic3(), grow(4), grow(5)]))
def test_patterns_equal_their_twin(picture, levels, family):
    picture = picture[:6, :6]
    values = np.float32(levels)
    distinct, first = np.unique(values, return_index=True)
    picture = np.clip(picture, distinct[0], distinct[-1])
    shown = dither(picture, Patterns(family), levels=levels).indices
    n, order = family.n, family.order.tolist()
    expected = oracle.replaced(picture.tolist(), distinct.tolist(), n, order)
    np.testing.assert_array_equal(shown, first[np.array(expected)])


@given(families, ladders(), st.tuples(st.integers(1, 9), st.integers(1, 9)))
def test_a_constant_picture_at_a_level_is_that_level(family, levels, shape):
    values = np.float32(levels)
    for value in np.unique(values):
        frame = dither(np.full(shape, value), Patterns(family), levels=levels)
        assert frame.shape == (shape[0] * family.n, shape[1] * family.n)
        assert (frame.indices == np.flatnonzero(values == value)[0]).all()


@pytest.mark.parametrize("name", FAMILIES)
@pytest.mark.parametrize("levels", [2, 256, "log:0.02:16", [0.02, 0.1, 0.15, 0.7, 1.0]])
def test_tones_are_within_half_a_step(name, levels):
    method = Patterns(FAMILIES[name])
    assert (method.claim.kind, method.claim.tones) == ("tones", method.scale**2 + 1)
    values = Levels.of(levels).luminance.astype(np.float64)
    tones = np.linspace(values[0], values[-1], 501).astype(np.float32)[None]
    shown = dither(tones, method, levels=levels).luminance.astype(np.float64)
    means = shown.reshape(method.scale, -1, method.scale).mean(axis=(0, 2))
    step = np.diff(values)[np.clip(np.searchsorted(values, tones[0]) - 1, 0, values.size - 2)]
    assert (np.abs(means - tones[0]) <= step / method.scale**2 / 2 + 1e-7).all()
    assert (np.diff(means) >= 0).all()


@given(ladders(), st.sampled_from([4, 9, 16, 64]))
def test_every_pattern_has_its_tone(levels, cells):
    """Just above the border of two tones the lighter pattern is shown, on it the darker."""
    distinct = np.unique(np.float32(levels))
    border = borders(distinct, cells)
    assert border.size == cells * (distinct.size - 1)
    assert (np.diff(border) >= 0).all()
    inner = border.reshape(-1, cells)
    assert (inner >= distinct[:-1, None]).all()
    assert (inner < distinct[1:, None]).all()  # so that the upper level is above them all


def test_ties_go_to_the_darker_pattern():
    tie = np.float32([[0.125, 0.375, 0.625, 0.875]])
    shown = dither(tie, Patterns(classic2()), levels=2).indices
    assert shown.reshape(2, 4, 2).sum(axis=(0, 2)).tolist() == [0, 1, 2, 3]
    above = np.nextafter(tie, np.float32(2))
    shown = dither(above, Patterns(classic2()), levels=2).indices
    assert shown.reshape(2, 4, 2).sum(axis=(0, 2)).tolist() == [1, 2, 3, 4]


def test_the_patterns_are_the_familys():
    ramp = np.linspace(0, 1, 10, dtype=np.float32)[None]
    shown = dither(ramp, Patterns(classic3()), levels=2).indices
    for k in range(10):
        np.testing.assert_array_equal(shown[:, 3 * k : 3 * k + 3], classic3().pattern(k))


@pytest.mark.parametrize(("n", "side"), [(2, 256), (3, 170), (4, 128)])
def test_the_picture_shrinks_to_what_the_device_has_dots_for(camera, n, side):
    method = Patterns(grow(n))
    frame = convert(camera, method=method, width=512, height=512)
    assert frame.shape == (512, 512)
    assert method.scale == n
    # side² whole patterns; a rim that holds no whole one shows the parts that fit
    assert 512 // n == side
    assert dither(camera[:side, :side], method).shape == (side * n, side * n)


@given(light(), ladders(), families, st.integers(1, 30))
def test_bands_give_the_whole(picture, levels, family, rows):
    whole = dither(picture, Patterns(family), levels=levels)
    kept = halftone.stages.BAND_ROWS
    try:
        halftone.stages.BAND_ROWS = rows
        for workers in (1, 3):
            again = dither(picture, Patterns(family), levels=levels, workers=workers)
            np.testing.assert_array_equal(again, whole)
    finally:
        halftone.stages.BAND_ROWS = kept


@given(
    st.integers(0, 2**32 - 1),
    ladders(),
    families,
    st.sampled_from(["srgb", "linear", "gamma:2.2"]),
    st.sampled_from([np.uint8, np.uint16]),
)
def test_codes_equal_their_light(seed, levels, family, encoding, dtype):
    from halftone.tone import encoding as find

    random = np.random.default_rng(seed)
    codes = random.integers(0, np.iinfo(dtype).max, (9, 11), dtype, endpoint=True)
    before = codes.copy()
    decoded = find(encoding).table(np.iinfo(dtype).max + 1)[codes]
    by_code = dither(codes, Patterns(family), levels=levels, encoding=encoding)
    np.testing.assert_array_equal(by_code, dither(decoded, Patterns(family), levels=levels))
    np.testing.assert_array_equal(codes, before)


@pytest.mark.parametrize("shape", [(1, 1), (1, 65_000), (65_000, 1), (3, 20_000)])
@pytest.mark.parametrize("name", ["classic2", "classic3", "8"])
def test_extreme_shapes(name, shape):
    method = Patterns(FAMILIES[name])
    n = method.scale
    ramp = np.linspace(0, 1, shape[0] * shape[1], dtype=np.float32).reshape(shape)
    frame = dither(ramp, method)
    assert frame.shape == (shape[0] * n, shape[1] * n)
    assert frame.indices[0, 0] == 0
    cells = frame.indices.reshape(shape[0], n, shape[1], n).sum(axis=(1, 3))
    assert (np.diff(cells.ravel().astype(int)) >= 0).all()


@pytest.mark.parametrize("value", [1e-45, 3.4e38, -3.4e38, 1 - 2**-24])
def test_extreme_values(value):
    frame = dither(np.full((3, 3), value, np.float32), Patterns(grow(8)))
    assert (frame.indices == (1 if value > 0.5 else 0)).all()


def test_256_levels_and_the_largest_patterns():
    ramp = np.linspace(0, 1, 700, dtype=np.float32)[None]
    frame = dither(ramp, Patterns(grow(16)), levels="uniform-linear:256")
    means = frame.luminance.astype(np.float64).reshape(16, -1, 16).mean(axis=(0, 2))
    assert np.abs(means - ramp[0]).max() <= 0.5 / 255 / 256 + 1e-7


def test_a_family_of_the_devices_own_number_of_levels():
    picture = np.linspace(0, 1, 40, dtype=np.float32)[None]
    own = Patterns(grow(3, levels=4))
    levels = [0.0, 0.2, 0.2, 0.5, 1.0]  # four different ones
    shown = dither(picture, own, levels=levels)
    np.testing.assert_array_equal(shown, dither(picture, Patterns(grow(3)), levels=levels))
    with pytest.raises(UsageError, match="4 levels"):
        dither(picture, own, levels=2)
    mixed = PatternFamily(2, 3, np.array([0, 0, 1, 1, 2, 2, 3, 3]), "mixed")
    with pytest.raises(UsageError, match="flat level"):
        Patterns(mixed)


def test_text_and_options():
    for name in FAMILIES:
        method = Patterns(name)
        assert method.text() == f"patterns:{name}"
        assert method == Patterns(FAMILIES[name])
        assert hash(method) == hash(Patterns(FAMILIES[name]))
    with pytest.raises(UsageError, match="does not apply"):
        dither(np.zeros((2, 2), np.float32), Patterns("4"), strength=0.5)
    with pytest.raises(UsageError, match="unknown pattern family"):
        Patterns("nine")
