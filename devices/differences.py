"""Where two pictures differ, as few boxes: what a partial update of a panel has to send."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["Box", "boxes"]

MOST = 16
"""Boxes that are given; where there would be more, wider gaps are bridged."""
GAP = 8
"""Rows or columns without a difference at which a box is divided in two, to begin with."""

Mask = NDArray[np.bool_]


class Box(NamedTuple):
    """A rectangle of pixels."""

    top: int
    left: int
    height: int
    width: int


def boxes(differ: Mask, columns: int = 1, most: int = MOST) -> list[Box]:
    """Rectangles without overlap that hold all of *differ* (M, N), at most *most*, from the top.

    columns : left edges and widths are multiples of it (but for the right rim), as a byte holds so
    many pixels.
    """
    rows, width = differ.shape
    padded = np.zeros((rows, -(-width // columns) * columns), np.bool_)
    padded[:, :width] = differ
    cells: Mask = np.logical_or.reduce(padded.reshape(rows, -1, columns), axis=2)
    gap = GAP
    while True:
        found = list(_divided(cells, 0, 0, gap, columns))
        if len(found) <= most:
            break
        gap *= 2
    return sorted(
        Box(top, left * columns, height, min((left + wide) * columns, width) - left * columns)
        for top, left, height, wide in found
    )


def _divided(cells: Mask, top: int, left: int, gap: int, columns: int) -> Iterator[Box]:
    """Tight boxes about what is set, divided at empty rows, else at empty columns, gap or more wide."""
    across = _runs(np.logical_or.reduce(cells, axis=1), gap)
    along = _runs(np.logical_or.reduce(cells, axis=0), -(-gap // columns))
    if not across:
        return
    if len(across) == len(along) == 1:
        (first, last), (start, stop) = across[0], along[0]
        yield Box(top + first, left + start, last - first, stop - start)
        return
    for first, last in across:
        for start, stop in along if len(across) == 1 else [(0, cells.shape[1])]:
            yield from _divided(cells[first:last, start:stop], top + first, left + start, gap, columns)


def _runs(used: Mask, gap: int) -> list[tuple[int, int]]:
    """(first, last + 1) of the runs of *used*, with gaps below *gap* bridged."""
    places = np.flatnonzero(used)
    if not places.size:
        return []
    breaks = np.flatnonzero(np.diff(places) > gap)
    first = places[np.concatenate(([0], breaks + 1))]
    last = places[np.concatenate((breaks, [places.size - 1]))] + 1
    return list(zip(first.tolist(), last.tolist(), strict=True))
