"""Error diffusion with weights that follow the tone, modulated thresholds, and a warm start."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import Light, shortest
from halftone.dithering.base import NO_CLAIM, Claim, Halftoner, Job, Method, check_flags, check_strength
from halftone.dithering.filters import ErrorFilter
from halftone.dithering.modulation import Decisions, Modulation
from halftone.dithering.warm import Warm, check_start
from halftone.errors import UsageError, near

__all__ = ["TABLES", "ToneDiffusion", "Toned", "tone_table"]

TABLES = {
    "ostromoukhov": ("ostromoukhov2001.csv", "Ostromoukhov 2001", 192),
    "zhou-fang": ("zhoufang2003.csv", "Zhou & Fang 2003; modulation made symmetric", 192),
}

PLACES = ((0, 1), (1, -1), (1, 0))
"""Taps of both tables: ahead, down-back, down."""


@dataclass(frozen=True)
class ToneDiffusion(Method):
    """Error diffusion with three weights for each of 256 tones between two levels.

    name : ``ostromoukhov`` or ``zhou-fang``, which adds noise to the threshold, tone by tone.
    noise : scales that noise, 0 … 1. edges : edge enhancement, −10 … 10 (Eschbach & Knox 1991).
    start : ``cold``, or ``warm`` (:mod:`halftone.dithering.warm`).
    The tables' tones are shares of the step between the two levels around the light.
    """

    name: str = "ostromoukhov"
    serpentine: bool = True
    strength: float = 1.0
    from_right: bool = False
    noise: float = 1.0
    edges: float = 0.0
    start: str = "cold"
    seed: int = 0

    needs = "kernel"
    options = ("strength", "serpentine", "seed")

    def __post_init__(self) -> None:
        if self.name not in TABLES:
            raise UsageError(near(self.name, TABLES, "table of weights"))
        check_strength(self.strength)
        check_flags(serpentine=self.serpentine, from_right=self.from_right)
        check_start(self.start)
        Modulation(self.noise, self.edges, self.seed)
        drawn = self.name == "zhou-fang"
        if self.noise != 1 and not drawn:
            raise UsageError(f"noise does not apply to '{self.name}', whose table has none")
        if self.seed and not drawn and self.start == "cold":
            raise UsageError(f"seed does not apply to '{self.name}': it draws no random numbers")

    @property
    def claim(self) -> Claim:
        if self.strength != 1:
            return NO_CLAIM
        return Claim("exact", side=enhanced_side(TABLES[self.name][2], self.edges))

    @property
    def source(self) -> str:
        return TABLES[self.name][1]

    def text(self) -> str:
        return text_of(self.name, self)

    def halftoner(self, job: Job) -> Halftoner:
        weights, noise = tone_table(self.name)
        scaled = (weights * self.strength).astype(np.float32)
        modulation = Modulation((noise * self.noise).astype(np.float32), self.edges, self.seed)
        coded = job.source.codes()
        if self.start == "cold" and coded is not None and coded[0].dtype == np.uint8:
            return _TonedCodes(job, scaled, modulation, self)
        taps = Taps(PLACES[1:], scaled[:, 1:], scaled[:, :1])
        return started(self, job, lambda inner: Toned(inner, taps, modulation, self))


@dataclass(frozen=True, eq=False)
class Taps:
    """places : of the rows below. weight : float32 (tones, places). left : (tones, 1 or 2).

    One row of weights stands for all tones.
    """

    places: tuple[tuple[int, int], ...]
    weight: NDArray[np.float32]
    left: NDArray[np.float32]

    @classmethod
    def of(cls, filter: ErrorFilter, strength: float) -> Taps:
        """The same weights for all tones."""
        share = {t[:2]: np.float32(t[2] * strength / filter.divisor) for t in filter.taps}
        left = np.array([share.pop((0, dx), 0) for dx in (1, 2)], np.float32)
        below = np.array(list(share.values()), np.float32)
        return cls(tuple(share), below[None], left[None])


class Toned:
    """State of the kernel between bands."""

    parallel = False

    def __init__(self, job: Job, taps: Taps, modulation: Modulation, scan: Any) -> None:
        width = job.source.shape[1]
        self.job = job
        self.decisions = Decisions(job.levels, modulation)
        self.dy = np.array([dy for dy, _ in taps.places], np.int64)
        self.dx = np.array([dx for _, dx in taps.places], np.int64)
        self.weight = np.ascontiguousarray(taps.weight.T, np.float32)
        self.left = np.zeros((2, taps.left.shape[0]), np.float32)
        self.left[: taps.left.shape[1]] = taps.left.T
        margin = int(np.abs(self.dx).max(initial=0))
        self.carry = np.zeros((int(self.dy.max(initial=0)) + 1, width), np.float32)
        self.error = np.zeros(width + 2 * margin, np.float32)
        self.sender = np.zeros(width + 2 * margin, np.uint8)
        self.scan = (int(scan.serpentine), int(scan.from_right))
        self.middle = job.levels.middles()

    def band(self, start: int, stop: int, out: NDArray[np.uint8]) -> None:
        from halftone.dithering._toned_kernels import diffuse_toned

        light = self.job.source.band(start, stop)
        decisions = self.decisions
        low, tone, threshold = decisions.band(light, decisions.noise(start, stop, out.shape[1]))
        levels = self.job.levels
        diffuse_toned(
            light, low, tone, threshold, out, self.carry, self.error, self.sender,
            self.dy, self.dx, self.weight, self.left,
            levels.distinct, self.middle, levels.index, decisions.least, decisions.most,
            start, *self.scan,
        )  # fmt: skip


class _TonedCodes:
    """The same for 8-bit codes and the three taps of the tables: what a code means is known once."""

    parallel = False

    def __init__(
        self, job: Job, weights: NDArray[np.float32], modulation: Modulation, scan: Any
    ) -> None:
        coded = job.source.codes()
        assert coded is not None
        self.codes, light = coded
        self.job = job
        self.decisions = Decisions(job.levels, modulation)
        self.middle = job.levels.middles()
        width = job.source.shape[1]
        self.carry = np.zeros(width + 2, np.float32)
        self.value, self.threshold = (np.empty(width, np.float32) for _ in range(2))
        self.scan = (int(scan.serpentine), int(scan.from_right))
        self._know(light, weights)

    def _know(self, light: Light, weights: NDArray[np.float32]) -> None:
        """Tables by code, as the kernel describes them."""
        decisions, distinct = self.decisions, self.job.levels.distinct
        none = np.empty((0, 0), np.float32)
        half = np.full((1, light.size), 0.5, np.float32)  # noise that moves no threshold
        low, tone, threshold = (
            v[0] for v in decisions.band(light[None], half if decisions.wide.any() else none)
        )
        known = np.zeros((light.size, 16), np.float32)
        known[:, 0] = np.clip(light, distinct[0], distinct[-1])
        known[:, 1], known[:, 2] = -distinct[low], distinct[low + 1]
        known[:, 3], known[:, 4] = decisions.least[low], decisions.most[low]
        known[:, 5] = threshold
        known[:, 6:9] = weights[tone]
        base = distinct[low].astype(np.float64)
        step = distinct[low + 1] - base
        share = np.clip((light - base) / step, 0, 1)
        drawn = np.zeros((light.size, 8))
        drawn[:, 0], drawn[:, 1] = base, step
        drawn[:, 2] = -decisions.modulation.edges * (share - 0.5)
        drawn[:, 3] = decisions.wide[tone]
        # A pixel exactly on a level keeps it.
        drawn[:, 4] = np.where(share == 0, 0, -np.inf)
        drawn[:, 5] = np.where(share == 1, 0, np.inf)
        self.low, self.known, self.drawn = low, known.ravel(), drawn.ravel()

    def band(self, start: int, stop: int, out: NDArray[np.uint8]) -> None:
        from halftone.dithering._toned_kernels import diffuse_toned_codes

        levels = self.job.levels
        diffuse_toned_codes(
            np.ascontiguousarray(self.codes[start:stop]),
            self.decisions.noise(start, stop, out.shape[1]),
            out, self.carry, self.value, self.threshold, self.known, self.drawn, self.low,
            levels.distinct, self.middle, levels.index, start, *self.scan,
        )  # fmt: skip


def enhanced_side(side: int, edges: float) -> int:
    """Side from which on tones are exact with edge enhancement: errors grow with its strength."""
    return side if not edges else -(-int(side * (1 + 1.6 * abs(edges))) // 32) * 32


def started(method: Any, job: Job, make: Any) -> Halftoner:
    """The halftoner that *make* makes of a job, begun as the method's ``start`` says."""
    return Warm(job, make, method.seed) if method.start == "warm" else make(job)


