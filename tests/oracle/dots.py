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


def diffuse_flats(classes: np.ndarray, tones: np.ndarray) -> np.ndarray:
    """Level indices 0 and 1 of one tile that goes on for ever, (places, tones)."""
    h, w = classes.shape
    lit = np.zeros((classes.size, tones.size), np.uint8)
    around = [(-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1)]
    for t, tone in enumerate(tones):
        share = np.zeros((h, w), np.float32)
        for place in np.argsort(classes, axis=None):
            y, x = divmod(int(place), w)
            value, total = np.float32(tone), 0
            for dy, dx in around:
                other = (y + dy) % h, (x + dx) % w
                part = 1 if dy and dx else 2
                if classes[other] < classes[y, x]:
                    value = np.float32(value + np.float32(np.float32(part) * share[other]))
                elif classes[other] > classes[y, x]:
                    total += part
            lit[place, t] = value >= np.float32(0.5)
            error = np.float32(value - np.float32(lit[place, t]))
            rest = np.float32(1 / total) if total else np.float32(0)
            share[y, x] = np.float32(error * rest)
    return lit
