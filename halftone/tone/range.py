"""Bringing light into the range a device has levels for, before any method sees it.

Error diffusion cannot pay for light that no level reaches: the debt grows row by row and then
spoils the rows after it. Every ladder has a lowest level above 0 and every render has highlights
above 1, so this step is never left out.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import BAND_ROWS, Light, Source
from halftone._parallel import bands
from halftone.errors import UsageError, near

__all__ = [
    "RULES",
    "bring_into_range",
    "check_rule",
    "clip",
    "compress",
    "extremes",
    "scale",
    "to_light",
]

Step = Callable[[Light], Light]

RULES = {
    "clip": "light beyond the levels becomes the darkest or the lightest level",
    "scale": "all light is divided so that the brightest point is the lightest level",
    "compress": "highlights roll off smoothly; nothing below 80 % of the lightest level changes",
}

KNEE = 0.8


def bring_into_range(source: Source, darkest: float, lightest: float, rule: str = "clip") -> Source:
    """*source* with all its light within darkest … lightest, by one of :data:`RULES`."""
    check_rule(rule)
    if rule == "scale":
        brightest = extremes(source)[1]
        if brightest > lightest:
            source = source.then(scale(float(lightest) / brightest))
    if rule == "compress":
        source = source.then(compress(lightest))
    return source.then(clip(darkest, lightest))


def check_rule(rule: str) -> None:
    """Refuse a name that is no rule."""
    if rule not in RULES:
        raise UsageError(near(str(rule), RULES, "range rule"))


def clip(darkest: float, lightest: float) -> Step:
    """Light below *darkest* or above *lightest* becomes that."""
    low, high = np.float32(darkest), np.float32(lightest)
    return lambda light: np.clip(light, low, high)


def scale(factor: float) -> Step:
    """Light times *factor*."""
    return lambda light: to_light(light * np.float64(factor))


def to_light(values: NDArray[np.float64]) -> Light:
    """float64 as float32 light; beyond what a float32 holds, the largest it does."""
    limit = np.finfo(np.float32).max
    return np.clip(values, -limit, limit).astype(np.float32)


def compress(lightest: float) -> Step:
    """Light above a knee at 0.8 × *lightest* rolls off to it: k + (w−k)·t/(1+t), t = (v−k)/(w−k).

    Slope 1 at the knee; infinite light is white.
    """
    knee = KNEE * float(lightest)
    room = float(lightest) - knee

    def step(light: Light) -> Light:
        t = np.maximum(light.astype(np.float64) - knee, 0) / room
        return np.where(light > knee, knee + room * (1 - 1 / (1 + t)), light).astype(np.float32)

    return step


def extremes(source: Source) -> tuple[float, float]:
    """The darkest and the brightest light of *source*, in one pass over its bands."""
    low, high = np.inf, -np.inf
    for start, stop in bands(source.shape[0], BAND_ROWS):
        light = source.band(start, stop)
        low, high = min(low, float(light.min())), max(high, float(light.max()))
    return low, high
