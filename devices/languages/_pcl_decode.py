"""PCL 5 read strictly: what a printer would draw of a job that is raster graphics and settings.

Rasters are laid on the page where the cursor stands, counted from the left margin and the top
margin; text, fonts, rectangles, colours, scaled rasters and HP-GL/2 are refused by name or offset.
"""

from __future__ import annotations

import re

from devices.languages._pcl_raster import Raster, compose, restored
from devices.languages.pcl import RESOLUTIONS, UEL
from devices.languages.reader import Reader
from halftone.frame import Frame

__all__ = ["decode"]

VALUE = re.compile(rb"([+-]?)([0-9]{0,6})(\.[0-9]{0,4})?")
HARMLESS = {
    b"&l": "ABCDEFGHLMOPSTUZ",  # page size, orientation, margins, trays, duplex, registration
    b"&a": "GLM",  # side of the sheet, margins of text
    b"&k": "GHSW",  # what line ends and text pitches mean
    b"&s": "C",
    b"*t": "IJK",  # gamma, rendering
    b"*r": "Q",
    b"*o": "DMQ",  # print quality
    b"%": "A",
}
"""Settings that change nothing of the dots, by what follows the escape and by their last letter."""
NEW_PAGE = "AOP"
"""Letters of ``&l`` that eject the page: allowed on an empty one only."""
POINT = 7200
"""Steps of the cursor in an inch."""


def decode(data: bytes, limit: int) -> list[Frame]:
    """The pages of a job. Raises ProtocolError."""
    return _Job(Reader("pcl", data), limit).run()


