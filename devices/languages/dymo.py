"""DYMO LabelWriter: rows of dots for label printers of the 400 and 450 series and the SE450.

Source: DYMO, LabelWriter 400 Series and 450 Series Technical Reference Manuals (commands, status);
the escapes that begin a job are those that CUPS and LPrint send.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from devices.languages.base import INK, LIMIT, Language, Page, Piece
from devices.languages.reader import Reader
from devices.status import Status
from halftone.errors import UsageError
from halftone.frame import Frame
from halftone.packing import bytes_per_row
from halftone.tone.levels import Levels

__all__ = ["Dymo"]

BYTES = 1 << 14
"""Bytes of a piece."""
CLEAR = b"\x1b" * 100 + b"\x1b@"
"""Ends a row that an earlier job left open (84 bytes at most), and resets."""
DENSITIES = b"cdeg"
"""Letters for 75, 87.5, 100 and 112.5 % of the normal heat."""
CONTINUOUS = 0xFFFF
SYN, ETB = 0x16, 0x17


@dataclass(frozen=True)
class Dymo(Language):
    """DYMO LabelWriter.

    dots : of the head: 672 (LabelWriter 400, 450), 448 (SE450), 1248 (4XL). length : rows that are
    fed at most in search of the mark between two labels, 0 on a roll without marks. graphics :
    places dots better, at lower speed. roll : 1 left or 2 right of a Twin Turbo, 0 does not say.

    Density is 1 … 4, light to dark. A page's right edge is filled up to whole bytes with paper.
    """

    dots: int = 672
    length: int = 3058
    graphics: bool = True
    roll: int = 0

    name = "dymo"
    title = "DYMO LabelWriter"
    media_type = "application/vnd.dymo-labelwriter"
    widest = 255 * 8
    status_query = b"\x1bA"

    def __post_init__(self) -> None:
        bounds = {"dots": (8, self.widest), "length": (0, 0x7FFF), "roll": (0, 2)}
        for key, (low, high) in bounds.items():
            if not low <= getattr(self, key) <= high:
                raise UsageError(f"dymo: {key} = {getattr(self, key)}; allowed: {low} … {high}")

    def encode(self, pages: Iterable[Page]) -> Iterator[Piece]:
        feed = partial(bytes, b"\x1bE")
        coming = iter(pages)
        page = next(coming, None)
        begin = CLEAR
        while page is not None:
            begin += self._begin(page)
            left = page.height
            for rows in page.bands(max(1, BYTES // (1 + bytes_per_row(page.width, 1)))):
                left -= len(rows)
                mark = np.full((len(rows), 1), SYN, np.uint8)
                data = begin + np.concatenate([mark, rows], axis=1).tobytes()
                begin, count = b"", len(rows)
                if left:
                    yield Piece(data, count, close=feed)
            try:
                page = next(coming, None)
            except Exception:  # the next cannot be read: this one is the last
                yield Piece(data + b"\x1bE", count)
                raise
            if page is None:
                yield Piece(data + b"\x1bE", count)  # the last label is fed to where it is torn off
            else:  # broken off here, this one is the last
                yield Piece(data, count, close=feed)
                begin = b"\x1bG"
        if begin:
            yield Piece(begin)

    def _begin(self, page: Page) -> bytes:
        """The commands before the rows of a page."""
        if page.width > self.dots or (self.length and page.height > self.length):
            rows = self.length or "any number of"
            raise UsageError(
                f"dymo: a page of {page.width} × {page.height} dots; allowed: {self.dots} × {rows} rows"
            )
        if page.copies > 1 or page.cut:
            raise UsageError("dymo knows no copies and no cutter: send the page as often as wanted")
        if page.density is not None and not 1 <= page.density <= len(DENSITIES):
            raise UsageError(f"dymo: density {page.density}; allowed: 1 … {len(DENSITIES)}")
        data = b"\x1bL" + (self.length or CONTINUOUS).to_bytes(2, "big")
        data += b"\x1bB\0\x1bD" + bytes([bytes_per_row(page.width, 1)])
        data += b"\x1bi" if self.graphics else b"\x1bh"
        if page.density is not None:
            data += b"\x1b" + DENSITIES[page.density - 1 : page.density]
        return data + (b"\x1bq%d" % self.roll if self.roll else b"")

    @classmethod
    def decode(cls, data: bytes, limit: int = LIMIT) -> list[Frame]:
        return _Job(Reader(cls.name, data), limit).run()

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        rest = head.lstrip(b"\x1b")
        return len(head) - len(rest) > 8 and rest[:1] == b"@"

    def parse_status(self, reply: bytes) -> Status | None:
        for byte in reply:
            if byte & 0x1C:
                continue  # bits that are never set: not a status
            reasons = set()
            if byte & 0x20:
                reasons.add("media-empty-error")
            if byte & 0x40:
                reasons.add("media-jam-error")
            if byte & 0x80 and not reasons:
                reasons.add("other-error")
            return Status(frozenset(reasons))
        return None


ARGUMENTS = {"*": 0, "A": 0, "V": 0, "h": 0, "i": 0, "y": 0, "z": 0, "L": 2, "Q": 2}
"""Commands that change no dot → bytes that follow them; y and z say how far apart rows are."""


class _Job:
    """What the printer has been told so far."""

    def __init__(self, reader: Reader, limit: int) -> None:
        self.reader, self.limit = reader, limit
        self.frames: list[Frame] = []
        self.rows: list[tuple[int, bytes]] = []  # number, and its bytes from the left edge
        self.height = self.right = 0
        self.reset()

    def reset(self) -> None:
        self.tab, self.size = 0, 84
        self.dpi: tuple[float, float] | None = None
        self.density: int | None = None

    def run(self) -> list[Frame]:
        reader = self.reader
        while reader.left:
            start = reader.place
            first = reader.byte("a command")
            if first == SYN:
                self.row(bytes(self.tab) + reader.take(self.size, "a row"), start)
            elif first == ETB:
                reader.fail("a compressed row, which is not read", start)
            elif first == 0x1B:
                self.command(start)
            else:
                reader.fail(f"byte {first:#04x} begins no command", start)
        if self.height:
            reader.fail("a form feed after the last row expected")
        return self.frames

    def row(self, row: bytes, start: int) -> None:
        self.right = max(self.right, len(row))
        self.rows.append((self.height, row))
        self.skip(1, start)

    def skip(self, count: int, start: int) -> None:
        self.height += count
        if 8 * max(self.right, self.tab + self.size) * self.height > self.limit:
            self.reader.fail(f"a page of more than {self.limit} pixels", start)

    def command(self, start: int) -> None:
        reader = self.reader
        letter = reader.byte("a command")
        many = letter == 0x1B
        while letter == 0x1B:
            letter = reader.byte("a command")
        name = chr(letter)
        if many and name != "@":
            reader.fail("a reset after many escapes expected", reader.place - 1)
        if name in ARGUMENTS:
            reader.take(ARGUMENTS[name], "a command's bytes")
            if name in "yz":
                self.dpi = (300.0, 300.0 if name == "y" else 203.0)
        elif name == "@":
            if self.height:
                reader.fail("a reset in the middle of a page", start)
            self.reset()
        elif letter in DENSITIES:
            self.density = DENSITIES.index(letter) + 1
        elif name == "B":
            self.tab = reader.byte("a dot tab")
        elif name == "D":
            self.size = reader.byte("bytes per line")
            if not self.size:
                reader.fail("a line of 0 bytes", reader.place - 1)
        elif name == "q":
            if reader.byte("a roll") not in b"012":
                reader.fail("roll '0', '1' or '2' expected", reader.place - 1)
        elif name == "f":
            reader.expect(b"\1", "1")
            self.skip(reader.byte("rows to skip"), start)
        elif name in "EG":
            self.eject(start)
        else:
            reader.fail(f"the command ESC {name!r} is not known", start)

    def eject(self, start: int) -> None:
        """The page as a frame."""
        if not self.height:
            self.reader.fail("a form feed without rows", start)
        size = self.right or self.tab + self.size
        packed: NDArray[np.uint8] = np.zeros((self.height, size), np.uint8)
        for number, row in self.rows:
            packed[number, : len(row)] = np.frombuffer(row, np.uint8)
        indices = np.unpackbits(packed, axis=1) ^ np.uint8(1)
        self.limit -= indices.size
        report = {} if self.density is None else {"density": self.density}
        self.frames.append(Frame(indices, Levels.of(2), "", self.dpi, INK, dict(report)))
        self.rows, self.height, self.right = [], 0, 0
