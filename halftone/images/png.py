"""PNG with a true bit depth of 1, 2, 4 or 8 (ISO/IEC 15948), which image libraries do not offer.

Gray where the levels are the evenly spaced codes of sRGB, so that any reader shows them right;
otherwise a palette of the levels' sRGB codes.
"""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halftone.packing import Packing, pack
from halftone.tone.levels import Levels

if TYPE_CHECKING:
    from halftone.frame import Bands, Frame
    from halftone.images.output import Output

__all__ = ["encode", "has_own_ladder", "write", "write_preview"]

Indices = NDArray[np.uint8]

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_GRAY, _PALETTE = 0, 3
_IDAT = 1 << 20
"""Bytes of compressed pixels in one chunk; the same for any height of bands."""


def write(bands: Bands, file: Output) -> None:
    """Level indices as a PNG file."""
    bits = bands.levels.bits
    colour = _GRAY if has_own_ladder(bands.levels, bits) else _PALETTE
    palette = b""
    if colour == _PALETTE:
        palette = _chunk(b"PLTE", np.repeat(bands.levels.srgb(), 3).tobytes())
    rows = (pack(band, Packing(bits)) for band in bands.indices)
    _write(file, bands.shape, bits, colour, rows, palette, bands.dpi)


def write_preview(bands: Bands, file: Output) -> None:
    """What the device shows as 8-bit sRGB gray codes."""
    rows = (part.preview() for part in bands)
    _write(file, bands.shape, 8, _GRAY, rows, b"", bands.dpi)


def encode(frame: Frame) -> bytes:
    """The frame's level indices as a PNG file."""
    file = io.BytesIO()
    write(frame.bands(), file)
    return file.getvalue()


def has_own_ladder(levels: Levels, bits: int) -> bool:
    """Whether level k looks like the gray code k of *bits* bits: k/(2^bits − 1) of sRGB."""
    top = (1 << bits) - 1
    codes = levels.srgb()
    return codes.size == top + 1 and np.array_equal(codes, np.rint(np.arange(top + 1) * 255 / top))


def _write(
    file: Output,
    shape: tuple[int, int],
    bits: int,
    colour: int,
    bands: Iterator[Indices],
    palette: bytes,
    dpi: tuple[float, float] | None,
) -> None:
    header = struct.pack(">IIBBBBB", shape[1], shape[0], bits, colour, 0, 0, 0)
    density = b""
    if dpi is not None and max(dpi) < 1e6:
        per_metre = (round(d / 0.0254) for d in dpi)
        density = _chunk(b"pHYs", struct.pack(">IIB", *per_metre, 1))
    file.write(_SIGNATURE + _chunk(b"IHDR", header) + _chunk(b"sRGB", b"\0") + palette + density)
    packer = zlib.compressobj(6)
    waiting = bytearray()
    for rows in bands:
        filtered = np.zeros((rows.shape[0], rows.shape[1] + 1), np.uint8)  # filter 0 before every row
        filtered[:, 1:] = rows
        waiting += packer.compress(filtered.data)
        while len(waiting) > _IDAT:
            file.write(_chunk(b"IDAT", bytes(waiting[:_IDAT])))
            del waiting[:_IDAT]
    waiting += packer.flush()
    for start in range(0, len(waiting), _IDAT):
        file.write(_chunk(b"IDAT", bytes(waiting[start : start + _IDAT])))
    file.write(_chunk(b"IEND", b""))


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
