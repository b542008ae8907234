"""Transparent pixels: composited over the background in linear light."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.cli.command import run
from tests.cli.files import chunk, decoded, png_of, write_oiio

BACKGROUNDS: dict[str, float] = {"": 1.0, "white": 1.0, "black": 0.0, "0.25": 0.25}
HALF = 128 / 255


def _light(picture: Path, background: str) -> np.ndarray:
    """What is shown of *picture* over *background*, to an 8-bit code."""
    out = picture.with_suffix(".out.png")
    extra = ("--background", background) if background else ()
    result = run("convert", picture, out, "-l", "256", "-m", "none", *extra)
    assert (result.code, result.err) == (0, "")
    return decoded(out)


@pytest.mark.parametrize(("background", "paper"), BACKGROUNDS.items())
def test_half_alpha_is_half_the_light(background: str, paper: float, tmp_path: Path) -> None:
    """Columns: black and white at alpha 128, black at alpha 0 and white at alpha 255."""
    codes = np.array([[0, 255, 0, 255]] * 3, np.uint8)
    alpha = np.array([[128, 128, 0, 255]] * 3, np.uint8)
    Image.fromarray(np.dstack([codes, alpha])).save(tmp_path / "la.png")
    Image.fromarray(np.dstack([codes, codes, codes, alpha])).save(tmp_path / "rgba.png")
    out = tmp_path / "out"
    extra = ("--background", background) if background else ()
    inputs = (tmp_path / "la.png", tmp_path / "rgba.png")
    assert run("convert", *inputs, out, "-l", "256", "-m", "none", *extra).code == 0
    expected = [(1 - HALF) * paper, HALF + (1 - HALF) * paper, paper, 1.0]
    for path in inputs:
        assert np.abs(decoded(out / path.name) - expected).max() < 0.005


def test_half_alpha_in_16_bits(tmp_path: Path) -> None:
    pixels = np.zeros((2, 3, 4), np.uint16)
    pixels[:, :, 3] = 0x8000
    write_oiio(tmp_path / "in.png", pixels, "uint16", oiio__UnassociatedAlpha=1)
    assert np.abs(_light(tmp_path / "in.png", "") - (1 - 0x8000 / 0xFFFF)).max() < 0.005


def test_a_palette_with_transparency(tmp_path: Path) -> None:
    palette = chunk(b"PLTE", bytes([0, 0, 0, 255, 255, 255])) + chunk(b"tRNS", bytes([128, 255]))
    (tmp_path / "in.png").write_bytes(png_of(2, 1, 8, 3, b"\0\0\1", palette))
    assert np.abs(_light(tmp_path / "in.png", "black") - [0, 1]).max() < 0.005
    assert np.abs(_light(tmp_path / "in.png", "") - [1 - HALF, 1]).max() < 0.005


def test_exr_is_weighted_by_alpha_already(tmp_path: Path) -> None:
    pixels = np.empty((2, 3, 4), np.float32)
    pixels[:] = (0.25, 0.25, 0.25, 0.5)
    write_oiio(tmp_path / "in.exr", pixels, "float")
    assert np.abs(_light(tmp_path / "in.exr", "") - 0.75).max() < 0.005
    assert np.abs(_light(tmp_path / "in.exr", "black") - 0.25).max() < 0.005


def test_tiff_with_associated_alpha(tmp_path: Path) -> None:
    """TIFF 6.0, ExtraSamples 1: the codes are weighted by alpha. White over white is white."""
    pixels = np.array([[[128] * 4, [0, 0, 0, 128], [255] * 4, [0] * 4]] * 2, np.uint8)
    write_oiio(tmp_path / "in.tif", pixels, "uint8")
    with Image.open(tmp_path / "in.tif") as picture:
        assert picture.tag_v2[338] == (1,)
    assert np.abs(_light(tmp_path / "in.tif", "") - [1, 1 - HALF, 1, 1]).max() < 0.005
    assert np.abs(_light(tmp_path / "in.tif", "black") - [HALF, 0, 1, 0]).max() < 0.005


def test_alpha_beside_a_depth_channel(tmp_path: Path) -> None:
    """As 3D programs write it: red, green, blue, alpha and Z in one EXR."""
    pixels = np.empty((2, 3, 5), np.float32)
    pixels[:] = (0.25, 0.25, 0.25, 0.5, 7.0)
    write_oiio(tmp_path / "in.exr", pixels, "float", ("R", "G", "B", "A", "Z"))
    assert np.abs(_light(tmp_path / "in.exr", "") - 0.75).max() < 0.005


def test_gray_and_alpha_beside_a_depth_channel(tmp_path: Path) -> None:
    pixels = np.empty((2, 3, 3), np.float32)
    pixels[:] = (0.25, 0.5, 0.1)
    write_oiio(tmp_path / "in.exr", pixels, "float", ("Y", "A", "Z"))
    assert np.abs(_light(tmp_path / "in.exr", "") - 0.75).max() < 0.005


@pytest.mark.parametrize("background", ["grey", "-0.1", "1.5", "nan"])
def test_a_background_that_is_none(background: str, gray: Path, tmp_path: Path) -> None:
    result = run("convert", gray, tmp_path / "o.png", f"--background={background}")
    line = result.complaint(2)
    assert background in line
    assert "white, black" in line
