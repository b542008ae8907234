"""HPSNR and tonal peaks of the methods: the README's table. Run with ``pytest -m bench -s``."""

from __future__ import annotations

import numpy as np
import pytest

import halftone
from halftone.metrics import hpsnr, tonal_peak
from halftone.tone import encoding

pytestmark = pytest.mark.bench

METHODS = (
    "random",
    "bayer8",
    "screen:round@45:8px",
    "blue-noise",
    "growth:8",
    "dots:knuth",
    "dots:mese16",
    "dots:64",
    "jarvis-judice-ninke",
    "atkinson",
    "riemersma",
    "floyd-steinberg",
    "floyd-steinberg:raster",
    "ostromoukhov",
    "zhou-fang",
)


def test_quality(camera):
    codes = camera / 255
    light = encoding("srgb").table(256)[camera]
    print("\n| method | HPSNR, codes | HPSNR, linear light | worst tonal peak | median |")
    print("|---|---|---|---|---|")
    for name in METHODS:
        seen = hpsnr(halftone.dither(codes, name).luminance, codes)
        linear = hpsnr(halftone.dither(camera, name).luminance, light)
        peaks = []
        for k in range(4, 252):
            dots = halftone.dither(np.full((512, 512), k / 255, np.float32), name).indices
            peaks.append(tonal_peak(dots, k / 255))
        print(
            f"| `{name}` | {seen:.2f} dB | {linear:.2f} dB | {max(peaks):.0f} | {np.median(peaks):.1f} |"
        )
        if name == "blue-noise":
            assert seen >= 31.4
            assert max(peaks) < 10
        if name == "dots:64":
            assert seen >= 34.5
            assert max(peaks) < 100
