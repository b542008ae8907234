"""Every format of input: the right size, and the right light in every pixel."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.cli.command import Result, run
from tests.cli.files import (
    GRAY,
    RGB,
    codes_of,
    light_of,
    shown,
    write_gray_png,
    write_oiio,
)

BILEVEL = np.where(GRAY > 127, 255, 0).astype(np.uint8)
OPAQUE = np.full_like(GRAY, 255)
LUMINANCE = codes_of(light_of(RGB))
SIZE = b"%d %d" % (GRAY.shape[1], GRAY.shape[0])

EXPECTED: dict[str, tuple[np.ndarray, float]] = {
    "gray1.png": (BILEVEL, 0),
    "gray2.png": (GRAY // 64 * 85, 0),
    "gray4.png": (GRAY // 16 * 17, 0),
    "gray8.png": (GRAY, 0),
    "gray16.png": (GRAY, 0),
    "rgb8.png": (LUMINANCE, 0.51),
    "rgb16.png": (LUMINANCE, 0.51),
    "la.png": (GRAY, 0),
    "rgba.png": (LUMINANCE, 0.51),
    "palette.png": (GRAY // 64 * 64, 0),
    "gray.jpg": (GRAY, 4),
    "rgb.jpg": (LUMINANCE, 8),
    "cmyk.jpg": (LUMINANCE, 8),
    "gray1.tif": (BILEVEL, 0),
    "gray8.tif": (GRAY, 0),
    "white-is-0.tif": (GRAY, 0),
    "gray16.tif": (GRAY, 0),
    "gray32.tif": (GRAY, 0),
    "float.tif": (GRAY, 0),
    "rgb8.tif": (LUMINANCE, 0.51),
    "palette.tif": (GRAY // 64 * 64, 1),  # Pillow writes the palette as 256 · code, not 257 · code
    "rgb.webp": (LUMINANCE, 0.51),
    "float.exr": (GRAY, 0),
    "half.exr": (LUMINANCE, 1),
    "rgb.hdr": (LUMINANCE, 2),
    "raw.pbm": (BILEVEL, 0),
    "plain.pbm": (BILEVEL, 0),
    "raw.pgm": (GRAY, 0),
    "plain.pgm": (GRAY, 0),
    "maxval15.pgm": (GRAY // 16 * 17, 0),
    "maxval1023.pgm": (GRAY, 0.51),
    "raw.ppm": (LUMINANCE, 0.51),
    "gray1.bmp": (BILEVEL, 0),
    "gray8.bmp": (GRAY, 0),
    "rgb8.bmp": (LUMINANCE, 0.51),
}
"""8-bit sRGB codes that must be shown of every file, and by how much they may differ."""


def _write_with_pillow(folder: Path) -> None:
    palette = Image.fromarray(GRAY // 64)
    palette.putpalette([v for k in range(4) for v in (64 * k,) * 3])
    pictures = {
        "gray1": Image.fromarray(BILEVEL).convert("1"),
        "gray8": Image.fromarray(GRAY),
        "gray": Image.fromarray(GRAY),
        "rgb8": Image.fromarray(RGB),
        "rgb": Image.fromarray(RGB),
        "la": Image.fromarray(np.dstack([GRAY, OPAQUE])),
        "rgba": Image.fromarray(np.dstack([RGB, OPAQUE])),
        "cmyk": Image.fromarray(RGB).convert("CMYK"),
        "palette": palette,
    }
    for name, options in {
        "gray1.png": {},
        "gray8.png": {},
        "rgb8.png": {},
        "la.png": {},
        "rgba.png": {},
        "palette.png": {},
        "gray.jpg": {"quality": 98},
        "rgb.jpg": {"quality": 98, "subsampling": 0},
        "cmyk.jpg": {"quality": 98, "subsampling": 0},
        "gray1.tif": {},
        "gray8.tif": {},
        "rgb8.tif": {},
        "palette.tif": {},
        "rgb.webp": {"lossless": True},
        "gray1.bmp": {},
        "gray8.bmp": {},
        "rgb8.bmp": {},
    }.items():
        pictures[name.partition(".")[0]].save(folder / name, **options)
    Image.fromarray(GRAY).save(folder / "white-is-0.tif", tiffinfo={262: 0})


def _write_with_oiio(folder: Path) -> None:
    light = light_of(GRAY).astype(np.float32)
    colours = np.dstack([light_of(RGB[:, :, c]) for c in range(3)]).astype(np.float32)
    write_oiio(folder / "rgb16.png", RGB.astype(np.uint16) * 257, "uint16")
    write_oiio(folder / "gray16.tif", GRAY.astype(np.uint16) * 257, "uint16")
    write_oiio(folder / "gray32.tif", GRAY.astype(np.uint32) * 0x01010101, "uint32")
    write_oiio(folder / "float.tif", light, "float")
    write_oiio(folder / "float.exr", light, "float")
    write_oiio(folder / "half.exr", colours, "half")
    write_oiio(folder / "rgb.hdr", colours, "float")


def _write_by_hand(folder: Path) -> None:
    write_gray_png(folder / "gray2.png", GRAY // 64, 2)
    write_gray_png(folder / "gray4.png", GRAY // 16, 4)
    write_gray_png(folder / "gray16.png", GRAY.astype(int) * 257, 16)
    ink = BILEVEL == 0
    packed = np.packbits(ink, axis=1).tobytes()
    tens = np.rint(GRAY.astype(float) * 1023 / 255).astype(">u2").tobytes()
    for name, data in {
        "raw.pbm": b"P4\n" + SIZE + b"\n" + packed,
        "plain.pbm": b"P1\n" + SIZE + b"\n" + _text(ink.astype(int)),
        "raw.pgm": b"P5\n# a comment\n" + SIZE + b"\n255\n" + GRAY.tobytes(),
        "plain.pgm": b"P2\n" + SIZE + b"\n255\n" + _text(GRAY),
        "maxval15.pgm": b"P5\n" + SIZE + b"\n15\n" + (GRAY // 16).tobytes(),
        "maxval1023.pgm": b"P5\n" + SIZE + b"\n1023\n" + tens,
        "raw.ppm": b"P6\n" + SIZE + b"\n255\n" + RGB.tobytes(),
    }.items():
        (folder / name).write_bytes(data)


def _text(values: np.ndarray) -> bytes:
    return "\n".join(" ".join(map(str, row)) for row in values.tolist()).encode() + b"\n"


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pictures")
    _write_with_pillow(folder)
    _write_with_oiio(folder)
    _write_by_hand(folder)
    assert sorted(p.name for p in folder.iterdir()) == sorted(EXPECTED)
    return folder


@pytest.fixture(scope="module")
def converted(pictures: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Result, Path]:
    """All of them at once to 256 grays, each named by its whole name."""
    links = tmp_path_factory.mktemp("links")
    for path in pictures.iterdir():
        (links / f"{path.name}.x").symlink_to(path)  # a name that says nothing of the format
    out = tmp_path_factory.mktemp("converted")
    inputs = sorted(links.iterdir())
    return run("convert", *inputs, out, "-l", "256", "-m", "none"), out


def test_all_formats_at_once_without_a_word(converted: tuple[Result, Path]) -> None:
    result, _ = converted
    assert (result.code, result.out, result.err) == (0, b"", "")


@pytest.mark.parametrize("name", sorted(EXPECTED))
def test_shows_the_light_of_the_file(name: str, converted: tuple[Result, Path]) -> None:
    codes = shown(converted[1] / f"{name}.png").astype(float)
    expected, tolerance = EXPECTED[name]
    assert codes.shape == expected.shape
    assert np.abs(codes - expected).max() <= tolerance
    assert abs(light_of(codes).mean() - light_of(expected).mean()) < 0.004


def test_two_levels_keep_the_mean_light(photo_png: Path, tmp_path: Path) -> None:
    assert run("convert", photo_png, tmp_path / "out.png").code == 0
    codes = shown(tmp_path / "out.png")
    assert set(np.unique(codes)) == {0, 255}
    assert abs((codes > 0).mean() - light_of(shown(photo_png)).mean()) < 0.004


def test_the_encoding_can_be_said(gray: Path, tmp_path: Path) -> None:
    args = ("convert", gray, tmp_path / "out.png", "-l", "256", "-m", "none")
    assert run(*args, "--encoding", "linear").code == 0
    assert np.abs(shown(tmp_path / "out.png") - codes_of(GRAY / 255)).max() <= 0.51
    assert run(*args, "--encoding", "gamma:2").code == 0
    assert np.abs(shown(tmp_path / "out.png") - codes_of((GRAY / 255) ** 2)).max() <= 0.51
