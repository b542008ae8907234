"""ESC/POS: receipt printers of 58 and 80 mm, by Epson and by nearly everybody else.

A page is ESC @ and settings, the picture in as many commands as the printer's buffer asks for, paper
fed, and a cut. Paper within the picture is sent as rows of zeros and never as a feed, which on many
printers has another pitch than the rows. Sources: Epson's ESC/POS reference; limits in the manuals of
TM-T81 and TM-T88III; DC2 and the density of clones in Adafruit's library for the CSN-A2.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from devices.errors import ProtocolError
from devices.languages import _realtime
from devices.languages._escpos_decode import Decoder
from devices.languages._realtime import PAIR, harmless
from devices.languages.base import LIMIT, Language, Page, Piece
from devices.status import Status
from halftone.errors import UsageError, near
from halftone.frame import Frame
from halftone.packing import bytes_per_row

__all__ = ["EscPos"]

Rows = NDArray[np.uint8]

RESET = b"\x1b@"
BAND = 24
"""Rows of a band of ESC *."""
MOST_ROWS = {"raster": 4095, "graphics": 4095, "column": BAND, "dc2": 255}
"""Rows that a command can state: Epson allows yH ≤ 15."""
WIDEST = {"raster": 65_535, "graphics": 65_535, "column": 2047, "dc2": 255 * 8}
CUTS = {"full": b"\x1dV\x00", "partial": b"\x1dV\x01"}
DENSITIES = {"none": (0, 0), "gs-k": (-128, 127), "esc-7": (3, 255), "dc2-hash": (0, 31)}


@dataclass(frozen=True)
class EscPos(Language):
    """ESC/POS. The defaults suit receipt printers of 80 mm.

    command : what carries the picture: ``raster`` (GS v 0), ``graphics`` (GS ( L, or GS 8 L where its
    length asks for it), ``column`` (ESC *, for old heads), ``dc2`` (DC2 *, small clones).
    max_rows, max_bytes : of picture in one command; many clones have small buffers. A command is made
    as a whole, so the memory taken is about max_bytes; at most 1 MiB.
    avoid_rows_multiple_of : a quirk: the POS-5890K prints garbage where 48 divides the rows; 0 none.
    feed : rows of paper after each page, to bring it past the cutter or the tear bar.
    cut : ``partial`` or ``full``, for pages that are to be cut.
    reset : whether each page begins with ESC @.
    density_command : what a page's density is set by: ``none``; ``gs-k`` (GS ( K, Epson: −128 … 127, 0
    the standard, negative is paler); ``esc-7`` (clones: heating time 3 … 255 in units of 10 µs);
    ``dc2-hash`` (clones: 0 … 31, in steps of 5 % from 50 %).
    auto_status : whether the printer is to report by itself when its state changes (GS a).
    """

    command: str = "raster"
    max_rows: int = 240
    max_bytes: int = 32_768
    avoid_rows_multiple_of: int = 0
    feed: int = 120
    cut: str = "partial"
    reset: bool = True
    density_command: str = "none"
    auto_status: bool = False

    name = "escpos"
    title = "ESC/POS, receipt printers"
    media_type = "application/vnd.escpos"
    cuts = True
    status_query = _realtime.QUERY

    def __post_init__(self) -> None:
        for option, allowed in (("command", MOST_ROWS), ("cut", CUTS), ("density_command", DENSITIES)):
            if getattr(self, option) not in allowed:
                raise UsageError(near(getattr(self, option), allowed, f"{option} of escpos"))
        for option, least, most in (
            ("max_rows", 1, 4095),
            ("max_bytes", 1, 1 << 20),
            ("avoid_rows_multiple_of", 0, 4095),
            ("feed", 0, 4095),
        ):
            value = getattr(self, option)
            if not least <= value <= most:
                raise UsageError(f"escpos: {option} = {value}; allowed: {least} … {most}")
        if self.avoid_rows_multiple_of == 1:
            raise UsageError("escpos: avoid_rows_multiple_of = 1 leaves no rows; allowed: 0, 2 … 4095")

    def encode(self, pages: Iterable[Page]) -> Iterator[Piece]:
        ready = (b"\x1b2" if self.command == "column" else b"") + (RESET if self.reset else b"")
        for page in pages:
            step = self._step(page)
            start, end = self._start(page), self._end(page)
            if start:
                yield Piece(start, close=partial(bytes, ready))
            broken_off = partial(bytes, end + ready)
            for rows in page.bands(step):
                if self.command == "column":
                    yield from _columns(rows, page.width, broken_off)
                    continue
                top = 0
                for count in self._parts(page.width, len(rows)):
                    yield from self._picture(rows[top : top + count], page.width, broken_off)
                    top += count
            if end:
                yield Piece(end, close=partial(bytes, ready))

    def _picture(self, rows: Rows, width: int, broken_off: partial[bytes]) -> Iterator[Piece]:
        """Commands that print *rows*."""
        count, size = rows.shape
        header = _header(self.command, width, count)
        data = harmless(header, rows.tobytes())
        assert len(data) == count * size, "the header states another length"
        if self.command == "graphics":
            close = partial(bytes, PRINT + broken_off())
            yield Piece(header + data, count, len(header), size, close)
            yield Piece(PRINT, close=broken_off)
        else:
            yield Piece(header + data, count, len(header), size, broken_off)

    def _start(self, page: Page) -> bytes:
        """Settings before the picture."""
        start = RESET if self.reset else b""
        if self.auto_status:
            start += b"\x1da\x0e"  # on-line, errors and paper; not the drawer
        if page.density is not None:
            start += self._density(page.density)
        return start + (b"\x1b3" + bytes((BAND,)) if self.command == "column" else b"")

    def _density(self, density: int) -> bytes:
        least, most = DENSITIES[self.density_command]
        if self.density_command == "none":
            names = ", ".join(name for name in DENSITIES if name != "none")
            raise UsageError(f"escpos: a density needs density_command; allowed: {names}")
        if not least <= density <= most:
            command = self.density_command
            raise UsageError(f"escpos: density {density} by {command}; allowed: {least} … {most}")
        if self.density_command == "gs-k":
            return b"\x1d(K\x02\x00\x31" + bytes((density % 256,))
        if self.density_command == "esc-7":  # 64 dots at once, 20 µs of rest: the printer's own values
            return b"\x1b7\x07" + bytes((density, 2))
        return b"\x12#" + bytes((2 << 5 | density,))  # 500 µs of rest, as above

    def _end(self, page: Page) -> bytes:
        """What follows the picture."""
        end = b"\x1b2" if self.command == "column" else b""
        whole, rest = divmod(self.feed, 255)
        end += b"\x1bJ\xff" * whole + (b"\x1bJ" + bytes((rest,)) if rest else b"")
        return end + (CUTS[self.cut] if page.cut else b"")

    def _step(self, page: Page) -> int:
        """Rows of a command. Raises UsageError for a page that cannot be printed with these options."""
        if page.copies > 1:
            raise UsageError("ESC/POS has no command for copies; give the page once for each of them")
        if page.width > WIDEST[self.command]:
            widest = WIDEST[self.command]
            raise UsageError(f"escpos, command = {self.command}: {page.width} dots; at most {widest}")
        size = bytes_per_row(page.width, 1)
        if self.command == "column":
            least, most = BAND, BAND
            if self.max_rows < BAND or self.max_bytes < page.width * BAND // 8:
                most = 0
        else:
            least, most = 1, min(self.max_rows, MOST_ROWS[self.command], self.max_bytes // size)
        for rows in range(most, least - 1, -1):
            if self._allowed(page.width, rows):
                return rows * 10 if self.command == "column" else rows
        raise UsageError(
            f"escpos, command = {self.command}: no command with {least} or more rows of {page.width}"
            f" dots is within max_rows = {self.max_rows}, max_bytes = {self.max_bytes} and"
            f" avoid_rows_multiple_of = {self.avoid_rows_multiple_of}, and free of real-time commands"
        )

    def _parts(self, width: int, rows: int) -> tuple[int, ...]:
        """*rows* as one command, or as two if there can be none with so many."""
        if self._allowed(width, rows):
            return (rows,)
        for first in range((rows + 1) // 2, rows):
            if self._allowed(width, first) and self._allowed(width, rows - first):
                return first, rows - first
        raise UsageError(
            f"escpos, command = {self.command}: {width} × {rows} dots need a real-time command in a"
            " header or a number of rows that is to be avoided; take another width or another command"
        )

    def _allowed(self, width: int, rows: int) -> bool:
        """Whether a command can have so many rows: not by a quirk, nor with DLE EOT in its header."""
        if self.avoid_rows_multiple_of and rows % self.avoid_rows_multiple_of == 0:
            return False
        return not PAIR.search(_header(self.command, width, rows))

    @classmethod
    def decode(cls, data: bytes, limit: int = LIMIT) -> list[Frame]:
        if not data:
            raise ProtocolError(cls.name, 0, "a command expected")
        return Decoder(data, limit).pages()

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        if len(head) < 2 or not any(first in head for first in b"\x1b\x1d\x12"):
            return False
        try:
            Decoder(head, 1 << 62).pages()
        except ProtocolError as error:
            return error.offset == len(head)  # all of it was right, and more is to follow
        return True

    def parse_status(self, reply: bytes) -> Status | None:
        return _realtime.parsed(reply)

    def unsolicited(self, received: bytes) -> Status | None:
        return _realtime.unsolicited(received)


PRINT = b"\x1d(L\x02\x00\x30\x32"
"""Function 50: print the graphics that were stored."""


def _header(command: str, width: int, rows: int) -> bytes:
    """What precedes the data of a command with *rows* rows of *width* dots."""
    size = bytes_per_row(width, 1)
    if command == "raster":
        return b"\x1dv0\x00" + _little(size, 2) + _little(rows, 2)
    if command == "dc2":
        return b"\x12*" + bytes((rows, size))
    if command == "column":
        return b"\x1b*\x21" + _little(width, 2)
    length = 10 + size * rows
    start = b"\x1d(L" + _little(length, 2) if length <= 65_535 else b"\x1d8L" + _little(length, 4)
    return start + b"\x30\x70\x30\x01\x01\x31" + _little(width, 2) + _little(rows, 2)


def _little(number: int, size: int) -> bytes:
    return number.to_bytes(size, "little")


def _columns(rows: Rows, width: int, broken_off: partial[bytes]) -> Iterator[Piece]:
    """Bands of ESC *: 3 bytes a column, the uppermost dot in the highest bit."""
    count = len(rows)
    bands = -(-count // BAND)
    dots = np.zeros((bands * BAND, width), np.uint8)
    dots[:count] = np.unpackbits(rows, axis=1, count=width)
    turned = np.packbits(dots.reshape(bands, BAND, width).transpose(0, 2, 1), axis=2)
    header = _header("column", width, BAND)
    for band in turned:
        data = harmless(header, band.tobytes())
        assert len(data) == width * BAND // 8, "the header states another length"
        held = min(count, BAND)
        # the last band may hold fewer rows: the paper is moved by these alone
        feed = b"\n" if held == BAND else b"\x1bJ" + bytes((held,))
        yield Piece(header + data + feed, held, close=broken_off)
        count -= held
