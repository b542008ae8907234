"""PNG (ISO/IEC 15948): one page, with the pixels, the palette and the dpi of ``halftone convert``.

Gray where the levels are the evenly spaced codes of sRGB, otherwise a palette of their codes.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from devices.languages.base import LIMIT, Language, Page, Piece
from devices.languages.png_reader import read_png
from halftone.errors import UsageError
from halftone.frame import Frame
from halftone.images.png import has_own_ladder
from halftone.packing import Packing, bytes_per_row
from halftone.tone.levels import Levels

__all__ = ["Png"]

SIGNATURE = b"\x89PNG\r\n\x1a\n"
BYTES = 1 << 15
"""Bytes of rows in a piece, before compression."""


@dataclass(frozen=True)
class Png(Language):
    """PNG. level : of the compression, 0 … 9."""

    name = "png"
    title = "PNG pictures"
    media_type = "image/png"

    level: int = 6

    def __post_init__(self) -> None:
        if not 0 <= self.level <= 9:
            raise UsageError(f"png: level = {self.level}; allowed: 0 (stored) … 9 (smallest)")

    def packing(self, levels: Levels) -> Packing:
        return Packing(levels.bits)

    def encode(self, pages: Iterable[Page]) -> Iterator[Piece]:
        for number, page in enumerate(pages):
            if number:
                raise UsageError("a PNG holds one page; give each its own, or take pwg or urf")
            if page.copies > 1 or page.density is not None:
                raise UsageError("png knows no copies and no density")
            yield from self._page(page)

    def _page(self, page: Page) -> Iterator[Piece]:
        """A chunk of pixels for each band; all its rows are in its bytes, so that a break-off after it
        can go on with paper."""
        packing = self.packing(page.levels)
        size = bytes_per_row(page.width, packing.bits)
        packer = zlib.compressobj(self.level)
        made, left = _start(page, packing), page.height
        paper = _paper(page, packing)
        for rows in page.bands(max(1, BYTES // (size + 1)), packing):
            filtered = np.zeros((len(rows), size + 1), np.uint8)  # filter 0 before every row
            filtered[:, 1:] = rows
            left -= len(rows)
            data = packer.compress(filtered.data)
            data += packer.flush(zlib.Z_SYNC_FLUSH if left else zlib.Z_FINISH)
            made += _chunk(b"IDAT", data)
            if left:
                yield Piece(made, len(rows), close=partial(_finish, packer.copy(), paper, left))
            else:
                yield Piece(made + _chunk(b"IEND", b""), len(rows))
            made = b""

    @classmethod
    def decode(cls, data: bytes, limit: int = LIMIT) -> list[Frame]:
        return [read_png(data, limit)]

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        return head.startswith(SIGNATURE)


def _start(page: Page, packing: Packing) -> bytes:
    """All that comes before the pixels."""
    gray = has_own_ladder(page.levels, packing.bits)
    if max(page.width, page.height) >= 1 << 31:
        raise UsageError(f"png: {page.width} × {page.height} dots; allowed: below 2³¹ each way")
    numbers = page.width.to_bytes(4, "big") + page.height.to_bytes(4, "big")
    made = SIGNATURE + _chunk(b"IHDR", numbers + bytes([packing.bits, 0 if gray else 3, 0, 0, 0]))
    made += _chunk(b"sRGB", b"\0")
    if not gray:
        made += _chunk(b"PLTE", np.repeat(page.levels.srgb(), 3).tobytes())
    if page.dpi is not None and max(page.dpi) < 1e6:
        per_metre = [round(d / 0.0254).to_bytes(4, "big") for d in page.dpi]
        made += _chunk(b"pHYs", b"".join(per_metre) + b"\1")
    return made


def _paper(page: Page, packing: Packing) -> bytes:
    """A row of the lightest level, with its filter; the bits after its last pixel are 0."""
    lightest = len(page.levels) - 1
    byte = sum(lightest << shift for shift in range(0, 8, packing.bits))
    row = bytearray([byte]) * bytes_per_row(page.width, packing.bits)
    row[-1] &= 0xFF << (len(row) * 8 - page.width * packing.bits) & 0xFF
    return b"\0" + bytes(row)


def _finish(packer: Any, paper: bytes, count: int) -> bytes:
    """The rest of the file, if the next *count* rows are *paper*."""
    data = b"".join(packer.compress(paper) for _ in range(count)) + packer.flush()
    return _chunk(b"IDAT", data) + _chunk(b"IEND", b"")


def _chunk(kind: bytes, data: bytes) -> bytes:
    end = zlib.crc32(kind + data).to_bytes(4, "big")
    return len(data).to_bytes(4, "big") + kind + data + end
