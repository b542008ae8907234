"""Slow twin of dot diffusion: the whole picture, class by class, one pixel at a time."""

from __future__ import annotations

import numpy as np

from tests.oracle.diffusion import nearest

f32 = np.float32

AROUND = [(-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1)]


def diffuse(
    light: np.ndarray, levels: np.ndarray, classes: list[list[int]], strength: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """Level indices, and the error that each pixel kept because nobody was left to take it."""
    distinct, first = np.unique(np.asarray(levels, f32), return_index=True)
    height, width = light.shape
    h, w = len(classes), len(classes[0])
    out = np.zeros((height, width), np.uint8)
    kept = np.zeros((height, width), f32)
    share: dict[tuple[int, int], np.float32] = {}

    def weights(y: int, x: int, higher: bool) -> list[tuple[int, int, int]]:
        """(row, column, weight) of the neighbours in the picture of higher or of lower class."""
        own, found = classes[y % h][x % w], []
        for dy, dx in AROUND:
            a, b = y + dy, x + dx
            if 0 <= a < height and 0 <= b < width:
                other = classes[a % h][b % w]
                if other != own and (other > own) == higher:
                    found.append((a, b, 1 if dy and dx else 2))
        return found

    pixels = [(y, x) for y in range(height) for x in range(width)]
    for y, x in sorted(pixels, key=lambda p: classes[p[0] % h][p[1] % w]):
        v = light[y, x]
        for a, b, weight in weights(y, x, higher=False):
            v = f32(v + f32(f32(weight) * share[a, b]))
        i = nearest(v, distinct)
        out[y, x] = first[i]
        total = sum(weight for _, _, weight in weights(y, x, higher=True))
        error = f32(v - distinct[i])
        share[y, x] = f32(error * f32(strength / total)) if total else f32(0)
        kept[y, x] = f32(0) if total else error
    return out, kept
