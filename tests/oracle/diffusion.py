"""Slow twins of the error-diffusion kernels: one pixel at a time, in plain Python."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

f32 = np.float32


def scan(y: int, width: int, serpentine: bool, from_right: bool) -> tuple[int, range]:
    """Step (+1 or −1) and columns of row y in the order of the scan."""
    backward = from_right != (serpentine and y % 2 == 1)
    return (-1, range(width - 1, -1, -1)) if backward else (1, range(width))


def nearest(v: np.float32, distinct: np.ndarray) -> int:
    """Index of the level from whose middle with the one below v is not darker."""
    chosen = 0
    for i in range(1, len(distinct)):
        low, high = distinct[i - 1], distinct[i]
        middle = f32((float(low) + float(high)) / 2)
        if middle <= low:
            middle = high
        if v >= middle:
            chosen = i
    return chosen


def diffuse_light(
    light: np.ndarray,
    levels: np.ndarray,
    taps: list[tuple[int, int, float]],
    divisor: float,
    serpentine: bool = True,
    strength: float = 1.0,
    from_right: bool = False,
) -> np.ndarray:
    """Error diffusion in float32; the sums in the order the kernel's docstring names."""
    distinct, first = np.unique(np.asarray(levels, f32), return_index=True)
    height, width = light.shape
    share = [(dy, dx, f32(w * strength / divisor)) for dy, dx, w in taps]
    ahead = {dx: w for dy, dx, w in share if dy == 0}
    below = [tap for tap in share if tap[0] > 0]
    errors: list[list[np.float32]] = []
    steps: list[int] = []
    out = np.zeros((height, width), np.uint8)
    for y in range(height):
        step, columns = scan(y, width, serpentine, from_right)
        row = [f32(0)] * width
        for x in columns:
            carry = f32(0)
            for above in range(max(0, y - 8), y):  # rows from the top, taps in table order
                for dy, dx, w in below:
                    sender = x - steps[above] * dx
                    if above + dy == y and 0 <= sender < width:
                        carry = f32(carry + f32(w * errors[above][sender]))
            v = f32(carry + min(max(light[y, x], distinct[0]), distinct[-1]))
            for back in (2, 1):
                sender = x - step * back
                if back in ahead and 0 <= sender < width:
                    v = f32(v + f32(ahead[back] * row[sender]))
            i = nearest(v, distinct)
            row[x] = f32(v - distinct[i])
            out[y, x] = first[i]
        errors.append(row)
        steps.append(step)
    return out


def diffuse_codes(codes: np.ndarray, serpentine: bool, from_right: bool = False) -> np.ndarray:
    """Floyd–Steinberg in whole units of 1/16 code, sending error forward as it is made."""
    height, width = codes.shape
    value = [[int(c) * 16 for c in row] for row in codes]
    out = np.zeros((height, width), np.uint8)
    for y in range(height):
        step, columns = scan(y, width, serpentine, from_right)
        for x in columns:
            e = value[y][x]
            if e >= 2040:
                out[y, x] = 1
                e -= 4080
            seven, three, five = e // 2 - e // 16, 3 * e // 16, 5 * e // 16
            shares = {(0, 1): seven, (1, -1): three, (1, 0): five, (1, 1): e - seven - three - five}
            for (dy, dx), part in shares.items():
                if y + dy < height and 0 <= x + step * dx < width:
                    value[y + dy][x + step * dx] += part
    return out


def diffuse_exactly(
    light: list[list[Fraction]],
    levels: list[Fraction],
    taps: list[tuple[int, int, int]],
    divisor: int,
) -> list[list[int]]:
    """The textbook: raster scan, error sent forward, in rational numbers without any rounding."""
    value = [list(row) for row in light]
    height, width = len(value), len(value[0])
    out = [[0] * width for _ in range(height)]
    for y in range(height):
        for x in range(width):
            v = value[y][x]
            i = max(range(len(levels)), key=lambda k: (-abs(v - levels[k]), k))
            out[y][x] = i
            for dy, dx, w in taps:
                if y + dy < height and 0 <= x + dx < width:
                    value[y + dy][x + dx] += (v - levels[i]) * Fraction(w, divisor)
    return out
