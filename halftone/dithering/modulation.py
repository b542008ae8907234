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
from halftone.dithering.noise import MAX_SEED, uniform_noise
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
    """For bands of light: the level below each pixel, its tone within the step, its threshold."""

    def __init__(self, levels: Levels, modulation: Modulation) -> None:
        self.distinct = levels.distinct
        self.modulation = modulation

    def band(self, light: Light, start: int) -> tuple[NDArray[np.uint8], NDArray[np.uint8], Light]:
        """(low, tone, threshold) for rows from *start* on.

        low : index of the distinct level at or below the light, at most the last but one.
        tone : 0 … 255, the light's place between low and the next, rounded.
        threshold : the light above which the next level is shown.
        """
        low = np.searchsorted(self.distinct[1:-1], light, side="right")
        base = self.distinct[low].astype(np.float64)
        step = self.distinct[low + 1] - base
        share = np.clip((light - base) / step, 0, 1)
        tone = np.rint(share * 255).astype(np.uint8)
        shift = -self.modulation.edges * (share - 0.5)
        width = self.modulation.noise
        if np.any(width):
            rows, columns = light.shape
            noise = uniform_noise(self.modulation.seed, start, start + rows, columns)
            wide = width[tone] if isinstance(width, np.ndarray) else np.float64(width)
            shift = shift + (noise.astype(np.float64) - 0.5) * wide
        # A pixel exactly on a level keeps it.
        shift = np.where(
            share == 0, np.maximum(shift, 0), np.where(share == 1, np.minimum(shift, 0), shift)
        )
        threshold = (base + (0.5 + shift) * step).astype(np.float32)
        return low.astype(np.uint8), tone, threshold
