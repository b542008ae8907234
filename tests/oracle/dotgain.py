"""Slow twins of halftone.tone.dotgain: areas by unions of intervals, neighbours one by one."""

from __future__ import annotations

import math
from collections.abc import Sequence

ROWS = 600


def area(code: int, across: float, down: float, rows: int = ROWS) -> float:
    """Covered share of a cell by the dots of its 3 × 3 neighbourhood, bit 3·row + column for each."""
    dots = [(bit % 3 - 1.0, bit // 3 - 1.0) for bit in range(9) if code >> bit & 1]
    total = 0.0
    for k in range(rows):
        y = (k + 0.5) / rows - 0.5
        intervals = []
        for middle, height in dots:
            inside = 1 - ((y - height) / (down / 2)) ** 2
            if inside > 0:
                half = across / 2 * math.sqrt(inside)
                intervals.append((min(middle - half, 0.5), min(middle + half, 0.5)))
        reached = -0.5
        for left, right in sorted(intervals):
            if right > reached:
                total += right - max(left, reached)
                reached = right
    return total / rows


def parts(rho: float) -> tuple[float, float, float]:
    """α, β, γ of Pappas & Neuhoff: what a dot beside, and one across the corner, cover of a cell, and
    what two dots beside it that meet at a corner cover both. rho : radius over T/√2, 1 … √2."""
    root = math.sqrt(2 * rho**2 - 1)
    arc = 0.5 * rho**2 * math.asin(1 / (math.sqrt(2) * rho))
    alpha = root / 4 + arc - 0.5
    beta = math.pi * rho**2 / 8 - arc - root / 4 + 0.25
    gamma = 0.5 * rho**2 * math.asin(math.sqrt((rho**2 - 1) / rho**2))
    return alpha, beta, gamma - 0.5 * math.sqrt(rho**2 - 1) - beta


def overlap(code: int, rho: float) -> float:
    """Covered share of a cell by their formula, f1·α + f2·β − f3·γ, or 1 where it has a dot itself."""
    ink = [code >> bit & 1 for bit in range(9)]
    if ink[4]:
        return 1.0
    alpha, beta, gamma = parts(rho)
    corners = ((0, 1, 3), (2, 1, 5), (6, 7, 3), (8, 7, 5))
    beside = ink[1] + ink[3] + ink[5] + ink[7]
    alone = sum(ink[c] and not ink[a] and not ink[b] for c, a, b in corners)
    meeting = sum(ink[a] and ink[b] for _, a, b in corners)
    return beside * alpha + alone * beta - meeting * gamma


def covered(ink: Sequence[Sequence[int]], table: Sequence[float]) -> list[list[float]]:
    """Covered area of every cell of a picture with paper around it."""
    rows, columns = len(ink), len(ink[0])
    found = []
    for y in range(rows):
        line = []
        for x in range(columns):
            code = 0
            for bit in range(9):
                row, column = y + bit // 3 - 1, x + bit % 3 - 1
                if 0 <= row < rows and 0 <= column < columns and ink[row][column]:
                    code |= 1 << bit
            line.append(table[code])
        found.append(line)
    return found
