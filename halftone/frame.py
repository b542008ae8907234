"""The result: level indices, and what they mean on the device."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from halftone._arrays import mapped, whole
from halftone.packing import Packing, bytes_per_row, pack
from halftone.tone.levels import Levels

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["Bands", "Frame"]

Indices = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Frame:
    """What the device will show.

    indices : uint8 (M, N), 0 = the darkest level. ``np.asarray(frame)`` gives them.
    levels : the luminance of every level.
    method : the text form of the method. dpi : dots per inch across and down, or None.
    packing : how the device wants its pixels.
    report : what was done, stage by stage, with seconds, and what was left out and why.
    """

    indices: Indices
    levels: Levels
    method: str = ""
    dpi: tuple[float, float] | None = None
    packing: Packing | None = None
    report: dict[str, Any] = field(default_factory=dict, repr=False)

    @property
    def shape(self) -> tuple[int, int]:
        return self.indices.shape[0], self.indices.shape[1]

    @property
    def luminance(self) -> NDArray[np.float32]:
        """Linear light that the device shows: float32 (M, N), 1 = the device's white."""
        return mapped(self.levels.luminance, self.indices)

    def packed(self, packing: Packing | None = None) -> NDArray[np.uint8]:
        """Rows of packed bytes, uint8 (M, bytes a row); ``.tobytes()`` is the whole buffer.

        packing : None takes the device's, or for a frame without a device the fewest of 1, 2, 4, 8
        bits that hold a level index, the leftmost pixel in the highest bits.
        """
        return pack(self.indices, packing or self.packing or Packing(self.levels.bits))

    def upscaled(self, factor: int) -> Frame:
        """Every pixel as factor × factor pixels."""
        factor = whole("upscale", factor, 1, 256)
        if factor == 1:
            return self
        dpi = None if self.dpi is None else (self.dpi[0] * factor, self.dpi[1] * factor)
        return replace(self, indices=_repeated(self.indices, factor), dpi=dpi)

    def preview(self) -> NDArray[np.uint8]:
        """8-bit sRGB gray codes of what the device shows, (M, N)."""
        return mapped(self.levels.srgb(), self.indices)

    def bands(self) -> Bands:
        """The frame as a single band."""
        parts = iter([self.indices])
        return Bands(self.shape, parts, self.levels, self.method, self.dpi, self.packing, self.report)

    def save(self, path: str | Path, format: str | None = None, *, overwrite: bool = True) -> None:
        """Write a PNG, PBM, PGM, TIFF or raw file, by the ending of *path* or by *format*."""
        self.bands().save(path, format, overwrite=overwrite)

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array(self.indices, dtype, copy=copy)

    def _repr_png_(self) -> bytes:
        from halftone.images.png import encode

        return encode(self)


@dataclass(frozen=True, eq=False)
class Bands:
    """A frame that comes from the top in bands of rows, once, and is never held as a whole.

    ``for part in bands`` gives a :class:`Frame` of consecutive rows at a time. shape : (M, N) of all
    of them. indices : the level indices of band after band. The rest is as in a Frame; the *report*
    is complete after the last band.
    """

    shape: tuple[int, int]
    indices: Iterator[Indices]
    levels: Levels
    method: str = ""
    dpi: tuple[float, float] | None = None
    packing: Packing | None = None
    report: dict[str, Any] = field(default_factory=dict, repr=False)

    def __iter__(self) -> Iterator[Frame]:
        for indices in self.indices:
            yield Frame(indices, self.levels, self.method, self.dpi, self.packing, self.report)

    def upscaled(self, factor: int) -> Bands:
        """Every pixel as factor × factor pixels."""
        factor = whole("upscale", factor, 1, 256)
        if factor == 1:
            return self
        dpi = None if self.dpi is None else (self.dpi[0] * factor, self.dpi[1] * factor)
        shape = (self.shape[0] * factor, self.shape[1] * factor)
        rows = max(1, UPSCALED // (shape[1] * factor))
        parts = (
            _repeated(band[top : top + rows], factor)
            for band in self.indices
            for top in range(0, len(band), rows)
        )
        return replace(self, shape=shape, indices=parts, dpi=dpi)

    def packed(self, packing: Packing | None = None) -> NDArray[np.uint8]:
        """All rows of packed bytes, as :meth:`Frame.packed` gives them, without all the indices."""
        chosen = packing or self.packing or Packing(self.levels.bits)
        rows = np.empty((self.shape[0], bytes_per_row(self.shape[1], chosen.bits)), np.uint8)
        top = 0
        for part in self.indices:
            rows[top : top + len(part)] = pack(part, chosen, len(self.levels))
            top += len(part)
        return rows

    def save(self, path: str | Path, format: str | None = None, *, overwrite: bool = True) -> None:
        """Write a file as :meth:`Frame.save` does, band by band, under its name only when whole."""
        from halftone.images.write import write

        write(self, path, format, overwrite=overwrite)


UPSCALED = 1 << 21
"""Pixels that are made at a time of those that are repeated."""


def _repeated(indices: Indices, factor: int) -> Indices:
    return indices.repeat(factor, axis=1).repeat(factor, axis=0)
