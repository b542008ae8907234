"""Steps of a source: applied to the table of codes they equal the steps on light, bit for bit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halftone._arrays import Source
from halftone.tone import encoding
from halftone.tone.adjust import auto_levels, brightness, contrast, invert
from halftone.tone.range import clip, compress, scale
from tests.strategies import shapes

amounts = st.floats(-1, 1)
steps = st.lists(
    st.one_of(
        st.builds(brightness, amounts),
        st.builds(contrast, amounts),
        st.builds(invert),
        st.builds(clip, st.just(0.02), st.just(0.9)),
        st.builds(scale, st.floats(0.01, 2)),
        st.builds(compress, st.floats(0.5, 2)),
    ),
    min_size=1,
    max_size=5,
)
names = st.sampled_from(["srgb", "linear", "gamma:2.2"])
seeds = st.integers(0, 2**32 - 1)


def random_codes(shape: tuple[int, ...], seed: int, kind: type = np.uint8) -> np.ndarray:
    top = np.iinfo(kind).max
    codes = np.random.default_rng(seed).integers(0, top, shape, endpoint=True).astype(kind)
    codes.flags.writeable = False
    return codes


def in_turn(light: np.ndarray, functions) -> np.ndarray:
    light = light.copy()
    light.flags.writeable = False  # a step that wrote into its argument would fail
    for function in functions:
        light = function(light)
        light.flags.writeable = False
    return light


@given(shapes, seeds, names, steps)
def test_steps_on_the_table_are_the_steps_on_light(shape, seed, name, functions):
    codes, table = random_codes(shape, seed), encoding(name).table(256)
    source = Source(codes, table).then(*functions)
    expected = in_turn(table[codes], functions)
    assert source.steps == ()  # taken by the table, at once
    found, light = source.codes()
    assert found is codes
    np.testing.assert_array_equal(light[codes], expected)
    np.testing.assert_array_equal(source.band(0, shape[0]), expected)


@given(shapes, seeds, steps)
def test_light_takes_its_steps_band_by_band(shape, seed, functions):
    light = encoding("srgb").table(256)[random_codes(shape, seed)]
    source = Source(light).then(*functions)
    expected = in_turn(light, functions)
    np.testing.assert_array_equal(source.band(0, shape[0]), expected)
    for row in range(shape[0]):
        np.testing.assert_array_equal(source.band(row, row + 1), expected[row : row + 1])


@given(shapes, seeds, steps, steps)
def test_steps_can_be_given_in_turn(shape, seed, first, second):
    codes, table = random_codes(shape, seed), encoding("srgb").table(256)
    for source in (Source(codes, table), Source(table[codes])):
        once = source.then(*first, *second).band(0, shape[0])
        np.testing.assert_array_equal(source.then(*first).then(*second).band(0, shape[0]), once)


@given(seeds, steps, steps)
def test_steps_given_from_the_start_come_first(seed, first, second):
    codes, table = random_codes((5, 6), seed), encoding("srgb").table(256)
    expected = in_turn(table[codes], [*first, *second])
    for start in (Source(codes, table), Source(table[codes])):
        source = replace(start, steps=tuple(first))
        np.testing.assert_array_equal(source.band(0, 5), in_turn(table[codes], first))
        np.testing.assert_array_equal(source.then(*second).band(0, 5), expected)


@given(seeds, steps)
def test_16_bit_codes_take_steps_by_their_table(seed, functions):
    codes, table = random_codes((9, 11), seed, np.uint16), encoding("srgb").table(65536)
    source = Source(codes, table).then(*functions)
    np.testing.assert_array_equal(source.band(0, 9), in_turn(table[codes], functions))
    np.testing.assert_array_equal(source.codes()[1][codes], in_turn(table[codes], functions))


@given(shapes, seeds, steps)
def test_neutral_colour_is_the_gray_of_the_same_codes(shape, seed, functions):
    gray, table = random_codes(shape, seed), encoding("srgb").table(256)
    colour = Source(np.repeat(gray[:, :, None], 3, axis=2), table).then(*functions)
    assert colour.codes() is None
    expected = Source(gray, table).then(*functions).band(0, shape[0])
    np.testing.assert_array_equal(colour.band(0, shape[0]), expected)


@given(shapes, seeds)
def test_auto_levels_of_codes_and_of_light_are_the_same_step(shape, seed):
    codes, table = random_codes(shape, seed), encoding("srgb").table(256)
    coded, plain = Source(codes, table), Source(table[codes])
    np.testing.assert_array_equal(
        coded.then(auto_levels(coded)).band(0, shape[0]),
        plain.then(auto_levels(plain)).band(0, shape[0]),
    )


@pytest.mark.parametrize("kind", ["codes", "light"])
def test_the_source_and_its_picture_stay_as_they_were(kind):
    table = encoding("srgb").table(256)
    codes = random_codes((6, 7), 1)
    picture = codes if kind == "codes" else table[codes]
    kept, whole = picture.copy(), table.copy()
    source = Source(picture, table if kind == "codes" else None)
    later = source.then(brightness(0.5), contrast(0.5), invert(), compress(1), clip(0, 1))
    assert (later.band(0, 6) != source.band(0, 6)).any()
    np.testing.assert_array_equal(source.band(0, 6), whole[codes])
    np.testing.assert_array_equal(picture, kept)
    np.testing.assert_array_equal(table, whole)