@cache
def tone_table(name: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Shares (256, 3) for the taps ahead, down-back and down, and the noise's width (256,) in steps.

    The published tables hold tones 0 … 127; tone 255 − t mirrors t.
    """
    from pathlib import Path

    path = Path(__file__).parent / "data" / TABLES[name][0]
    rows = np.loadtxt(path, delimiter=",", skiprows=1)
    half = rows[:, 1:4] / rows[:, 4:5]
    # Zhou & Fang add up to 128 of 255 codes, on one side; half that to either side is the same width.
    noise = rows[:, 5] / 100 * (128 / 255) if rows.shape[1] > 5 else np.zeros(len(rows))
    return np.concatenate([half, half[::-1]]), np.concatenate([noise, noise[::-1]])


def text_of(name: str, method: Any) -> str:
    """*name* and the parts that differ from what its class has."""
    default = type(method)
    parts = [name]
    if method.serpentine != default.serpentine:
        parts.append("serpentine" if method.serpentine else "raster")
    if method.from_right:
        parts.append("right")
    for field in ("strength", "noise", "edges"):
        if getattr(method, field) != getattr(default, field):
            parts.append(f"{field}={shortest(getattr(method, field))}")
    if method.start != default.start:
        parts.append(method.start)
    if method.seed:
        parts.append(f"seed={method.seed}")
    return ":".join(parts)
