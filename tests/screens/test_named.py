"""Maps of ImageMagick and netpbm: their numbers, even tones, and dots of a minimum size."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halftone import Ordered, Screen, UsageError, dither
from halftone.screens.bayer import bayer_ranks
from halftone.screens.named import NAMES, named, numbers
from tests.oracle import screens as oracle
from tests.strategies import ladders

SHAPES = {
    "checks": (2, 3), "o2x2": (2, 5), "o3x3": (3, 10), "o4x4": (4, 17), "o8x8": (8, 65),
    "h4x4a": (4, 9), "h6x6a": (6, 19), "h8x8a": (8, 33),
    "h4x4o": (4, 17), "h6x6o": (6, 37), "h8x8o": (8, 65), "h16x16o": (16, 257),
    "c5x5b": (5, 25), "c5x5w": (5, 26), "c6x6b": (6, 37), "c6x6w": (6, 37),
    "c7x7b": (7, 49), "c7x7w": (7, 50),
    "cluster3": (6, 19), "cluster4": (8, 33), "cluster8": (16, 129),
}  # fmt: skip
"""Side and tones; the tones are ImageMagick's divisors but for the two maps with a number twice."""


def test_sides_and_tones():
    assert set(NAMES) == set(SHAPES)
    for name, (side, tones) in SHAPES.items():
        assert named(name).thresholds.shape == (side, side)
        assert named(name).tones == tones
        assert named(name).name == name


def test_numbers_have_not_changed():
    """Read from the programs once."""
    text = "".join(f"{name}{numbers(name).tolist()}" for name in NAMES)
    assert (
        hashlib.sha256(text.encode()).hexdigest()
        == "fac146942eb660097961c1e43dd647b4ce8965fdad5ff243ec5d897a01bedfcb"
    )


@pytest.mark.parametrize("name", NAMES)
def test_thresholds_equal_their_twin(name):
    expected = np.float32(oracle.even_thresholds(numbers(name).tolist()))
    np.testing.assert_array_equal(named(name).thresholds, expected)


def test_numbers_as_printed():
    assert numbers("o3x3").tolist() == [[3, 7, 4], [6, 1, 9], [2, 8, 5]]
    assert numbers("h4x4a").tolist() == [[4, 2, 7, 5], [3, 1, 8, 6], [7, 5, 4, 2], [8, 6, 3, 1]]


@pytest.mark.parametrize("name", [n for n in NAMES if n.startswith(("h", "cluster")) and "o" not in n])
def test_angled_maps_are_two_cells(name):
    """A map at 45° repeats when moved by half its side both ways."""
    array = numbers(name)
    half = array.shape[0] // 2
    np.testing.assert_array_equal(np.roll(array, (half, half), (0, 1)), array)


@pytest.mark.parametrize("n", [2, 4, 8])
def test_imagemagicks_bayer_maps(n):
    """o2x2 and o4x4 are our Bayer arrays ranked from the other end; o8x8 is mirrored too."""
    theirs = n * n - numbers(f"o{n}x{n}")
    np.testing.assert_array_equal(theirs.T if n == 8 else theirs, bayer_ranks(n))


@given(st.sampled_from([n for n in NAMES if n not in ("c5x5b", "c7x7b")]), ladders(), st.data())
def test_tones_are_exact_on_whole_tiles(name, levels, data):
    """Between two neighbouring levels, k/(tones − 1) of a tile shows the upper one."""
    screen = named(name)
    distinct = np.unique(np.float32(levels)).astype(np.float64)
    i = data.draw(st.integers(0, distinct.size - 2))
    step = screen.tones - 1
    k = data.draw(st.integers(0, step))
    light = np.float32(distinct[i] + (distinct[i + 1] - distinct[i]) * k / step)
    shown = dither(np.full(screen.thresholds.shape, light, np.float32), Ordered(screen), levels=levels)
    if distinct[i + 1] - distinct[i] > 1e-4:  # closer levels leave float32 no room for the tones
        lit = shown.luminance.astype(np.float64) > distinct[i]
        assert lit.sum() * step == k * screen.thresholds.size
        assert set(np.unique(shown.luminance)) <= set(np.float32(distinct[i : i + 2]))


@pytest.mark.parametrize("name", ["c5x5b", "c7x7b"])
def test_maps_with_a_number_twice_are_within_half_a_step(name):
    screen = named(name)
    for k in range(256):
        lit = np.asarray(dither(np.full(screen.thresholds.shape, k / 255, np.float32), Ordered(screen)))
        assert abs(lit.mean() - k / 255) <= 1 / screen.thresholds.size + 1e-6  # half of two places


def test_unknown_name():
    with pytest.raises(UsageError, match="h8x8a"):
        named("h8x8")
    assert isinstance(named("h8x8a"), Screen)
