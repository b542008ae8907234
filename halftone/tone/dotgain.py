"""Dot gain: printed dots are round, and larger than the cells of the grid they lie on.

A dot is an ellipse about the middle of its cell; ink on ink is ink. How much of a cell is covered then
depends on its 3 × 3 neighbourhood, so a table of 512 areas says it for any picture.

Source: Pappas & Neuhoff, Printer models and error diffusion (IEEE Trans. Image Processing 4, 1995), the
circular dot-overlap model; the areas here are integrated, and so hold for ellipses and any diameter.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import mapped
from halftone.errors import UsageError

__all__ = ["WIDEST", "DotModel", "neighbourhoods"]

WIDEST = 3.0
"""Diameter, in dots, beyond which a dot would reach past its neighbours."""
SMALLEST = 0.1
COLUMNS = 8192
"""Of a cell, in each of which the covered height is exact: areas are right within 2e-6."""

Area = NDArray[np.float32]
Ink = NDArray[np.uint8]


@dataclass(frozen=True)
class DotModel:
    """A printed dot. across, down : its diameters in units of the distance between dots, 0.1 … 3.

    √2 both ways is the smallest round dot that covers its cell: a solid area is then black, and each
    black dot takes 14 % of every white neighbour beside it.
    """

    across: float
    down: float

    def __post_init__(self) -> None:
        for name in ("across", "down"):
            value = getattr(self, name)
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not number or not SMALLEST <= value <= WIDEST:
                raise UsageError(f"dot {name} = {value!r}; allowed: {SMALLEST:g} … {WIDEST:g} dots")

    @property
    def table(self) -> Area:
        """Covered area of a cell, float32 (512,), by its 3 × 3 neighbourhood: bit 3·row + column is 1
        where there is ink, row by row from the upper left; bit 4 is the cell's own."""
        return _table(self.across, self.down)

    @property
    def solid(self) -> float:
        """Covered share of an area that is all ink; below 1 black cannot be reached."""
        return float(self.table[511])

    def covered(self, ink: Ink, above: Ink | None = None, below: Ink | None = None) -> Area:
        """Covered area of every cell.

        ink : uint8 (M, N), 1 where a dot is printed. above, below : the rows (N,) before and after, for
        a band of a larger picture; None is paper, as it is to the left and right.
        """
        rows, columns = ink.shape
        padded = np.zeros((rows + 2, columns + 2), np.uint16)
        padded[1:-1, 1:-1] = ink
        for row, given in ((0, above), (-1, below)):
            if given is not None:
                padded[row, 1:-1] = given
        return mapped(self.table, neighbourhoods(padded))


def neighbourhoods(ink: NDArray[np.uint16]) -> NDArray[np.uint16]:
    """Places in :attr:`DotModel.table` of the cells of *ink* (M + 2, N + 2), 0 or 1, less its rim."""
    three = ink[:, :-2] | ink[:, 1:-1] << 1 | ink[:, 2:] << 2
    return np.asarray(three[:-2] | three[1:-1] << 3 | three[2:] << 6, np.uint16)


@lru_cache(maxsize=32)
def _table(across: float, down: float) -> Area:
    """In each column of the middle cell: the dots of a row cover one interval about the row's middle,
    as high as the highest of them; three intervals make the covered height."""
    x = (np.arange(COLUMNS) + 0.5) / COLUMNS - 0.5
    high = np.zeros((8, COLUMNS))  # half the height that a row of three dots covers, by its pattern
    for pattern in range(8):
        for place in range(3):
            if pattern >> place & 1:
                inside = 1 - ((x - (place - 1)) / (across / 2)) ** 2
                high[pattern] = np.maximum(high[pattern], down / 2 * np.sqrt(np.maximum(inside, 0)))
    table = np.empty(512, np.float64)
    for code in range(512):
        upper, own, lower = high[code & 7], high[code >> 3 & 7], high[code >> 6]
        first, last = np.clip(upper - 0.5, 0, 1), np.clip(1.5 - lower, 0, 1)  # ink above, ink below
        top, bottom = np.maximum(0.5 - own, first), np.minimum(0.5 + own, last)
        apart = first + (1 - last) + np.maximum(bottom - top, 0)
        table[code] = np.where(first >= last, 1.0, apart).mean()
    result = np.minimum(table, 1).astype(np.float32)
    result.flags.writeable = False
    return result