class _Job:
    """What the printer has been told so far."""

    def __init__(self, reader: Reader, limit: int) -> None:
        self.reader, self.limit = reader, limit
        self.frames: list[Frame] = []
        self.rasters: list[Raster] = []
        self.open: Raster | None = None
        self.ended = False  # whether nothing has followed the last page or reset
        self.reset()

    def reset(self) -> None:
        self.dpi, self.unit, self.copies, self.mode = 75, 300, 1, 0
        self.width: int | None = None
        self.height: int | None = None
        self.x = self.y = self.left = 0

    def run(self) -> list[Frame]:
        reader = self.reader
        while reader.left:
            start = reader.place
            self.ended = False
            first = reader.byte("a command")
            if first == 0x0C:
                self.eject(start)
                self.ended = True
            elif first == 0x0D:
                self.finish()
                self.x = 0
            elif first != 0x1B:
                reader.fail(f"byte {first:#04x}, text, which is not read; a command expected", start)
            elif reader.peek(1) == b"E":
                reader.place += 1
                self.leave(start)
            elif reader.data.startswith(UEL, start):
                reader.place = start + len(UEL)
                self.leave(start)
                self.job_language()
            else:
                self.commands(start)
        if not self.ended:
            reader.fail("a form feed or a reset expected at the end of the job")
        return self.frames

    def leave(self, start: int) -> None:
        """A reset, which ejects what was drawn."""
        if self.rasters or self.open is not None:
            self.eject(start)
        self.reset()
        self.ended = True

    def job_language(self) -> None:
        """Lines of PJL up to the one that enters PCL, or to where they end."""
        reader = self.reader
        while reader.peek(4) == b"@PJL":
            start = reader.place
            end = reader.data.find(b"\n", start, start + 1024)
            if end < 0:
                reader.fail("a line of PJL without an end", start)
            line = reader.take(end + 1 - start, "a line of PJL")[:-1].rstrip(b"\r")
            for place, byte in enumerate(line):
                if not (32 <= byte < 127 or byte == 9):
                    reader.fail(f"byte {byte:#04x} in a line of PJL", start + place)
            words = line.upper().replace(b"=", b" = ").split()
            if words[1:2] == [b"ENTER"]:
                if words[2:] != [b"LANGUAGE", b"=", b"PCL"]:
                    reader.fail(f"'{line.decode()}'; only PCL is read", start)
                self.ended = False
                return

    def commands(self, start: int) -> None:
        """One escape sequence: a single command, or several that share their first characters."""
        reader = self.reader
        prefix = reader.take(1, "a command")
        if not b"!" <= prefix <= b"/":
            reader.fail(f"the command ESC {prefix!r} is not known", start)
        if b"`" <= reader.peek(1) <= b"~":
            prefix += reader.take(1, "a command")
        while True:
            place = reader.place
            found = VALUE.match(reader.data, place)
            assert found is not None  # it matches nothing, too
            reader.place = found.end()
            letter = reader.take(1, "the letter of a command")
            if not b"@" <= letter <= b"~":
                reader.fail(f"a number or a letter expected, not {letter!r}", reader.place - 1)
            sign = found[1].decode()
            whole = int(found[2] or 0) * (-1 if sign == "-" else 1)
            if found[3] and found[3].strip(b".0"):
                reader.fail("a whole number expected", place)
            self.command(prefix, letter.upper().decode(), whole, sign, place)
            if letter < b"`":
                return

    def command(self, prefix: bytes, letter: str, value: int, sign: str, place: int) -> None:
        """One command; *place* is that of its value."""
        fail = self.reader.fail
        if prefix == b"*b":
            self.raster_data(letter, value, place)
        elif prefix == b"*r" and letter == "A":
            if value not in (0, 1):
                fail(f"a raster of kind {value}; allowed: 0, 1", place)
            self.finish()
            self.begin(self.x if value else 0, place)
        elif prefix == b"*r" and letter in "BC":
            self.finish()
        elif prefix in (b"*r", b"*t") and letter in "FRSTU" and self.open is not None:
            fail(f"{prefix.decode()}#{letter} within a raster", place)
        elif prefix == b"*t" and letter == "R":
            self.dpi = self.one_of("resolution", value, RESOLUTIONS, place)
        elif prefix == b"*r" and letter == "S":
            self.width = self.within("raster width", value, 1, 65_535, place)
        elif prefix == b"*r" and letter == "T":
            self.height = self.within("raster height", value, 1, 65_535, place)
        elif prefix == b"*r" and letter == "F":
            self.one_of("presentation mode", value, (0, 3), place)
        elif prefix == b"*r" and letter == "U":
            self.one_of("number of colour planes", value, (1,), place)
        elif prefix == b"&l" and letter == "X":
            self.copies = self.within("number of copies", value, 1, 32_767, place)
        elif prefix == b"&u" and letter == "D":
            if not 96 <= value <= POINT or POINT % value:
                fail(f"{value} units in an inch", place)
            self.unit = value
        elif prefix == b"*p" and letter in "XY":
            self.move(letter, value * (POINT // self.unit), sign, place)
        elif prefix == b"&a" and letter in "HV":
            self.move("X" if letter == "H" else "Y", value * 10, sign, place)
        elif letter in HARMLESS.get(prefix, ""):
            if prefix == b"&l" and letter in NEW_PAGE and (self.rasters or self.open is not None):
                fail(f"&l#{letter} in the middle of a page", place)
        else:
            fail(f"the command ESC {prefix.decode()}#{letter} is not known", place)

    def within(self, what: str, value: int, low: int, high: int, place: int) -> int:
        if not low <= value <= high:
            self.reader.fail(f"a {what} of {value}; allowed: {low} … {high}", place)
        return value

    def one_of(self, what: str, value: int, allowed: tuple[int, ...], place: int) -> int:
        if value not in allowed:
            self.reader.fail(f"a {what} of {value}; allowed: {', '.join(map(str, allowed))}", place)
        return value

    def move(self, axis: str, steps: int, sign: str, place: int) -> None:
        """Move the cursor, which ends a raster; with a sign, from where it stands."""
        self.finish()
        if axis == "X":
            self.x = steps + (self.x if sign else 0)
            self.left = self.x
        else:
            self.y = steps + (self.y if sign else 0)
        if self.x < 0 or self.y < 0:
            self.reader.fail("a place to the left or above of the page", place)

    def begin(self, left: int, place: int) -> Raster:
        """A raster with its left edge at *left* and its top where the cursor stands."""
        self.left = left
        x, y = left * self.dpi // POINT, self.y * self.dpi // POINT
        self.open = Raster(x, y, self.dpi, self.width, self.height)
        self.check(self.open, place)
        return self.open

    def finish(self) -> None:
        """End the raster; the cursor stands at its left edge, below its last row."""
        if self.open is not None:
            self.rasters.append(self.open)
            self.x = self.left
            self.y += self.open.bottom * (POINT // self.open.dpi)
            self.open = None

    def raster_data(self, letter: str, value: int, place: int) -> None:
        """Rows, rows that are left blank, and the mode of compression."""
        if letter == "M":
            self.mode = self.one_of("compression mode", value, (0, 1, 2, 3), place)
            return
        if letter not in "WY":
            self.reader.fail(f"the command ESC *b#{letter} is not known", place)
        raster = self.open or self.begin(self.left, place)  # rows begin a raster by themselves
        self.within("row of bytes" if letter == "W" else "number of rows", value, 0, 65_535, place)
        if letter == "Y":
            raster.skip(value)
        else:
            row = restored(self.reader, self.mode, value, raster.seed, self.limit // 8 + 1)
            if not raster.add(row):
                self.reader.fail("ink to the right of the raster", place)
        if raster.height is not None and raster.next > raster.height:
            self.reader.fail(f"more rows than the {raster.height} of the raster", place)
        self.check(raster, place)

    def check(self, raster: Raster, place: int) -> None:
        if raster.right * (raster.y + raster.bottom) > self.limit:
            self.reader.fail(f"a page of more than {self.limit} pixels", place)

    def eject(self, start: int) -> None:
        """The page as a frame."""
        self.finish()
        frame = compose(self.reader, self.rasters, self.limit, start, self.copies)
        self.limit -= frame.indices.size
        self.frames.append(frame)
        self.rasters = []
        self.x = self.y = self.left = 0
