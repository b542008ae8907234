"""Point methods: every pixel is compared with a threshold of its place, on a step between levels.

A pixel of light v lies between the levels a ≤ v ≤ b; it shows b where v − a > t·(b − a), in float32,
else a. One rule serves ordered dither, dither noise, fixed thresholds and the nearest level. A pixel
exactly on a level keeps it, because 0 < t < 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import Light, shortest
from halftone.dithering.base import NO_CLAIM, Claim, Job, Method, check_strength
from halftone.screens.order import Screen, tiled

__all__ = ["Ordered", "step_up"]


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

    def halftoner(self, job: Job) -> _Ordered:
        half = np.float32(0.5)
        tile = half + np.float32(self.strength) * (self.screen.thresholds - half)
        return _Ordered(job, tile)


def step_up(light: Light, threshold: Light, distinct: Light) -> NDArray[np.intp]:
    """Index into *distinct* of what each pixel shows: the rule of this module, for any levels."""
    if distinct.size == 2:
        up: NDArray[np.bool_] = light - distinct[0] > threshold * (distinct[1] - distinct[0])
        return up.astype(np.intp)
    low = np.searchsorted(distinct[1:-1], light, side="right")
    base = distinct[low]
    return np.add(low, light - base > threshold * (distinct[low + 1] - base), dtype=np.intp)


class _Ordered:
    """Compares light with thresholds; integer codes with thresholds encoded once as codes."""

    parallel = True

    def __init__(self, job: Job, tile: Light) -> None:
        self.job = job
        self.tile = tile
        self.coded = job.source.codes()
        if self.coded is not None:
            self._encode(self.coded[1])

    def _encode(self, light: Light) -> None:
        """For every code the level below it, and how many of the screen's thresholds it passes."""
        distinct = self.job.levels.distinct
        values, rank = np.unique(self.tile, return_inverse=True)
        kind = np.uint16 if values.size < 1 << 16 else np.uint32
        self.rank = rank.reshape(self.tile.shape).astype(kind)
        low = np.searchsorted(distinct[1:-1], light, side="right")
        base, above = distinct[low], distinct[low + 1]
        self.low = self.job.levels.index[low]
        self.high = self.job.levels.index[low + 1]
        # The number of thresholds passed, by bisection: passing is monotone in the threshold.
        first, last = np.zeros(light.size, np.int64), np.full(light.size, values.size)
        while (first < last).any():
            middle = (first + last) // 2
            passed = light - base > values[np.minimum(middle, values.size - 1)] * (above - base)
            open_ = first < last
            first = np.where(open_ & passed, middle + 1, first)
            last = np.where(open_ & ~passed, middle, last)
        self.passed = first.astype(kind)
        self.cut = self._cut(distinct, light) if distinct.size == 2 and light.size == 256 else None

    def _cut(self, distinct: Light, light: Light) -> NDArray[np.uint8] | None:
        """Two levels, light that rises with the code: a pixel is light where code > cut."""
        if (np.diff(light) < 0).any():
            return None
        ranks = np.arange(int(self.rank.max()) + 1)
        codes = np.searchsorted(self.passed, ranks, side="right")
        if codes.min() < 1:
            return None
        cut: NDArray[np.uint8] = (codes - 1).astype(np.uint8)[self.rank]
        return cut

    def band(self, start: int, stop: int, out: NDArray[np.uint8]) -> None:
        width = out.shape[1]
        index = self.job.levels.index
        if self.coded is None:
            light = self.job.source.band(start, stop)
            threshold = tiled(self.tile, start, stop - start, width)
            np.take(index, step_up(light, threshold, self.job.levels.distinct), out=out)
            return
        codes = self.coded[0][start:stop]
        if self.cut is not None:
            np.greater(codes, tiled(self.cut, start, stop - start, width), out=out.view(np.bool_))
            if index[1] != 1 or index[0] != 0:
                np.take(index, out, out=out)
            return
        rank = tiled(self.rank, start, stop - start, width)
        up = rank < np.take(self.passed, codes)
        out[:] = np.where(up, np.take(self.high, codes), np.take(self.low, codes))
