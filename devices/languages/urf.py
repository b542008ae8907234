"""URF, Apple's raster (AirPrint): 8-bit sRGB gray. Printers of it seldom take 1-bit pages.

Apple has not published it; the source is what libcups reads and writes (cups/raster-stream.c).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sized
from dataclasses import dataclass

from devices.languages.base import LIMIT, Language, Page, Piece
from devices.languages.raster_header import URF
from devices.languages.raster_page import gray_packing, whole_dpi
from devices.languages.raster_start import QUALITIES, URF_START
from devices.languages.raster_stream import frames
from devices.languages.runs import pieces
from halftone.errors import UsageError
from halftone.frame import Frame
from halftone.packing import Packing
from halftone.tone.levels import Levels

__all__ = ["Urf"]

BLACK_WHITE = Packing(8, "msb", (0, 255))


@dataclass(frozen=True)
class Urf(Language):
    """URF.

    quality : IPP's print-quality, 3 draft, 4 normal, 5 high, 0 leaves it to the printer.
    """

    name = "urf"
    title = "URF, Apple's raster (AirPrint)"
    media_type = "image/urf"

    quality: int = 0

    def __post_init__(self) -> None:
        if self.quality not in QUALITIES:
            raise UsageError(f"urf: quality = {self.quality}; allowed: 0, 3 draft, 4 normal, 5 high")

    def packing(self, levels: Levels) -> Packing:
        return BLACK_WHITE if len(levels) == 2 else gray_packing(self.name, levels)

    def encode(self, pages: Iterable[Page]) -> Iterator[Piece]:
        # Several pages may be broken off after the first: only of one the count is sure.
        count = 1 if isinstance(pages, Sized) and len(pages) == 1 else 0
        start = URF_START + count.to_bytes(4, "big")
        for page in pages:
            if page.copies > 1 or page.density is not None:
                raise UsageError("urf knows no copies and no density")
            x, y = whole_dpi(self.name, page)
            if x != y:
                raise UsageError(f"urf has one resolution for both directions, not {x} × {y} dpi")
            values = {
                "BitsPerPixel": 8,
                "ColorSpace": 0,
                "Duplex": 1,  # one-sided
                "Quality": self.quality,
                "Width": page.width,
                "Height": page.height,
                "Resolution": x,
            }
            yield from pieces(start + URF.write(values, ">"), page, self.packing(page.levels), 255)
            start = b""

    @classmethod
    def decode(cls, data: bytes, limit: int = LIMIT) -> list[Frame]:
        return frames(data, cls.name, limit)

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        return head.startswith(URF_START)
