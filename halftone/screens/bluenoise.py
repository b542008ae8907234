"""Blue-noise screens by void-and-cluster (Ulichney 1993), for any size, and the one that ships.

Energies are whole numbers: adding and removing a dot undo each other, and the ranks are the same on
every machine. Where the Gaussian is nil, dots sparser than one in 200 pixels would be placed blindly;
a second one, three times as wide and 10⁻⁹ as high, decides there.
"""

from __future__ import annotations

import hashlib
from decimal import Context, Decimal
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import shortest
from halftone.errors import UsageError
from halftone.screens.order import Screen, from_ranks

__all__ = ["LARGEST", "SHIPPED", "SIGMA", "blue_noise", "blue_noise_ranks", "digest", "shipped"]

SIGMA = 1.5
LARGEST = 512
SHIPPED = Path(__file__).parent / "data" / "blue-noise-256.npz"
SOURCE = "Ulichney 1993"

Integers = NDArray[np.int64]

_UNITS = 1 << 52
_TAIL, _WIDER = Decimal("1e-9"), 3
_MINORITY = 10  # one pixel in ten carries a dot of the first pattern


def blue_noise_ranks(height: int, width: int, seed: int = 0, sigma: float = SIGMA) -> Integers:
    """Ranks 0 … height·width−1 of a tile that wraps around, each once.

    A random pattern of a tenth of the pixels is evened out by moving the tightest cluster to the
    largest void until that gains nothing. Its dots are ranked downwards by removing the tightest
    cluster, all other pixels upwards by filling the largest void. (Ulichney's third phase, the
    tightest cluster of holes, is the largest void again: the energies of both sum to a constant.)

    height, width : 1 … 512. seed : 0 … 2⁶⁴−1. sigma : of the Gaussian, 0.5 … 4 pixels.
    """
    _check(height, width, seed, sigma)
    gauss, reach = gaussian(height, width, sigma)
    twice = np.ascontiguousarray(np.tile(gauss, (1, 2)))
    size = height * width
    count = -(-size // _MINORITY)
    dots = np.zeros((height, width), np.uint8)
    dots.flat[shuffled(size, seed)[:count]] = 1
    energy = _energies(gauss, reach[0], dots)
    torus = _Torus(twice, reach, dots, energy)
    while True:
        (cluster,) = torus.toggled(1, -1, both=True)
        left = energy.flat[cluster]
        (void,) = torus.toggled(1, 1, both=True)
        if energy.flat[void] - gauss[0, 0] >= left:
            break
    ranks = np.zeros(size, np.int64)
    ranks[_Torus(twice, reach, dots.copy(), energy.copy()).toggled(count, -1)] = np.arange(count)[::-1]
    ranks[torus.toggled(size - count, 1)] = np.arange(count, size)
    return ranks.reshape(height, width)


@lru_cache
def blue_noise(height: int = 256, width: int = 256, seed: int = 0, sigma: float = SIGMA) -> Screen:
    """A blue-noise screen with height·width + 1 tones between two levels.

    The default, 256 × 256 from seed 0, is read from the package; others are made when asked for, in
    about 1 s for 256 × 256.
    """
    _check(height, width, seed, sigma)
    name = "blue-noise"
    if (height, width) != (256, 256):
        name += f":{width}x{height}"
    if seed:
        name += f":seed={seed}"
    if sigma != SIGMA:
        name += f":sigma={shortest(sigma)}"
    ranks = shipped() if name == "blue-noise" else blue_noise_ranks(height, width, seed, sigma)
    return from_ranks(ranks, name, SOURCE)


def shipped() -> NDArray[np.uint16]:
    """Ranks 0 … 65,535 of the 256 × 256 mask that ships; made with seed 0 and sigma 1.5."""
    with np.load(SHIPPED) as stored:
        ranks: NDArray[np.uint16] = stored["ranks"]
    return ranks


def digest(ranks: NDArray[np.integer]) -> str:
    """SHA-256 of ranks as little-endian 32-bit numbers, row by row."""
    return hashlib.sha256(np.ascontiguousarray(ranks, "<u4").tobytes()).hexdigest()


def gaussian(height: int, width: int, sigma: float) -> tuple[Integers, tuple[int, int]]:
    """What a dot at (0, 0) gives to (y, x) of a torus, in 2⁻⁵², and how far it reaches.

    The shortest way around counts. Decimal arithmetic, because exp() differs between machines in
    its last bit.
    """
    y = np.minimum(np.arange(height), height - np.arange(height))
    x = np.minimum(np.arange(width), width - np.arange(width))
    squared = y[:, None] ** 2 + x[None, :] ** 2
    context, variance = Context(prec=40), Decimal(sigma) ** 2
    distances, where = np.unique(squared, return_inverse=True)
    values = np.zeros(distances.size, np.int64)
    for i, r2 in enumerate(distances.tolist()):
        narrow = context.exp(-r2 / (2 * variance))
        wide = context.exp(-r2 / (2 * variance * _WIDER**2))
        values[i] = round(_UNITS * (narrow + _TAIL * wide))
        if values[i] == 0:
            break
    table = values[where].reshape(height, width)
    reach = int(y[table.any(axis=1)].max()), int(x[table.any(axis=0)].max())
    return table, reach


def shuffled(size: int, seed: int) -> Integers:
    """0 … size−1 in the order of the numbers SplitMix64 gives them (Steele, Lea & Flood 2014)."""
    z = np.arange(1, size + 1, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15) + np.uint64(seed)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.argsort(z ^ (z >> np.uint64(31)), kind="stable")


class _Torus:
    """A pattern of dots with their energies, both changed in place."""

    def __init__(
        self, twice: Integers, reach: tuple[int, int], dots: NDArray[np.uint8], energy: Integers
    ) -> None:
        self.twice, self.reach, self.dots, self.energy = twice, reach, dots, energy
        none = np.int64(1) << 62
        kinds = np.stack([np.where(dots, none, energy), np.where(dots, -energy, none)])
        self.best = np.ascontiguousarray(kinds.min(axis=2))
        self.best_at = np.ascontiguousarray(kinds.argmin(axis=2))

    def toggled(self, count: int, sign: int, both: bool = False) -> Integers:
        """Places of the next *count* voids filled (*sign* 1) or clusters emptied (−1)."""
        from halftone.screens._screen_kernels import toggle_extremes

        place = np.zeros(count, np.int64)
        toggle_extremes(
            self.twice, self.dots, self.energy, self.best, self.best_at,
            place, sign, int(both), *self.reach,
        )  # fmt: skip
        return place


def _energies(gauss: Integers, reach: int, dots: NDArray[np.uint8]) -> Integers:
    """The sum of gauss over all dots, rows within reach of each dot at a time."""
    height, width = dots.shape
    rows = np.array(sorted({d % height for d in range(-reach, reach + 1)}))
    twice = np.tile(gauss[rows], (1, 2))
    energy = np.zeros((height, width), np.int64)
    for y, x in np.argwhere(dots):
        energy[(y + rows) % height] += twice[:, width - x : 2 * width - x]
    return energy


def _check(height: int, width: int, seed: int, sigma: float) -> None:
    for what, side in (("height", height), ("width", width)):
        if isinstance(side, bool) or not isinstance(side, int | np.integer) or not 1 <= side <= LARGEST:
            raise UsageError(f"blue-noise of {what} {side!r}; allowed: 1, 2, … {LARGEST}")
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or not 0 <= seed < 1 << 64:
        raise UsageError(f"blue-noise with seed={seed!r}; allowed: 0 … 2^64 − 1")
    if not 0.5 <= sigma <= 4:
        raise UsageError(f"blue-noise with sigma={sigma!r}; allowed: 0.5 … 4 pixels")
