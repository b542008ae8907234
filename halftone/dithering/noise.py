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

__all__ = ["MAX_SEED", "RandomDither", "row_keys", "uniform_noise"]

MAX_SEED = (1 << 64) - 1
GOLDEN = 0x9E3779B97F4A7C15
CACHED = 16384
"""Counters mixed at a time: few enough to stay in the cache."""

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
        threshold = self._thresholds(start, stop, out.shape[1])
        step_up(self.job.source.band(start, stop), threshold, self.job.levels, out)

    def _thresholds(self, start: int, stop: int, width: int) -> Light:
        method = self.method
        noise = uniform_noise(method.seed, start, stop, width)
        if method.noise == "triangular":
            noise = (noise + uniform_noise(~method.seed, start, stop, width)) / np.float32(2)
        if method.strength == 1:
            return noise  # to the last bit what follows
        half = np.float32(0.5)
        return half + np.float32(method.strength) * (noise - half)


def uniform_noise(seed: int, start: int, stop: int, width: int) -> Light:
    """Uniform random numbers for rows start … stop−1: float32, (i + ½)/2²², i = 0 … 2²²−1.

    A 64-bit counter (row, column) is mixed with the seed by the finaliser of SplitMix64 (Steele,
    Lea & Flood 2014), once for the row and once for the pixel. 22 bits, so that no product with a
    float32 step rounds up to the step.
    """
    keys = row_keys(seed, start, stop)[:, None]
    columns = np.arange(1, width + 1, dtype=np.uint64) * np.uint64(GOLDEN)
    noise = np.empty((stop - start, width), np.float32)
    some = max(1, CACHED // width)
    z, shifted = (np.empty((some, width), np.uint64) for _ in range(2))
    for first in range(0, stop - start, some):
        part = noise[first : first + some]
        z, shifted = z[: len(part)], shifted[: len(part)]
        np.add(keys[first : first + some], columns, out=z)
        _mix(z, shifted)
        np.right_shift(z, np.uint64(42), out=z)
        part[:] = z.view(np.int64)  # signed: that conversion is one instruction
        part += np.float32(0.5)
        part *= np.float32(2.0**-22)
    return noise


def row_keys(seed: int, start: int, stop: int) -> NDArray[np.uint64]:
    """What the counters of rows start … stop−1 begin with."""
    rows = np.arange(start + 1, stop + 1).astype(np.uint64) * np.uint64(GOLDEN)
    keys = rows + np.uint64(seed & MAX_SEED)
    _mix(keys, np.empty_like(keys))
    keys ^= keys >> np.uint64(31)
    return keys


def _mix(z: NDArray[np.uint64], shifted: NDArray[np.uint64]) -> None:
    """SplitMix64's finaliser in place, without its last step, z ^= z >> 31.

    That step changes none of the upper 31 bits. *shifted* : work space of the size of *z*.
    """
    for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):
        np.right_shift(z, np.uint64(shift), out=shifted)
        np.bitwise_xor(z, shifted, out=z)
        np.multiply(z, np.uint64(factor), out=z)
