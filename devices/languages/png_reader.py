"""PNG read strictly: gray of 1, 2, 4 or 8 bits or a palette of grays, not interlaced, opaque, sRGB."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from devices.languages.reader import Reader
from halftone.frame import Frame
from halftone.packing import Packing, bytes_per_row, unpack
from halftone.tone.levels import Levels
from halftone.tone.transfer import encoding

__all__ = ["read_png"]

Indices = NDArray[np.uint8]

GRAY, PALETTE = 0, 3
ONCE = (b"IHDR", b"PLTE", b"sRGB", b"gAMA", b"pHYs", b"iCCP", b"cHRM", b"tRNS")
SRGB_GAMMA = 45_455


@dataclass
class Head:
    """What comes before the pixels."""

    width: int
    height: int
    bits: int
    colour: int
    palette: Indices | None = None
    dpi: tuple[float, float] | None = None


def read_png(data: bytes, limit: int) -> Frame:
    """The picture in *data*, of at most *limit* pixels; raises ProtocolError."""
    reader = Reader("png", data)
    reader.expect(b"\x89PNG\r\n\x1a\n", "PNG's signature")
    head, parts, start = _read(reader, limit)
    size = bytes_per_row(head.width, head.bits)
    raw = _inflated(reader, parts, head.height * (size + 1), start)
    rows = _unfiltered(reader, raw.reshape(head.height, size + 1), start)
    indices = unpack(rows, head.width, Packing(head.bits))
    if head.palette is None:
        levels = Levels.of(1 << head.bits)
    else:
        if int(indices.max()) >= len(head.palette):
            reader.fail(f"a pixel of colour {indices.max()}, beyond the palette", start)
        order = np.argsort(head.palette, kind="stable")
        codes = head.palette[order]
        if (order != np.arange(len(order))).any():
            indices = np.argsort(order).astype(np.uint8)[indices]
        levels = Levels.of(encoding("srgb").decode(codes / 255))
    return Frame(indices, levels, "", head.dpi, Packing(head.bits))


def _chunks(reader: Reader) -> Iterator[tuple[bytes, bytes, int]]:
    """Kind, data and offset of the data of each chunk; their check sums are right."""
    while True:
        place = reader.place
        size = reader.big(4, "size of a chunk")
        kind = reader.take(4, "kind of a chunk")
        if size >= 1 << 31:
            reader.fail(f"a chunk of {size} bytes", place)
        if not kind.isalpha() or not kind[2:3].isupper():
            reader.fail(f"a chunk called {kind!r}", place + 4)
        data = reader.take(size, f"chunk {kind.decode()}")
        if reader.big(4, "check sum") != zlib.crc32(kind + data):
            reader.fail(f"wrong check sum of the chunk {kind.decode()}", reader.place - 4)
        yield kind, data, place + 8
        if kind == b"IEND":
            return


def _read(reader: Reader, limit: int) -> tuple[Head, list[bytes], int]:
    """The head, the compressed pixels, and where these begin."""
    head: Head | None = None
    parts: list[bytes] = []
    start, last, seen = 0, b"", set()
    for kind, data, place in _chunks(reader):
        if (head is None) != (kind == b"IHDR") or (kind in ONCE and kind in seen):
            reader.fail(f"chunk {kind.decode()} where it may not be", place - 4)
        if head is None:
            head = _header(reader, data, place, limit)
        elif kind == b"IDAT":
            if head.colour == PALETTE and head.palette is None:
                reader.fail("a palette expected before the pixels", place - 4)
            if parts and last != b"IDAT":
                reader.fail("pixels after another chunk", place - 4)
            start = start or place
            parts.append(data)
        elif kind == b"IEND":
            if data:
                reader.fail("data in the last chunk", place)
        elif parts and kind in ONCE:
            reader.fail(f"chunk {kind.decode()} after the pixels", place - 4)
        else:
            _ancillary(reader, head, kind, data, place)
        seen.add(kind)
        last = kind
    if reader.left:
        reader.fail("data after the last chunk")
    if head is None or not parts:
        reader.fail("no pixels")
    return head, parts, start


def _header(reader: Reader, data: bytes, place: int, limit: int) -> Head:
    if len(data) != 13:
        reader.fail(f"a header of {len(data)} bytes; 13 expected", place - 8)
    width, height = int.from_bytes(data[:4], "big"), int.from_bytes(data[4:8], "big")
    bits, colour, *rest = data[8:]
    for offset, size, what in ((0, width, "width"), (4, height, "height")):
        if not 1 <= size < 1 << 31:
            reader.fail(f"{what} = {size}; allowed: 1 … 2³¹ − 1", place + offset)
    if colour not in (GRAY, PALETTE):
        reader.fail(f"colour type {colour}; read here: 0 (gray), 3 (palette)", place + 9)
    if bits not in (1, 2, 4, 8):
        reader.fail(f"{bits} bits; read here: 1, 2, 4, 8", place + 8)
    for offset, value in enumerate(rest):
        if value:
            what = ("compression", "filter method", "interlacing")[offset]
            reader.fail(f"{what} {value}; read here: 0", place + 10 + offset)
    if width * height > limit:
        reader.fail(f"{width} × {height} pixels; allowed: {limit} of them", place)
    return Head(width, height, bits, colour)


def _ancillary(reader: Reader, head: Head, kind: bytes, data: bytes, place: int) -> None:
    """The palette and the resolution; refused is what would make the pixels look otherwise."""
    if kind == b"PLTE":
        _palette(reader, head, data, place)
    elif kind == b"pHYs":
        if len(data) != 9 or data[8] > 1:
            reader.fail("pHYs of another form", place)
        x, y = int.from_bytes(data[:4], "big"), int.from_bytes(data[4:8], "big")
        if data[8] == 1 and x and y:
            head.dpi = round(x * 0.0254, 2), round(y * 0.0254, 2)
    elif kind == b"sRGB":
        if len(data) != 1 or data[0] > 3:
            reader.fail("sRGB of another form", place)
    elif kind == b"gAMA":
        if int.from_bytes(data, "big") != SRGB_GAMMA or len(data) != 4:
            reader.fail(f"a gamma other than that of sRGB ({SRGB_GAMMA})", place)
    elif kind in (b"tRNS", b"iCCP"):
        reader.fail(f"chunk {kind.decode()}, which is not read here", place - 4)
    elif kind[:1].isupper():
        reader.fail(f"unknown chunk {kind.decode()}", place - 4)


def _palette(reader: Reader, head: Head, data: bytes, place: int) -> None:
    if head.colour != PALETTE:
        reader.fail("a palette in a gray picture", place - 4)
    if len(data) % 3 or not 3 <= len(data) <= 3 << head.bits:
        reader.fail(f"a palette of {len(data)} bytes", place)
    colours = np.frombuffer(data, np.uint8).reshape(-1, 3)
    odd = np.flatnonzero((colours != colours[:, :1]).any(axis=1))
    if odd.size:
        reader.fail("a colour that is not gray", place + 3 * int(odd[0]))
    head.palette = colours[:, 0]
    if head.palette.min() == head.palette.max():
        reader.fail("a palette of a single gray", place)


def _inflated(reader: Reader, parts: list[bytes], size: int, start: int) -> Indices:
    """Exactly *size* bytes, and never more than that of memory."""
    unpacker = zlib.decompressobj()
    raw = bytearray()
    try:
        for number, part in enumerate(parts):
            if unpacker.eof and part:
                reader.fail(f"data after the pixels, in part {number + 1}", start)
            raw += unpacker.decompress(part, size + 1 - len(raw))
            if unpacker.unconsumed_tail or len(raw) > size:
                reader.fail(f"more than {size} bytes of pixels", start)
    except zlib.error as error:
        reader.fail(f"the pixels cannot be decompressed ({error})", start)
    if unpacker.unused_data:
        reader.fail("data after the pixels", start)
    if not unpacker.eof or len(raw) != size:
        reader.fail(f"{len(raw)} bytes of pixels, {size} expected", start)
    return np.frombuffer(raw, np.uint8)


def _unfiltered(reader: Reader, raw: Indices, start: int) -> Indices:
    """Rows without their filters; a pixel is a byte or less, so every filter looks one byte back."""
    filters, rows = raw[:, 0], raw[:, 1:].copy()
    if filters.max() > 4:
        reader.fail(f"filter {filters.max()}; allowed: 0 … 4", start)
    above = np.zeros(rows.shape[1], np.uint8)
    for kind, row in zip(filters.tolist(), rows, strict=True):
        if kind == 1:
            np.cumsum(row, dtype=np.uint8, out=row)
        elif kind == 2:
            row += above
        elif kind == 3:
            row[:] = _average(row.tolist(), above.tolist())
        elif kind == 4:
            row[:] = _paeth(row.tolist(), above.tolist())
        above = row
    return rows


def _average(row: list[int], above: list[int]) -> list[int]:
    left = 0
    for x, up in enumerate(above):
        left = row[x] = row[x] + (left + up) // 2 & 255
    return row


def _paeth(row: list[int], above: list[int]) -> list[int]:
    left = corner = 0
    for x, up in enumerate(above):
        a, b, c = abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)
        guess = left if a <= b and a <= c else up if b <= c else corner
        left = row[x] = row[x] + guess & 255
        corner = up
    return row
