"""The size asked for: by width, by box, by device; and what is refused rather than cropped."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.cli.command import run
from tests.cli.files import GRAY, header_of, shown

HEIGHT, WIDTH = GRAY.shape


def _size(out: Path) -> tuple[int, int]:
    return header_of(out.read_bytes())[:2]


@pytest.mark.parametrize(
    ("args", "size"),
    [
        ((), (WIDTH, HEIGHT)),
        (("--width", "82"), (82, 48)),
        (("--width", "10"), (10, 6)),
        (("--width", "1"), (1, 1)),
        (("--size", "20x"), (20, 12)),
        (("--size", "x48"), (82, 48)),
        (("--size", "x1"), (2, 1)),
        (("--size", "30x30"), (30, 30)),
        (("--size", "30x30", "--fit", "cover"), (30, 30)),
        (("--size", "30x30", "--fit", "stretch"), (30, 30)),
        (("--size", "1x100", "--fit", "cover"), (1, 100)),
        (("--size", "100x1"), (100, 1)),
        (("--size", "7×9"), (7, 9)),
        (("--size", "7X9"), (7, 9)),
    ],
)
def test_sizes(args: tuple[str, ...], size: tuple[int, int], gray: Path, tmp_path: Path) -> None:
    result = run("convert", gray, tmp_path / "out.png", *args)
    assert (result.code, result.err) == (0, "")
    assert _size(tmp_path / "out.png") == size


@pytest.fixture(scope="module")
def black(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Black, 20 × 10."""
    path = tmp_path_factory.mktemp("black") / "black.png"
    Image.new("L", (20, 10), 0).save(path)
    return path


def test_contain_leaves_the_background_around(black: Path, tmp_path: Path) -> None:
    expected = np.full((20, 20), 255)
    expected[5:15] = 0
    assert run("convert", black, tmp_path / "out.png", "--size", "20x20").code == 0
    assert np.array_equal(shown(tmp_path / "out.png"), expected)
    args = ("--size", "20x20", "--background", "black")
    assert run("convert", black, tmp_path / "out.png", *args).code == 0
    assert not shown(tmp_path / "out.png").any()


@pytest.mark.parametrize("fit", ["cover", "stretch"])
def test_cover_and_stretch_leave_no_background(fit: str, black: Path, tmp_path: Path) -> None:
    assert run("convert", black, tmp_path / "out.png", "--size", "33x47", "--fit", fit).code == 0
    assert shown(tmp_path / "out.png").shape == (47, 33)
    assert not shown(tmp_path / "out.png").any()


def test_cover_keeps_the_middle_and_stretch_the_whole(tmp_path: Path) -> None:
    """A white middle between black sides: only the whole picture shows the sides."""
    codes = np.zeros((10, 40), np.uint8)
    codes[:, 10:30] = 255
    Image.fromarray(codes).save(tmp_path / "in.png")
    args = ("convert", tmp_path / "in.png", tmp_path / "out.png", "--size", "10x10", "--fit")
    assert run(*args, "cover", "-m", "none").code == 0
    assert (shown(tmp_path / "out.png") == 255).all()
    assert run(*args, "stretch", "-m", "none").code == 0
    columns = shown(tmp_path / "out.png").mean(axis=0)
    assert (columns[[0, 1, 8, 9]] == 0).all()
    assert (columns[3:7] == 255).all()


@pytest.mark.parametrize(
    "size", ["5", "x", "", "0x5", "5x0", "5x-1", "-5x5", "axb", "1.5x2", "5x5x5", "5 5"]
)
def test_sizes_that_are_none(size: str, gray: Path, tmp_path: Path) -> None:
    line = run("convert", gray, tmp_path / "out.png", f"--size={size}").complaint(2)
    assert f"'{size}'" in line
    assert "WxH" in line


@pytest.mark.parametrize(
    "args",
    [("--width", "0"), ("--width", "-3"), ("--width", "x"), ("--size", "5x5", "--width", "5")],
)
def test_widths_that_are_none(args: tuple[str, ...], gray: Path, tmp_path: Path) -> None:
    assert "width" in run("convert", gray, tmp_path / "out.png", *args).complaint(2)


def test_a_size_beyond_the_memory_limit(gray: Path, tmp_path: Path) -> None:
    for args in (("--width", "1000000"), ("--size", "99999x99999"), ("--size", "x99999999999")):
        assert "max-memory" in run("convert", gray, tmp_path / "out.png", *args).complaint(3)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("args", [("--width", "600"), ("--size", "577x10"), ("--size", "x400")])
def test_no_more_dots_than_the_device_has(args: tuple[str, ...], gray: Path, tmp_path: Path) -> None:
    """x400 makes 683 dots across: a receipt printer has 576, and nothing is cropped silently."""
    out = tmp_path / "out.png"
    line = run("convert", gray, out, "-d", "receipt-80mm", "-q", *args).complaint(2)
    assert "576" in line
    assert not out.exists()


def test_no_more_rows_than_the_device_has(gray: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.png"
    args = ("convert", gray, out, "-d", "epaper-4gray", "-q", "--size", "400x600")
    assert "300" in run(*args).complaint(2)


def test_upscale_repeats_every_pixel(gray: Path, tmp_path: Path) -> None:
    assert run("convert", gray, tmp_path / "1.png", "-l", "4").code == 0
    assert run("convert", gray, tmp_path / "3.png", "-l", "4", "--upscale", "3").code == 0
    once, thrice = shown(tmp_path / "1.png"), shown(tmp_path / "3.png")
    assert np.array_equal(thrice, once.repeat(3, axis=0).repeat(3, axis=1))
    assert header_of((tmp_path / "3.png").read_bytes()) == (3 * WIDTH, 3 * HEIGHT, 2, 0)


@pytest.mark.parametrize("factor", ["0", "-1", "257", "1.5"])
def test_upscale_refuses(factor: str, gray: Path, tmp_path: Path) -> None:
    args = ("convert", gray, tmp_path / "out.png", f"--upscale={factor}")
    assert "upscale" in run(*args).complaint(2)


def test_the_memory_limit_holds_for_upscaling(gray: Path, tmp_path: Path) -> None:
    """10,496 × 6,144 level indices are 61 MiB, of 1 MiB allowed."""
    args = ("convert", gray, tmp_path / "out.png", "--upscale", "256", "--max-memory", "1M")
    assert "max-memory" in run(*args).complaint(3)
