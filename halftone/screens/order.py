"""Threshold arrays: a screen says, for every place in a tile, at which share of a step a dot comes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halftone.errors import UsageError

__all__ = ["Screen", "from_ranks"]


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

    @property
    def tones(self) -> int:
        """Tones between and with two neighbouring levels."""
        return np.unique(self.thresholds).size + 1

    def rows(self, y: int, count: int, width: int) -> NDArray[np.float32]:
        """Thresholds of *count* rows from row *y* on, *width* columns from column 0."""
        return tiled(self.thresholds, y, count, width)


def tiled(tile: np.ndarray, y: int, count: int, width: int) -> np.ndarray:
    """*tile* repeated: *count* rows from row *y* on, *width* columns from column 0."""
    rows = tile[np.arange(y, y + count) % tile.shape[0]]
    return np.ascontiguousarray(np.tile(rows, (1, -(-width // tile.shape[1])))[:, :width])


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
    return Screen(((array + 0.5) / counts.size).astype(np.float32), name, source)
