"""Bayer's dispersed-dot threshold arrays (Bayer 1973), by recursion."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from halftone.errors import UsageError
from halftone.screens.order import Screen, from_ranks

__all__ = ["SIZES", "bayer", "bayer_ranks"]

SIZES = (2, 4, 8, 16)

D2 = np.array([[3, 1], [0, 2]])


def bayer_ranks(n: int) -> NDArray[np.int64]:
    """Ranks 0 … n²−1 for n = 2, 4, 8, …: D_n = 4·D_{n/2}, tiled, plus D_2, blown up to n × n.

    D_2 = [[3, 1], [0, 2]], the form of Hearn & Baker (ordered dither).
    """
    if isinstance(n, bool) or n < 2 or n & (n - 1) or n > 256:
        raise UsageError(f"a Bayer array of size {n}; allowed: 2, 4, 8, 16, … 256")
    ranks = D2
    while ranks.shape[0] < n:
        ranks = 4 * np.tile(ranks, (2, 2)) + np.kron(D2, np.ones_like(ranks))
    return ranks.astype(np.int64)


@lru_cache
def bayer(n: int) -> Screen:
    """The n × n Bayer screen, n²+1 tones between two levels."""
    return from_ranks(bayer_ranks(n), f"bayer{n}", "Bayer 1973")
