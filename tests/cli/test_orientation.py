"""EXIF orientation: pictures come out upright, whichever way the camera was held."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.cli.command import Result, run
from tests.cli.files import shown

UPRIGHT = np.repeat(np.repeat(np.array([[0, 60, 120], [180, 250, 90]], np.uint8), 8, 0), 8, 1)
"""16 rows of 24 pixels in blocks of 8 × 8, no two alike, so that a JPEG keeps them."""

STORED: dict[int, Callable[[np.ndarray], np.ndarray]] = {
    1: lambda a: a,
    2: np.fliplr,
    3: lambda a: np.rot90(a, 2),
    4: np.flipud,
    5: np.transpose,
    6: np.rot90,  # 6: to be turned clockwise, so it lies turned anticlockwise
    7: lambda a: np.rot90(a, 2).T,
    8: lambda a: np.rot90(a, -1),
}
"""How a file with each orientation holds the upright picture (TIFF 6.0, tag 274)."""

KINDS = {"tif": 0, "png": 0, "jpg": 2}
"""Formats, and by how many codes their pixels may differ."""


@pytest.fixture(scope="module")
def converted(tmp_path_factory: pytest.TempPathFactory) -> tuple[Result, Path]:
    folder, out = tmp_path_factory.mktemp("turned"), tmp_path_factory.mktemp("upright")
    inputs = []
    for number, turn in STORED.items():
        picture = Image.fromarray(np.ascontiguousarray(turn(UPRIGHT)))
        exif = Image.Exif()
        exif[274] = number
        for kind in KINDS:
            inputs.append(folder / f"{kind}{number}.{kind}")
            if kind == "tif":
                picture.save(inputs[-1], tiffinfo={274: number})
            else:
                picture.save(inputs[-1], exif=exif, **({"quality": 100} if kind == "jpg" else {}))
    return run("convert", *inputs, out, "-l", "256", "-m", "none"), out


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("number", STORED)
def test_comes_out_upright(kind: str, number: int, converted: tuple[Result, Path]) -> None:
    result, folder = converted
    assert (result.code, result.err) == (0, "")
    codes = shown(folder / f"{kind}{number}.png").astype(int)
    assert codes.shape == UPRIGHT.shape
    assert np.abs(codes - UPRIGHT).max() <= KINDS[kind]


def test_alpha_is_turned_with_the_picture(tmp_path: Path) -> None:
    """White on the left where it is opaque, black paper on the right where it is not."""
    alpha = np.zeros((4, 6), np.uint8)
    alpha[:, :2] = 255
    stored = np.ascontiguousarray(np.rot90(np.dstack([np.full_like(alpha, 255), alpha])))
    exif = Image.Exif()
    exif[274] = 6
    Image.fromarray(stored).save(tmp_path / "in.png", exif=exif)
    args = ("convert", tmp_path / "in.png", tmp_path / "out.png", "--background", "black")
    assert run(*args, "-m", "none").code == 0
    assert np.array_equal(shown(tmp_path / "out.png"), alpha)
