"""PBM and PGM, the raw forms (netpbm's pbm(5) and pgm(5))."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from halftone.errors import UsageError
from halftone.packing import Packing, pack

if TYPE_CHECKING:
    from halftone.frame import Bands
    from halftone.images.output import Output

__all__ = ["write_pbm", "write_pgm"]


def write_pbm(bands: Bands, file: Output) -> None:
    """Two levels as P4, where 1 is black."""
    if len(bands.levels) != 2:
        raise UsageError(
            f"PBM holds 2 levels and the frame has {len(bands.levels)}; use PGM, PNG, TIFF or raw"
        )
    height, width = bands.shape
    file.write(b"P4\n%d %d\n" % (width, height))
    for indices in bands.indices:
        file.write(pack(indices, Packing(1, codes=(1, 0))).data)


def write_pgm(bands: Bands, file: Output) -> None:
    """Any levels as P5: maxval n−1 where the levels are sRGB's own n codes, else sRGB codes of 255."""
    height, width = bands.shape
    n = len(bands.levels)
    ladder = np.array_equal(bands.levels.srgb(), np.rint(np.arange(n) * 255 / (n - 1)))
    file.write(b"P5\n%d %d\n%d\n" % (width, height, n - 1 if ladder else 255))
    for part in bands:
        file.write(np.ascontiguousarray(part.indices if ladder else part.preview()).data)
