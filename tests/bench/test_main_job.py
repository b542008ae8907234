"""Start-up as whole processes, and Floyd–Steinberg on codes beside Pillow."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

import halftone
from tests.bench.timing import best_and_median, compare, machine, process

pytestmark = pytest.mark.bench


def report(times: dict[str, list[float]], unit: str, of: dict[str, float] | None = None) -> None:
    print(f"\n{machine()}")
    for name, seconds in times.items():
        best, median = best_and_median(seconds)
        if of is None:
            print(f"{name:54} {best * 1e3:8.0f} {median * 1e3:8.0f} {unit}")
        else:
            print(f"{name:54} {of[name] / best / 1e6:8.0f} {of[name] / median / 1e6:8.0f} {unit}")


def test_start_up(tmp_path, camera):
    from PIL import Image

    picture = str(tmp_path / "576.png")
    Image.fromarray(camera).resize((576, 576)).save(picture)
    out = str(tmp_path / "out.pbm")
    command = str(Path(sys.executable).with_name("halftone"))
    kept, cold = str(tmp_path / "kept"), tmp_path / "cold"

    def first_ever() -> None:
        shutil.rmtree(cold, ignore_errors=True)
        process(command, "convert", picture, out, "-m", "fs", HALFTONE_CACHE_DIR=str(cold))()

    def convert(method: str):
        return process(command, "convert", picture, out, "-m", method, HALFTONE_CACHE_DIR=kept)

    times = compare(
        {
            "python -c pass (yardstick)": process(sys.executable, "-c", "pass"),
            "python -c 'import numpy' (yardstick)": process(sys.executable, "-c", "import numpy"),
            "… and OpenImageIO (yardstick)": process(sys.executable, "-c", "import numpy, OpenImageIO"),
            "halftone --help": process(command, "--help"),
            "576×576 PNG → PBM, threshold": convert("threshold"),
            "576×576 PNG → PBM, bayer8": convert("bayer8"),
            "576×576 PNG → PBM, floyd-steinberg, warm": convert("fs"),
        }
    )
    times |= compare({"576×576 PNG → PBM, floyd-steinberg, first ever": first_ever}, runs=5)
    report(times, "ms, best and median of whole processes")


def test_floyd_steinberg_beside_pillow():
    from PIL import Image

    random = np.random.default_rng(1)
    y, x = np.mgrid[0:4096, 0:4096]
    codes = ((x + y) / 32 + 30 * np.sin(x / 40) * np.sin(y / 60) + random.normal(0, 1.5, x.shape)).clip(
        0, 255
    )
    codes = codes.astype(np.uint8)
    image = Image.fromarray(codes)
    light = (codes / 255).astype(np.float32)
    work = {
        "Pillow convert('1'), raster, 8-bit integers": lambda: image.convert("1"),
        "ours, raster, 8-bit codes as light, int32 1/16": lambda: halftone.dither(
            codes, "fs:raster", encoding="linear"
        ),
        "ours, serpentine, 8-bit codes as light, int32 1/16": lambda: halftone.dither(
            codes, "fs", encoding="linear"
        ),
        "ours, raster, 8-bit sRGB codes, float32": lambda: halftone.dither(codes, "fs:raster"),
        "ours, serpentine, float32 light, float32": lambda: halftone.dither(light, "fs"),
        "ours, serpentine, 16 levels, float32": lambda: halftone.dither(light, "fs", levels=16),
        "ours, bayer8, 8-bit sRGB codes": lambda: halftone.dither(codes, "bayer8"),
        "ours, random, 8-bit sRGB codes": lambda: halftone.dither(codes, "random"),
    }
    times = compare(work, runs=7)
    report(times, "MP/s, best and median, 4096 × 4096, 1 thread", dict.fromkeys(work, codes.size))
    pillow, integer = (best_and_median(times[name])[1] for name in list(work)[:2])
    print(f"ours (raster, integers) / Pillow: {pillow / integer:.2f}")
    assert integer <= pillow
