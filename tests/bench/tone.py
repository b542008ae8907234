"""Printed tone with the correction, of every method on every profile with a dot model: a Markdown table.

``python -m tests.bench.tone [PROFILE …]``. At 33 luminances between ink and paper, an even patch of
another size than those the curve was computed from is converted and simulated; its mean, but for a rim,
is compared with what was asked for. Allowed: 1/255 of the span where the method's claim is exact; where
it is k tones, half the largest step between printed tones, if that is more.
"""

from __future__ import annotations

import sys
import tempfile
import time
from typing import Any

import numpy as np

import halftone
from devices.profile import load, names
from halftone import _objects, flatfield
from halftone.dithering.registry import method as find_method
from halftone.dithering.registry import methods
from halftone.flatfield import PrintCurve, print_curve
from tests.bench.table import markdown

__all__ = ["measured_errors"]

TONES = 33
RIM = 8
"""Pixels at each side that are not measured: error diffusion takes a while to settle."""


def patch_shape(curve: PrintCurve, method: Any, dpi: Any) -> tuple[int, int]:
    """Rows and columns: of a screen whole periods, else what the claim holds for, and a little more."""
    screen = flatfield._screen(method, dpi)
    if screen is not None:
        rows, columns = screen.thresholds.shape
        return rows * -(-200 // rows) + 2 * RIM, columns * -(-300 // columns) + 2 * RIM
    side = max(method.claim.side, 240)
    return side + 2 * RIM, side + 64 + 2 * RIM


def measured_errors(profile: Any, name: str, tones: int = TONES) -> tuple[PrintCurve, np.ndarray]:
    """The curve, and printed less asked luminance at evenly spaced tones that the profile can print."""
    method, dot, levels = find_method(name), profile.dot, profile.levels
    curve = print_curve(method, levels, dot, profile.dpi)
    rows, columns = patch_shape(curve, method, profile.dpi)
    asked = np.linspace(curve.darkest, curve.lightest, tones)
    errors = []
    for tone in asked:
        light = np.full((rows, columns), tone, np.float32)
        work = _Free(profile)
        frame = halftone.convert(light, profile=work, method=method)
        covered = dot.covered((frame.indices == 0).astype(np.uint8))[RIM:-RIM, RIM:-RIM]
        seen = levels.lightest - (levels.lightest - levels.darkest) * covered.mean(dtype=np.float64)
        errors.append(seen - tone)
    return curve, np.array(errors)


class _Free:
    """A profile without a size, so that patches are not scaled."""

    width = height = None

    def __init__(self, profile: Any) -> None:
        self._profile = profile

    def __getattr__(self, name: str) -> Any:
        return getattr(self._profile, name)


def main(chosen: list[str]) -> int:
    profiles = [load(name) for name in chosen or names()]
    rows, failed, seen = [], 0, set()
    for profile in profiles:
        like = (profile.dot, tuple(profile.levels.luminance))  # no listed method asks for the dpi
        if profile.dot is None or like in seen:
            continue
        seen.add(like)
        for name, method in methods().items():
            if name in ("none", "threshold"):
                continue
            with tempfile.TemporaryDirectory() as folder:
                _objects.directory().mkdir(parents=True, exist_ok=True)
                first, again, kept = _times(profile, method, folder)
            curve, errors = measured_errors(profile, name)
            span = curve.lightest - curve.darkest
            kind = method.claim.kind
            steps = np.diff(np.unique(curve.printed)).max() / span * 255
            allowed = {"exact": 1.0, "tones": max(1.0, steps / 2)}.get(kind, np.inf)
            worst = float(np.abs(errors).max() / span * 255)
            failed += worst > allowed
            rows.append(
                [
                    profile.name,
                    name,
                    str(method.claim),
                    f"{worst:.2f}",
                    "—" if kind == "none" else f"{allowed:.2f}",
                    "yes" if worst <= allowed else "**no**",
                    "yes" if curve.rising else "no",
                    f"{len(curve.asked)}",
                    f"{first:.0f}",
                    f"{again:.2f}",
                    f"{kept * 1000:.0f}",
                ]
            )
            print(" | ".join(rows[-1]), file=sys.stderr, flush=True)
    heads = "profile, method, claim, worst of 33 (1/255), allowed, within, rising, patches, first (ms)"
    print(markdown([*heads.split(", "), "from file (ms)", "from memory (µs)"], rows))
    print(f"\n{len(rows)} curves, {failed} not within what is allowed")
    return failed


def _times(profile: Any, method: Any, folder: str) -> tuple[float, float, float]:
    """Milliseconds of the curve when it is computed, read from its file, and known to the process."""
    import os

    before = os.environ.get("HALFTONE_CACHE_DIR")
    halftone.dither(np.full((8, 8), 0.5, np.float32), "floyd-steinberg")
    flatfield.print_curve(method, profile.levels, _other(profile.dot), profile.dpi)  # kernels loaded
    os.environ["HALFTONE_CACHE_DIR"] = folder
    times = []
    for forget in (True, True, False):
        if forget:
            flatfield._memory.clear()
        start = time.perf_counter()
        print_curve(method, profile.levels, profile.dot, profile.dpi)
        times.append((time.perf_counter() - start) * 1000)
    if before is None:
        del os.environ["HALFTONE_CACHE_DIR"]
    else:
        os.environ["HALFTONE_CACHE_DIR"] = before
    return times[0], times[1], times[2]


def _other(dot: Any) -> Any:
    return type(dot)(1.0, 1.0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]) > 0)
