"""PBM and PGM, the raw forms (netpbm's pbm(5) and pgm(5))."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from halftone.errors import UsageError
from halftone.packing import Packing, pack

if TYPE_CHECKING:
    from halftone.frame import Frame

__all__ = ["encode_pbm", "encode_pgm"]


def encode_pbm(frame: Frame) -> bytes:
    """Two levels as P4, where 1 is black."""
    if len(frame.levels) != 2:
        raise UsageError(
            f"PBM holds 2 levels and the frame has {len(frame.levels)}; use PGM, PNG, TIFF or raw"
        )
    height, width = frame.shape
    return b"P4\n%d %d\n" % (width, height) + pack(frame.indices, Packing(1, codes=(1, 0))).tobytes()


def encode_pgm(frame: Frame) -> bytes:
    """Any levels as P5: maxval n−1 where the levels are sRGB's own n codes, else sRGB codes of 255."""
    height, width = frame.shape
    n = len(frame.levels)
    ladder = np.array_equal(frame.levels.srgb(), np.rint(np.arange(n) * 255 / (n - 1)))
    values = frame.indices if ladder else frame.preview()
    return b"P5\n%d %d\n%d\n" % (width, height, n - 1 if ladder else 255) + values.tobytes()
