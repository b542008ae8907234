"""EPL2 (page mode), the language of Eltron's and of Zebra's older label printers.

A page is one label: ``N``, settings, its rows in ``GW`` commands below each other, ``P``. In a bitmap
0 burns a dot. Source: EPL2 Programmer's Manual (Zebra 14245L): N, q, Q, R, D, S, Z, GW, P, C; and what
CUPS and LPrint send.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from devices.languages.base import LIMIT, Language, Page, Piece
from devices.languages.label import Labels
from halftone.errors import UsageError, near
from halftone.frame import Frame
from halftone.packing import bytes_per_row

__all__ = ["Epl2"]

BYTES = 1 << 16
"""Bytes of rows in a GW."""
MOST_DOTS = 32_000
DARKEST = 15
FASTEST = 6
MEDIA = ("", "continuous")


def _end() -> bytes:
    return b"P1\n"


@dataclass(frozen=True)
class Epl2(Language):
    """EPL2.

    speed : the printer's own step, 1 … 6. media : ``continuous`` says that the labels have no gaps
    and are as long as the page. 0 and empty leave them as they are set.

    Width and height are at most 32,000 dots. A page's density is 0 … 15. It has no status query.
    """

    name = "epl2"
    title = "EPL2, Eltron and older Zebra label printers"
    media_type = "application/vnd.eltron-epl"
    cuts = True
    native_copies = True
    widest = MOST_DOTS

    speed: int = 0
    media: str = ""

    def __post_init__(self) -> None:
        if self.media not in MEDIA:
            raise UsageError(near(self.media, [m for m in MEDIA if m], "media of 'epl2'"))
        _within("speed", self.speed, 0, FASTEST)

    def encode(self, pages: Iterable[Page]) -> Iterator[Piece]:
        for page in pages:
            yield Piece(self._setup(page))
            size, top = bytes_per_row(page.width, 1), 0
            for rows in page.bands(max(1, BYTES // size)):
                head = b"GW0,%d,%d,%d," % (top, size, len(rows))
                data = head + (~rows).tobytes() + b"\n"
                yield Piece(data, len(rows), len(head), size, _end, paper=0xFF)
                top += len(rows)
            yield Piece(b"P%d\n" % page.copies + (b"C\n" if page.cut else b""))

    def _setup(self, page: Page) -> bytes:
        """The beginning of a label, after a line feed that ends whatever was open."""
        _within("a label's height", page.height, 1, MOST_DOTS)
        setup = b"\nN\nZT\nR0,0\n"
        if self.speed:
            setup += b"S%d\n" % self.speed
        if page.density is not None:
            _within("density", page.density, 0, DARKEST)
            setup += b"D%d\n" % page.density
        setup += b"q%d\n" % page.width
        if self.media:
            setup += b"Q%d,0\n" % page.height
        return setup

    @classmethod
    def decode(cls, data: bytes, limit: int = LIMIT) -> list[Frame]:
        return Decoder(cls.name, data, limit).frames()

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        return re.match(rb"\r?\nN\r?\n", head) is not None


def _within(what: str, value: int, least: int, most: int) -> None:
    if not least <= value <= most:
        raise UsageError(f"epl2: {what} = {value}; allowed: {least} … {most}")


BITMAP = re.compile(rb"(\d{1,5}),(\d{1,5}),(\d{1,5}),(\d{1,5})(?:,|\r?\n)")
LINE = re.compile(rb"([^\r\n]{0,40})\r?\n")
SETTINGS = {
    "density": re.compile(rb"D(\d|1[0-5])"),
    "speed": re.compile(rb"S([0-6])"),
    "direction": re.compile(rb"Z([TB])"),
    "options": re.compile(rb"O([DSCPFLN0-9,]{0,8})"),
    "cut": re.compile(rb"(C)"),
}
"""Commands that lay nothing, by what they are called in a frame's report."""
WIDTH = re.compile(rb"q(\d{1,5})")
HEIGHT = re.compile(rb"Q(\d{1,5}),(?:B?\d{1,3})(?:[+-]\d{1,3})?")
HOME = re.compile(rb"R(\d{1,5}),(\d{1,5})")
PRINT = re.compile(rb"P(\d{1,5})(?:,(\d{1,5}))?")


class Decoder(Labels):
    """The labels of a stream. Without q or Q a label is as wide and high as its bitmaps need; N clears
    it, P may repeat it."""

    def frames(self) -> list[Frame]:
        reader = self.reader
        if not reader.data.strip():
            reader.fail("an EPL2 command expected")
        while reader.left:
            place = reader.place
            if reader.peek(2) == b"GW":
                reader.take(2, "a command")
                self._bitmap(place)
            else:
                self._line(place)
        return self.made

    def _line(self, place: int) -> None:
        found = LINE.match(self.reader.data, place)
        if not found:
            self.reader.fail("a command that ends with its line expected")
        text = found[1]
        if text == b"N":
            self.laid, self.home = [], (0, 0)
        elif match := WIDTH.fullmatch(text):
            self.size = int(match[1]), self.size[1]
        elif match := HEIGHT.fullmatch(text):
            self.size = self.size[0], int(match[1])
        elif match := HOME.fullmatch(text):
            self.home = int(match[1]), int(match[2])
        elif match := PRINT.fullmatch(text):
            self.print(int(match[1]) * int(match[2] or 1), "P", place)
        elif text:
            self._set(text)
        self.reader.place = found.end()

    def _set(self, text: bytes) -> None:
        for key, pattern in SETTINGS.items():
            if match := pattern.fullmatch(text):
                self.settings[key] = int(match[1]) if match[1].isdigit() else match[1].decode()
                return
        self.reader.fail(f"unknown command {text[:20]!r}")

    def _bitmap(self, place: int) -> None:
        reader = self.reader
        found = BITMAP.match(reader.data, reader.place)
        if not found:
            reader.fail("GW with four numbers expected")
        self.lay(found, place)
