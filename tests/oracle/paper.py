"""Slow twins of devices.paper: points in ellipses, counted; and sums over the eye's point spread."""

from __future__ import annotations

import math
from collections.abc import Sequence

Ink = Sequence[Sequence[int]]
Rows = list[list[float]]


def covered(ink: Ink, y: float, x: float, across: float, down: float) -> bool:
    """Whether the point (y, x), in cells from the upper left corner, lies in a dot."""
    for row in range(math.floor(y) - 2, math.floor(y) + 3):
        for column in range(math.floor(x) - 2, math.floor(x) + 3):
            if 0 <= row < len(ink) and 0 <= column < len(ink[0]) and ink[row][column]:
                dx, dy = (x - column - 0.5) / (across / 2), (y - row - 0.5) / (down / 2)
                if dx * dx + dy * dy <= 1:
                    return True
    return False


def drawn(
    ink: Ink, light: tuple[float, float], dot: tuple[float, float], scale: int, points: int
) -> Rows:
    """Light of ink and paper at scale × scale samples a cell, each of points × points points."""
    out = []
    for row in range(len(ink) * scale):
        line = []
        for column in range(len(ink[0]) * scale):
            hits = 0
            for i in range(points):
                for j in range(points):
                    y, x = row + (i + 0.5) / points, column + (j + 0.5) / points
                    hits += covered(ink, y / scale, x / scale, *dot)
            share = hits / points**2
            line.append(light[0] * share + light[1] * (1 - share))
        out.append(line)
    return out


def patch_mean(areas: Rows, row: int, column: int, reach: int) -> float:
    """Mean of the areas within *reach* cells of one, as far as the picture goes."""
    found = [
        areas[y][x]
        for y in range(max(0, row - reach), min(len(areas), row + reach + 1))
        for x in range(max(0, column - reach), min(len(areas[0]), column + reach + 1))
    ]
    return math.fsum(found) / len(found)


def point_spread(dpi: tuple[float, float], distance: float, rows: int, columns: int) -> Rows:
    """Näsänen's (α² + (2πq)²)^(−3/2) at 100 cd/m², q in degrees, for rows × columns samples."""
    alpha = 1 / (0.525 * math.log(100) + 3.91)
    out = []
    for row in range(rows):
        line = []
        for column in range(columns):
            x = (column - columns // 2) / dpi[0] / distance * 180 / math.pi
            y = (row - rows // 2) / dpi[1] / distance * 180 / math.pi
            line.append((alpha**2 + 4 * math.pi**2 * (x * x + y * y)) ** -1.5)
        out.append(line)
    total = math.fsum(math.fsum(line) for line in out)
    return [[value / total for value in line] for line in out]


def mirrored(place: int, size: int) -> int:
    """A place beyond the border, mirrored there with the edge repeated, as often as it takes."""
    place %= 2 * size
    return place if place < size else 2 * size - 1 - place


def blurred(light: Rows, spread: Rows) -> Rows:
    """Light summed with the weights of *spread*."""
    up, left = len(spread) // 2, len(spread[0]) // 2
    height, width = len(light), len(light[0])
    return [
        [
            math.fsum(
                spread[i][j] * light[mirrored(y + i - up, height)][mirrored(x + j - left, width)]
                for i in range(len(spread))
                for j in range(len(spread[0]))
            )
            for x in range(width)
        ]
        for y in range(height)
    ]
