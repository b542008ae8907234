"""No halftoning: the nearest level (``none``), and one threshold for the whole picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halftone.dithering.base import Halftoner, Job, Method
from halftone.dithering.ordered import Ordered, step_up
from halftone.errors import UsageError
from halftone.screens.order import Screen
from halftone.tone.adjust import BINS, light_histogram
from halftone.tone.ladder import borders
from halftone.tone.levels import Levels

__all__ = ["MIDDLE", "Nearest", "Threshold", "otsu"]

MIDDLE = 0.2140
"""Light of the sRGB code ½ (0.2140411…, rounded): the middle of a text's black and white."""


@dataclass(frozen=True)
class Nearest(Method):
    """Every pixel becomes the nearest level: by ``arithmetic`` difference, or by ``ratio``."""

    by: str = "arithmetic"

    def __post_init__(self) -> None:
        if self.by not in ("arithmetic", "ratio"):
            raise UsageError(f"none:{self.by} is unknown; allowed: none:arithmetic, none:ratio")

    @property
    def source(self) -> str:
        return "Hearn & Baker, intensity levels"

    def text(self) -> str:
        return "none" if self.by == "arithmetic" else "none:ratio"

    def check(self, levels: Levels) -> None:
        """A ratio needs levels above 0."""
        borders(levels.distinct.astype(np.float64), self.by)

    def halftoner(self, job: Job) -> Halftoner:
        distinct = job.levels.distinct.astype(np.float64)
        border = borders(distinct, self.by)
        share = ((border - distinct[:-1]) / np.diff(distinct)).astype(np.float32)
        if (share == share[0]).all():
            return Ordered(_constant(float(share[0]), self.text())).halftoner(job)
        return _PerStep(job, share)


class _PerStep:
    """Each step between two levels has a threshold of its own."""

    parallel = True

    def __init__(self, job: Job, share: NDArray[np.float32]) -> None:
        self.job, self.share = job, share

    def band(self, start: int, stop: int, out: NDArray[np.uint8]) -> None:
        levels = self.job.levels
        light = self.job.source.band(start, stop)
        low = np.searchsorted(levels.distinct[1:-1], light, side="right")
        step_up(light, self.share[low], levels, out)


@dataclass(frozen=True)
class Threshold(Method):
    """Two levels, one threshold.

    at : the share of the step from the dark to the light level, in light, 0 < at < 1; or ``otsu``
    for the threshold that separates the picture's 8-bit sRGB codes into the two classes with the
    largest variance between them (Otsu 1979).
    """

    at: float | str = MIDDLE

    def __post_init__(self) -> None:
        if self.at != "otsu" and not (
            isinstance(self.at, int | float | np.floating) and 0 < np.float32(self.at) < 1
        ):
            raise UsageError(f"threshold:{self.at}; allowed: above 0 and below 1, or otsu")

    @property
    def source(self) -> str:
        return "Otsu 1979" if self.at == "otsu" else "—"

    def text(self) -> str:
        return "threshold" if self.at == MIDDLE else f"threshold:{self.at}"

    def check(self, levels: Levels) -> None:
        """Two levels, and no more."""
        if levels.distinct.size != 2:
            raise UsageError(
                f"threshold needs two levels and the device has {levels.distinct.size}; "
                "use the method 'none' for the nearest of several levels"
            )

    def halftoner(self, job: Job) -> Halftoner:
        at = self.at
        if isinstance(at, str):
            dark, light = (float(v) for v in job.levels.distinct)
            border = float(BINS[otsu(light_histogram(job.source))])
            at = min(max((border - dark) / (light - dark), 1e-6), 1 - 1e-6)
        return Ordered(_constant(at, self.text())).halftoner(job)


def otsu(counts: NDArray[np.int64]) -> int:
    """The last bin of the dark class that maximises the variance between both classes (Otsu 1979).

    Ties and a picture of one tone take the first such bin.
    """
    weight = counts.astype(np.float64)
    bins = np.arange(weight.size)
    dark = weight.cumsum()
    light = dark[-1] - dark
    sums = (weight * bins).cumsum()
    with np.errstate(invalid="ignore", divide="ignore"):
        gap = sums / dark - (sums[-1] - sums) / light
        between = np.nan_to_num(dark * light * gap**2)
    return int(np.argmax(between[:-1]))


def _constant(at: float, name: str) -> Screen:
    return Screen(np.array([[at]], np.float32), name)
