"""Threshold modulation: noise that breaks patterns up, and the picture itself, which sharpens edges.

A pixel whose light lies between the levels a ≤ x ≤ b, at the share u = (x − a)/(b − a), is decided at
(a + b)/2 + (noise·(r − ½) − edges·(u − ½))·(b − a) instead of halfway, with r uniform in (0, 1). The
error is still taken against what is shown, so no tone is lost (Eschbach & Knox 1991: a threshold
that follows the picture filters the picture and leaves the mean).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import Light, whole
from halftone.dithering.noise import MAX_SEED, row_keys
from halftone.errors import UsageError
from halftone.tone.levels import Levels

__all__ = ["MAX_EDGES", "Decisions", "Modulation"]

MAX_EDGES = 10.0


@dataclass(frozen=True)
class Modulation:
    """noise : 0 … 1, the width of the noise in steps, or (256,) one for each tone of a step.
    edges : −10 … 10, the strength of edge enhancement; 0 is none. seed : of the noise.
    """

    noise: float | NDArray[np.float32] = 0.0
    edges: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        if not all(
            isinstance(v, int | float | np.number | np.ndarray) for v in (self.noise, self.edges)
        ):
            raise UsageError(f"noise={self.noise!r}, edges={self.edges!r}; allowed: numbers")
        if not np.all((np.asarray(self.noise) >= 0) & (np.asarray(self.noise) <= 1)):
            raise UsageError(f"noise={self.noise!r}; allowed: 0 … 1, as a share of a step")
        if not -MAX_EDGES <= self.edges <= MAX_EDGES:
            raise UsageError(f"edges={self.edges!r}; allowed: -10 … 10, where 0 changes nothing")
        object.__setattr__(self, "seed", whole("seed", self.seed, 0, MAX_SEED))

    @property
    def reach(self) -> float:
        """How far beyond its two levels, in steps, a value may be decided between them.

        Farther off, the nearest level is taken: a debt from a wide step must not stay unpaid where
        the steps are narrow. Below 0: thresholds are not modulated at all.
        """
        widest = float(np.max(self.noise)) / 2 + abs(self.edges) / 2
        return 0.5 + widest if widest else -1.0


class Decisions:
    """For bands of light: the level below each pixel, its tone within the step, its threshold.

    least, most : float32, for every step, the values between which the threshold decides.
    """

    def __init__(self, levels: Levels, modulation: Modulation) -> None:
        self.distinct = levels.distinct
        self.modulation = modulation
        width = np.broadcast_to(np.asarray(modulation.noise), 256)
        self.wide = np.ascontiguousarray(width, np.float64)
        low, high = self.distinct[:-1], self.distinct[1:]
        middle = levels.middles()
        # The nearest level: at the middle the upper one, so the threshold is the number before it.
        before = np.nextafter(middle, np.float32(-np.inf))
        self.fixed = np.zeros(0, np.float32) if modulation.reach >= 0 else before
        if self.distinct.size == 2:
            # Thresholds lie well within the reach: beyond it, the nearest level is on their side.
            self.least, self.most = (np.array([v], np.float32) for v in (-np.inf, np.inf))
        elif modulation.reach < 0:
            self.least = np.append(np.float32(-np.inf), middle[:-1])
            self.most = np.append(before[1:], np.float32(np.inf))
        else:
            far = np.float32(modulation.reach) * (high - low)
            self.least, self.most = low - far, high + far

    def band(
        self, light: Light, noise: Light
    ) -> tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.float32]]:
        """(low, tone, threshold) of *light*, with the rows' random numbers, or (0, 0) without.

        low : index of the distinct level at or below the light, at most the last but one.
        tone : 0 … 255, the light's place between low and the next, rounded.
        threshold : the light above which the next level is shown.
        """
        from halftone.dithering._toned_kernels import decide

        low, tone = (np.empty(light.shape, np.uint8) for _ in range(2))
        threshold = np.empty(light.shape, np.float32)
        edges = float(self.modulation.edges)
        decide(light, noise, low, tone, threshold, self.distinct, self.fixed, self.wide, edges)
        return low, tone, threshold

    def noise(self, start: int, stop: int, width: int) -> Light:
        """Random numbers of rows start … stop−1, as :func:`uniform_noise`; (0, 0) if not wanted."""
        from halftone.dithering._toned_kernels import draw_noise

        noise = np.empty((stop - start, width) if self.wide.any() else (0, 0), np.float32)
        if noise.size:
            keys = row_keys(self.modulation.seed, start, stop)
            with np.errstate(over="ignore"):  # where the kernel runs as plain Python
                draw_noise(keys.view(np.int64), noise)
        return noise
