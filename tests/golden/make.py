"""The golden images: what each method makes of one synthetic picture. Run to make them anew::

    python -m tests.golden.make

The output of a released method never changes silently: a change here is an entry in CHANGELOG.md.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import halftone

FOLDER = Path(__file__).parent

CASES = [
    *((name, 2, "linear") for name in halftone.methods() if name != "random"),
    *((name, 4, "srgb") for name in ("none", "bayer8", "floyd-steinberg", "stucki", "shiau-fan")),
    ("random", 2, "srgb"),
    ("random:triangular:seed=7", 3, "srgb"),
    ("threshold:otsu", 2, "srgb"),
    ("floyd-steinberg:raster", 2, "linear"),
    ("floyd-steinberg:raster", 2, "srgb"),
    ("floyd-steinberg", 2, "srgb"),
    ("floyd-steinberg:right", 2, "srgb"),
    ("jarvis-judice-ninke:raster", "log:0.02:5", "gamma:2.2"),
    ("atkinson:strength=0.9", "0.02,0.1,0.4,0.4,1", "bt709"),
    ("none:ratio", "log:0.01:8", "srgb"),
]


def picture() -> np.ndarray:
    """A zone plate over a ramp with flat corners, in integers: uint8 (96, 112)."""
    y, x = np.mgrid[0:96, 0:112].astype(np.int64)
    ramp = x * 255 // 111
    rings = (x * x + y * y) // 24 % 256
    waves = np.where(rings < 128, rings * 2, 510 - rings * 2)
    codes = np.where(y < 32, ramp, (waves + ramp) // 2)
    codes[80:, :28] = 3
    codes[80:, 28:56] = 64
    codes[80:, 56:84] = 127
    codes[80:, 84:] = 252
    return np.clip(codes, 0, 255).astype(np.uint8)


def path(name: str, levels: object, encoding: str) -> Path:
    text = f"{name}_{levels}_{encoding}".translate(str.maketrans(":=,/", "-.+-"))
    return FOLDER / f"{text}.png"


def frame(name: str, levels: object, encoding: str) -> halftone.Frame:
    return halftone.dither(picture(), name, levels=levels, encoding=encoding)


def main() -> None:
    for old in FOLDER.glob("*.png"):
        old.unlink()
    for case in CASES:
        frame(*case).save(path(*case))


if __name__ == "__main__":
    main()
