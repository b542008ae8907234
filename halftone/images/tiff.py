"""TIFF 6.0 with a true bit depth of 1, 2, 4 or 8: gray where the levels are sRGB's own, else a palette.

Little-endian, one Deflate-compressed strip per 64 KiB, which every reader of Adobe Deflate takes.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from halftone.images.png import has_own_ladder
from halftone.packing import Packing, pack

if TYPE_CHECKING:
    from halftone.frame import Frame

__all__ = ["encode"]

_SHORT, _LONG, _RATIONAL = 3, 4, 5
_FORMAT = {_SHORT: "<H", _LONG: "<I", _RATIONAL: "<II"}
_STRIP_BYTES = 1 << 16

Field = tuple[int, int, Sequence[int | tuple[int, int]]]


def encode(frame: Frame) -> bytes:
    """The frame's level indices as a TIFF file."""
    height, width = frame.shape
    bits = frame.levels.bits
    rows = pack(frame.indices, Packing(bits))
    gray = has_own_ladder(frame, bits)
    per_strip = max(1, _STRIP_BYTES // rows.shape[1])
    strips = [zlib.compress(rows[y : y + per_strip].data, 6) for y in range(0, height, per_strip)]
    offsets = 8 + np.cumsum([0, *(len(s) for s in strips)])
    fields: list[Field] = [
        (256, _LONG, [width]),
        (257, _LONG, [height]),
        (258, _SHORT, [bits]),
        (259, _SHORT, [8]),
        (262, _SHORT, [1 if gray else 3]),
        (273, _LONG, offsets[:-1].tolist()),
        (277, _SHORT, [1]),
        (278, _LONG, [per_strip]),
        (279, _LONG, [len(s) for s in strips]),
    ]
    if frame.dpi is not None and max(frame.dpi) < 1e6:
        for tag, dpi in zip((282, 283), frame.dpi, strict=True):
            fields.append((tag, _RATIONAL, [(round(dpi * 1000), 1000)]))
        fields.append((296, _SHORT, [2]))
    if not gray:
        codes = np.zeros(1 << bits, np.int64)
        codes[: len(frame.levels)] = frame.levels.srgb()
        fields.append((320, _SHORT, np.tile(codes * 257, 3).tolist()))
    end = int(offsets[-1])
    directory = end + end % 2  # on a word boundary
    header = struct.pack("<2sHI", b"II", 42, directory)
    return b"".join((header, *strips, b"\0" * (end % 2), _directory(fields, directory)))


def _directory(fields: list[Field], start: int) -> bytes:
    """The image file directory at the offset *start*, with the values that do not fit into it."""
    after = start + 2 + 12 * len(fields) + 4
    entries, values = [], b""
    for tag, kind, items in fields:
        data = b"".join(
            struct.pack(_FORMAT[kind], *(item if isinstance(item, tuple) else (item,))) for item in items
        )
        if len(data) <= 4:
            place = data.ljust(4, b"\0")
        else:
            place = struct.pack("<I", after + len(values))
            values += data + b"\0" * (len(data) % 2)
        entries.append(struct.pack("<HHI", tag, kind, len(items)) + place)
    return struct.pack("<H", len(fields)) + b"".join(entries) + b"\0\0\0\0" + values
