"""PNG with a true bit depth of 1, 2, 4 or 8 (ISO/IEC 15948), which image libraries do not offer.

Gray where the levels are the evenly spaced codes of sRGB, so that any reader shows them right;
otherwise a palette of the levels' sRGB codes.
"""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halftone.packing import Packing, pack

if TYPE_CHECKING:
    from halftone.frame import Frame

__all__ = ["encode", "encode_gray", "has_own_ladder"]

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_GRAY, _PALETTE = 0, 3


def encode(frame: Frame) -> bytes:
    """The frame's level indices as a PNG file."""
    bits = frame.levels.bits
    colour = _GRAY if has_own_ladder(frame, bits) else _PALETTE
    palette = b""
    if colour == _PALETTE:
        palette = _chunk(b"PLTE", np.repeat(frame.levels.srgb(), 3).tobytes())
    rows = pack(frame.indices, Packing(bits))
    return _file(frame.shape, bits, colour, rows, palette, frame.dpi)


def encode_gray(codes: NDArray[np.uint8], dpi: tuple[float, float] | None = None) -> bytes:
    """8-bit sRGB gray codes (M, N) as a PNG file."""
    return _file((codes.shape[0], codes.shape[1]), 8, _GRAY, np.ascontiguousarray(codes), b"", dpi)


def has_own_ladder(frame: Frame, bits: int) -> bool:
    """Whether level k looks like the gray code k of *bits* bits: k/(2^bits − 1) of sRGB."""
    top = (1 << bits) - 1
    codes = frame.levels.srgb()
    return codes.size == top + 1 and np.array_equal(codes, np.rint(np.arange(top + 1) * 255 / top))


def _file(
    shape: tuple[int, int],
    bits: int,
    colour: int,
    rows: NDArray[np.uint8],
    palette: bytes,
    dpi: tuple[float, float] | None,
) -> bytes:
    filtered = np.zeros((rows.shape[0], rows.shape[1] + 1), np.uint8)  # filter 0 before every row
    filtered[:, 1:] = rows
    header = struct.pack(">IIBBBBB", shape[1], shape[0], bits, colour, 0, 0, 0)
    density = b""
    if dpi is not None and max(dpi) < 1e6:
        per_metre = (round(d / 0.0254) for d in dpi)
        density = _chunk(b"pHYs", struct.pack(">IIB", *per_metre, 1))
    return b"".join(
        (
            _SIGNATURE,
            _chunk(b"IHDR", header),
            _chunk(b"sRGB", b"\0"),
            palette,
            density,
            _chunk(b"IDAT", zlib.compress(filtered.data, 6)),
            _chunk(b"IEND", b""),
        )
    )


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
