"""Files out: true bit depths, palettes for levels that are not sRGB's own, and raw bytes."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.cli.command import run
from tests.cli.files import GRAY, codes_of, header_of, light_of, shown

HEIGHT, WIDTH = GRAY.shape
LADDER4 = "0.01,0.2,0.5,1"

DEPTHS = {
    "2": (1, 0),
    "4": (2, 0),
    "16": (4, 0),
    "256": (8, 0),
    "3": (2, 3),
    "5": (4, 3),
    "17": (8, 3),
    "uniform-linear:2": (1, 0),
    "0.02,1": (1, 3),
    LADDER4: (2, 3),
    "lstar:16": (4, 3),
    "log:0.02:200": (8, 3),
}
"""Levels, with the bit depth and the PNG colour type (0 gray, 3 palette) that they need."""


def _codes(levels: str) -> np.ndarray:
    """The sRGB codes of *levels*, as integers."""
    kind, _, rest = levels.partition(":")
    if kind == "uniform-linear":
        light = np.linspace(0, 1, int(rest))
    elif kind == "log":
        black, count = float(rest.split(":")[0]), int(rest.split(":")[1])
        light = black ** np.linspace(1, 0, count)
    elif kind == "lstar":
        star = np.linspace(0, 100, int(rest))
        light = np.where(star <= 8, star * (3 / 29) ** 3, ((star + 16) / 116) ** 3)
    elif "," in kind:
        light = np.array([float(v) for v in kind.split(",")])
    else:
        return np.rint(np.linspace(0, 255, int(kind))).astype(int)
    return np.rint(codes_of(light)).astype(int)


@pytest.fixture(scope="module")
def png(gray: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """The gray picture as a PNG with the levels named, converted when it is first asked for."""
    folder = tmp_path_factory.mktemp("levels")

    @cache
    def made(levels: str) -> Path:
        out = folder / f"{levels}.png"
        assert run("convert", gray, out, "-l", levels).code == 0
        return out

    return made


@pytest.mark.parametrize("levels", DEPTHS)
def test_png(levels: str, png: Callable[[str], Path]) -> None:
    out = png(levels)
    assert header_of(out.read_bytes()) == (WIDTH, HEIGHT, *DEPTHS[levels])
    codes = shown(out)
    assert set(np.unique(codes)) <= set(_codes(levels))
    assert abs(light_of(codes).mean() - light_of(GRAY).mean()) < 0.02


@pytest.mark.parametrize("levels", ["2", "4", "16", "256", "0.02,1", LADDER4, "log:0.02:200"])
def test_tiff(levels: str, png: Callable[[str], Path], gray: Path, tmp_path: Path) -> None:
    import OpenImageIO as oiio

    tiff = tmp_path / "out.tiff"
    assert run("convert", gray, tiff, "-l", levels).code == 0
    depth, colour = DEPTHS[levels]
    with Image.open(tiff) as picture:
        assert picture.tag_v2[258] == (depth,)
        assert picture.tag_v2[262] == (3 if colour == 3 else 1)
    assert np.array_equal(shown(tiff), shown(png(levels)))
    file = oiio.ImageInput.open(str(tiff))
    if colour == 0:  # OpenImageIO shows a palette as 8-bit colours
        assert file.spec().get_int_attribute("oiio:BitsPerSample") == depth
    pixels = file.read_image(0, 0, 0, file.spec().nchannels, "uint8")
    assert np.array_equal(np.asarray(pixels)[:, :, 0], shown(png(levels)))


def test_pbm(png: Callable[[str], Path], gray: Path, tmp_path: Path) -> None:
    assert run("convert", gray, tmp_path / "out.pbm").code == 0
    data = (tmp_path / "out.pbm").read_bytes()
    head = b"P4\n%d %d\n" % (WIDTH, HEIGHT)
    assert data.startswith(head)
    rows = np.frombuffer(data[len(head) :], np.uint8).reshape(HEIGHT, (WIDTH + 7) // 8)
    ink = np.unpackbits(rows, axis=1)
    assert not ink[:, WIDTH:].any()
    assert np.array_equal(ink[:, :WIDTH] == 0, shown(png("2")) == 255)
    assert np.array_equal(shown(tmp_path / "out.pbm"), shown(png("2")))


def test_pbm_holds_two_levels_only(gray: Path, tmp_path: Path) -> None:
    line = run("convert", gray, tmp_path / "out.pbm", "-l", "4").complaint(2)
    assert "PBM" in line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("levels", "top"), [("2", 1), ("5", 4), ("256", 255), (LADDER4, 255)])
def test_pgm(levels: str, top: int, png: Callable[[str], Path], gray: Path, tmp_path: Path) -> None:
    assert run("convert", gray, tmp_path / "out.pgm", "-l", levels).code == 0
    data = (tmp_path / "out.pgm").read_bytes()
    head = b"P5\n%d %d\n%d\n" % (WIDTH, HEIGHT, top)
    assert data.startswith(head)
    values = np.frombuffer(data[len(head) :], np.uint8).reshape(HEIGHT, WIDTH)
    assert np.array_equal(np.rint(values * 255.0 / top), shown(png(levels)))


@pytest.mark.parametrize(
    ("levels", "bits", "ending"),
    [("2", 1, "raw"), ("3", 2, "bin"), ("16", 4, "raw"), ("17", 8, "bin")],
)
def test_raw(levels: str, bits: int, ending: str, gray: Path, tmp_path: Path) -> None:
    out = tmp_path / f"out.{ending}"
    assert run("convert", gray, out, "-l", levels, "--width", "13").code == 0
    assert run("convert", gray, tmp_path / "out.png", "-l", levels, "--width", "13").code == 0
    expected = shown(tmp_path / "out.png")
    rows = expected.shape[0]
    data = out.read_bytes()
    assert len(data) == rows * ((13 * bits + 7) // 8)
    wide = np.unpackbits(np.frombuffer(data, np.uint8).reshape(rows, -1), axis=1)
    assert not wide[:, 13 * bits :].any()
    index = wide[:, : 13 * bits].reshape(rows, 13, bits) @ (1 << np.arange(bits)[::-1])
    assert np.array_equal(_codes(levels)[index], expected)


@pytest.mark.parametrize(("code", "row"), [(255, b"\0\0"), (0, b"\xff\xf8")])
def test_a_receipt_printer_burns_ones(code: int, row: bytes, tmp_path: Path) -> None:
    """White paper is all zeros, black all ones up to the last of 13 dots."""
    Image.new("L", (13, 4), code).save(tmp_path / "in.png")
    out = tmp_path / "out.raw"
    result = run("convert", tmp_path / "in.png", out, "-d", "receipt-80mm", "--width", "13")
    assert result.code == 0
    assert out.read_bytes() == row * 4


def test_a_receipt_is_as_wide_as_the_roll(gray: Path, tmp_path: Path) -> None:
    result = run("convert", gray, tmp_path / "out.raw", "-d", "receipt-80mm")
    assert result.code == 0
    assert "576" in result.err
    height = round(576 * HEIGHT / WIDTH)
    assert (tmp_path / "out.raw").stat().st_size == height * 72
    quiet = run("convert", gray, tmp_path / "out.png", "-d", "receipt-80mm", "-q")
    assert (quiet.code, quiet.err) == (0, "")
    with Image.open(tmp_path / "out.png") as picture:
        assert picture.size == (576, height)
        assert picture.info["dpi"] == pytest.approx((203.2, 203.2), abs=0.02)


def test_the_format_may_be_named(gray: Path, tmp_path: Path) -> None:
    assert run("convert", gray, tmp_path / "out.pgm").code == 0
    assert run("convert", gray, tmp_path / "out.x", "--format", "PGM").code == 0
    assert (tmp_path / "out.x").read_bytes() == (tmp_path / "out.pgm").read_bytes()


@pytest.mark.parametrize("name", ["out.jpg", "out.gif", "out", "out.png.gz"])
def test_endings_that_cannot_be_written(name: str, gray: Path, tmp_path: Path) -> None:
    line = run("convert", gray, tmp_path / name).complaint(2)
    assert ".png" in line
    assert list(tmp_path.iterdir()) == []
