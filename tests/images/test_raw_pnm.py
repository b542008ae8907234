"""Raw PNM read by ourselves: what OpenImageIO and Pillow read, and exact where they are not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halftone.errors import InputFileError
from halftone.images.raw_pnm import raw_pnm
from halftone.images.read import read_picture

GAPS = [b"\n", b" ", b"\r\n", b"\t \n", b"\n# a comment\n", b"#\n", b" # 7 7\n# 8\n "]


def _body(kind: bytes, values: np.ndarray, maxval: int) -> bytes:
    if kind == b"P4":
        return np.packbits(values == 0, axis=1).tobytes()
    return values.astype(np.uint8 if maxval < 256 else ">u2").tobytes()


@pytest.mark.parametrize("maxval", [1, 3, 5, 15, 51, 100, 254, 255, 257, 1000, 4095, 65535])
@pytest.mark.parametrize("kind", [b"P5", b"P6"])
def test_codes_are_values_over_maxval(kind: bytes, maxval: int, tmp_path: Path) -> None:
    """To the nearest 16-bit code; 8 bits where these hold them exactly, as OpenImageIO gives."""
    shape = (300, 7) if kind == b"P5" else (300, 7, 3)
    values = np.random.default_rng(maxval).integers(0, maxval + 1, shape)
    path = tmp_path / "a.pnm"
    path.write_bytes(kind + b"\n7 300\n%d\n" % maxval + _body(kind, values, maxval))
    pixels = read_picture(path).pixels[:]
    assert pixels.shape == shape
    full = np.iinfo(pixels.dtype).max
    assert np.array_equal(pixels, np.rint(values * (full / maxval)))
    if pixels.dtype == np.uint8:
        assert 255 % maxval == 0
    file = oiio.ImageInput.open(str(path))
    theirs = np.asarray(file.read_image(0, 0, 0, file.spec().nchannels, "unknown")).reshape(shape)
    file.close()
    if pixels.dtype == theirs.dtype:
        assert np.abs(pixels.astype(int) - theirs).max() <= (0 if full % maxval == 0 else 1)
    else:
        assert np.abs(pixels / full - theirs / np.iinfo(theirs.dtype).max).max() <= 1 / 255


@given(width=st.integers(1, 40), height=st.integers(1, 9), seed=st.integers(0, 2**32 - 1))
def test_pbm_of_any_width(width: int, height: int, seed: int, tmp_path: Path) -> None:
    white = np.random.default_rng(seed).integers(0, 2, (height, width))
    path = tmp_path / "a.pbm"
    path.write_bytes(b"P4 %d %d\n" % (width, height) + _body(b"P4", white, 1))
    assert np.array_equal(read_picture(path).pixels[:], white * 255)


@given(*[st.sampled_from(GAPS)] * 3, st.sampled_from([b"\n", b" ", b"\t"]))
def test_headers_of_any_form(one: bytes, two: bytes, three: bytes, last: bytes) -> None:
    head = b"P5" + one + b"12" + two + b"34" + three + b"200" + last
    found = raw_pnm(head + b"#\n 1")
    assert found is not None
    assert (found.width, found.height, found.maxval, found.start) == (12, 34, 200, len(head))


@pytest.mark.parametrize(
    "head",
    [b"", b"P5", b"P7\n1 1\n255\n", b"P2\n1 1\n255\n", b"P512 1 255\n", b"P5\n0 1\n255\n",
     b"P5\n1 1\n0\n", b"P5\n1 1\n65536\n", b"P5\n1 1\n", b"P5\n-1 1\n255\n", b"P5\nx 1\n255\n"],
)  # fmt: skip
def test_what_is_no_raw_pnm(head: bytes) -> None:
    assert raw_pnm(head) is None


def test_values_above_maxval_are_white(tmp_path: Path) -> None:
    (tmp_path / "a.pgm").write_bytes(b"P5\n3 1\n3\n\x00\x03\xff")
    assert read_picture(tmp_path / "a.pgm").pixels[:].tolist() == [[0, 255, 255]]


@pytest.mark.parametrize("missing", [1, 30, 1000])
def test_cut_off(missing: int, tmp_path: Path) -> None:
    path = tmp_path / "a.pgm"
    path.write_bytes(b"P5\n40 30\n255\n" + bytes(1200 - missing))
    with pytest.raises(InputFileError, match="cut off.*row"):
        read_picture(path).pixels[0:1]


def test_a_file_that_becomes_shorter(tmp_path: Path) -> None:
    path = tmp_path / "a.pgm"
    path.write_bytes(b"P5\n400 300\n255\n" + bytes(120_000))
    read = read_picture(path, keep=1)
    read.pixels[0:1]
    path.write_bytes(b"P5\n400 300\n255\n" + bytes(30_000))
    with pytest.raises(InputFileError, match="cut off"):
        read.pixels[200:300]
