"""Pattern replacement: every picture pixel becomes the n × n pattern whose tone is nearest.

The result is n times as wide and as high as the picture. A pattern's tone is its mean luminance
over the device's levels, whatever these are; of two equally near patterns the darker is shown.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import Light
from halftone.dithering.base import Claim, Job, Method
from halftone.dithering.ordered import Ordered
from halftone.errors import UsageError
from halftone.screens.family import PatternFamily
from halftone.tone.levels import Levels

__all__ = ["Patterns", "borders", "grown"]

CHUNK = 1 << 20
"""Output pixels written at a time, but at least one row of the picture's."""


@dataclass(frozen=True)
class Patterns(Method):
    """Patterns of a family in place of pixels.

    family : a :class:`PatternFamily` or its text form. One of two levels fits a device of any
    number: it grows from each level to the next (level-major), so that a pattern holds two
    neighbouring levels at most and a picture exactly on a level stays flat. One of L levels needs a
    device of L different levels, and must pass through every flat level as well.
    """

    family: PatternFamily
    scale: int = field(init=False, default=1, repr=False)

    def __post_init__(self) -> None:
        if isinstance(self.family, str):
            from halftone.screens.growth import family

            object.__setattr__(self, "family", family(self.family))
        if not self.family.level_major:
            raise UsageError(
                f"the pattern family '{self.family.name}' does not pass through every flat level, so "
                "that a picture on a level would not stay flat; use a family of 2 levels"
            )
        object.__setattr__(self, "scale", self.family.n)

    @property
    def claim(self) -> Claim:
        return Claim("tones", self.family.n**2 + 1)

    @property
    def source(self) -> str:
        return self.family.source

    def text(self) -> str:
        return f"patterns:{self.family.name}"

    def check(self, levels: Levels) -> None:
        """Two levels fit any device, L levels one of L different luminances."""
        if self.family.levels not in (2, levels.distinct.size):
            raise UsageError(
                f"the pattern family '{self.family.name}' has {self.family.levels} levels and the "
                f"device {levels.distinct.size} different ones; allowed: as many, or a family of 2 "
                "levels, which fits any number"
            )

    def halftoner(self, job: Job) -> _Patterns:
        self.check(job.levels)
        return _Patterns(self.family.extended(job.levels.distinct.size), job)


def grown(text: str) -> Ordered:
    """Ordered dither, at full resolution, in the order in which a family's patterns grow."""
    from halftone.screens.growth import family

    return Ordered(family(text).screen())


def borders(distinct: Light, cells: int) -> Light:
    """Light above which the next pattern is the nearer one, (patterns − 1,), ascending.

    The border of patterns j and j+1 of *cells* dots on the step a … b is
    (a·(2·cells − 2j − 1) + b·(2j + 1)) / (2·cells), in float64, then the largest float32 that is
    not above it: a float32 lies above the one just where it lies above the other.
    """
    low, high = (distinct[part, None].astype(np.float64) for part in (slice(-1), slice(1, None)))
    odd = 2 * np.arange(cells) + 1
    exact = ((low * (2 * cells - odd) + high * odd) / (2 * cells)).ravel()
    border = exact.astype(np.float32)
    return np.where(border > exact, np.nextafter(border, np.float32(-np.inf)), border)


class _Patterns:
    """Looks up the pattern of every pixel, and copies its rows."""

    parallel = True

    def __init__(self, family: PatternFamily, job: Job) -> None:
        self.job, self.n = job, family.n
        self.border = borders(job.levels.distinct, family.n**2)
        # One item of n bytes for a row of a pattern: row r of pattern k is rows[r, k].
        kind = np.dtype(f"u{family.n}" if family.n in (2, 4, 8) else f"V{family.n}")
        shown = np.take(job.levels.index, family.patterns().transpose(1, 0, 2))
        self.rows = np.ascontiguousarray(shown).view(kind)[:, :, 0]
        coded = job.source.codes()
        self.codes = None if coded is None else (coded[0], self._chosen(coded[1]))

    def _chosen(self, light: Light) -> NDArray[np.intp]:
        """The number of the pattern for each light."""
        return np.searchsorted(self.border, light, side="left")

    def band(self, start: int, stop: int, out: NDArray[np.uint8]) -> None:
        if self.codes is None:
            chosen = self._chosen(self.job.source.band(start, stop))
        else:
            chosen = np.take(self.codes[1], self.codes[0][start:stop])
        height, width = chosen.shape
        shown = out.reshape(height, self.n, width * self.n).view(self.rows.dtype)
        rows = max(1, CHUNK // (width * self.n**2))
        for top in range(0, height, rows):
            for r in range(self.n):
                shown[top : top + rows, r] = np.take(self.rows[r], chosen[top : top + rows])
