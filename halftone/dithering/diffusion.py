"""Error diffusion: what a pixel could not show is carried on to its neighbours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone.dithering.base import NO_CLAIM, Claim, Halftoner, Job, Method, check_flags, check_strength
from halftone.dithering.filters import FILTERS, ErrorFilter
from halftone.dithering.modulation import Modulation
from halftone.dithering.toned import Taps, Toned, enhanced_side, started, text_of
from halftone.dithering.warm import check_start
from halftone.dithering.wave import WaveCodes, WaveLight, few_rounds
from halftone.errors import UsageError, near

__all__ = ["ErrorDiffusion", "FloydSteinberg"]

LINEAR = (np.arange(256) / 255).astype(np.float32)
"""The light of 8-bit codes that are light."""


@dataclass(frozen=True)
class ErrorDiffusion(Method):
    """Error diffusion with an error filter, for any levels (Floyd & Steinberg 1976).

    filter : an :class:`ErrorFilter` or the name of a canonical one.
    serpentine : odd rows are scanned backwards, with the filter mirrored.
    from_right : the first row starts at the right; the picture is the mirror image of what the
    mirrored input gives from the left.
    strength : share of the error that is passed on, 0 (nearest level) … 1.
    noise, edges, seed : threshold modulation (:mod:`halftone.dithering.modulation`): noise of 0 … 1
    step, and edge enhancement of −10 … 10.
    start : ``cold``, or ``warm``, which cures start-up voids (:mod:`halftone.dithering.warm`).

    Error that would fall off the picture's sides or bottom is dropped, as in the definition. 8-bit
    codes whose light is linear go to two levels 0 and 1 by Floyd–Steinberg in integer arithmetic,
    in units of 1/16 code; everything else is computed in float32 light.
    """

    filter: ErrorFilter = FILTERS["floyd-steinberg"]
    serpentine: bool = True
    strength: float = 1.0
    from_right: bool = False
    noise: float = 0.0
    edges: float = 0.0
    start: str = "cold"
    seed: int = 0

    needs = "kernel"
    options = ("strength", "serpentine", "seed")

    def __post_init__(self) -> None:
        if isinstance(self.filter, str):
            if self.filter not in FILTERS:
                raise UsageError(near(self.filter, FILTERS, "error filter"))
            object.__setattr__(self, "filter", FILTERS[self.filter])
        check_strength(self.strength)
        check_flags(serpentine=self.serpentine, from_right=self.from_right)
        check_start(self.start)
        modulation = Modulation(self.noise, self.edges, self.seed)
        if self.seed and modulation.reach < 0 and self.start == "cold":
            raise UsageError(f"seed does not apply to '{self.filter.name}': it draws no random numbers")

    @property
    def claim(self) -> Claim:
        if not self.filter.conserves or self.strength != 1:
            return NO_CLAIM
        return Claim("exact", side=enhanced_side(self.filter.exact_side, self.edges))

    @property
    def source(self) -> str:
        return self.filter.source

    def text(self) -> str:
        return text_of(self.filter.name, self)

    def halftoner(self, job: Job) -> Halftoner:
        modulation = Modulation(self.noise, self.edges, self.seed)
        if modulation.reach >= 0:
            taps = Taps.of(self.filter, self.strength)
            return started(self, job, lambda inner: Toned(inner, taps, modulation, self))
        if self.start == "cold":
            if self._integer(job):
                return _Codes(self, job) if self.serpentine else WaveCodes(job, self.from_right)
            if not self.serpentine and few_rounds(job.levels):
                return WaveLight(job, self.filter, self.strength, self.from_right)
            if _Four.takes(self, job):
                return _Four(self, job)
        return started(self, job, lambda inner: _Light(self, inner))

    def _integer(self, job: Job) -> bool:
        coded = job.source.codes()
        return (
            self.filter == FILTERS["floyd-steinberg"]
            and self.strength == 1
            and coded is not None
            and coded[0].dtype == np.uint8
            and job.levels.distinct.tolist() == [0, 1]
            and np.array_equal(coded[1], LINEAR)
        )


def FloydSteinberg(**options: Any) -> ErrorDiffusion:  # noqa: N802 (reads as a method's name)
    """Error diffusion by Floyd & Steinberg 1976; options as in :class:`ErrorDiffusion`."""
    return ErrorDiffusion(FILTERS["floyd-steinberg"], **options)


class _Light:
    """State of the float32 kernel between bands: the ring of carries, and one row of errors."""

    parallel = False

    def __init__(self, method: ErrorDiffusion, job: Job) -> None:
        width = job.source.shape[1]
        taps = method.filter.taps
        share = {t[:2]: np.float32(t[2] * method.strength / method.filter.divisor) for t in taps}
        self.left = [float(share.pop((0, dx), 0)) for dx in (1, 2)]
        self.dy = np.array([dy for dy, _ in share], np.int64)
        self.dx = np.array([dx for _, dx in share], np.int64)
        self.weight = np.array(list(share.values()), np.float32)
        self.carry = np.zeros((method.filter.depth + 1, width), np.float32)
        self.error = np.zeros(width + 2 * method.filter.reach, np.float32)
        self.scan = (int(method.serpentine), int(method.from_right))
        self.job = job
        self.middle = job.levels.middles()
        self.bucket, self.scale = job.levels.buckets()

    def band(self, start: int, stop: int, out: NDArray[np.uint8]) -> None:
        from halftone.dithering._diffusion_kernels import diffuse_light

        levels = self.job.levels
        diffuse_light(
            self.job.source.band(start, stop), out, self.carry, self.error,
            self.dy, self.dx, self.weight, *self.left,
            levels.distinct, self.middle, levels.index, self.bucket, self.scale,
            start, *self.scan,
        )  # fmt: skip


class _Four:
    """State between bands of the kernel for 8-bit codes, two levels and four places."""

    parallel = False
    PLACES = ((0, 1), (1, -1), (1, 0), (1, 1))

    def __init__(self, method: ErrorDiffusion, job: Job) -> None:
        share = {t[:2]: t[2] * method.strength / method.filter.divisor for t in method.filter.taps}
        self.weight = np.array([share.get(place, 0.0) for place in self.PLACES], np.float32)
        self.carry = np.zeros(job.source.shape[1] + 2, np.float32)
        self.scan = (int(method.serpentine), int(method.from_right))
        self.job = job
        self.half = float(job.levels.middles()[0])
        coded = job.source.codes()
        assert coded is not None
        self.codes, light = coded
        self.table = np.clip(light, job.levels.distinct[0], job.levels.distinct[-1])

    @classmethod
    def takes(cls, method: ErrorDiffusion, job: Job) -> bool:
        coded = job.source.codes()
        # The sums are those of the filter's table, in its order: the places must come in ours.
        places = [tap[:2] for tap in method.filter.taps if tap[0]]
        fits = places == [place for place in cls.PLACES[1:] if place in places]
        fits = fits and all(tap[:2] in cls.PLACES for tap in method.filter.taps)
        return (
            fits and job.levels.distinct.size == 2 and coded is not None and coded[0].dtype == np.uint8
        )

    def band(self, start: int, stop: int, out: NDArray[np.uint8]) -> None:
        from halftone.dithering._diffusion_kernels import diffuse_four

        diffuse_four(
            np.ascontiguousarray(self.codes[start:stop]), self.table, out, self.carry, self.weight,
            self.job.levels.distinct, self.half, self.job.levels.index, start, *self.scan,
        )  # fmt: skip


class _Codes:
    """State of the integer kernel between bands."""

    parallel = False

    def __init__(self, method: ErrorDiffusion, job: Job) -> None:
        width = job.source.shape[1]
        self.carry = np.zeros(width, np.int32)
        self.error = np.zeros(width + 2, np.int32)
        self.scan = (int(method.serpentine), int(method.from_right))
        self.job = job

    def band(self, start: int, stop: int, out: NDArray[np.uint8]) -> None:
        from halftone.dithering._diffusion_kernels import diffuse_codes

        codes = np.ascontiguousarray(self.job.source.pixels[start:stop])
        index = self.job.levels.index
        diffuse_codes(codes, out, self.carry, self.error, index, start, *self.scan)
