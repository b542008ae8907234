"""Dot diffusion (Knuth 1987): what a pixel could not show goes to its neighbours of higher class.

A class matrix, repeated over the whole picture, says in which order pixels are decided. A pixel
gives its error to those of its eight neighbours that come later, 2 parts to each beside, above or
below and 1 part to each across a corner, over the sum of the parts. Neighbours outside the picture
do not exist. A pixel with nobody left to give to (a baron) keeps its error.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import shortest
from halftone.dithering.base import NO_CLAIM, Claim, Job, Method, check_strength
from halftone.dithering.classes import AROUND, ClassMatrix, classes, neighbours
from halftone.errors import UsageError

__all__ = ["DotDiffusion"]


@dataclass(frozen=True)
class DotDiffusion(Method):
    """Dot diffusion with a class matrix, for any levels (Knuth 1987; Mese & Vaidyanathan 2000).

    classes : a :class:`ClassMatrix`, or its text form (``knuth``, ``mese16``, a file …).
    strength : share of the error that is passed on, 0 (nearest level) … 1.

    The value of a pixel is its light plus weight · share of each neighbour of lower class, in
    raster order, in float32; its share is its error times float32(strength / sum of the weights of
    its neighbours of higher class). It shows the nearest level, the lighter one of two as near.
    """

    classes: ClassMatrix
    strength: float = 1.0

    needs = "kernel"
    options = ("strength",)

    def __post_init__(self) -> None:
        given: Any = self.classes
        if isinstance(given, str):
            object.__setattr__(self, "classes", classes(given))
        elif not isinstance(given, ClassMatrix):
            raise UsageError(f"classes is a {type(given).__name__}; allowed: a ClassMatrix or its name")
        check_strength(self.strength)

    @property
    def claim(self) -> Claim:
        return self.classes.claim if self.strength == 1 else NO_CLAIM

    @property
    def source(self) -> str:
        return self.classes.source

    def text(self) -> str:
        tail = "" if self.strength == 1 else f":strength={shortest(self.strength)}"
        return f"dots:{self.classes.name}{tail}"

    def halftoner(self, job: Job) -> _Dots:
        return _Dots(self, job)


class _Plan(NamedTuple):
    """What a class matrix means for the kernel, in the order of the classes."""

    cell: NDArray[np.int64]
    """Row, column, reach down, reach up, number of neighbours of lower class."""
    row: NDArray[np.int64]
    """Columns of the tile between a pixel and each neighbour of lower class, rows counted in."""
    tile: NDArray[np.int64]
    """Tiles to the right of the pixel's own in which that neighbour lies: −1, 0 or 1."""
    weight: NDArray[np.float32]
    total: NDArray[np.int64]
    """Weights of the neighbours of higher class, in 16 cases of rows and columns that are last."""


@lru_cache(8)
def _plan(matrix: ClassMatrix) -> _Plan:
    w = matrix.classes.shape[1]
    order = np.argsort(matrix.classes, axis=None)
    cy, cx = np.divmod(order, w)
    own = matrix.classes.ravel()[order]
    count = np.zeros(order.size, np.int64)
    row, tile = (np.zeros((order.size, 8), np.int64) for _ in range(2))
    weight = np.zeros((order.size, 8), np.float32)
    total = np.zeros((order.size, 16), np.int64)
    for (dy, dx), around in zip(AROUND, neighbours(matrix.classes), strict=True):
        other = around.ravel()[order]
        part = 1 if dy and dx else 2
        lower = np.flatnonzero(other < own)
        place = lower, count[lower]
        away, column = np.divmod(cx[lower] + dx, w)
        row[place] = dy * w + column - cx[lower]
        tile[place] = away
        weight[place] = part
        count[lower] += 1
        for case in range(16):
            missing = (case & 1 and dy < 0) or (case & 2 and dy > 0)
            missing = missing or (case & 4 and dx < 0) or (case & 8 and dx > 0)
            if not missing:
                total[:, case] += part * (other > own)
    down, up = (reach.ravel()[order] for reach in matrix.reach())
    return _Plan(np.stack([cy, cx, down, up, count], axis=1), row, tile, weight, total)


class _Dots:
    """Each band is computed on its own, with those pixels above and below on which it depends."""

    parallel = True

    def __init__(self, method: DotDiffusion, job: Job) -> None:
        self.job = job
        self.tile = method.classes.classes.shape
        plan = _plan(method.classes)
        self.cell, self.weight = plan.cell, plan.weight
        self.halo = int(plan.cell[:, 2].max()), int(plan.cell[:, 3].max())
        self.count = -(-job.source.shape[1] // self.tile[1])
        self.link = plan.row * (self.count + 2) + plan.tile
        rim = method.strength / np.maximum(plan.total, 1)
        self.rim = np.where(plan.total > 0, rim, 0).astype(np.float32)
        self.middle = job.levels.middles()
        self.bucket, self.scale = job.levels.buckets()
        coded = job.source.codes()
        self.coded = coded if coded is not None and coded[0].dtype == np.uint8 else None
        self.spare: list[NDArray[np.float32]] = []
        """Shares of bands that are done: fresh memory would cost as much as a third of the work."""

    def band(self, start: int, stop: int, out: NDArray[np.uint8]) -> None:
        from halftone.dithering._dots_kernels import diffuse_dots

        height = self.job.source.shape[0]
        levels = self.job.levels
        h, w = self.tile
        first, last = max(0, start - self.halo[0]), min(height, stop + self.halo[1])
        share = self._shares(first, last)
        diffuse_dots(
            out, share, np.empty(self.count, np.float32),
            np.empty((stop - start) * w * self.count, np.uint8),
            self.cell, self.link, self.weight, self.rim,
            levels.distinct, self.middle, levels.index, self.bucket, self.scale,
            h, w, first, start, stop, height,
        )  # fmt: skip
        self.spare.append(share)

    def _shares(self, first: int, last: int) -> NDArray[np.float32]:
        """The light of rows first … last−1 as the kernel wants it, with zeros around."""
        from halftone.dithering._dots_kernels import part_codes, part_light

        w = self.tile[1]
        row = w * (self.count + 2)
        try:
            share = self.spare.pop()
        except IndexError:
            share = np.empty(0, np.float32)
        if share.size < (last - first + 2) * row:
            share = np.zeros((last - first + 2) * row, np.float32)
        # All else around is 0 still; here may be a row of a taller band.
        share[(last - first + 1) * row :][:row] = 0
        if self.coded is None:
            part_light(self.job.source.band(first, last), share, w)
        else:
            codes, known = self.coded
            part_codes(np.ascontiguousarray(codes[first:last]), known, share, w)
        return share
