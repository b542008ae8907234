"""Point methods: every pixel is compared with a threshold of its place, on a step between levels.

A pixel of light v lies between the levels a ≤ v ≤ b; it shows b where v − a > t·(b − a), in float32,
else a. One rule serves ordered dither, dither noise, fixed thresholds and the nearest level. A pixel
exactly on a level keeps it, because 0 < t < 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import BAND_ROWS, Light, Pixels, shortest
from halftone.dithering.base import NO_CLAIM, Claim, Halftoner, Job, Method, check_strength
from halftone.screens.order import Screen, Tiling, tiled
from halftone.tone.levels import Levels

__all__ = ["Ordered", "step_up"]

BAND_PIXELS = 1 << 20
"""Of a band: comparing is so quick that bands of BAND_ROWS are much Python for few pixels."""


@dataclass(frozen=True)
class Ordered(Method):
    """Ordered dither by a screen (threshold array).

    strength : 1 uses the thresholds as they are, 0 is the nearest level; between, they are drawn
    towards ½.
    """

    screen: Screen
    strength: float = 1.0

    options = ("strength",)

    def __post_init__(self) -> None:
        check_strength(self.strength)

    @property
    def claim(self) -> Claim:
        return Claim("tones", self.screen.tones) if self.strength == 1 else NO_CLAIM

    @property
    def source(self) -> str:
        return self.screen.source

    def text(self) -> str:
        tail = "" if self.strength == 1 else f":strength={shortest(self.strength)}"
        return self.screen.name + tail

    def halftoner(self, job: Job) -> Halftoner:
        coded = job.source.codes()
        if coded is None:
            return _OrderedLight(job, self._drawn(self.screen.thresholds))
        values, rank = self.screen.ranked
        return _OrderedCodes(job, *coded, self._drawn(values), rank)

    def _drawn(self, threshold: Light) -> Light:
        """Thresholds drawn towards ½ by the strength."""
        half = np.float32(0.5)
        return half + np.float32(self.strength) * (threshold - half)


def step_up(light: Light, threshold: Light, levels: Levels, out: NDArray[np.uint8]) -> None:
    """Level indices of what each pixel shows into *out*: the rule of this module, for any levels."""
    distinct = levels.distinct
    if distinct.size == 2:
        up = out.view(np.bool_)
        np.greater(light - distinct[0], threshold * (distinct[1] - distinct[0]), out=up)
        _name(levels, out)
        return
    low = np.searchsorted(distinct[1:-1], light, side="right")
    base = distinct[low]
    up = light - base > threshold * (distinct[low + 1] - base)
    np.take(levels.index, np.add(low, up, out=low), out=out)


def _name(levels: Levels, out: NDArray[np.uint8]) -> None:
    """0 and 1 to the level indices of the two levels."""
    if levels.index[0] != 0 or levels.index[1] != 1:
        np.take(levels.index, out, out=out)


class _OrderedLight:
    """Compares light with thresholds."""

    parallel = True

    def __init__(self, job: Job, tile: Light) -> None:
        self.job = job
        self.tile = tile

    def band(self, start: int, stop: int, out: NDArray[np.uint8]) -> None:
        light = self.job.source.band(start, stop)
        threshold = tiled(self.tile, start, stop - start, out.shape[1])
        step_up(light, threshold, self.job.levels, out)


class _OrderedCodes:
    """Compares codes with thresholds encoded as codes; *values* are the thresholds, ascending.

    With two levels, and a code that shows the lighter one whenever a lower code does, every place
    has the last code that stays dark: the *cut*. Else each code has the number of thresholds that it
    passes on its step, and every place the rank of its threshold.
    """

    parallel = True

    def __init__(
        self, job: Job, codes: Pixels, light: Light, values: Light, rank: NDArray[np.uint32]
    ) -> None:
        self.levels = job.levels
        self.codes = codes
        self.band_rows = max(1, min(2 * BAND_ROWS, BAND_PIXELS // job.source.shape[1]))
        distinct = job.levels.distinct
        low = np.searchsorted(distinct[1:-1], light, side="right")
        self.passed = np.empty(light.size, np.uint32)
        for step in np.flatnonzero(np.bincount(low)):
            on = low == step
            base, above = distinct[step], distinct[step + 1]
            self.passed[on] = np.searchsorted(values * (above - base), light[on] - base, side="left")
        self.cut: Tiling | None = None
        if distinct.size == 2 and self.passed[0] == 0 and (self.passed[1:] >= self.passed[:-1]).all():
            dark = np.bincount(self.passed, minlength=values.size + 1).cumsum()[: values.size]
            cut = np.take((dark - 1).astype(codes.dtype), rank)
            self.cut = Tiling(cut, *job.source.shape, self.band_rows)
            return
        kind = np.min_scalar_type(values.size)
        self.passed = self.passed.astype(kind)
        self.rank = Tiling(rank.astype(kind), *job.source.shape, self.band_rows)
        self.low = job.levels.index[low]
        self.high = job.levels.index[low + 1]

    def band(self, start: int, stop: int, out: NDArray[np.uint8]) -> None:
        codes = self.codes[start:stop]
        if self.cut is not None:
            np.greater(codes, self.cut.rows(start, stop - start), out=out.view(np.bool_))
            _name(self.levels, out)
            return
        up = self.rank.rows(start, stop - start) < np.take(self.passed, codes)
        np.take(self.low, codes, out=out)
        if (self.high - self.low == 1).all():
            out += up.view(np.uint8)
        else:
            np.copyto(out, np.take(self.high, codes), where=up)
