"""Slow twins of the screens: void-and-cluster, dots by hand, thresholds by counting."""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np

MASK = (1 << 64) - 1


def first_pattern(size: int, seed: int) -> list[int]:
    """Places in the order of their SplitMix64 numbers."""

    def drawn(i: int) -> int:
        z = ((i + 1) * 0x9E3779B97F4A7C15 + seed) & MASK
        z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 & MASK
        z = (z ^ z >> 27) * 0x94D049BB133111EB & MASK
        return z ^ z >> 31

    return sorted(range(size), key=drawn)


def gauss(dy: int, dx: int, height: int, width: int, sigma: float) -> int:
    """What a dot gives at an offset, in 2⁻⁵²; the shortest way around the torus counts."""
    dy, dx = min(dy % height, -dy % height), min(dx % width, -dx % width)
    with localcontext() as context:
        context.prec = 40
        r2 = Decimal(dy * dy + dx * dx)
        narrow = (-r2 / (2 * Decimal(sigma) ** 2)).exp()
        wide = (-r2 / (2 * Decimal(sigma) ** 2 * 9)).exp()
        return round((1 << 52) * (narrow + Decimal("1e-9") * wide))


def blue_noise(height: int, width: int, seed: int, sigma: float) -> list[list[int]]:
    """Void-and-cluster, every energy summed anew from the dots for every step."""
    size = height * width
    table = {
        (dy, dx): gauss(dy, dx, height, width, sigma)
        for dy in range(-height, height)
        for dx in range(-width, width)
    }

    def energy(place: int, dots: set[int]) -> int:
        y, x = divmod(place, width)
        return sum(table[y - d // width, x - d % width] for d in dots)

    def cluster(dots: set[int]) -> int:
        return max(sorted(dots), key=lambda p: energy(p, dots))

    def void(dots: set[int]) -> int:
        return min(sorted(set(range(size)) - dots), key=lambda p: energy(p, dots))

    dots = set(first_pattern(size, seed)[: -(-size // 10)])
    while True:
        moved = cluster(dots)
        dots.remove(moved)
        to = void(dots)
        gained = energy(to, dots) < energy(moved, dots)
        dots.add(to)
        if not gained:
            break
    ranks = [0] * size
    left = set(dots)
    for rank in reversed(range(len(dots))):
        place = cluster(left)
        left.remove(place)
        ranks[place] = rank
    for rank in range(len(dots), size):
        place = void(dots)
        dots.add(place)
        ranks[place] = rank
    return np.array(ranks).reshape(height, width).tolist()


def holes_as_minority(ranks: np.ndarray, sigma: float) -> list[int]:
    """Ulichney's third phase as he gives it, from the half-filled pattern: the places in order."""
    height, width = ranks.shape
    size = height * width
    holes = {int(p) for p in np.flatnonzero(ranks.ravel() >= size // 2)}
    filled = []
    while holes:

        def clustered(p: int) -> int:
            y, x = divmod(p, width)
            return sum(gauss(y - q // width, x - q % width, height, width, sigma) for q in holes)

        place = max(sorted(holes), key=clustered)
        holes.remove(place)
        filled.append(place)
    return filled


def even_thresholds(numbers: list[list[int]]) -> list[list[float]]:
    """For each place the share of places below it, and half of those like it."""
    every = [n for row in numbers for n in row]

    def threshold(n: int) -> float:
        return (sum(m < n for m in every) + sum(m == n for m in every) / 2) / len(every)

    return [[threshold(n) for n in row] for row in numbers]


def owners(
    along: tuple[int, int], across: tuple[int, int], n: int, height: int, width: int
) -> np.ndarray:
    """Which of the n × n cells each pixel centre lies in, by floats; and how near to a border."""
    matrix = np.linalg.inv(np.array([along, across], float).T / n)
    y, x = np.mgrid[0:height, 0:width] + 0.5
    u, v = np.einsum("ij,jyx->iyx", matrix, np.stack([x, y]))
    border = np.minimum(np.abs(u - np.round(u)), np.abs(v - np.round(v)))
    cells = (np.floor(u).astype(int) % n) * n + np.floor(v).astype(int) % n
    return np.where(border < 1e-9, -1, cells)
