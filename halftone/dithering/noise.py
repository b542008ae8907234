"""Dither noise: a random threshold at every pixel.

The random number of a pixel is a function of (seed, row, column) alone, so that bands and workers
do not change the picture.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import Light, shortest, whole
from halftone.dithering.base import NO_CLAIM, Claim, Job, Method, check_strength
from halftone.dithering.ordered import step_up
from halftone.errors import UsageError

__all__ = ["RandomDither", "uniform_noise"]

MAX_SEED = (1 << 64) - 1

SHAPES = ("uniform", "triangular")


@dataclass(frozen=True)
class RandomDither(Method):
    """A threshold drawn anew for each pixel.

    noise : ``uniform`` keeps the mean tone; ``triangular`` (the mean of two uniform numbers) is
    smoother and harder in contrast, and claims no tone.
    strength : 0 (nearest level) … 1.
    """

    noise: str = "uniform"
    strength: float = 1.0
    seed: int = 0

    options = ("strength", "seed")

    def __post_init__(self) -> None:
        if self.noise not in SHAPES:
            raise UsageError(f"random:{self.noise} is unknown; allowed: {', '.join(SHAPES)}")
        check_strength(self.strength)
        object.__setattr__(self, "seed", whole("seed", self.seed, 0, MAX_SEED))

    @property
    def claim(self) -> Claim:
        # The patch mean is off by √(g(1−g))/192; 32 tones leave six such deviations.
        exact = self.noise == "uniform" and self.strength == 1
        return Claim("tones", 32) if exact else NO_CLAIM

    @property
    def source(self) -> str:
        return "Hearn & Baker, dither noise"

    def text(self) -> str:
        parts = ["random"]
        if self.noise != "uniform":
            parts.append(self.noise)
        if self.strength != 1:
            parts.append(f"strength={shortest(self.strength)}")
        if self.seed:
            parts.append(f"seed={self.seed}")
        return ":".join(parts)

    def halftoner(self, job: Job) -> _Random:
        return _Random(self, job)


class _Random:
    parallel = True

    def __init__(self, method: RandomDither, job: Job) -> None:
        self.method, self.job = method, job

    def band(self, start: int, stop: int, out: NDArray[np.uint8]) -> None:
        method, levels = self.method, self.job.levels
        noise = uniform_noise(method.seed, start, stop, out.shape[1])
        if method.noise == "triangular":
            noise = (noise + uniform_noise(~method.seed, start, stop, out.shape[1])) / np.float32(2)
        half = np.float32(0.5)
        threshold = half + np.float32(method.strength) * (noise - half)
        light = self.job.source.band(start, stop)
        np.take(levels.index, step_up(light, threshold, levels.distinct), out=out)


def uniform_noise(seed: int, start: int, stop: int, width: int) -> Light:
    """Uniform random numbers for rows start … stop−1: float32, (i + ½)/2²², i = 0 … 2²²−1.

    A 64-bit counter (row, column) is mixed with the seed by the finaliser of SplitMix64 (Steele,
    Lea & Flood 2014), once for the row and once for the pixel. 22 bits, so that no product with a
    float32 step rounds up to the step.
    """
    seed &= (1 << 64) - 1
    golden = 0x9E3779B97F4A7C15
    rows = np.arange(start + 1, stop + 1).astype(np.uint64) * np.uint64(golden)
    columns = np.arange(1, width + 1, dtype=np.uint64) * np.uint64(golden)
    mixed = _mix(_mix(rows + np.uint64(seed))[:, None] + columns[None, :])
    return ((mixed >> np.uint64(42)).astype(np.float32) + np.float32(0.5)) * np.float32(2.0**-22)


def _mix(z: NDArray[np.uint64]) -> NDArray[np.uint64]:
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))
