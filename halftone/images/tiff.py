"""TIFF 6.0 with a true bit depth of 1, 2, 4 or 8: gray where the levels are sRGB's own, else a palette.

Little-endian, one Deflate-compressed strip per 64 KiB, which every reader of Adobe Deflate takes.
"""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from halftone.errors import OutputError
from halftone.images.png import has_own_ladder
from halftone.packing import Packing, bytes_per_row, pack

if TYPE_CHECKING:
    from halftone.frame import Bands, Frame
    from halftone.images.output import Output

__all__ = ["encode", "write"]

_SHORT, _LONG, _RATIONAL = 3, 4, 5
_FORMAT = {_SHORT: "<H", _LONG: "<I", _RATIONAL: "<II"}
_STRIP_BYTES = 1 << 16
_MOST = (1 << 32) - (1 << 24)
"""Bytes of all strips: offsets have 32 bits, and the directory comes after them."""

Field = tuple[int, int, Sequence[int | tuple[int, int]]]


def write(bands: Bands, file: Output) -> None:
    """Level indices as a TIFF file; *file* must be able to seek: the directory's place is known last."""
    height, width = bands.shape
    bits = bands.levels.bits
    gray = has_own_ladder(bands.levels, bits)
    per_strip = max(1, _STRIP_BYTES // bytes_per_row(width, bits))
    file.write(struct.pack("<2sHI", b"II", 42, 0))
    end, sizes = 8, []
    for strip in _strips(bands, per_strip):
        end += len(strip)
        if end >= _MOST:
            raise OutputError("a TIFF file cannot hold 4 GiB; write PNG, PBM, PGM or raw")
        sizes.append(len(strip))
        file.write(strip)
    offsets = 8 + np.cumsum([0, *sizes[:-1]])
    fields: list[Field] = [
        (256, _LONG, [width]),
        (257, _LONG, [height]),
        (258, _SHORT, [bits]),
        (259, _SHORT, [8]),
        (262, _SHORT, [1 if gray else 3]),
        (273, _LONG, offsets.tolist()),
        (277, _SHORT, [1]),
        (278, _LONG, [per_strip]),
        (279, _LONG, sizes),
    ]
    if bands.dpi is not None and max(bands.dpi) < 1e6:
        for tag, dpi in zip((282, 283), bands.dpi, strict=True):
            fields.append((tag, _RATIONAL, [(round(dpi * 1000), 1000)]))
        fields.append((296, _SHORT, [2]))
    if not gray:
        codes = np.zeros(1 << bits, np.int64)
        codes[: len(bands.levels)] = bands.levels.srgb()
        fields.append((320, _SHORT, np.tile(codes * 257, 3).tolist()))
    directory = end + end % 2  # on a word boundary
    file.write(b"\0" * (end % 2) + _directory(fields, directory))
    file.seek(4)
    file.write(struct.pack("<I", directory))


def encode(frame: Frame) -> bytes:
    """The frame's level indices as the bytes of a TIFF file."""
    file = io.BytesIO()
    write(frame.bands(), file)
    return file.getvalue()


def _strips(bands: Bands, per_strip: int) -> Iterator[bytes]:
    """Compressed strips of *per_strip* rows, whatever the height of the bands."""
    packer, data, missing = zlib.compressobj(6), b"", per_strip
    for indices in bands.indices:
        rows = pack(indices, Packing(bands.levels.bits))
        while len(rows):
            data += packer.compress(rows[:missing].data)
            missing, rows = missing - len(rows[:missing]), rows[missing:]
            if not missing:
                yield data + packer.flush()
                packer, data, missing = zlib.compressobj(6), b"", per_strip
    if missing < per_strip:
        yield data + packer.flush()


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
