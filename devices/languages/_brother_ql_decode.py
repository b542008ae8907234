"""Brother QL raster streams read strictly: of every page the part that can be printed on."""

from __future__ import annotations

import numpy as np

from devices.languages.base import INK
from devices.languages.brother_ql import DPI, MEDIA, PINS, Media
from devices.languages.packbits import unpacked
from devices.languages.reader import Reader
from halftone.frame import Frame
from halftone.tone.levels import Levels

__all__ = ["decode"]

CANCEL = 200
"""Zeros, and a reset after them, by which a page is given up in the middle."""
PASSED = {
    b"!": 1,  # whether status comes by itself
    b"S": 0,  # a question for status
    b"UJ": 14,  # a job's number
    b"Uw\x01": 127,  # more about the media
}
"""Letters after ``ESC i`` that change no dot → bytes that follow them."""


def decode(data: bytes, limit: int) -> list[Frame]:
    """The pages of a job. Raises ProtocolError."""
    return _Job(Reader("brother-ql", data), limit).run()


class _Job:
    """What the printer has been told so far."""

    def __init__(self, reader: Reader, limit: int) -> None:
        self.reader, self.limit = reader, limit
        self.frames: list[Frame] = []
        self.open = False  # whether a job has begun that has not ended
        self.reset()

    def reset(self) -> None:
        self.compressed = self.fine = self.cut = False
        self.report: dict[str, object] = {}
        self.clear()

    def clear(self) -> None:
        """Wait for the next page."""
        self.window: tuple[int, int] | None = None  # mm, as stated
        self.stated = 0  # rows
        self.rows: list[bytes] = []
        self.pins: int | None = None

    def run(self) -> list[Frame]:
        reader = self.reader
        while reader.left:
            start = reader.place
            first = reader.byte("a command")
            if first == 0x00:
                self.zeros(start)
            elif first == 0x1B:
                self.escape(start)
            elif first == ord("M"):
                if reader.peek(1) not in (b"\0", b"\2"):
                    reader.fail("a compression of 0 or 2 expected")
                self.compressed = reader.byte("compression") == 2
            elif first in (ord("g"), ord("Z")):
                self.row(first, start)
            elif first == ord("w"):
                reader.fail("a row of a second colour, which is not read", start)
            elif first in (0x0C, 0x1A):
                self.end(start)
                self.open = first == 0x0C
            else:
                reader.fail(f"byte {first:#04x} begins no command", start)
        if self.window is not None or self.open:
            reader.fail("the print command of the last page expected")
        return self.frames

    def zeros(self, start: int) -> None:
        """Zeros mean nothing, but for many before a reset within a page, which is then given up."""
        reader = self.reader
        end = start
        while reader.data[end : end + 4096].strip(b"\0") == b"" and end < len(reader.data):
            end = min(end + 4096, len(reader.data))
        while end < len(reader.data) and reader.data[end] == 0:
            end += 1
        reader.place = end
        if end - start >= CANCEL and reader.peek(2) == b"\x1b@":
            if self.rows:
                self.frame(end, cancelled=True)
            self.open = False
            self.clear()

    def escape(self, start: int) -> None:
        """A command that begins with an escape."""
        reader = self.reader
        kind = reader.take(1, "a command")
        if kind == b"@":
            if self.window is not None:
                reader.fail("a reset in the middle of a page", start)
            self.reset()
            return
        if kind != b"i":
            reader.fail(f"the command ESC {kind!r} is not known", start)
        for letters, size in PASSED.items():
            if reader.peek(len(letters)) == letters:
                reader.place += len(letters)
                reader.take(size, "a command's bytes")
                return
        letter = reader.take(1, "a command").decode("latin-1")
        place = reader.place
        if letter == "z":
            self.page(start)
        elif letter == "a":
            if reader.byte("the mode") != 1:
                reader.fail("a mode other than that of rasters (1)", place)
        elif letter == "M":
            self.cut = bool(self.flags("automatic cut", 0x40) & 0x40)
        elif letter == "A":
            every = reader.byte("pages between cuts")
            if not every:
                reader.fail("a cut after every 0 pages", place)
            self.report["cut_every"] = every
        elif letter == "K":
            self.fine = bool(self.flags("expanded mode (two colours are not read)", 0x48) & 0x40)
        elif letter == "d":
            self.report["margin"] = reader.little(2, "a margin")
        else:
            reader.fail(f"the command ESC i {letter!r} is not known", start)

    def flags(self, what: str, allowed: int) -> int:
        """A byte of which only the bits of *allowed* may be set."""
        value = self.reader.byte(what)
        if value & ~allowed:
            self.reader.fail(f"{what} of {value:#04x}", self.reader.place - 1)
        return value

    def page(self, start: int) -> None:
        """What a page is printed on, and how many rows it has."""
        reader = self.reader
        if self.rows:
            reader.fail("a second page before the print command of the first", start)
        place = reader.place
        flags = self.flags("what counts of the media", 0xCE)
        kind, width, length = reader.take(3, "the media")
        if flags & 0x02 and kind not in (0x0A, 0x0B):
            reader.fail(f"media of kind {kind:#04x}; allowed: 0x0a, 0x0b", place + 1)
        if not flags & 0x04:
            width = 0
        if not flags & 0x08 or (flags & 0x02 and kind == 0x0A):
            length = 0
        self.stated = reader.little(4, "the number of rows")
        if reader.byte("first or other page") > 1 or reader.byte("zero"):
            reader.fail("0 or 1, and 0 expected", reader.place - 1)
        if not self.stated:
            reader.fail("a page without rows", place + 4)
        self.window, self.open = (width, length), True
        widest = MEDIA[width, length].dots if (width, length) in MEDIA else max(PINS)
        if self.stated * widest > self.limit:
            reader.fail(f"a page of more than {self.limit} pixels", place + 4)

    def row(self, kind: int, start: int) -> None:
        """One row; those that are not compressed may be short of pins on the left."""
        reader = self.reader
        if self.window is None:
            reader.fail("a row before the page's size", start)
        if len(self.rows) == self.stated:
            reader.fail(f"more rows than the {self.stated} of the page", start)
        if kind == ord("Z"):
            if not self.compressed:
                reader.fail("a blank row without compression", start)
            self.rows.append(b"")
            return
        if reader.byte("zero"):
            reader.fail("zero expected", reader.place - 1)
        size = reader.byte("the size of a row")
        if not size:
            reader.fail("a row without bytes", reader.place - 1)
        if self.compressed:
            row = unpacked(reader, size, max(PINS) // 8)
            if len(row) * 8 not in PINS:
                reader.fail(f"a row of {len(row)} bytes; allowed: 90, 162", start)
        else:
            row = reader.take(size, "a row")
        pins = 720 if len(row) <= 90 else 1296
        if (self.pins or pins) != pins or len(row) > 162:
            reader.fail(f"a row of {len(row)} bytes on a head of {self.pins or 1296} pins", start)
        self.pins = pins
        self.rows.append(row)

    def end(self, start: int) -> None:
        if self.window is None:
            self.reader.fail("a print command before a page", start)
        if len(self.rows) < self.stated:
            self.reader.fail(f"{len(self.rows)} rows of a page of {self.stated}", start)
        self.frame(start)
        self.clear()

    def frame(self, offset: int, cancelled: bool = False) -> None:
        """The page as far as its rows came."""
        assert self.window is not None
        known = MEDIA.get(self.window)
        pins = self.pins or (720 if known is None or known.dots + known.offset <= 720 else 1296)
        window = known or Media(pins - PINS[pins], 0)
        first = window.offset + PINS[pins]
        stop = first + window.dots
        if stop > pins:
            self.reader.fail(f"media of {window.dots} dots on a head of {pins} pins", offset)
        height = len(self.rows)
        if window.dots * height > self.limit:
            self.reader.fail(f"a page of more than {self.limit} pixels", offset)
        self.limit -= window.dots * height
        joined = b"".join(row.ljust(pins // 8, b"\0") for row in self.rows)
        packed = np.frombuffer(joined, np.uint8).reshape(height, -1)
        dots = np.unpackbits(packed, axis=1)
        if dots[:, :first].any() or dots[:, stop:].any():
            self.reader.fail("ink beside the media", offset)
        report = {**self.report, "cut": self.cut, "media": self.window}
        if cancelled:
            report["cancelled"] = True
        indices = np.ascontiguousarray(dots[:, first:stop][:, ::-1]) ^ np.uint8(1)
        self.frames.append(Frame(indices, Levels.of(2), "", DPI[self.fine], INK, report))
