"""Void-and-cluster on a torus, in integers: no order of sums can change a rank."""

import numpy as np
from numpy.typing import NDArray

from halftone._jit import kernel

Integers = NDArray[np.int64]


@kernel("i8[:,:]; u1[:,:]; i8[:,:]; i8[:,:]; i8[:,:]; i8[:]; i8; i8; i8; i8")
def toggle_extremes(
    gauss: Integers,
    dots: NDArray[np.uint8],
    energy: Integers,
    best: Integers,
    best_at: Integers,
    place: Integers,
    sign: int,
    both: int,
    reach_y: int,
    reach_x: int,
) -> None:
    """Fill the largest void (*sign* 1) or empty the tightest cluster (−1), len(place) times.

    gauss : (h, 2w), what a dot at (0, 0) gives to (y, x) on the torus, twice side by side, so that
    an offset of −w … w − 1 needs no remainder; 0 beyond the reaches.
    dots : (h, w), 1 where a dot is. energy : (h, w), the sum of gauss over all dots.
    best, best_at : (2, h), the lowest energy of the holes in each row, the lowest −energy of its
    dots, 2⁶² for none, and their columns; of equal ones the first column and the first row win.
    Those of the other kind are kept up to date only where *both* is 1.
    place : receives y·w + x of every change, in order.
    """
    h, w = dots.shape
    none = np.int64(1) << 62
    kind = 0 if sign > 0 else 1
    rows = 2 * reach_y + 1 if 2 * reach_y + 1 < h else h
    columns = 2 * reach_x + 1 if 2 * reach_x + 1 < w else w
    for step in range(place.shape[0]):
        y = 0
        for r in range(1, h):
            if best[kind, r] < best[kind, y]:
                y = r
        x = best_at[kind, y]
        place[step] = y * w + x
        dots[y, x] = 1 - kind
        # Columns within reach: one run, and what wraps around on the left or on the right.
        first = x - reach_x if x > reach_x else 0
        end = x + reach_x + 1 if x + reach_x < w else w
        left = x - reach_x + w if x - reach_x + w > end else end
        right = x + reach_x + 1 - w if x + reach_x + 1 - w < first else first
        for i in range(rows):
            r = (y - reach_y + i) % h
            dy = (r - y) % h
            for c in range(right):
                energy[r, c] += sign * gauss[dy, w - x + c]
            for c in range(first, end):
                energy[r, c] += sign * gauss[dy, w - x + c]
            for c in range(left, w):
                energy[r, c] += sign * gauss[dy, w - x + c]
            for k in range(2):
                # This kind only got worse, so a best place out of reach is still the best.
                within = (best_at[k, r] - x + reach_x) % w < columns
                if (k == kind and within) or (k != kind and both == 1):
                    s = 1 - 2 * k
                    low = none
                    for c in range(w):
                        e = s * energy[r, c] if dots[r, c] == k else none
                        low = e if e < low else low
                    best[k, r] = low
                    c = 0
                    while c < w - 1 and (dots[r, c] != k or s * energy[r, c] != low):
                        c += 1
                    best_at[k, r] = c
