"""PNG, TIFF, PBM and PGM: what Pillow and OpenImageIO read back is what was put in."""

from __future__ import annotations

import io
import os
import struct
import tempfile
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest
from hypothesis import given, settings
from PIL import Image

from halftone.errors import UsageError
from halftone.frame import Frame
from halftone.images import png, tiff, write
from halftone.tone.levels import Levels
from tests.images.strategies import frames


def _by_openimageio(data: bytes, ending: str) -> tuple[np.ndarray, oiio.ImageSpec]:
    """8-bit codes (M, N, C), and what the file says."""
    handle, name = tempfile.mkstemp(suffix=f".{ending}")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        picture = oiio.ImageInput.open(name)
        assert picture is not None, oiio.geterror()
        spec = picture.spec()
        pixels = picture.read_image(0, 0, 0, spec.nchannels, "uint8")
        assert not picture.geterror()
        picture.close()
    finally:
        Path(name).unlink()
    return np.asarray(pixels).reshape(spec.height, spec.width, spec.nchannels), spec


def _check(frame: Frame, data: bytes, ending: str) -> Image.Image:
    """All that every format must keep; returns Pillow's picture."""
    codes = frame.preview()
    with Image.open(io.BytesIO(data)) as picture:
        picture.load()
    assert picture.size == frame.shape[::-1]
    assert np.array_equal(np.asarray(picture.convert("RGB")), np.dstack([codes] * 3))
    pixels, _ = _by_openimageio(data, ending)
    assert np.array_equal(pixels, codes[:, :, None].repeat(pixels.shape[2], axis=2))
    # The levels' codes all differ, so that codes are indices.
    back = np.searchsorted(frame.levels.srgb(), pixels[:, :, 0])
    assert np.array_equal(back, frame.indices)
    return picture


def _ihdr(data: bytes) -> tuple[int, ...]:
    return struct.unpack(">IIBBBBB", data[16:29])


@given(frames())
@settings(max_examples=150)
def test_png_round_trip(frame: Frame) -> None:
    data = png.encode(frame)
    picture = _check(frame, data, "png")
    width, height, depth, colour, *rest = _ihdr(data)
    assert (height, width) == frame.shape
    assert depth == frame.levels.bits
    assert rest == [0, 0, 0]
    if colour == 3:
        assert np.array_equal(np.asarray(picture), frame.indices)
        assert picture.getpalette()[: 3 * len(frame.levels) : 3] == frame.levels.srgb().tolist()
    else:
        assert colour == 0
        assert len(frame.levels) == 1 << depth
    if frame.dpi is None:
        assert "dpi" not in picture.info
    else:
        assert picture.info["dpi"] == pytest.approx(frame.dpi, abs=0.02)


@given(frames())
@settings(max_examples=150)
def test_tiff_round_trip(frame: Frame) -> None:
    data = tiff.encode(frame)
    picture = _check(frame, data, "tif")
    assert picture.tag_v2[258] == (frame.levels.bits,)
    if picture.mode == "P":
        assert np.array_equal(np.asarray(picture), frame.indices)
    if frame.dpi is None:
        assert 282 not in picture.tag_v2
    else:
        assert picture.info["dpi"] == pytest.approx(frame.dpi, abs=0.001)


def test_tiff_of_many_strips() -> None:
    """More than 64 KiB of rows; a row that alone is longer; and the same in 1 bit."""
    random = np.random.default_rng(3)
    shapes = {(700, 333): 256, (3, 70_001): 200, (2000, 1001): 2, (1500, 701): 3}
    for shape, count in shapes.items():
        frame = Frame(random.integers(0, count, shape, np.uint8), Levels.of(count))
        picture = _check(frame, tiff.encode(frame), "tif")
        assert len(picture.tag_v2[273]) > 1


