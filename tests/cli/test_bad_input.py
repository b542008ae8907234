"""Pictures that cannot be used: exit code 3, one line that names the file, nothing written."""

from __future__ import annotations

import io
import os
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.cli.command import names_in, run
from tests.cli.files import GRAY, chunk, light_of, png_of, shown, write_oiio

NOISE = np.random.default_rng(5).integers(0, 256, (30, 40, 3), np.uint8)


def _encoded(kind: str, **options: object) -> bytes:
    file = io.BytesIO()
    Image.fromarray(NOISE).save(file, kind, **options)
    return file.getvalue()


def _damaged_crc() -> bytes:
    data = bytearray(_encoded("PNG"))
    data[len(data) // 2] ^= 0xFF
    return bytes(data)


BAD: dict[str, tuple[bytes, str]] = {
    "empty.png": (b"", "empty"),
    "text.png": (b"Dear reader,\n" * 20, "not a picture"),
    "text.jpg": (b"Dear reader,\n" * 20, "not a picture"),
    "zeros.tif": (bytes(1000), "not a picture"),
    "only-signature.png": (b"\x89PNG\r\n\x1a\n", "not a picture"),
    "no-width.png": (png_of(0, 5, 8, 0, b""), "not a picture"),
    "no-size.pgm": (b"P5\n0 0\n255\n", "not a picture"),
    "bad-crc.png": (_damaged_crc(), "damaged"),
    "cut.png": (_encoded("PNG")[:-400], "damaged"),
    "cut.jpg": (_encoded("JPEG")[:-400], "damaged"),
    "cut-in-header.jpg": (_encoded("JPEG")[:100], ""),
    "cut.bmp": (_encoded("BMP")[:-400], ""),
    "cut.tif": (_encoded("TIFF", compression="tiff_lzw")[:-400], ""),
    "cut.webp": (_encoded("WEBP")[:-400], ""),
    "cut.pgm": (b"P5\n40 30\n255\n" + bytes(1000), ""),
    "cut.ppm": (b"P6\n40 30\n255\n" + bytes(1000), ""),
}


@pytest.mark.parametrize("name", BAD)
def test_is_named_in_one_line(name: str, tmp_path: Path) -> None:
    data, what = BAD[name]
    path = tmp_path / name
    path.write_bytes(data)
    line = run("convert", path, tmp_path / "out.png").complaint(3)
    assert line.startswith(f"halftone: '{path}' ")
    assert what in line
    assert names_in(tmp_path) == [name]


@pytest.mark.parametrize("name", ["nowhere.png", "no/such/folder.png", "x" * 300 + ".png"])
def test_missing(name: str, tmp_path: Path) -> None:
    assert name in run("convert", tmp_path / name, tmp_path / "out.png").complaint(3)


def test_a_folder(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    line = run("convert", tmp_path / "folder", tmp_path / "out.png").complaint(3)
    assert "is a folder" in line


def test_unreadable(gray: Path, tmp_path: Path) -> None:
    path = tmp_path / "closed.png"
    path.write_bytes(gray.read_bytes())
    path.chmod(0)
    if os.access(path, os.R_OK):
        pytest.skip("this user may read everything")
    assert str(path) in run("convert", path, tmp_path / "out.png").complaint(3)


@pytest.mark.parametrize("kind", ["png", "pgm", "bmp", "tif"])
def test_a_huge_size_is_refused_by_the_header_alone(kind: str, tmp_path: Path) -> None:
    """100,000² pixels in a file of some hundred bytes; 60,000² as more are no PGM here."""
    path = tmp_path / f"huge.{kind}"
    if kind == "png":
        path.write_bytes(png_of(100_000, 100_000, 8, 0, bytes(100)))
    elif kind == "pgm":
        path.write_bytes(b"P5\n60000 60000\n255\n" + bytes(100))
    else:
        Image.fromarray(GRAY).save(path)
        data = bytearray(path.read_bytes())
        if kind == "bmp":
            data[18:26] = (100_000).to_bytes(4, "little") * 2
        else:
            directory = int.from_bytes(data[4:8], "little")
            for entry in (directory + 2, directory + 14):  # width and height come first
                assert int.from_bytes(data[entry : entry + 2], "little") in (256, 257)
                data[entry + 2 : entry + 12] = bytes([4, 0, 1, 0, 0, 0, 0xA0, 0x86, 1, 0])
        path.write_bytes(data)
    start = time.monotonic()
    line = run("convert", path, tmp_path / "out.png", timeout=20).complaint(3)
    assert time.monotonic() - start < 10
    assert str(path) in line


def test_a_picture_beyond_the_memory_limit(tmp_path: Path) -> None:
    """2000 × 1500 gray pixels: 3 MB as stored alone."""
    path = tmp_path / "in.png"
    Image.new("L", (2000, 1500), 255).save(path)
    for size in ("2.5M", "2", "2900k"):
        line = run("convert", path, tmp_path / "out.png", "--max-memory", size).complaint(3)
        assert str(path) in line
        assert "2000 × 1500" in line
        assert "--max-memory" in line
    assert run("convert", path, tmp_path / "out.png", "--max-memory", "0.2G").code == 0


def test_nan_is_refused_with_its_place(tmp_path: Path) -> None:
    light = np.full((90, 70), 0.5, np.float32)
    light[71, 13] = np.nan
    write_oiio(tmp_path / "nan.exr", light, "float")
    line = run("convert", tmp_path / "nan.exr", tmp_path / "out.png").complaint(3)
    assert "row 71, column 13" in line
    assert str(tmp_path / "nan.exr") in line
    assert "--nonfinite clip" in line


@pytest.mark.parametrize("more", [(), ("--size", "35x45")])
def test_nonfinite_clip_shows_black_and_white(more: tuple[str, ...], tmp_path: Path) -> None:
    """NaN is black, +inf white and −inf black, and what lies apart is as it was."""
    light = np.tile(light_of([[0, 85, 170, 255, 170]]), (90, 14)).astype(np.float32)
    light[0:30] = np.nan
    light[30:60, :35] = np.inf
    light[30:60, 35:] = -np.inf
    write_oiio(tmp_path / "in.exr", light[:, :, None].repeat(3, 2), "float")
    args = ("-l", "4", "-m", "none", "--nonfinite", "clip", *more)
    result = run("convert", tmp_path / "in.exr", tmp_path / "out.png", *args)
    assert (result.code, result.err) == (0, "")
    codes = shown(tmp_path / "out.png")
    third, half = codes.shape[0] // 3, codes.shape[1] // 2
    assert (codes[2 : third - 2] == 0).all()
    assert (codes[third + 2 : 2 * third - 2, 2 : half - 2] == 255).all()
    assert (codes[third + 2 : 2 * third - 2, half + 2 :] == 0).all()
    if not more:
        assert np.array_equal(codes[60:, :5], [[0, 85, 170, 255, 170]] * 30)


def test_signed_integers(tmp_path: Path) -> None:
    write_oiio(tmp_path / "in.tif", GRAY.astype(np.int16), "int16")
    assert "int16" in run("convert", tmp_path / "in.tif", tmp_path / "out.png").complaint(3)


def test_a_picture_under_another_ending(gray: Path, tmp_path: Path) -> None:
    """Not bad at all: what a file is, its content says."""
    (tmp_path / "in.jpg").write_bytes(gray.read_bytes())
    result = run("convert", tmp_path / "in.jpg", tmp_path / "out.png")
    assert (result.code, result.err) == (0, "")


@pytest.mark.parametrize("good", [True, False])
def test_a_name_that_is_not_utf_8(good: bool, gray: Path, tmp_path: Path) -> None:
    path = Path(os.fsdecode(os.fsencode(tmp_path) + b"/\xff\xfe.png"))
    path.write_bytes(gray.read_bytes() if good else b"text")
    result = run("convert", path, tmp_path / "out.png")
    if good:
        assert (result.code, result.err) == (0, "")
    else:
        result.complaint(3)


def test_a_name_of_two_lines_is_said_in_one(tmp_path: Path) -> None:
    path = tmp_path / "two\nlines.png"
    path.write_bytes(b"text")
    run("convert", path, tmp_path / "out.png").complaint(3)


def test_an_unknown_chunk_is_no_damage(tmp_path: Path) -> None:
    more = chunk(b"quIz", b"?")
    (tmp_path / "in.png").write_bytes(png_of(2, 1, 8, 0, b"\0\0\xff", more))
    assert run("convert", tmp_path / "in.png", tmp_path / "out.png").code == 0
    assert shown(tmp_path / "out.png").tolist() == [[0, 255]]


def test_arrays_without_pixels() -> None:
    import halftone

    for shape in ((0, 5), (5, 0), (0, 0, 3), (0,), ()):
        with pytest.raises(halftone.InputError):
            halftone.convert(np.zeros(shape, np.float32))
