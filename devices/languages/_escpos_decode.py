"""A strict reader of ESC/POS streams that hold pictures.

A page ends with a cut or with ESC @. Its pictures follow each other downwards, with the paper that is
fed between them; what is fed before the first and after the last one is no part of it. Margins and
alignment are reported and not drawn, for the width of the paper is not in the bytes; pictures that
would lie at different places across are therefore an error. So is text.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from devices.languages.reader import Reader, Sheet
from halftone.frame import Frame
from halftone.packing import bytes_per_row

__all__ = ["Decoder"]

Rows = NDArray[np.uint8]

BAND = 24
"""Rows of a band of ESC *, in all its modes: those with 8 dots are three times as high."""
PITCH = 30
"""Rows from line to line after ESC @ and ESC 2, as most manuals state it."""
ALIGNMENTS = ("left", "center", "right")

ANY = range(256)
SWITCH = b"\x00\x0101"
NUMBER = b"\x00\x01\x02\x03\x04012345"


class Decoder:
    """One reading of *data*. ``pages()`` gives the frames."""

    def __init__(self, data: bytes, limit: int) -> None:
        self.reader = Reader("escpos", data)
        self.left = limit
        self.frames: list[Frame] = []
        self.line: list[Rows] = []  # pieces of a band of ESC * that wait for a feed: dots (24, n)
        self.line_width = 0
        self.stored: tuple[Rows, int] | None = None  # graphics that wait for function 50
        self.start = 0  # of the command that is being read
        self.new_page()
        self.reset_state()

    def new_page(self) -> None:
        self.sheet = Sheet(self.reader, self.left)
        self.gap = 0
        self.place: tuple[object, ...] | None = None

    def reset_state(self) -> None:
        self.pitch, self.align, self.margin, self.area = PITCH, "left", 0, 0
        self.density: object = None

    def pages(self) -> list[Frame]:
        while self.reader.left:
            self.command()
        self.start = self.reader.place
        self.end_page()
        return self.frames

    def command(self) -> None:
        reader = self.reader
        self.start = reader.place
        key = reader.take(1, "a command")
        while key in UNFINISHED:
            key += reader.take(1, "a command")
        if key not in COMMANDS:
            reader.fail(f"{key.hex(' ')} is text or an unknown command", self.start)
        action, *parameters = COMMANDS[key]
        action(self, *(self.parameter(allowed) for allowed in parameters))

    def parameter(self, allowed: Collection[int]) -> int:
        value = self.reader.byte("a parameter")
        if value not in allowed:
            self.reader.fail(f"parameter {value} is not allowed", self.reader.place - 1)
        return value

    # -- pages and paper ------------------------------------------------------------------------

    def end_page(self, cut: str | None = None) -> None:
        """Close the page, if there is a picture on it."""
        self.nothing_waits()
        if self.sheet.height:
            self.frames.append(
                self.sheet.frame(
                    feed=self.gap, cut=cut, density=self.density, align=self.align, left=self.margin
                )
            )
            self.left -= self.sheet.width * self.sheet.height
        self.new_page()

    def nothing_waits(self) -> None:
        """Refuse what is allowed only where nothing is half printed."""
        if self.line:
            self.reader.fail("a line that was not printed by a feed", self.start)
        if self.stored is not None:
            self.reader.fail("graphics that were stored and not printed", self.start)

    def reset(self) -> None:
        self.end_page()
        self.reset_state()

    def cut(self, mode: int) -> None:
        if mode in b"ABabgh":
            self.gap += self.parameter(ANY)
        self.end_page("partial" if mode in b"\x011Bbh" else "full")

    def feed(self, rows: int) -> None:
        """Print the line that waits; move the paper by *rows* in all, at least by what was printed."""
        if self.line:
            dots = np.concatenate(self.line, axis=1)
            self.line, self.line_width = [], 0
            height = BAND
            if rows < BAND and not dots[rows:].any():
                height = rows  # the last band of a picture whose height 24 does not divide
            self.lay(np.packbits(dots[:height], axis=1), dots.shape[1])
            rows -= height
        self.gap += max(0, rows)

    def line_feed(self) -> None:
        self.feed(max(self.pitch, BAND) if self.line else self.pitch)

    def feed_lines(self, lines: int) -> None:
        self.feed(max(self.pitch * lines, BAND) if self.line else self.pitch * lines)

    def set_pitch(self, rows: int) -> None:
        self.pitch = rows

    def default_pitch(self) -> None:
        self.pitch = PITCH

    # -- settings -------------------------------------------------------------------------------

    def set_align(self, n: int) -> None:
        self.nothing_waits()
        self.align = ALIGNMENTS[n % 48]

    def set_margin(self, low: int, high: int) -> None:
        self.nothing_waits()
        self.margin = low + 256 * high

    def set_area(self, low: int, high: int) -> None:
        self.nothing_waits()
        self.area = low + 256 * high

    def set_heat(self, *values: int) -> None:
        self.density = values

    def set_density(self, value: int) -> None:
        self.density = value

    def gs_k(self) -> None:
        self.reader.expect(b"\x02\x00\x31", "GS ( K function 49")
        self.density = (self.parameter(ANY) + 128) % 256 - 128

    def ignored(self, *parameters: int) -> None:
        """It changes text, or asks for an answer."""

    def font_of_kanji(self) -> None:
        self.reader.expect(b"\x02\x00\x30", "FS ( A function 48")
        self.parameter(NUMBER)

    # -- pictures -------------------------------------------------------------------------------

    def lay(self, packed: Rows, width: int, offset: int | None = None) -> None:
        """Put rows on the page, below what was fed."""
        offset = self.start if offset is None else offset
        place: tuple[object, ...] = (self.margin,)
        if self.align != "left":
            place += (self.align, self.area, width)
        if self.place not in (None, place):
            self.reader.fail("a picture that lies elsewhere across the paper", offset)
        self.place = place
        if self.gap and self.sheet.height:
            self.sheet.check(width, self.gap + len(packed), offset)
            self.sheet.add(np.zeros((self.gap, 1), np.uint8), 1, offset)
        self.gap = 0
        self.sheet.add(packed, width, offset)

    def picture(self, width: int, height: int, across: int, down: int, at: int) -> Rows:
        """The rows of a picture whose header is read, each dot *across* × *down* dots large."""
        if not width or not height:
            self.reader.fail(f"a picture of {width} × {height} dots", at)
        self.sheet.check(width * across, height * down, at)
        size = bytes_per_row(width, 1)
        start = self.reader.place
        rows = np.frombuffer(self.reader.take(size * height, "rows"), np.uint8).reshape(height, size)
        if width % 8 and (rows[:, -1] & (0xFF >> width % 8)).any():
            self.reader.fail("ink to the right of the last dot", start)
        if across == 2:
            dots = np.unpackbits(rows, axis=1, count=width)
            rows = np.packbits(np.repeat(dots, 2, axis=1), axis=1)
        return np.repeat(rows, down, axis=0) if down > 1 else rows

    def raster(self, mode: int) -> None:
        """GS v 0 m x y: x is bytes."""
        self.nothing_waits()
        at = self.reader.place
        size, height = self.reader.little(2, "bytes a row"), self.reader.little(2, "rows")
        across, down = 1 + mode % 2, 1 + mode % 48 // 2
        self.lay(self.picture(size * 8, height, across, down, at), size * 8 * across)

    def dc2_raster(self, height: int, size: int) -> None:
        """DC2 * r n: n is bytes a row."""
        self.nothing_waits()
        self.lay(self.picture(size * 8, height, 1, 1, self.start + 2), size * 8)

    def columns(self, mode: int, low: int, high: int) -> None:
        """ESC *: kept until a feed prints it, for more may follow to its right."""
        if self.stored is not None:
            self.nothing_waits()
        count, rows = low + 256 * high, BAND if mode >= 32 else 8
        across = 1 if mode % 2 else 2
        if not count:
            self.reader.fail("ESC * without columns", self.start + 3)
        self.line_width += count * across
        self.sheet.check(self.line_width, BAND, self.start + 3)
        data = np.frombuffer(self.reader.take(count * rows // 8, "columns"), np.uint8)
        dots = np.unpackbits(data.reshape(count, rows // 8), axis=1).T
        self.line.append(np.repeat(np.repeat(dots, BAND // rows, axis=0), across, axis=1))

    def graphics(self, length_bytes: int = 2) -> None:
        """GS ( L and GS 8 L: functions 112 (store) and 50 (print)."""
        at = self.reader.place
        length = self.reader.little(length_bytes, "length")
        self.reader.expect(b"0", "graphics of the kind '0'")
        function = self.parameter(b"\x02\x32\x70")
        if function == 0x70:
            self.store(length, at)
            return
        if length != 2:
            self.reader.fail(f"length {length} for function {function}, which has 2", at)
        if self.stored is None:
            self.reader.fail("print graphics, without any stored", self.start)
        (rows, width), self.stored = self.stored, None
        self.nothing_waits()
        self.lay(rows, width)

    def store(self, length: int, at: int) -> None:
        self.nothing_waits()
        self.reader.expect(b"0", "monochrome graphics")
        across, down = self.parameter(b"\x01\x02"), self.parameter(b"\x01\x02")
        self.reader.expect(b"1", "the first colour")
        size_at = self.reader.place
        width, height = self.reader.little(2, "width"), self.reader.little(2, "rows")
        needed = 10 + bytes_per_row(width, 1) * height
        if length != needed:
            self.reader.fail(f"length {length}; graphics of {width} × {height} dots have {needed}", at)
        self.stored = self.picture(width, height, across, down, size_at), width * across

    def long_graphics(self) -> None:
        self.graphics(4)

    # -- real-time commands between others --------------------------------------------------------

    def pulse(self) -> None:
        self.reader.expect(b"\x01", "DLE DC4 1 (others of its functions empty buffers or switch off)")
        self.parameter(b"\x00\x01")
        self.parameter(range(1, 9))


D = Decoder
COMMANDS: dict[bytes, tuple[Any, ...]] = {
    # pictures
    b"\x1dv0": (D.raster, b"\x00\x01\x02\x030123"),
    b"\x1d(L": (D.graphics,),
    b"\x1d8L": (D.long_graphics,),
    b"\x1b*": (D.columns, b"\x00\x01\x20\x21", ANY, ANY),
    b"\x12*": (D.dc2_raster, ANY, ANY),
    # paper
    b"\x1b@": (D.reset,),
    b"\n": (D.line_feed,),
    b"\r": (D.ignored,),
    b"\x1bJ": (D.feed, ANY),
    b"\x1bd": (D.feed_lines, ANY),
    b"\x1b2": (D.default_pitch,),
    b"\x1b3": (D.set_pitch, ANY),
    b"\x1dV": (D.cut, b"\x00\x0101ABabgh"),
    # settings
    b"\x1ba": (D.set_align, b"\x00\x01\x02012"),
    b"\x1dL": (D.set_margin, ANY, ANY),
    b"\x1dW": (D.set_area, ANY, ANY),
    b"\x1b7": (D.set_heat, ANY, ANY, ANY),
    b"\x12#": (D.set_density, ANY),
    b"\x1d(K": (D.gs_k,),
    b"\x1da": (D.ignored, ANY),
    # text: fonts, spacing, underline, emphasis, size, code pages
    b"\x1bM": (D.ignored, NUMBER + b"ab"),
    b"\x1b ": (D.ignored, ANY),
    b"\x1b-": (D.ignored, NUMBER),
    b"\x1bE": (D.ignored, SWITCH),
    b"\x1bG": (D.ignored, SWITCH),
    b"\x1b!": (D.ignored, ANY),
    b"\x1bt": (D.ignored, ANY),
    b"\x1bR": (D.ignored, ANY),
    b"\x1b{": (D.ignored, b"\x000"),  # upside down would turn pictures too
    b"\x1dB": (D.ignored, SWITCH),
    b"\x1d!": (D.ignored, ANY),
    b"\x1c.": (D.ignored,),
    b"\x1c&": (D.ignored,),
    b"\x1cS": (D.ignored, ANY, ANY),
    b"\x1c-": (D.ignored, NUMBER),
    b"\x1cC": (D.ignored, NUMBER),
    b"\x1c(A": (D.font_of_kanji,),
    # questions
    b"\x1bv": (D.ignored,),
    b"\x1dr": (D.ignored, b"\x01\x02\x0412" + b"4"),
    b"\x10\x04": (D.ignored, range(1, 5)),
    b"\x10\x05": (D.ignored, b"\x00\x01"),
    b"\x10\x14": (D.pulse,),
}
"""First bytes of a command: its action and what each of its parameters may be."""
UNFINISHED = {command[:size] for command in COMMANDS for size in range(1, len(command))}
