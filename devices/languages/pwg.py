"""PWG raster (PWG 5102.4-2012), what driverless printers take: 1-bit black or 8-bit gray.

Two levels are sent as ``black_1``, more as ``sgray_8``, each as the sRGB code of its luminance.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from devices.languages.base import INK, LIMIT, Language, Page, Piece
from devices.languages.raster_header import PAGE
from devices.languages.raster_page import gray_packing, header_of
from devices.languages.raster_start import QUALITIES, is_pwg
from devices.languages.raster_stream import frames
from devices.languages.runs import pieces
from halftone.errors import UsageError
from halftone.frame import Frame
from halftone.packing import Packing
from halftone.tone.levels import Levels

__all__ = ["Pwg"]

TEXTS = {
    "media_color": "MediaColor",
    "media": "MediaType",
    "page_size": "cupsPageSizeName",
    "optimize": "OutputType",
    "intent": "cupsRenderingIntent",
}
WHITE = 0xFFFFFF


@dataclass(frozen=True)
class Pwg(Language):
    """PWG raster.

    media, media_color, page_size : names of PWG 5101.1, as ``labels``, ``white``,
    ``iso_a4_210x297mm``; empty is the printer's default. quality : IPP's print-quality, 3 draft,
    4 normal, 5 high, 0 leaves it to the printer. optimize, intent : IPP's print-content-optimize
    and print-rendering-intent.
    """

    name = "pwg"
    title = "PWG raster, of driverless printers"
    media_type = "image/pwg-raster"
    cuts = True
    native_copies = True

    media: str = ""
    media_color: str = ""
    page_size: str = ""
    optimize: str = ""
    intent: str = ""
    quality: int = 0

    def __post_init__(self) -> None:
        for option in TEXTS:
            text = getattr(self, option)
            if len(text) > 63 or not text.isascii() or not text.isprintable():
                raise UsageError(f"pwg: {option} = {text!r}; allowed: up to 63 characters of ASCII")
        if self.quality not in QUALITIES:
            raise UsageError(f"pwg: quality = {self.quality}; allowed: 0, 3 draft, 4 normal, 5 high")

    def packing(self, levels: Levels) -> Packing:
        return INK if len(levels) == 2 else gray_packing(self.name, levels)

    def encode(self, pages: Iterable[Page]) -> Iterator[Piece]:
        start = b"RaS2"
        for page in pages:
            packing = self.packing(page.levels)
            values = header_of(self.name, page, packing)
            values |= {field: getattr(self, option) for option, field in TEXTS.items()}
            values["MediaClass"] = "PwgRaster"
            # pages unknown; neither side mirrored; no box; white; quality
            values["cupsInteger"] = (0, 1, 1, 0, 0, 0, 0, WHITE, self.quality, *[0] * 7)
            head = start + PAGE.write(values, ">")
            yield from pieces(head, page, packing, 0 if packing == INK else 255)
            start = b""

    @classmethod
    def decode(cls, data: bytes, limit: int = LIMIT) -> list[Frame]:
        return frames(data, cls.name, limit)

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        return is_pwg(head)
