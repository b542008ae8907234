"""The result: level indices, and what they mean on the device."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from halftone._arrays import mapped, whole
from halftone.packing import Packing, pack
from halftone.tone.levels import Levels

__all__ = ["Frame"]


@dataclass(frozen=True, eq=False)
class Frame:
    """What the device will show.

    indices : uint8 (M, N), 0 = the darkest level. ``np.asarray(frame)`` gives them.
    levels : the luminance of every level.
    method : the text form of the method. dpi : dots per inch across and down, or None.
    packing : how the device wants its pixels.
    report : what was done, stage by stage, with seconds, and what was left out and why.
    """

    indices: NDArray[np.uint8]
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
        big = self.indices.repeat(factor, axis=0).repeat(factor, axis=1)
        return Frame(big, self.levels, self.method, dpi, self.packing, self.report)

    def preview(self) -> NDArray[np.uint8]:
        """8-bit sRGB gray codes of what the device shows, (M, N)."""
        return mapped(self.levels.srgb(), self.indices)

    def save(self, path: str | Path, format: str | None = None, *, overwrite: bool = True) -> None:
        """Write a PNG, PBM, PGM, TIFF or raw file, by the ending of *path* or by *format*."""
        from halftone.images.write import write

        write(self, path, format, overwrite=overwrite)

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array(self.indices, dtype, copy=copy)

    def _repr_png_(self) -> bytes:
        from halftone.images.png import encode

        return encode(self)
