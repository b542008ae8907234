"""What a user may do to a picture before it is halftoned: brightness, contrast, levels, negative.

All of it acts on linear light, in this order: auto-levels, brightness, contrast, invert.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from halftone._arrays import BAND_ROWS, Light, Source
from halftone._parallel import bands
from halftone.errors import UsageError
from halftone.tone.range import scale, to_light
from halftone.tone.transfer import encoding

__all__ = ["auto_levels", "brightness", "contrast", "invert", "light_histogram"]

Step = Callable[[Light], Light]

MIDDLE_GRAY = 0.18
"""Light that contrast leaves as it is: the gray card of photography."""

BINS = encoding("srgb").decode((np.arange(255) + 0.5) / 255).astype(np.float32)
"""Borders between the lights of neighbouring 8-bit sRGB codes."""


def brightness(amount: float) -> Step:
    """Light times 4^amount, −1 … 1: two stops darker … two stops brighter. Black stays black."""
    factor = 4.0 ** _unit(amount, "brightness")
    return scale(factor)


def contrast(amount: float) -> Step:
    """0.18 · (light/0.18)^(4^amount), −1 … 1: exponents from 1/4 (flat) to 4 (hard).

    Straight lines in a diagram of log light, as in photography; black stays black.
    """
    power = 4.0 ** _unit(amount, "contrast")

    def step(light: Light) -> Light:
        base = np.maximum(light.astype(np.float64), 0) / MIDDLE_GRAY
        with np.errstate(over="ignore"):
            return to_light(MIDDLE_GRAY * base**power)

    return step


def invert() -> Step:
    """White light less the light, 1 − v: for two levels, every dot exchanged."""
    return lambda light: np.float32(1) - light


def auto_levels(source: Source, share: float = 0.005) -> Step:
    """Stretch so that *share* of the pixels is black and as many are white, by a first pass.

    The stretch is affine in light. A picture with a single tone is left as it is.
    """
    counts = light_histogram(source).cumsum()
    total = int(counts[-1])
    low = int(np.searchsorted(counts, share * total, side="right"))
    high = int(np.searchsorted(counts, total - share * total))
    code = encoding("srgb").table(256)
    black, white = float(code[low]), float(code[high])
    if white <= black:
        return lambda light: light
    return lambda light: to_light((light.astype(np.float64) - black) / (white - black))


def light_histogram(source: Source) -> np.ndarray:
    """Pixels per 8-bit sRGB code, (256,): the code whose light is nearest in code value."""
    counts = np.zeros(256, np.int64)
    coded = source.codes()
    for start, stop in bands(source.shape[0], BAND_ROWS):
        if coded is not None and coded[1].size == 256:
            counts += np.bincount(coded[0][start:stop].ravel(), minlength=256)
        else:
            place = np.searchsorted(BINS, source.band(start, stop).ravel())
            counts += np.bincount(place, minlength=256)
    if coded is not None and coded[1].size == 256:
        place = np.searchsorted(BINS, coded[1])
        counts = np.bincount(place, weights=counts, minlength=256).astype(np.int64)
    return counts


def _unit(amount: float, what: str) -> float:
    if not -1 <= amount <= 1:
        raise UsageError(f"{what}={amount!r}; allowed: -1 … 1, where 0 changes nothing")
    return float(amount)