@pytest.mark.parametrize("encode", [png.encode, tiff.encode])
@pytest.mark.parametrize("count", [2, 4, 16, 256])
def test_gray_where_the_levels_are_srgbs_own(encode: object, count: int) -> None:
    indices = np.arange(count, dtype=np.uint8).reshape(2, -1)
    own = io.BytesIO(encode(Frame(indices, Levels.of(count))))
    other = io.BytesIO(encode(Frame(indices, Levels.of(f"log:0.02:{count}"))))
    with Image.open(own) as gray, Image.open(other) as palette:
        assert gray.mode in ("1", "L")
        assert palette.mode == "P"


@given(frames(most=2))
def test_pbm_round_trip(frame: Frame) -> None:
    height, width = frame.shape
    data = write.encode(frame, "pbm")
    head = b"P4\n%d %d\n" % (width, height)
    assert data.startswith(head)
    assert len(data) == len(head) + height * ((width + 7) // 8)
    with Image.open(io.BytesIO(data)) as picture:
        assert np.array_equal(np.asarray(picture), frame.indices == 1)
    pixels, _ = _by_openimageio(data, "pbm")
    assert np.array_equal(pixels[:, :, 0] == 255, frame.indices == 1)
    assert set(np.unique(pixels)) <= {0, 255}


@given(frames())
@settings(max_examples=80)
def test_pgm_round_trip(frame: Frame) -> None:
    height, width = frame.shape
    data = write.encode(frame, "pgm")
    magic, size, top, pixels = data.split(b"\n", 3)
    assert (magic, size) == (b"P5", b"%d %d" % (width, height))
    values = np.frombuffer(pixels, np.uint8).reshape(height, width)
    assert int(top) in (len(frame.levels) - 1, 255)
    if int(top) == len(frame.levels) - 1:
        assert np.array_equal(values, frame.indices)
    assert np.array_equal(np.rint(values * 255.0 / int(top)), frame.preview())
    with Image.open(io.BytesIO(data)) as picture:
        assert np.abs(np.asarray(picture).astype(int) - frame.preview()).max() <= 1
    read, _ = _by_openimageio(data, "pgm")
    assert np.abs(read[:, :, 0].astype(int) - frame.preview()).max() <= 1


def test_pbm_refuses_three_levels() -> None:
    with pytest.raises(UsageError, match="3"):
        write.encode(Frame(np.zeros((2, 2), np.uint8), Levels.of(3)), "pbm")


def test_png_of_what_is_seen() -> None:
    codes = np.arange(6, dtype=np.uint8).reshape(2, 3) * 50
    for array in (codes, np.asfortranarray(codes), codes[:, ::-1]):
        file = io.BytesIO()
        png.write_preview(Frame(array, Levels.of(256), dpi=(300.0, 150.0)).bands(), file)
        data = file.getvalue()
        assert _ihdr(data) == (3, 2, 8, 0, 0, 0, 0)
        with Image.open(io.BytesIO(data)) as picture:
            assert np.array_equal(np.asarray(picture), array)
            assert picture.info["dpi"] == pytest.approx((300, 150), abs=0.02)


@pytest.mark.parametrize("ending", ["png", "tif", "pbm", "pgm", "raw"])
def test_saving_is_repeatable_and_says_no_time(ending: str, tmp_path: Path) -> None:
    frame = Frame(np.eye(9, dtype=np.uint8), Levels.of(2), dpi=(100.0, 100.0))
    frame.save(tmp_path / f"a.{ending}")
    frame.save(tmp_path / f"b.{ending}")
    assert (tmp_path / f"a.{ending}").read_bytes() == (tmp_path / f"b.{ending}").read_bytes()


def test_an_upscaled_frame_keeps_its_size_on_paper() -> None:
    frame = Frame(np.eye(4, dtype=np.uint8), Levels.of(2), dpi=(100.0, 50.0)).upscaled(3)
    with Image.open(io.BytesIO(png.encode(frame))) as picture:
        assert picture.size == (12, 12)
        assert picture.info["dpi"] == pytest.approx((300, 150), abs=0.02)
