"""Masks from files and arrays, dots of a minimum size, and the text forms of screens."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from halftone import Ordered, Screen, UsageError, dither
from halftone.dithering.screened import NAMES, screen, screened
from halftone.screens import bayer
from halftone.screens.bluenoise import blue_noise
from halftone.screens.mask import is_even, mask, minimum_dot
from halftone.screens.named import named
from tests.strategies import ladders

RANKS = np.array([[3, 1, 4], [0, 2, 5]])
EXPECTED = ((RANKS + 0.5) / 6).astype(np.float32)


@pytest.fixture
def folder(tmp_path):
    """Files with the ranks above, or their thresholds, each in its own format."""
    np.save(tmp_path / "ranks.npy", RANKS)
    np.save(tmp_path / "thresholds.npy", EXPECTED)
    np.savez(tmp_path / "one.npz", anything=RANKS)
    np.savez(tmp_path / "named.npz", ranks=RANKS, seed=3)
    (tmp_path / "ranks.txt").write_text("# a comment\n3 1 4\n\n0 2 5  # more\n")
    (tmp_path / "ranks.csv").write_text("3, 1, 4\n0,2,5\n")
    (tmp_path / "thresholds.TXT").write_text("\n".join(" ".join(map(str, row)) for row in EXPECTED))
    return tmp_path


FILES = (
    "ranks.npy",
    "thresholds.npy",
    "one.npz",
    "named.npz",
    "ranks.txt",
    "ranks.csv",
    "thresholds.TXT",
)


@pytest.mark.parametrize("file", FILES)
def test_files(folder, file):
    made = mask(folder / file)
    np.testing.assert_array_equal(made.thresholds, EXPECTED)
    assert made.name == f"mask:{folder / file}"
    assert screened(made.name) == Ordered(made)
    assert (
        screened(f"mask:{folder / file}:dot=2x3:strength=0.5").text().endswith(":dot=2x3:strength=0.5")
    )


def test_arrays_are_not_changed():
    array = RANKS.copy()
    for given_array in (array, array.tolist(), array.astype(np.uint8), EXPECTED, EXPECTED.astype(float)):
        np.testing.assert_array_equal(mask(given_array).thresholds, EXPECTED)
    np.testing.assert_array_equal(array, RANKS)
    assert mask(array, "own").name == "own"


@pytest.mark.parametrize("suffix", [".png", ".tif", ".pgm"])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_gray_pictures(tmp_path, suffix, dtype):
    top = np.iinfo(dtype).max
    codes = np.array([[0, 1, top // 2], [top - 1, top, 7]], dtype)
    path = tmp_path / f"mask{suffix}"
    Image.fromarray(codes).save(path)
    expected = ((codes + 0.5) / (top + 1)).astype(np.float32)
    np.testing.assert_array_equal(mask(path).thresholds, expected)


def test_colon_and_case_in_a_file_name(tmp_path):
    path = tmp_path / "My:Mask 1.npy"
    np.save(path, RANKS)
    np.testing.assert_array_equal(screen(f"mask:{path}").thresholds, EXPECTED)


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        ([[0, 1], [2, 4]], "0 … 4 for 4 places"),
        ([[1, 2], [3, 4]], "subtract 1"),
        ([[-1, 0], [1, 2]], "−?-1 … 2"),
        ([[0, 0], [1, 2]], r"\[1, 2"),
        ([[0, 1, 1, 3]], "missing"),
        ([[0.5, np.nan]], "nan at row 0, column 1"),
        ([[0.5, 1.0]], "threshold 1 at row 0, column 1"),
        ([[0.0], [0.5]], "threshold 0 at row 0"),
        ([[np.inf, 0.5]], "inf"),
        ([0.5, 0.5], "shape"),
        (np.zeros((2, 2, 3)), "shape"),
        (np.zeros((0, 2)), "shape"),
        (np.zeros((1, 2049)), "shape"),
        ([["a", "b"]], "whole numbers"),
        ([[1, 2], [3]], "not an array|object"),
        ([[True, False]], "bool"),
        (None, "object"),
    ],
    ids=str,
)
def test_bad_arrays(bad, message):
    with pytest.raises(UsageError, match=message):
        mask(bad)


def test_bad_files(tmp_path):
    (tmp_path / "cut.npy").write_bytes(b"\x93NUMPY")
    (tmp_path / "empty.npy").write_bytes(b"")
    (tmp_path / "junk.npz").write_bytes(b"PK\x03\x04 junk")
    (tmp_path / "junk.png").write_bytes(b"junk")
    (tmp_path / "empty.txt").write_text("# nothing\n")
    (tmp_path / "ragged.csv").write_text("1,2\n3\n")
    (tmp_path / "words.txt").write_text("dark light\n")
    (tmp_path / "bytes.txt").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "huge.txt").write_text("99999999999999999999999 0\n")
    np.save(tmp_path / "object.npy", np.array([{}]), allow_pickle=True)
    np.savez(tmp_path / "two.npz", a=RANKS, b=RANKS)
    Image.new("RGB", (4, 4)).save(tmp_path / "rgb.png")
    Image.new("LA", (4, 4)).save(tmp_path / "alpha.png")
    Image.new("1", (4, 4)).save(tmp_path / "bilevel.png")
    Image.new("L", (2049, 1)).save(tmp_path / "wide.png")
    (tmp_path / "folder.npy").mkdir()
    for file in tmp_path.iterdir():
        with pytest.raises(UsageError, match=rf"mask:.*{file.name}"):
            mask(file)
    for missing in ("none.npy", "none.doc", "none"):
        with pytest.raises(UsageError, match="allowed|no such file"):
            mask(tmp_path / missing)
    for text in ("mask", "mask:", "mask::dot=2"):
        with pytest.raises(UsageError, match="names no file"):
            screen(text)


def test_the_largest_ranks_stay_below_one():
    count = 2048 * 2048
    made = mask(np.arange(count).reshape(2048, 2048))
    assert made.thresholds.max() < 1
    white = dither(np.ones((8, 2048), np.float32), Ordered(made))
    assert np.asarray(white).all()
    nearly = mask([[1 - 1e-12, 1e-300]])
    assert dither(np.array([[1.0, 0.0]], np.float32), Ordered(nearly)).indices.tolist() == [[1, 0]]


def test_uneven_masks_claim_no_tone(tmp_path):
    np.save(tmp_path / "curve.npy", np.linspace(0.1, 0.9, 64).reshape(8, 8) ** 2)
    made = screened(f"mask:{tmp_path / 'curve.npy'}")
    assert not is_even(made.screen)
    assert made.claim.kind == "none"
    for even in (bayer(8), blue_noise(), named("c5x5b"), named("h8x8a"), mask(EXPECTED)):
        assert is_even(even)
        assert Ordered(even).claim.tones == even.tones


@given(
    st.integers(1, 5),
    st.integers(1, 5),
    st.sampled_from(["bayer4", "h4x4a", "blue-noise:9x7:seed=1", "checks"]),
    ladders(),
    st.integers(0, 2**32 - 1),
)
def test_no_dot_is_smaller_than_asked(width, height, name, levels, seed):
    """A picture of blocks: every block is of one level, and as the screen alone would have it."""
    small = np.random.default_rng(seed).random((7, 9)).astype(np.float32)
    light = np.repeat(np.repeat(small, height, axis=0), width, axis=1)
    made = screened(f"{name}:dot={width}x{height}")
    shown = np.asarray(dither(light, made, levels=levels))
    expected = np.asarray(dither(small, name if name == "bayer4" else screened(name), levels=levels))
    np.testing.assert_array_equal(shown, np.repeat(np.repeat(expected, height, axis=0), width, axis=1))
    assert made.claim == screened(name).claim


@given(st.integers(2, 4), st.integers(2, 4), st.floats(0, 1))
def test_no_single_pixel_on_a_flat_patch(width, height, tone):
    """Each pixel has a like neighbour on its left or right, and one above or below, on a torus."""
    tile = minimum_dot(named("o8x8"), width, height).thresholds
    lit = np.float32(tone) > tile
    for axis in (0, 1):
        alike = (np.roll(lit, 1, axis) == lit) | (np.roll(lit, -1, axis) == lit)
        assert alike.all()


def test_minimum_dot_names_and_refusals():
    base = bayer(4)
    assert minimum_dot(base, 1) is base
    assert minimum_dot(base, 2).name == "bayer4:dot=2x2"
    assert minimum_dot(base, 2, 3).thresholds.shape == (12, 8)
    assert base.thresholds.shape == (4, 4)
    for bad in ((0,), (17,), (2, 0), (2.5,), (True,), ("2",)):
        with pytest.raises(UsageError, match="allowed: 1 … 16"):
            minimum_dot(base, *bad)


TEXTS = (
    "blue-noise",
    "blue-noise:12x8:seed=3",
    "blue-noise:8x8:sigma=1.9:dot=2x1",
    "h8x8a",
    "cluster4:dot=2x2",
    "bayer8",
    "bayer16:dot=1x2:strength=0.5",
)


@pytest.mark.parametrize("text", TEXTS)
def test_text_form(text):
    made = screened(text)
    assert made.text() == text
    assert screened(made.text()) == made


def test_names_are_loose():
    assert screen("Blue_Noise:8X8") == blue_noise(8, 8)
    assert screen(" H8x8A ") == named("h8x8a")
    assert isinstance(screen("checks"), Screen)
    assert "h16x16o" in NAMES
    assert screened("o3x3", 0.25).text() == "o3x3:strength=0.25"


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        ("", "unknown screen"),
        ("h8x8b", "h8x8a"),
        ("h8x8a:raster", "unknown; allowed: dot=2"),
        ("blue-noise:0x4", "allowed: 1, 2, … 512"),
        ("blue-noise:4x", "not a number"),
        ("blue-noise:900x4", "512"),
        ("blue-noise:seed=x", "not a number"),
        ("blue-noise:seed=-1", "2\\^64"),
        ("blue-noise:seed=1_0", "not a number"),
        ("blue-noise:sigma=nan", "0.5 … 4"),
        ("blue-noise:green", "unknown"),
        ("bayer8:dot=", "not a number"),
        ("bayer8:dot=0x2", "1 … 16"),
        ("bayer8:strength=", "not a number"),
        ("bayer8:strength=7", "strength"),
        ("bayer5", "bayer"),
    ],
)
def test_bad_text(bad, message):
    with pytest.raises(UsageError, match=message):
        screened(bad)
