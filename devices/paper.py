"""Simulated paper: what a bilevel printer's dots look like, cell by cell, dot by dot, and from afar.

Dots are the ellipses of :class:`halftone.tone.dotgain.DotModel`. What ink does to a cell then depends
on its 3 × 3 neighbourhood alone, so a table by its 512 codes gives the cell's light, and a table of
512 tiles gives the dots in it, drawn.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray

from devices.eye import FURTHEST, at_distance, point_spread, spread_by, with_context
from halftone._arrays import whole
from halftone.errors import InputError, UsageError
from halftone.frame import Bands, Frame
from halftone.tone.dotgain import DotModel, neighbourhoods
from halftone.tone.levels import Levels
from halftone.tone.transfer import encoding

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["FINEST", "FURTHEST", "Paper", "at_distance", "point_spread"]

FINEST = 32
"""Samples a cell, across and down, that can be drawn."""
PIECE = 1 << 21
"""Samples drawn at a time: 8 MB."""
COLUMNS = 2048
"""Of a cell, in each of which the covered height is exact: cells are right within 1e-5, samples at
scale 8 within 1e-4 and at 32 within 2e-3 (ten times that for needles of 0.1 dots)."""
PATCH = 8
"""Cells on each side of one that make the patch whose luminance was measured: a 17 × 17."""
_UNIT = 1 << 30  # areas as whole numbers: sums that do not depend on how the rows were cut

Light = NDArray[np.float32]
Indices = NDArray[np.uint8]
Pairs = Sequence[tuple[float, float]]


class Paper:
    """Ink on paper.

    levels : two: the luminance of solid ink and of paper. dot : the printed dot; None is a square
    that fills its cell and nothing more. measured : pairs (predicted luminance, measured luminance)
    of flat patches, both rising, from a calibration; None trusts the dot.

    With *measured* the mean of a patch, not every cell, is mapped: light scatters in paper, so what
    lies between the dots is darker than their shapes make it (or, where it prints lighter than that,
    the dots are lighter). Solid ink and bare paper have the luminance measured for them.
    The levels of a picture need only be two; what they look like is said here.
    """

    def __init__(self, levels: Any, dot: DotModel | None, measured: Pairs | None = None) -> None:
        self.levels = Levels.of(levels)
        if len(self.levels) != 2:
            raise UsageError(
                f"paper with {len(self.levels)} levels; allowed: 2, the luminance of solid ink and of "
                "paper. Several grays have no printed dots; show their Frame.luminance instead"
            )
        self.dot = dot
        self.ink, self.white = (float(y) for y in self.levels.luminance)
        self._areas = np.array(_square(1)[:, 0, 0] if dot is None else dot.table, np.float64)
        self._measured = None if measured is None else _checked(measured)
        if self._measured is not None and not self._reading(self.ink) < self._reading(self.white):
            raise UsageError(
                f"ink and paper are both measured as {self._reading(self.ink):g}; allowed: paper "
                "lighter than ink. Let the pairs reach from ink to paper"
            )

    @overload
    def seen(self, picture: Bands) -> Iterator[Light]: ...
    @overload
    def seen(self, picture: Frame | Indices) -> Light: ...
    def seen(self, picture: Frame | Bands | Indices) -> Light | Iterator[Light]:
        """Mean light of every cell, 1 = white: float32 (M, N); for bands, bands of it.

        picture : a frame, its bands, or level indices uint8 (M, N): 0 is ink, 1 is paper.
        """
        if isinstance(picture, Bands):
            return (self._light(*window) for window in self._windows(picture, 1))
        indices = np.asarray(picture)
        out = np.empty(indices.shape, np.float32)
        done = 0
        for window in self._windows(picture, 1):
            part = self._light(*window)
            out[done : done + len(part)] = part
            done += len(part)
        return out

    def drawn(self, picture: Frame | Bands | Indices, scale: int) -> Iterator[Light]:
        """The dots as shapes, *scale* × *scale* samples a cell (1 … 32): bands of light, float32
        (rows·scale, N·scale), each sample the mean over its area. Over a cell they make ``seen``."""
        scale = whole("scale", scale, 1, FINEST)
        dot = self.dot
        tiles = _square(scale) if dot is None else _tiles(dot.across, dot.down, scale)
        light = self._between(tiles).astype(np.float32)
        return (self._drawn(light, *window) for window in self._windows(picture, scale))

    def save(
        self,
        path: str | Path,
        picture: Frame | Bands,
        scale: int = 8,
        distance: float | None = None,
        *,
        overwrite: bool = True,
    ) -> None:
        """Write the dots as an 8-bit gray PNG (sRGB; light above 1 is white), band by band.

        distance : as the eye sees them from so many inches away; the picture must know its dpi.
        """
        from halftone.images.write import write

        if distance is not None and picture.dpi is None:
            raise UsageError("a distance was given for a picture without dpi; allowed: a frame with dpi")
        parts = self.drawn(picture, scale)
        rows, columns = picture.shape
        dpi = None if picture.dpi is None else (picture.dpi[0] * scale, picture.dpi[1] * scale)
        if distance is not None and dpi is not None:
            parts = spread_by(parts, point_spread(dpi, distance))
        codes = (_srgb_codes(part) for part in parts)
        bands = Bands((rows * scale, columns * scale), codes, Levels.of(256), dpi=dpi)
        write(bands, path, "png", overwrite=overwrite)

    def _windows(self, picture: Any, scale: int) -> Iterator[tuple[NDArray[np.uint16], int, int]]:
        """Neighbourhood codes of rows, and which of them are to be shown; the others are context."""
        reach = 1 if self._measured is None else PATCH + 1
        windows = with_context(_pieces(picture, scale), reach)
        return ((neighbourhoods(np.pad(rows, 1)), first, last) for rows, first, last in windows)

    def _between(self, areas: NDArray[Any]) -> NDArray[np.float64]:
        """Light where ink covers *areas*."""
        return self.ink * areas.astype(np.float64) + self.white * (1 - areas.astype(np.float64))

    def _light(self, codes: NDArray[np.uint16], first: int, last: int) -> Light:
        """Mean light of the cells of rows first … last−1."""
        light: Light = self._between(self._areas).astype(np.float32)[codes[first:last]]
        if self._measured is None:
            return light
        slope, base = self._correction(codes, first, last)
        return (slope * light + base).astype(np.float32)

    def _drawn(self, tiles: Light, codes: NDArray[np.uint16], first: int, last: int) -> Light:
        """The tiles of rows first … last−1, laid side by side."""
        scale, columns = tiles.shape[1], codes.shape[1]
        out = np.empty((last - first, scale, columns, scale), np.float32)
        lines = [np.ascontiguousarray(tiles[:, line]) for line in range(scale)]
        for row, own in zip(out, codes[first:last].astype(np.intp), strict=True):
            for line, tile in zip(row, lines, strict=True):
                np.take(tile, own, axis=0, out=line, mode="clip")  # not checked twice: codes are < 512
        if self._measured is not None:
            slope, base = self._correction(codes, first, last)
            out *= slope.astype(np.float32)[:, None, :, None]
            out += base.astype(np.float32)[:, None, :, None]
        return out.reshape((last - first) * scale, columns * scale)

    def _reading(self, light: Any) -> Any:
        """Measured luminance of a predicted one."""
        assert self._measured is not None
        return np.interp(light, *self._measured)

    def _correction(
        self, codes: NDArray[np.uint16], first: int, last: int
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(slope, base): predicted light · slope + base is what was measured of such a patch.

        The line goes through solid ink where the patch is darker than ink and paper alone would
        make it, else through paper: so light stays between the two.
        """
        predicted = self._between(_patch_means(self._areas, codes, first, last))
        measured = self._reading(predicted)
        low, high = self._reading(self.ink), self._reading(self.white)
        straight = (high - low) / (self.white - self.ink)
        darker = measured - low <= (predicted - self.ink) * straight
        fixed, target = np.where(darker, self.ink, self.white), np.where(darker, low, high)
        apart = predicted - fixed
        slope = np.full(apart.shape, straight)
        np.divide(measured - target, apart, out=slope, where=np.abs(apart) > 1e-9 * self.white)
        return slope, target - fixed * slope


