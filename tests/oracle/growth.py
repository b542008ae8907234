"""Slow twins of the pattern families: patterns, streaks and isolated dots on a tiled plane."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

Pattern = list[list[int]]


def patterns(n: int, order: list[int]) -> list[Pattern]:
    """Pattern 0, 1, … of an order of positions: each is a copy of the last with one pixel raised."""
    made = [[[0] * n for _ in range(n)]]
    for position in order:
        following = [list(row) for row in made[-1]]
        following[position // n][position % n] += 1
        made.append(following)
    return made


def nested(family: list[Pattern]) -> bool:
    """Whether every pattern is the one before with a single pixel one level higher."""
    for before, after in pairwise(family):
        pairs = [p for rows in zip(before, after, strict=True) for p in zip(*rows, strict=True)]
        changes = [b - a for a, b in pairs if a != b]
        if changes != [1]:
            return False
    return True


def has_streak(pattern: Pattern, on: bool = True) -> bool:
    """Whether a walk over the tiled plane, right, down or along a diagonal, meets only on-pixels.

    on=False: only off-pixels.
    """
    n = len(pattern)
    for y in range(n):
        for x in range(n):
            for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
                walk = [pattern[(y + i * dy) % n][(x + i * dx) % n] for i in range(2 * n)]
                if all((v > 0) == on for v in walk):
                    return True
    return False


def has_isolated(pattern: Pattern) -> bool:
    """Whether, in the middle of 3 × 3 tiles, an on-pixel has four off-neighbours."""
    n = len(pattern)
    plane = [row * 3 for row in pattern] * 3
    for y in range(n, 2 * n):
        for x in range(n, 2 * n):
            if plane[y][x] > 0:
                around = (plane[y - 1][x], plane[y + 1][x], plane[y][x - 1], plane[y][x + 1])
                if not any(around):
                    return True
    return False


def spread(n: int, order: list[int]) -> float:
    """Minus the visible noise of all patterns: Σ over patterns and pairs of on-pixels of the blur."""
    total = 0.0
    for pattern in patterns(n, order):
        on = [(y, x) for y in range(n) for x in range(n) if pattern[y][x] > 0]
        for y, x in on:
            for v, u in on:
                for i in range(-3, 4):
                    for j in range(-3, 4):
                        a = min((y - v) % n, (v - y) % n) + i * n
                        b = min((x - u) % n, (u - x) % n) + j * n
                        total += (4 + a * a + b * b) ** -1.5
    return -total


def replaced(light: list[list[float]], levels: list[float], n: int, order: list[int]) -> list[list[int]]:
    """Every pixel as the pattern, grown from level to level, of the nearest mean; ties darker.

    levels : distinct luminances. The means are rational numbers, without any rounding.
    """
    values = [Fraction(v) for v in levels]
    family = patterns(n, order * (len(values) - 1))
    tones = [sum(values[v] for row in p for v in row) / (n * n) for p in family]
    out = [[0] * (n * len(light[0])) for _ in range(n * len(light))]
    for y, row in enumerate(light):
        for x, v in enumerate(row):
            best = min(range(len(tones)), key=lambda k: (abs(tones[k] - Fraction(v)), k))
            for i in range(n):
                for j in range(n):
                    out[y * n + i][x * n + j] = family[best][i][j]
    return out
