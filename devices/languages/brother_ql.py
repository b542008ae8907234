"""Brother QL: the raster commands of label printers with 720 or 1296 pins at 300 dpi.

Sources: Brother, Raster Command Reference of the QL-710W/720NW, QL-800/810W/820NWB and
QL-1100/1110NWB; the media's printable dots as brother_ql 0.9.4 lists them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from devices.languages._brother_ql_status import packets, status_of
from devices.languages.base import LIMIT, Language, Page, Piece
from devices.languages.packbits import packed_rows
from devices.status import Status
from halftone.errors import UsageError
from halftone.frame import Frame

__all__ = ["MEDIA", "PINS", "BrotherQl", "Media", "mirrored"]

Rows = NDArray[np.uint8]


class Media(NamedTuple):
    """What can be printed on. dots : across. offset : pins of a head of 720 to the right of them.
    rows : of a die-cut label at 300 dpi, 0 on a roll."""

    dots: int
    offset: int
    rows: int = 0


MEDIA = {
    (12, 0): Media(106, 29),
    (29, 0): Media(306, 6),
    (38, 0): Media(413, 12),
    (50, 0): Media(554, 12),
    (54, 0): Media(590, 0),
    (62, 0): Media(696, 12),
    (102, 0): Media(1164, 12),
    (12, 12): Media(94, 113, 94),  # round
    (17, 54): Media(165, 0, 566),
    (17, 87): Media(165, 0, 956),
    (23, 23): Media(202, 42, 202),
    (24, 24): Media(236, 42, 236),  # round
    (29, 42): Media(306, 6, 425),
    (29, 90): Media(306, 6, 991),
    (38, 90): Media(413, 12, 991),
    (39, 48): Media(425, 6, 495),
    (52, 29): Media(578, 0, 271),
    (58, 58): Media(618, 51, 618),  # round
    (62, 29): Media(696, 12, 271),
    (62, 100): Media(696, 12, 1109),
    (102, 51): Media(1164, 12, 526),
    (102, 153): Media(1164, 12, 1660),
}
"""Width and length in mm (0: a roll) → the part of it that the printers reach."""
PINS = {720: 0, 1296: 44}
"""Pins of a head, and how many more of them lie to the right of the media than with 720."""
LONGEST = {720: 11_811, 1296: 35_433}
"""Rows of a page on a roll at 300 dpi: 1 m, 3 m."""
DPI = ((300.0, 300.0), (300.0, 600.0))
BYTES = 1 << 14
"""Bytes of a piece."""


@dataclass(frozen=True)
class BrotherQl(Language):
    """Brother QL.

    media : its width in mm on a roll (``62``), width and length of a die-cut label (``29x90``).
    pins : 720, or 1296 of the wide models (QL-1050, 1060N, 11xx). compress : PackBits, which the
    QL-5xx (but for 580N), 600, 700 and 800 do not know. cutter : no of a QL-500. cut_every : pages
    between two cuts. quality : rather than speed. margin : rows fed before and after a page of a
    roll. switch : whether to send the switch to raster mode, which the oldest models do not know.
    invalidate : zeros that end a command left open by an earlier job.

    A page of 300 × 600 dpi is printed with 600 rows an inch. A page narrower than the media begins
    at its left edge.
    """

    media: str = "62"
    pins: int = 720
    compress: bool = False
    cutter: bool = True
    cut_every: int = 1
    quality: bool = True
    margin: int = 35
    switch: bool = True
    invalidate: int = 400

    name = "brother-ql"
    title = "Brother QL label printers"
    media_type = "application/vnd.brother-ql"
    cuts = True
    widest = 1164
    status_query = b"\x1biS"

    def __post_init__(self) -> None:
        if self.pins not in PINS:
            raise UsageError(f"brother-ql: {self.pins} pins; allowed: {', '.join(map(str, PINS))}")
        _, _, window = self._window()
        if window.dots + window.offset + PINS[self.pins] > self.pins:
            raise UsageError(f"brother-ql: media {self.media} on {self.pins} pins; it needs 1296")
        bounds = {"cut_every": (1, 255), "margin": (0, 1500), "invalidate": (200, 512)}
        for key, (low, high) in bounds.items():
            if not low <= getattr(self, key) <= high:
                raise UsageError(f"brother-ql: {key} = {getattr(self, key)}; allowed: {low} … {high}")

    def _window(self) -> tuple[int, int, Media]:
        """Width and length of the media in mm, and what can be printed on."""
        width, x, length = self.media.lower().partition("x")
        key = (
            int(width) if width.isdecimal() else 0,
            int(length) if length.isdecimal() else -1 if x else 0,
        )
        if key not in MEDIA:
            names = ", ".join(f"{w}x{n}" if n else str(w) for w, n in MEDIA)
            raise UsageError(f"brother-ql: media '{self.media}'; allowed: {names}")
        return *key, MEDIA[key]

    def encode(self, pages: Iterable[Page]) -> Iterator[Piece]:
        clear = bytes(self.invalidate) + b"\x1b@"
        cancel = partial(bytes, clear)
        coming = iter(pages)
        page = next(coming, None)
        begin, first = clear, True
        while page is not None:
            begin += self._begin(page, first)
            left = page.height
            for rows in page.bands(BYTES // (3 + self.pins // 8)):
                left -= len(rows)
                data = begin + self._rows(rows, page.width)
                begin, count = b"", len(rows)
                if left:
                    yield Piece(data, count, close=cancel)
            first = False
            try:
                page = next(coming, None)  # whether another follows decides how this one ends
            except Exception:  # the one that follows cannot be read: this one is the last
                yield Piece(data + b"\x1a", count)
                raise
            if page is None:
                yield Piece(data + b"\x1a", count)
            else:
                yield Piece(data + b"\x0c", count, close=cancel)
        if begin:
            yield Piece(begin)

    def _begin(self, page: Page, first: bool) -> bytes:
        """The commands before the rows of a page."""
        width, length, window = self._window()
        fine = page.dpi == DPI[1]
        most = (window.rows or LONGEST[self.pins]) * (2 if fine else 1)
        if page.dpi not in (None, *DPI):
            raise UsageError(f"brother-ql: a page of {page.dpi} dpi; allowed: (300, 300), (300, 600)")
        if page.width > window.dots or page.height > most:
            raise UsageError(
                f"brother-ql: a page of {page.width} × {page.height} dots; "
                f"media {self.media} has {window.dots} × {most} at most"
            )
        if page.copies > 1 or page.density is not None:
            raise UsageError(
                "brother-ql knows no copies and no density: send the page as often as wanted"
            )
        if page.cut and not self.cutter:
            raise UsageError("brother-ql: the page is to be cut, and 'cutter' says that there is none")
        data = b"\x1bia\x01" if self.switch else b""
        flags = 0x8E | (0x40 if self.quality else 0)  # keep a failed page; kind, width, length count
        data += bytes([0x1B, ord("i"), ord("z"), flags, 0x0B if length else 0x0A, width, length])
        data += page.height.to_bytes(4, "little") + bytes([0 if first else 1, 0])
        if self.cutter:
            data += b"\x1biM" + (b"\x40" if page.cut else b"\x00")
            data += b"\x1biA" + bytes([self.cut_every])
            data += b"\x1biK" + bytes([(0x08 if page.cut else 0) | (0x40 if fine else 0)])
        elif fine:
            raise UsageError("brother-ql: 300 × 600 dpi is for models with a cutter")
        data += b"\x1bid" + (0 if length else self.margin).to_bytes(2, "little")
        return data + (b"M\x02" if self.compress else b"")

    def _rows(self, rows: Rows, width: int) -> bytes:
        """Transfers of *rows* as the pins take them."""
        _, _, window = self._window()
        pins = mirrored(rows, width, window, self.pins)
        if not self.compress:
            head = np.array([ord("g"), 0, self.pins // 8], np.uint8)
            return np.concatenate([np.broadcast_to(head, (len(rows), 3)), pins], axis=1).tobytes()
        data, starts = packed_rows(pins)
        return b"".join(b"g\0%c%b" % (end - start, data[start:end]) for start, end in pairwise(starts))

    @classmethod
    def decode(cls, data: bytes, limit: int = LIMIT) -> list[Frame]:
        from devices.languages._brother_ql_decode import decode

        return decode(data, limit)

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        rest = head.lstrip(b"\0")
        zeros = len(head) - len(rest)
        if rest.startswith(b"\x1b@"):
            return zeros >= 200 or rest.startswith((b"\x1b@\x1bia\x01", b"\x1b@\x1biz", b"\x1b@\x1biS"))
        return rest.startswith((b"\x1bia\x01", b"\x1biz", b"\x1biS"))

    def parse_status(self, reply: bytes) -> Status | None:
        for packet in packets(reply):
            if packet[18] == 0x00:  # what was asked for; others come by themselves
                return status_of(packet)
        return None

    def unsolicited(self, received: bytes) -> Status | None:
        found = packets(received)
        return status_of(found[-1]) if found else None


def mirrored(rows: Rows, width: int, window: Media, pins: int) -> Rows:
    """Packed rows (n, bytes a row) as the head takes them (n, pins / 8): from the right to the left."""
    dots = np.zeros((len(rows), pins), np.uint8)
    stop = window.offset + PINS[pins] + window.dots
    dots[:, stop - width : stop] = np.unpackbits(rows, axis=1, count=width)[:, ::-1]
    return np.packbits(dots, axis=1)
