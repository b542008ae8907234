"""CUPS raster, what CUPS hands to its filters: version 2 compressed, version 3 as it is.

Source: spec-raster.html of CUPS. Version 1, which is older and not compressed, is read.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import partial

from devices.languages.base import INK, LIMIT, Language, Page, Piece
from devices.languages.raster_header import PAGE
from devices.languages.raster_page import gray_packing, header_of
from devices.languages.raster_start import SYNC, is_pwg
from devices.languages.raster_stream import frames
from devices.languages.runs import BYTES, pieces
from halftone.errors import UsageError
from halftone.frame import Frame
from halftone.packing import Packing, bytes_per_row
from halftone.tone.levels import Levels

__all__ = ["CupsRaster"]

ORDERS = {"little": "<", "big": ">"}


@dataclass(frozen=True)
class CupsRaster(Language):
    """CUPS raster: 1-bit black for two levels, 8-bit sRGB gray for more.

    version : 2 (compressed) or 3. order : of the bytes of a number, ``little`` or ``big``.
    """

    name = "cups-raster"
    title = "CUPS raster, what CUPS hands to its filters"
    media_type = "application/vnd.cups-raster"
    cuts = True
    native_copies = True

    version: int = 3
    order: str = "little"

    def __post_init__(self) -> None:
        if self.version not in (2, 3):
            raise UsageError(f"cups-raster: version = {self.version}; allowed: 2 (compressed), 3")
        if self.order not in ORDERS:
            raise UsageError(f"cups-raster: order = '{self.order}'; allowed: {', '.join(ORDERS)}")

    def packing(self, levels: Levels) -> Packing:
        return INK if len(levels) == 2 else gray_packing(self.name, levels)

    def encode(self, pages: Iterable[Page]) -> Iterator[Piece]:
        order = ORDERS[self.order]
        start = next(sync for sync, kind in SYNC.items() if kind == (order, self.version))
        for page in pages:
            packing = self.packing(page.levels)
            values = header_of(self.name, page, packing)
            width, height = values["PageSize"]
            values |= {
                "ImagingBoundingBox": (0, 0, width, height),
                "cupsBorderlessScalingFactor": 1.0,
                "cupsPageSize": (width, height),
                "cupsImagingBBox": (0, 0, width, height),
            }
            head = start + PAGE.write(values, order)
            paper = 0 if packing == INK else 255
            yield from (pieces if self.version == 2 else _plain)(head, page, packing, paper)
            start = b""

    @classmethod
    def decode(cls, data: bytes, limit: int = LIMIT) -> list[Frame]:
        return frames(data, cls.name, limit)

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        return head[:4] in SYNC and not is_pwg(head)


def _plain(head: bytes, page: Page, packing: Packing, paper: int) -> Iterator[Piece]:
    """*head* and the page's rows as they are."""
    size, left = bytes_per_row(page.width, packing.bits), page.height
    for rows in page.bands(max(1, BYTES // size), packing):
        left -= len(rows)
        stride = 0 if paper else size  # an abort lays zeros
        close = partial(_blank, left * size, paper)
        yield Piece(head + rows.tobytes(), len(rows), len(head), stride, close)
        head = b""


def _blank(count: int, paper: int) -> bytes:
    return bytes([paper]) * count
