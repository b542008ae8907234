"""Error diffusion against its slow twins, the textbook in fractions, and the published tables."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halftone import ErrorDiffusion, ErrorFilter, UsageError, dither
from halftone.dithering import FILTERS
from tests.oracle import diffusion as oracle
from tests.strategies import ladders, light

filters = st.sampled_from(sorted(FILTERS))


@given(light(-0.2, 1.2), ladders(), filters, st.booleans(), st.booleans(), st.sampled_from([1, 0.6, 0]))
def test_light_kernel_equals_its_twin(picture, levels, name, serpentine, right, strength):
    method = ErrorDiffusion(name, serpentine, strength, right)
    table = FILTERS[name]
    expected = oracle.diffuse_light(
        picture, levels, table.taps, table.divisor, serpentine, strength, right
    )
    np.testing.assert_array_equal(dither(picture, method, levels=levels), expected)


@given(st.integers(1, 40), st.integers(1, 60), st.integers(0, 2**32 - 1), st.booleans(), st.booleans())
def test_code_kernel_equals_its_twin(height, width, seed, serpentine, right):
    codes = np.random.default_rng(seed).integers(0, 256, (height, width)).astype(np.uint8)
    frame = dither(codes, ErrorDiffusion("floyd-steinberg", serpentine, 1.0, right), encoding="linear")
    np.testing.assert_array_equal(frame, oracle.diffuse_codes(codes, serpentine, right))


def test_codes_at_the_extremes_of_the_integer_kernel():
    for codes in (
        np.tile(np.uint8([0, 255]), (64, 64)),
        np.full((64, 128), 127, np.uint8),
        np.full((64, 128), 128, np.uint8),
        np.kron(np.uint8([[0, 255], [255, 0]]), np.ones((32, 32), np.uint8)),
    ):
        frame = dither(codes, "fs:raster", encoding="linear")
        np.testing.assert_array_equal(frame, oracle.diffuse_codes(codes, False))


@given(
    st.lists(st.lists(st.integers(0, 16), min_size=3, max_size=3), min_size=3, max_size=3),
    st.sampled_from([[0, 16], [0, 4, 16], [0, 5, 10, 16]]),
)
def test_three_by_three_by_hand(codes, levels):
    """Multiples of 1/16 stay exact in float32 for three rows, so the textbook must agree."""
    taps = [(0, 1, 7), (1, -1, 3), (1, 0, 5), (1, 1, 1)]
    exact = oracle.diffuse_exactly(
        [[Fraction(c, 16) for c in row] for row in codes],
        [Fraction(v, 16) for v in levels],
        taps,
        16,
    )
    frame = dither(np.array(codes, np.float32) / 16, "fs:raster", levels=[v / 16 for v in levels])
    assert frame.indices.tolist() == exact


def test_one_small_picture_worked_by_hand():
    """0.5 → 1 (error −½): right 0.5 − 7/32 = 0.28 → 0; and so on."""
    frame = dither(np.full((2, 2), 0.5, np.float32), "fs:raster")
    # row 0: 0.5 → 1; 0.5 − 0.21875 = 0.28125 → 0, error 0.28125
    # row 1: 0.5 − 5/32 + 3·0.28125/16 = 0.396484 → 0, error 0.396484
    #        0.5 − 1/32 + 5·0.28125/16 + 7·0.396484/16 = 0.730103 → 1
    assert frame.indices.tolist() == [[1, 0], [0, 1]]


@pytest.mark.parametrize(
    ("name", "weights", "total"),
    [
        ("floyd-steinberg", [7, 3, 5, 1], 1),
        ("false-floyd-steinberg", [3, 3, 2], 1),
        ("jarvis-judice-ninke", [7, 5, 3, 5, 7, 5, 3, 1, 3, 5, 3, 1], 1),
        ("stucki", [8, 4, 2, 4, 8, 4, 2, 1, 2, 4, 2, 1], 1),
        ("burkes", [8, 4, 2, 4, 8, 4, 2], 1),
        ("sierra", [5, 3, 2, 4, 5, 4, 2, 2, 3, 2], 1),
        ("sierra-two-row", [4, 3, 1, 2, 3, 2, 1], 1),
        ("sierra-lite", [2, 1, 1], 1),
        ("atkinson", [1, 1, 1, 1, 1, 1], 0.75),
        ("stevenson-arce", [32, 6, 13, 10, 19, 10, 18, 8, 12, 26, 12, 3, 6, 4, 8, 4, 7, 2], 1),
        ("shiau-fan", [8, 1, 1, 2, 4], 1),
        ("shiau-fan-2", [7, 1, 3, 5], 1),
    ],
)
def test_published_weights(name, weights, total):
    table = FILTERS[name]
    assert [w for _, _, w in table.taps] == weights
    assert sum(weights) / table.divisor == total
    assert table.conserves == (total == 1)


def test_every_filter_has_its_weights_tested():
    assert len(FILTERS) == 12


@given(light(), filters, st.booleans(), ladders())
def test_mirror(picture, name, serpentine, levels):
    """A mirrored picture started from the right gives the mirrored result."""
    left = dither(picture, ErrorDiffusion(name, serpentine), levels=levels)
    right = dither(picture[:, ::-1], ErrorDiffusion(name, serpentine, from_right=True), levels=levels)
    np.testing.assert_array_equal(np.asarray(right)[:, ::-1], left)


@given(light(), ladders())
def test_strength_zero_is_the_nearest_level(picture, levels):
    none = np.asarray(dither(picture, "none", levels=levels)).astype(int)
    zero = np.asarray(dither(picture, "fs:strength=0", levels=levels)).astype(int)
    distinct = np.unique(np.float32(levels)).astype(np.float64)
    middle = (distinct[1:] + distinct[:-1]) / 2
    clipped = np.clip(picture, distinct[0], distinct[-1]).astype(np.float64)
    # A value halfway between two levels may go either way.
    tie = np.isclose(clipped[..., None], middle, rtol=0, atol=1e-7).any(axis=-1)
    assert ((none == zero) | tie).all()


def test_any_four_weights_and_no_more_than_one():
    picture = np.full((64, 64), 0.3, np.float32)
    own = dither(picture, "ed:4,4,4,4/16")
    table = [(0, 1, 4), (1, -1, 4), (1, 0, 4), (1, 1, 4)]
    np.testing.assert_array_equal(own, oracle.diffuse_light(picture, [0, 1], table, 16))
    np.testing.assert_array_equal(dither(picture, "ed:7,3,5,1/16"), dither(picture, "fs"))
    for text in ("ed:7,3,5,2/16", "ed:1,1,1/4", "ed:7,3,5,-1/16", "ed:7,3,5,x/16", "ed:0,0,0,0/0"):
        with pytest.raises(UsageError):
            dither(picture, text)


@pytest.mark.parametrize(
    "taps",
    [
        ((0, -1, 1),),
        ((0, 0, 1),),
        ((0, 3, 1),),
        ((1, 9, 1),),
        ((1, 0, 1), (1, 0, 1)),
        ((1, 0, float("nan")),),
    ],
)
def test_taps_that_cannot_be_scanned_are_refused(taps):
    with pytest.raises(UsageError):
        ErrorFilter("own", taps, 4)


@pytest.mark.parametrize("name", sorted(FILTERS))
def test_wind_up(name):
    """Light that no level can pay must not reach the rows after it."""
    picture = np.full((330, 96), 0.4, np.float32)
    picture[:300] = -3.0
    dark = dither(picture, name, levels=[0.05, 1.0]).luminance
    picture[:] = 0.4
    picture[:50] = 4.0
    bright = dither(picture, name, levels=[0.05, 0.9]).luminance
    clean = dither(picture[50:], name, levels=[0.05, 0.9]).luminance
    assert (dark[:300] == np.float32(0.05)).all()
    assert (bright[:50] == np.float32(0.9)).all()
    # 8 rows in, the tone is that of a patch which started there, within .02.
    tone = clean[8:200].mean()
    assert abs(bright[58:].mean() - tone) <= 0.02
    assert (
        abs(
            dark[308:].mean() - dither(picture[:22] * 0 + 0.4, name, levels=[0.05, 1.0]).luminance.mean()
        )
        <= 0.05
    )
