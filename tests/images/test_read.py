"""halftone.images.read: what the file says of its codes, its resolution and its orientation."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from halftone.errors import InputFileError
from halftone.images.read import read_picture
from tests.cli.files import chunk, light_of, png_of, write_gray_png, write_oiio

CODES = np.arange(0, 240, 10, dtype=np.uint8).reshape(4, 6)


def _png(path: Path, *more: bytes) -> Path:
    write_gray_png(path, CODES, 8, *more)
    return path


@pytest.mark.parametrize(
    ("gamma", "encoding"),
    [(100_000, "linear"), (45_455, "gamma:2.2"), (55_556, "gamma:1.8"), (50_000, "gamma:2.0")],
)
def test_png_gamma(gamma: int, encoding: str, tmp_path: Path) -> None:
    """gAMA holds 100,000 / γ."""
    read = read_picture(_png(tmp_path / "in.png", chunk(b"gAMA", struct.pack(">I", gamma))))
    kind, _, value = read.encoding.partition(":")
    expected, _, number = encoding.partition(":")
    assert kind == expected
    assert float(value or 1) == pytest.approx(float(number or 1), abs=0.01)


def test_png_srgb_goes_before_gamma(tmp_path: Path) -> None:
    more = chunk(b"sRGB", b"\0") + chunk(b"gAMA", struct.pack(">I", 45_455))
    assert read_picture(_png(tmp_path / "in.png", more)).encoding == "srgb"


@pytest.mark.parametrize("kind", ["png", "jpg", "tif", "bmp", "ppm", "webp"])
def test_integers_are_srgb(kind: str, tmp_path: Path) -> None:
    path = tmp_path / f"in.{kind}"
    Image.fromarray(CODES).convert("RGB").save(path)
    assert read_picture(path).encoding == "srgb"


@pytest.mark.parametrize(
    ("kind", "type"), [("exr", "half"), ("exr", "float"), ("tif", "float"), ("hdr", "float")]
)
def test_floats_are_light(kind: str, type: str, tmp_path: Path) -> None:
    path = tmp_path / f"in.{kind}"
    write_oiio(path, light_of(CODES).astype(np.float32)[:, :, None].repeat(3, 2), type)
    read = read_picture(path)
    assert read.encoding == "linear"
    assert read.pixels.dtype == np.float32
    assert np.abs(read.pixels[:][:, :, 0] - light_of(CODES)).max() < 0.005


def test_orientation_by_hand(tmp_path: Path) -> None:
    """TIFF 6.0, tag 274: where row 0 and column 0 of the file lie in the upright picture."""
    corners = {1: (0, 0), 2: (0, -1), 3: (-1, -1), 4: (-1, 0)}
    corners |= {5: (0, 0), 6: (0, -1), 7: (-1, -1), 8: (-1, 0)}
    stored = np.zeros((3, 5), np.uint8)
    stored[0] = (200, 100, 100, 100, 100)  # its first row, and its first pixel
    for orientation, (y, x) in corners.items():
        path = tmp_path / f"{orientation}.tif"
        Image.fromarray(stored).save(path, tiffinfo={274: orientation})
        upright = read_picture(path).pixels[:]
        assert upright[y, x] == 200
        edge = upright[:, x] if orientation >= 5 else upright[y]
        assert sorted(edge) == [100, 100, 100, 100, 200]
        assert np.count_nonzero(upright) == 5


@pytest.mark.parametrize("mode", ["LA", "RGBA"])
def test_alpha_is_kept_apart(mode: str, tmp_path: Path) -> None:
    channels = [CODES] * (1 if mode == "LA" else 3)
    alpha = CODES[::-1].copy()
    Image.fromarray(np.dstack([*channels, alpha])).save(tmp_path / "in.png")
    read = read_picture(tmp_path / "in.png")
    assert read.pixels.shape == (CODES.shape if mode == "LA" else (*CODES.shape, 3))
    assert np.array_equal(read.pixels[:].reshape(4, 6, -1)[:, :, 0], CODES)
    assert np.array_equal(read.alpha[:], alpha)
    assert not read.premultiplied


def test_the_limit_counts_the_window_that_is_held(tmp_path: Path) -> None:
    """1000 gray pixels across: a window of 384 rows and two pieces of 64, however high it is."""
    for height in (1000, 3000):
        path = tmp_path / f"{height}.png"
        Image.new("L", (1000, height)).save(path)
        assert read_picture(path, 513_000).pixels.shape == (height, 1000)
        with pytest.raises(InputFileError, match=f"1000 × {height}"):
            read_picture(path, 511_000)


def test_the_limit_counts_all_of_a_picture_that_is_held_whole(tmp_path: Path) -> None:
    """1000 × 1000 gray, to be turned: a megabyte as stored, and some more on the way."""
    path, exif = tmp_path / "in.png", Image.Exif()
    exif[274] = 6
    Image.new("L", (1000, 1000)).save(path, exif=exif)
    assert read_picture(path, 100_000_000).pixels.shape == (1000, 1000)
    with pytest.raises(InputFileError, match="1000 × 1000"):
        read_picture(path, 1_000_000)


def test_the_limit_is_met_before_the_pixels_are_read(tmp_path: Path) -> None:
    """20,000² interlaced in 380 MB is within reach of the library, and its pixels are not there."""
    path = tmp_path / "in.png"
    data = bytearray(png_of(20_000, 20_000, 1, 0, bytes(10_000)) + bytes(1 << 20))
    data[28] = 1
    data[29:33] = zlib.crc32(data[12:29]).to_bytes(4, "big")
    path.write_bytes(data)
    with pytest.raises(InputFileError) as caught:
        read_picture(path, 1 << 30)
    assert "20000 × 20000" in str(caught.value)


def test_a_color_palette_and_its_bit_depth(tmp_path: Path) -> None:
    """A palette is read as the colours it stands for."""
    palette = chunk(b"PLTE", bytes([10, 20, 30, 200, 100, 50]))
    (tmp_path / "in.png").write_bytes(png_of(3, 1, 1, 3, b"\0\x40", palette))
    pixels = read_picture(tmp_path / "in.png").pixels[:]
    assert pixels.tolist() == [[[10, 20, 30], [200, 100, 50], [10, 20, 30]]]
