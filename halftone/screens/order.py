"""Threshold arrays: a screen says, for every place in a tile, at which share of a step a dot comes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halftone._arrays import BAND_ROWS
from halftone.errors import UsageError

__all__ = ["Screen", "Tiling", "from_ranks", "tiled"]


@dataclass(frozen=True, eq=False)
class Screen:
    """A tile of thresholds that is repeated over the picture.

    thresholds : float32 (h, w), all above 0 and below 1: a pixel goes from its level to the next
    where the share of the step is *above* the threshold, so that no level ever changes.
    name : the text form; source : where it was published.
    """

    thresholds: NDArray[np.float32]
    name: str
    source: str = ""

    def __post_init__(self) -> None:
        array = np.array(self.thresholds, np.float32)
        if array.ndim != 2 or array.size == 0 or not ((array > 0) & (array < 1)).all():
            raise UsageError(
                f"screen '{self.name}': thresholds of shape {array.shape} within "
                f"{array.min(initial=9):g} … {array.max(initial=-9):g}; allowed: (h, w), all above 0 "
                "and below 1. For ranks 0 … n−1 use from_ranks"
            )
        array.flags.writeable = False
        object.__setattr__(self, "thresholds", array)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Screen) and np.array_equal(self.thresholds, other.thresholds)

    def __hash__(self) -> int:
        return hash(self.thresholds.tobytes())

    @cached_property
    def ranked(self) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
        """The different thresholds, ascending, and which of them stands at every place."""
        values, rank = np.unique(self.thresholds, return_inverse=True)
        return values, rank.reshape(self.thresholds.shape).astype(np.uint32)

    @property
    def tones(self) -> int:
        """Tones between and with two neighbouring levels."""
        return self.ranked[0].size + 1

    def rows(self, y: int, count: int, width: int) -> NDArray[np.float32]:
        """Thresholds of *count* rows from row *y* on, *width* columns from column 0."""
        return tiled(self.thresholds, y, count, width)


class Tiling:
    """*tile* repeated over a picture (height, width), made once if that takes no more than 16 MiB."""

    def __init__(self, tile: np.ndarray, height: int, width: int, band: int = BAND_ROWS) -> None:
        self.tile, self.width = tile, width
        # Wherever in the tile a band of so many rows begins, they then lie in one block.
        rows = min(tile.shape[0] + band, height)
        fits = rows * width * tile.itemsize <= 1 << 24
        self.block = tiled(tile, 0, rows, width) if fits else tile[:0]

    def rows(self, y: int, count: int) -> np.ndarray:
        """*count* rows from row *y* on."""
        first = y % self.tile.shape[0]
        if first + count > self.block.shape[0]:
            return tiled(self.tile, y, count, self.width)
        return self.block[first : first + count]


def tiled(tile: np.ndarray, y: int, count: int, width: int) -> np.ndarray:
    """*tile* repeated: *count* rows from row *y* on, *width* columns from column 0."""
    filled = min(tile.shape[1], width)
    rows = np.empty((count, width), tile.dtype)
    rows[:, :filled] = tile[np.arange(y, y + count) % tile.shape[0], :filled]
    while filled < width:  # what is there, once more beside it
        more = min(filled, width - filled)
        rows[:, filled : filled + more] = rows[:, :more]
        filled += more
    return rows


def from_ranks(ranks: ArrayLike, name: str, source: str = "") -> Screen:
    """A screen from ranks 0 … n−1, each taken the same number of times: thresholds (rank + ½)/n."""
    array = np.asarray(ranks)
    counts = np.bincount(array.ravel().astype(np.int64)) if array.size else np.zeros(1, int)
    if array.ndim != 2 or (counts != counts[0]).any() or counts[0] == 0:
        missing = [int(i) for i in np.flatnonzero(counts != max(counts.max(), 1))[:5]]
        raise UsageError(
            f"screen '{name}': ranks of shape {array.shape} in which {missing} are missing or taken "
            "a different number of times; allowed: every rank 0 … n−1 equally often"
        )
    screen = Screen(((array + 0.5) / counts.size).astype(np.float32), name, source)
    values = ((np.arange(counts.size) + 0.5) / counts.size).astype(np.float32)
    if array.dtype.kind in "iu" and (values[1:] > values[:-1]).all():
        vars(screen)["ranked"] = values, array.astype(np.uint32)  # known: no need to sort
    return screen
