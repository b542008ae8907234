"""Clustered-dot screens at a ruling and an angle, by supercells (rational tangents).

A screen's cell vectors are rarely whole pixels. A supercell of n × n cells has corners on pixels; it
approximates ruling and angle better than one cell could, and holds more tones, because each of its
cells may grow by a pixel at a time. All geometry is in whole numbers, so that ranks are the same on
every machine.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from halftone.errors import UsageError, near
from halftone.screens.order import Screen, from_ranks

__all__ = [
    "SHAPES",
    "Ruling",
    "Supercell",
    "clustered",
    "clustered_ranks",
    "find_supercell",
    "rulings",
    "screen_levels",
]

Integers = NDArray[np.int64]
Dpi = tuple[float, float]

FINEST, COARSEST = 2, 20
"""Pixels a period may have: a ruling of dpi/20 … dpi/2."""
LPI_TOLERANCE = 0.02
ANGLE_TOLERANCE = 1.0
FEWEST_TONES = 65
BEST_TONES = 257
RULINGS = (20, 25, 30, 40, 50, 60, 65, 75, 85, 100, 106, 120, 133, 150, 175, 200, 250, 300, 400, 600)

_SPAN = 160  # pixels a supercell may be long
_TILE = 1 << 21  # pixels of the rectangle that is repeated


def _round(u: Integers, v: Integers, d: int) -> Integers:
    return u * u + v * v


def _euclidean(u: Integers, v: Integers, d: int) -> Integers:
    """Round dots up to the checkerboard at ½, then round holes."""
    u, v = np.abs(u), np.abs(v)
    hole = 2 * (d // 2) ** 2 - (d // 2 - u) ** 2 - (d // 2 - v) ** 2
    return np.where(u + v <= d // 2, u * u + v * v, hole)


def _diamond(u: Integers, v: Integers, d: int) -> Integers:
    return np.abs(u) + np.abs(v)


def _ellipse(u: Integers, v: Integers, d: int) -> Integers:
    """Axes 3 : 2; neighbours join along the angle at 52 % first."""
    return 4 * u * u + 9 * v * v


def _square(u: Integers, v: Integers, d: int) -> Integers:
    return np.maximum(np.abs(u), np.abs(v))


def _line(u: Integers, v: Integers, d: int) -> Integers:
    return np.abs(v)


def _cross(u: Integers, v: Integers, d: int) -> Integers:
    return np.minimum(np.abs(u), np.abs(v))


SHAPES: dict[str, Callable[[Integers, Integers, int], Integers]] = {
    "round": _round,
    "euclidean": _euclidean,
    "diamond": _diamond,
    "ellipse": _ellipse,
    "square": _square,
    "line": _line,
    "cross": _cross,
}
"""Spot functions: what grows with the distance (u, v) from the centre of the dark dot, −d/2 … d/2."""


@dataclass(frozen=True)
class Supercell:
    """n × n cells between two whole vectors.

    along, across : (x, y) in pixels, y downwards, from corner to corner of the n cells in the
    direction of the angle and at 90° to it.
    dpi : dots per inch across and down.
    """

    along: tuple[int, int]
    across: tuple[int, int]
    n: int
    dpi: Dpi

    @property
    def pixels(self) -> int:
        """Pixels of the supercell."""
        return self.along[1] * self.across[0] - self.along[0] * self.across[1]

    @property
    def tones(self) -> int:
        return self.pixels + 1

    @property
    def lpi(self) -> float:
        """Lines per inch: one over the root of the area of a cell."""
        return self.n * math.sqrt(self.dpi[0] * self.dpi[1] / self.pixels)

    @property
    def angle(self) -> float:
        """Degrees counter-clockwise, −180 … 180: the mean of both directions, the second less 90."""
        first, second = self.directions()
        return first + ((second - 90 - first + 180) % 360 - 180) / 2

    def directions(self) -> tuple[float, float]:
        """Angles of both cell vectors on the device, degrees counter-clockwise."""
        return (_direction(self.along, self.dpi), _direction(self.across, self.dpi))

    @property
    def tile(self) -> tuple[int, int]:
        """(h, w) of the smallest rectangle that repeats."""
        (ax, ay), (bx, by) = self.along, self.across
        return self.pixels // math.gcd(ax, bx), self.pixels // math.gcd(ay, by)


def _direction(vector: tuple[int, int], dpi: Dpi) -> float:
    return math.degrees(math.atan2(-vector[1] / dpi[1], vector[0] / dpi[0]))


def _errors(cell: Supercell, angle: float, lpi: float) -> tuple[float, float]:
    """The larger relative error of both cell lengths, and of both directions in degrees."""
    lengths, turns = [], []
    for vector, wanted in ((cell.along, angle), (cell.across, angle + 90)):
        length = math.hypot(vector[0] / cell.dpi[0], vector[1] / cell.dpi[1]) / cell.n
        lengths.append(abs(length * lpi - 1))
        turns.append(abs((_direction(vector, cell.dpi) - wanted + 180) % 360 - 180))
    return max(lengths), max(turns)


@lru_cache(256)
def find_supercell(
    angle: float,
    lpi: float,
    dpi: Dpi,
    tones: int = FEWEST_TONES,
    lpi_tolerance: float = LPI_TOLERANCE,
    angle_tolerance: float = ANGLE_TOLERANCE,
) -> Supercell:
    """The supercell for a ruling of *lpi* lines per inch at *angle* degrees counter-clockwise.

    Of all with both cell lengths within *lpi_tolerance* (relative) and both directions within
    *angle_tolerance* (degrees), at least *tones* tones and a tile of at most 2²¹ pixels, the one
    with the least sum of both errors, as shares of their tolerances, and |log₂(its tones/257)|.

    Raises :class:`UsageError` if *dpi* cannot show *lpi*, or no such supercell exists.
    """
    _check(angle, lpi, dpi)
    cosine, sine = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    period = dpi[0] / lpi, dpi[1] / lpi
    best, least = None, math.inf
    for n in range(1, int(_SPAN / max(period)) + 2):
        ideal = n * period[0] * cosine, -n * period[1] * sine
        other = -n * period[0] * sine, -n * period[1] * cosine
        for along in _around(*ideal):
            # On square pixels the other vector is this one, turned: the cells stay square.
            turned = [(along[1], -along[0])] if dpi[0] == dpi[1] else _around(*other)
            for across in turned:
                cell = Supercell(along, across, n, dpi)
                if cell.pixels < max(tones - 1, 1) or math.prod(cell.tile) > _TILE:
                    continue
                off, turn = _errors(cell, angle, lpi)
                if off > lpi_tolerance or turn > angle_tolerance:
                    continue
                cost = off / lpi_tolerance + turn / angle_tolerance
                cost += abs(math.log2(cell.tones / BEST_TONES))
                cost = round(cost, 9)  # equal ones stay equal on every machine: the first is taken
                if cost < least:
                    best, least = cell, cost
    if best is None:
        raise UsageError(
            f"no supercell shows {lpi:g} lpi at {angle:g}° with {tones} tones on {dpi[0]:g} × "
            f"{dpi[1]:g} dpi within {lpi_tolerance:.1%} and {angle_tolerance:g}°; ask for another "
            "ruling or angle, or fewer tones"
        )
    return best


def clustered_ranks(shape: str, cell: Supercell) -> Integers:
    """Ranks of *cell*'s tile, (h, w): 0 … pixels−1, each as often as the supercell is in the tile.

    The dark dot of each cell grows from its centre by the spot function of *shape*. At every tone
    the cells are filled to the same share, within a pixel; which cell takes the next pixel goes by
    an order that disperses them.
    """
    if shape not in SHAPES:
        raise UsageError(near(shape, SHAPES, "dot shape"))
    (ax, ay), (bx, by), n, d = cell.along, cell.across, cell.n, 2 * cell.pixels
    # Hermite's normal form: the lattice is that of (w, 0) and (s, h).
    h, i, j = _bezout(ay, by)
    w = cell.pixels // h
    s = (i * ax + j * bx) % w
    y, x = np.mgrid[0:h, 0:w].astype(np.int64).reshape(2, -1) * 2 + 1  # centres, in half pixels
    u = n * (y * bx - x * by)
    v = n * (x * ay - y * ax)
    owner = (u // d % n) * n + v // d % n
    u, v = u % d - d // 2, v % d - d // 2
    spot, r2 = SHAPES[shape](u, v, d), u * u + v * v
    quadrant = np.where(u >= 0, np.where(v >= 0, 0, 3), np.where(v >= 0, 2, 1))
    by_cell = np.lexsort((quadrant, r2, spot, owner))
    count = np.bincount(owner, minlength=n * n)
    first = np.cumsum(count) - count
    inked = np.empty(owner.size, np.int64)
    inked[by_cell] = np.arange(owner.size) - first[owner[by_cell]]
    share = (2 * inked + 1) / (2 * count[owner])
    ranks = np.empty(owner.size, np.int64)
    ranks[np.lexsort((_dispersed(n)[owner], share))] = np.arange(owner.size)[::-1]
    rows = ranks.reshape(h, w)
    return np.concatenate([np.roll(rows, k * s, axis=1) for k in range(cell.tile[0] // h)])


@lru_cache(32)
def clustered(shape: str, cell: Supercell, name: str) -> Screen:
    """The clustered-dot screen of *cell*; *name* is its text form."""
    return from_ranks(clustered_ranks(shape, cell), name, "clustered dot, supercell")


def screen_levels(dpi: float | Dpi, lpi: float) -> int:
    """Tones of a plain cell of whole pixels: ⌊dpi/lpi + ½⌋ squared, and one."""
    across, down = _pair(dpi)
    return max(int(across / lpi + 0.5), 1) * max(int(down / lpi + 0.5), 1) + 1


class Ruling(NamedTuple):
    """What a device shows at a ruling.

    pixels : of a cell, ideally. tones : of a plain cell of whole pixels. supercell_tones : of the
    supercell, and the ruling and angle it achieves; 0 where there is none within the tolerances.
    """

    lpi: float
    pixels: float
    tones: int
    supercell_tones: int
    achieved_lpi: float
    achieved_angle: float


def rulings(dpi: float | Dpi, angle: float = 45.0) -> list[Ruling]:
    """A row for each customary ruling that *dpi* can show (dpi/20 … dpi/2)."""
    across, down = _pair(dpi)
    rows = []
    for lpi in RULINGS:
        if not (max(across, down) / COARSEST <= lpi <= min(across, down) / FINEST):
            continue
        plain = across * down / lpi**2, screen_levels((across, down), lpi)
        try:
            cell = find_supercell(angle, lpi, (across, down))
        except UsageError:
            rows.append(Ruling(lpi, *plain, 0, 0.0, 0.0))
        else:
            rows.append(Ruling(lpi, *plain, cell.tones, cell.lpi, cell.angle))
    return rows


def _check(angle: float, lpi: float, dpi: Dpi) -> None:
    if not all(0 < d < math.inf for d in dpi):
        raise UsageError(f"dpi={dpi}; allowed: above 0")
    if not -360 <= angle <= 360:
        raise UsageError(f"a screen angle of {angle!r}°; allowed: −360 … 360")
    low, high = max(dpi) / COARSEST, min(dpi) / FINEST
    # The ends count, also after a division that rounded.
    if not low * (1 - 1e-9) <= lpi <= high * (1 + 1e-9):
        raise UsageError(
            f"{lpi:g} lines per inch on {dpi[0]:g} × {dpi[1]:g} dpi, a period of {dpi[0] / lpi:.3g} "
            f"pixels; allowed: {low:.4g} … {high:.4g} lpi (periods of {FINEST} … {COARSEST} pixels)"
            if lpi > 0
            else f"{lpi!r} lines per inch; allowed: above 0"
        )


def _pair(dpi: float | Dpi) -> Dpi:
    return dpi if isinstance(dpi, tuple) else (dpi, dpi)


def _around(x: float, y: float) -> list[tuple[int, int]]:
    """Whole vectors next to (x, y), the nearest first."""
    near_by = [(round(x) + i, round(y) + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    return sorted(near_by, key=lambda p: (round((p[0] - x) ** 2 + (p[1] - y) ** 2, 6), p))


def _bezout(a: int, b: int) -> tuple[int, int, int]:
    """(g, i, j) with g = gcd(a, b) = i·a + j·b, g > 0 (Euclid's extended algorithm)."""
    old, new = (a, 1, 0), (b, 0, 1)
    while new[0]:
        q = old[0] // new[0]
        old, new = new, (old[0] - q * new[0], old[1] - q * new[1], old[2] - q * new[2])
    return old if old[0] > 0 else (-old[0], -old[1], -old[2])


@lru_cache(32)
def _dispersed(n: int) -> Integers:
    """An order of the n × n cells of a torus: each next one where the others are farthest.

    Each cell repels by 2⁴⁰/(1 + r²), in whole numbers; of equal places the first is taken.
    """
    step = np.minimum(np.arange(n), n - np.arange(n)).astype(np.int64)
    repel = (1 << 40) // (1 + step[:, None] ** 2 + step[None, :] ** 2)
    energy = np.zeros((n, n), np.int64)
    order = np.empty(n * n, np.int64)
    for k in range(n * n):
        y, x = divmod(int(energy.argmin()), n)
        order[y * n + x] = k
        energy += np.roll(repel, (y, x), (0, 1))
        energy[y, x] = 1 << 61
    return order
