"""A warm start: error diffusion that is in its stride when it reaches the picture.

Started from no error at all, it leaves the first rows of light tones empty (71 rows at 1/255 by
Floyd–Steinberg) and drops error at both sides. A warm start diffuses the picture's own first 176
rows, mirrored, before it, and 32 mirrored columns on either side, and throws them away; random
carries of ± half a step in the first of those rows keep flat tones from beating in time. It costs
176 rows and 64 columns, and leaves the fluctuation that error diffusion has anywhere: 16 rows of
512 pixels are right within 0.5/255.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import BAND_ROWS, Codes, Light, Source
from halftone.dithering.base import Job
from halftone.dithering.noise import uniform_noise
from halftone.errors import UsageError

__all__ = ["COLUMNS", "ROWS", "STARTS", "Warm", "check_start"]

STARTS = ("cold", "warm")
ROWS = 176
"""Rows before the picture; even, so that serpentine rows keep their direction."""
COLUMNS = 32


def check_start(start: str) -> None:
    if start not in STARTS:
        raise UsageError(f"start='{start}'; allowed: {', '.join(STARTS)}")


class Warm:
    """A scanning halftoner over the picture with its mirrored margins."""

    parallel = False

    def __init__(self, job: Job, make: Callable[[Job], Any], seed: int) -> None:
        wide = _Mirrored(job.source.pixels, inner=job.source)
        self.inner = make(Job(wide, job.levels, job.dpi))
        self.width = wide.shape[1]
        distinct = job.levels.distinct
        first = wide.band(0, 1)
        low = np.searchsorted(distinct[1:-1], first, side="right")
        noise = uniform_noise(seed, 0, 1, self.width) - np.float32(0.5)
        self.inner.carry[:1] = noise * _payable(first, low, distinct)
        self.next = -ROWS

    def band(self, start: int, stop: int, out: NDArray[np.uint8]) -> None:
        while self.next < start:  # the rows before the picture, a few at a time
            after = min(self.next + BAND_ROWS, start)
            self._rows(self.next, after)
        out[:] = self._rows(start, stop)[:, COLUMNS:-COLUMNS]

    def _rows(self, start: int, stop: int) -> NDArray[np.uint8]:
        rows = np.empty((stop - start, self.width), np.uint8)
        self.inner.band(start + ROWS, stop + ROWS, rows)
        self.next = stop
        return rows


def _payable(light: Light, low: NDArray[np.intp], distinct: Light) -> Light:
    """The widest carry that the levels around can pay: the narrowest step beside the light's own.

    0 where the light is a level, which then stays.
    """
    steps = np.diff(distinct)
    around = np.minimum(
        steps, np.minimum(np.append(steps[1:], steps[-1]), np.append(steps[0], steps[:-1]))
    )
    on_level = (light == distinct[low]) | (light == distinct[low + 1])
    return np.where(on_level, np.float32(0), around[low])


@dataclass(frozen=True)
class _Mirrored(Source):
    """A source with mirrored rows before it and mirrored columns beside it."""

    inner: Source | None = None

    @property
    def shape(self) -> tuple[int, int]:
        height, width = self._picture.shape
        return height + ROWS, width + 2 * COLUMNS

    def codes(self) -> tuple[Codes, Light] | None:
        return None

    def band(self, start: int, stop: int) -> Light:
        height = self._picture.shape[0]
        rows = []
        for y in range(start - ROWS, min(0, stop - ROWS)):
            back = (-y - 1) % (2 * height)
            back = back if back < height else 2 * height - 1 - back
            rows.append(self._picture.band(back, back + 1))
        if stop > ROWS:
            rows.append(self._picture.band(max(0, start - ROWS), stop - ROWS))
        light = np.concatenate(rows)
        return np.pad(light, ((0, 0), (COLUMNS, COLUMNS)), mode="symmetric")

    @property
    def _picture(self) -> Source:
        assert self.inner is not None
        return self.inner