def _checked(pairs: Pairs) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Measured pairs as two arrays."""
    try:
        table = np.array(pairs, np.float64)
    except (TypeError, ValueError):
        table = np.empty(0)
    if table.ndim != 2 or table.shape[1] != 2 or len(table) < 2 or not np.isfinite(table).all():
        raise UsageError(
            "measured must be two or more pairs (predicted luminance, measured luminance) of finite "
            f"numbers; got {pairs!r}"
        )
    predicted, measured = table.T
    if (np.diff(predicted) <= 0).any() or (np.diff(measured) < 0).any() or (measured < 0).any():
        raise UsageError(
            "measured pairs must rise: a higher predicted luminance must not be measured as darker; "
            "got " + ", ".join(f"{p:g} → {m:g}" for p, m in table)
        )
    return predicted, measured


def _pieces(picture: Frame | Bands | Indices, scale: int) -> Iterator[NDArray[np.uint16]]:
    """Ink (1 where there is a dot) in rows that are few enough to be drawn at once."""
    if isinstance(picture, Frame | Bands):
        if len(picture.levels) != 2:
            raise UsageError(
                f"a picture of {len(picture.levels)} levels; allowed: 2, ink and paper. Halftone it "
                "with levels=2 or with the printer's profile"
            )
        shape = picture.shape
        parts: Iterable[Indices] = picture.indices if isinstance(picture, Bands) else [picture.indices]
    else:
        indices = np.asarray(picture)
        shape, parts = indices.shape, [indices]
        if indices.ndim != 2 or indices.size == 0 or indices.dtype.kind not in "bu":
            raise InputError(
                f"level indices of shape {indices.shape} and type {indices.dtype}; "
                "allowed: uint8 (M, N), 0 = ink, 1 = paper"
            )
    return _cut(parts, max(1, PIECE // (shape[1] * scale**2)))


def _cut(parts: Iterable[Indices], rows: int) -> Iterator[NDArray[np.uint16]]:
    for part in parts:
        for top in range(0, len(part), rows):
            indices = part[top : top + rows]
            if indices.max() > 1:
                raise InputError(f"level index {indices.max()}; allowed: 0 = ink, 1 = paper")
            yield (indices == 0).astype(np.uint16)


def _patch_means(
    areas: NDArray[np.float64], codes: NDArray[np.uint16], first: int, last: int
) -> NDArray[np.float64]:
    """Mean covered area about every cell of rows first … last−1, of the patch that lies inside."""
    sums = np.rint(areas * _UNIT).astype(np.int64)[codes]
    count = np.ones((1, 1))
    for axis, wanted in ((0, range(first, last)), (1, range(codes.shape[1]))):
        size = sums.shape[axis]
        low = np.maximum(np.array(wanted) - PATCH, 0)
        high = np.minimum(np.array(wanted) + PATCH + 1, size)
        added = np.insert(np.cumsum(sums, axis), 0, 0, axis)
        sums = added.take(high, axis) - added.take(low, axis)
        count = count * np.expand_dims(high - low, 1 - axis)
    return np.asarray(sums / (count * _UNIT))


def _square(scale: int) -> Light:
    """Tiles of a dot that is its cell: covered where bit 4 of the code is 1."""
    own = (np.arange(512) >> 4 & 1).astype(np.float32)
    return np.broadcast_to(own[:, None, None], (512, scale, scale))


@lru_cache(maxsize=8)
def _tiles(across: float, down: float, scale: int) -> Light:
    """Covered area of every sample of a cell, float32 (512, scale, scale), by its neighbourhood.

    As halftone.tone.dotgain does for the whole cell: in each column, ink from the row above reaches
    down to *first*, that from below up to *last*, and the own row's lies between *top* and *bottom*.
    """
    fine = -(-COLUMNS // scale)
    x = (np.arange(scale * fine) + 0.5) / (scale * fine) - 0.5
    high = np.zeros((8, x.size))  # half the height that a row of three dots covers, by its pattern
    for pattern in range(8):
        for place in range(3):
            if pattern >> place & 1:
                inside = 1 - ((x - (place - 1)) / (across / 2)) ** 2
                high[pattern] = np.maximum(high[pattern], down / 2 * np.sqrt(np.maximum(inside, 0)))
    y = (np.arange(scale + 1) / scale)[:, None]
    tiles = np.empty((512, scale, scale), np.float32)
    for code in range(512):
        upper, own, lower = high[code & 7], high[code >> 3 & 7], high[code >> 6]
        first, last = np.clip(upper - 0.5, 0, 1), np.clip(1.5 - lower, 0, 1)
        top, bottom = np.maximum(0.5 - own, first), np.minimum(0.5 + own, last)
        apart = np.minimum(y, first) + np.maximum(np.minimum(y, bottom) - top, 0)
        above = np.where(first >= last, y, apart + np.maximum(y - last, 0))  # covered from 0 to y
        tiles[code] = np.diff(above, axis=0).reshape(scale, scale, fine).mean(axis=2) * scale
    tiles = np.clip(tiles, 0, 1)
    tiles.flags.writeable = False
    return tiles


def _srgb_codes(light: Light) -> Indices:
    """8-bit sRGB codes of light, by a table of 65,536 steps."""
    steps = np.rint(np.clip(light, 0, 1) * np.float32(65535)).astype(np.uint16)
    return np.asarray(_srgb_table()[steps])


@lru_cache(maxsize=1)
def _srgb_table() -> Indices:
    return np.rint(encoding("srgb").encode(np.arange(65536) / 65535) * 255).astype(np.uint8)
