"""``halftone convert``: the options that change the picture, and a second run of the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.cli.command import run
from tests.cli.files import GRAY, codes_of, decoded, header_of, light_of, shown

LIGHT = light_of(GRAY)


def _shown(gray: Path, tmp_path: Path, *args: str) -> np.ndarray:
    """8-bit codes of the gray picture, each pixel at the nearest of 256 grays."""
    result = run("convert", gray, tmp_path / "out.png", "-l", "256", "-m", "none", *args)
    assert (result.code, result.err) == (0, "")
    return shown(tmp_path / "out.png").astype(float)


@pytest.mark.parametrize(
    ("args", "light"),
    [
        (("--invert",), 1 - LIGHT),
        (("--brightness", "0.5"), np.minimum(2 * LIGHT, 1)),
        (("--brightness=-0.5",), LIGHT / 2),
        (("--contrast", "0.5"), np.minimum(0.18 * (LIGHT / 0.18) ** 2, 1)),
        (("--range", "clip"), LIGHT),
        (("--brightness", "0.5", "--range", "scale"), LIGHT / LIGHT.max()),
    ],
)
def test_adjusts_light(args: tuple[str, ...], light: np.ndarray, gray: Path, tmp_path: Path) -> None:
    assert np.abs(_shown(gray, tmp_path, *args) - codes_of(light)).max() <= 0.51


def test_auto_levels_reach_black_and_white(tmp_path: Path) -> None:
    flat = tmp_path / "flat.png"
    Image.fromarray((80 + GRAY // 4).astype(np.uint8)).save(flat)
    codes = _shown(flat, tmp_path, "--auto-levels")
    assert codes.min() == 0
    assert codes.max() == 255


def test_the_same_run_gives_the_same_bytes(photo_png: Path, tmp_path: Path) -> None:
    for method in ("floyd-steinberg", "random"):
        for name in "ab":
            args = ("convert", photo_png, tmp_path / f"{name}.png", "-m", method, "-l", "4")
            assert run(*args).code == 0
        assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_the_seed_changes_what_is_random(photo_png: Path, tmp_path: Path) -> None:
    for seed in "12":
        args = ("convert", photo_png, tmp_path / f"{seed}.png", "-m", "random", "--seed", seed)
        assert run(*args).code == 0
    assert (tmp_path / "1.png").read_bytes() != (tmp_path / "2.png").read_bytes()


def test_scan_order_and_strength(photo_png: Path, tmp_path: Path) -> None:
    seen = set()
    for args in (("--serpentine",), ("--raster",), ("--strength", "0.5"), ("--strength", "0")):
        assert run("convert", photo_png, tmp_path / "out.png", *args).code == 0
        seen.add((tmp_path / "out.png").read_bytes())
    assert run("convert", photo_png, tmp_path / "none.png", "-m", "none").code == 0
    assert len(seen) == 4
    assert (tmp_path / "none.png").read_bytes() in seen


def test_names_of_methods_are_lenient(photo_png: Path, tmp_path: Path) -> None:
    seen = set()
    for name in ("floyd-steinberg", "fs", "Floyd_Steinberg", "FLOYDSTEINBERG", ""):
        more = ("-m", name) if name else ()
        assert run("convert", photo_png, tmp_path / "out.png", *more).code == 0
        seen.add((tmp_path / "out.png").read_bytes())
    assert len(seen) == 1


def test_gamma_is_the_response_of_the_device(gray: Path, tmp_path: Path) -> None:
    """16 codes under gamma 1 are equal steps of light."""
    for name, args in {"g": ("-l", "16", "--gamma", "1"), "u": ("-l", "uniform-linear:16")}.items():
        assert run("convert", gray, tmp_path / f"{name}.png", *args).code == 0
    assert (tmp_path / "g.png").read_bytes() == (tmp_path / "u.png").read_bytes()
    line = run("convert", gray, tmp_path / "o.png", "-l", "lstar:4", "--gamma", "2.2").complaint(2)
    assert "gamma" in line


def test_a_preview_is_three_panels_of_which_the_second_is_what_is_sent(
    gray: Path, tmp_path: Path
) -> None:
    levels = ("-l", "0.1,0.4,0.9", "--upscale", "2")
    assert run("convert", gray, tmp_path / "out.png", *levels).code == 0
    assert run("convert", gray, tmp_path / "preview.png", *levels, "--preview").code == 0
    assert header_of((tmp_path / "preview.png").read_bytes()) == (3 * 82 + 8, 48, 8, 0)
    panels = decoded(tmp_path / "preview.png")
    sent = decoded(tmp_path / "out.png")
    assert np.array_equal(panels[:, 86:168], sent)
    assert np.array_equal(panels[:, 172:], sent)  # no device: seen as sent
    asked = np.clip(light_of(GRAY), 0.1, 0.9).repeat(2, axis=0).repeat(2, axis=1)
    assert np.abs(panels[:, :82] - asked).max() < 0.006


def test_a_preview_is_a_png_only(gray: Path, tmp_path: Path) -> None:
    args = ("convert", gray, "--preview", tmp_path / "out.pbm")
    assert "preview" in run(*args).complaint(2)
    assert "preview" in run(*args, "--format", "raw").complaint(2)


@pytest.mark.parametrize(
    ("device", "levels", "size"),
    [
        ("generic-1bit", "2", (41, 24)),
        ("framebuffer-16", "16", (41, 24)),
        ("epaper-4gray", "0.0021,0.0830,0.3703,1.0", (400, 300)),
    ],
)
def test_a_device_gives_levels_and_size(
    device: str, levels: str, size: tuple[int, int], gray: Path, tmp_path: Path
) -> None:
    assert run("convert", gray, tmp_path / "d.png", "-d", device, "-q").code == 0
    box = ("--size", f"{size[0]}x{size[1]}")
    assert run("convert", gray, tmp_path / "l.png", "-l", levels, *box).code == 0
    assert np.array_equal(shown(tmp_path / "d.png"), shown(tmp_path / "l.png"))
    assert shown(tmp_path / "d.png").shape == size[::-1]


@pytest.mark.parametrize("levels", ["16", "2"])
def test_a_device_shows_its_own_number_of_levels(levels: str, gray: Path, tmp_path: Path) -> None:
    """16 levels do not fit into 1 bit; of 16 levels, 0 and 1 are not black and white."""
    device = "generic-1bit" if levels == "16" else "framebuffer-16"
    out = tmp_path / "out.raw"
    line = run("convert", gray, out, "-d", device, "-l", levels).complaint(2)
    assert "levels" in line
    assert not out.exists()
