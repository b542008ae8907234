"""Slow twins of the point methods: thresholds, noise, Bayer's arrays, Otsu."""

from __future__ import annotations

import numpy as np

f32 = np.float32


def step_up(light: np.ndarray, threshold: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """b where v − a > t·(b − a), else a, for the levels a ≤ v ≤ b around each pixel."""
    distinct, first = np.unique(np.asarray(levels, f32), return_index=True)
    out = np.zeros(light.shape, np.uint8)
    for (y, x), value in np.ndenumerate(light):
        v = min(max(value, distinct[0]), distinct[-1])
        k = 0
        while k < len(distinct) - 2 and v >= distinct[k + 1]:
            k += 1
        a, b = distinct[k], distinct[k + 1]
        t = f32(threshold[y % threshold.shape[0], x % threshold.shape[1]])
        out[y, x] = first[k + 1] if f32(v - a) > f32(t * f32(b - a)) else first[k]
    return out


def bayer(n: int) -> list[list[int]]:
    """Ranks by interleaving the bits of x and of x xor y, most significant last."""
    bits = n.bit_length() - 1
    rows = []
    for y in range(n):
        row = []
        for x in range(n):
            rank = 0
            for bit in range(bits):
                pair = [[3, 1], [0, 2]][y >> bit & 1][x >> bit & 1]
                rank += pair << 2 * (bits - 1 - bit)
            row.append(rank)
        rows.append(row)
    return rows


def mix(z: int) -> int:
    """The finaliser of SplitMix64."""
    mask = (1 << 64) - 1
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 & mask
    z = (z ^ z >> 27) * 0x94D049BB133111EB & mask
    return z ^ z >> 31


def noise(seed: int, y: int, x: int) -> float:
    """The uniform random number of one pixel."""
    mask = (1 << 64) - 1
    golden = 0x9E3779B97F4A7C15
    row = mix((y + 1) * golden + seed & mask)
    return ((mix(row + (x + 1) * golden & mask) >> 42) + 0.5) / (1 << 22)


def otsu(counts: list[int]) -> int:
    """The bin that gives the largest variance between the classes it divides."""
    best, chosen = -1.0, 0
    total = sum(counts)
    for t in range(len(counts) - 1):
        dark = counts[: t + 1]
        n = sum(dark)
        if n in (0, total):
            continue
        low = sum(i * c for i, c in enumerate(dark)) / n
        high = sum(i * c for i, c in enumerate(counts) if i > t) / (total - n)
        between = n * (total - n) * (low - high) ** 2
        if between > best * (1 + 1e-12):
            best, chosen = between, t
    return chosen
