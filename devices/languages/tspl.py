"""TSPL and TSPL2, the language of TSC's label printers and of many others.

A page is one label: settings, ``CLS``, its rows in ``BITMAP`` commands below each other, ``PRINT``.
In a bitmap 0 burns a dot. Source: TSPL/TSPL2 Programming Language (TSC): SIZE, GAP, DENSITY, SPEED,
BITMAP, PRINT, SET CUTTER, <ESC>!?.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import partial

from devices.languages.base import LIMIT, Language, Page, Piece
from devices.languages.label import Labels
from devices.status import Status
from halftone.errors import UsageError, near
from halftone.frame import Frame
from halftone.packing import bytes_per_row

__all__ = ["Tspl"]

BYTES = 1 << 16
"""Bytes of rows in a BITMAP."""
MOST_DOTS = 32_000
DARKEST = 15
FASTEST = 18
MEDIA = {"": b"", "continuous": b"GAP 0 mm,0 mm\r\n"}
STATES = {
    0x01: "cover-open-error",  # the head is open
    0x02: "media-jam-error",
    0x04: "media-empty-error",
    0x08: "marker-supply-empty-error",
    0x10: "paused-error",
    0x40: "cover-open-error",
    0x80: "fuser-over-temp-error",
}
"""Bits of the answer to <ESC>!?; 0x20 says that it prints."""


@dataclass(frozen=True)
class Tspl(Language):
    """TSPL.

    unit : how SIZE states the label: ``dot`` (exact; firmware 6.27 and later) or ``mm`` (every one;
    the page must have a dpi). speed : inches a second, 1 … 18. media : ``continuous`` says that the
    labels have no gaps. 0 and empty leave them as they are set.

    Width and height are at most 32,000 dots. A page's density is 0 … 15.
    """

    name = "tspl"
    title = "TSPL, TSC and compatible label printers"
    media_type = "application/vnd.tspl"
    cuts = True
    widest = MOST_DOTS
    native_copies = True
    status_query = b"\x1b!?"

    unit: str = "dot"
    speed: int = 0
    media: str = ""

    def __post_init__(self) -> None:
        if self.unit not in ("dot", "mm"):
            raise UsageError(near(self.unit, ["dot", "mm"], "unit of 'tspl'"))
        if self.media not in MEDIA:
            raise UsageError(near(self.media, [m for m in MEDIA if m], "media of 'tspl'"))
        _within("speed", self.speed, 0, FASTEST)

    def encode(self, pages: Iterable[Page]) -> Iterator[Piece]:
        cutting = False
        for page in pages:
            setup = self._setup(page)
            if page.cut or cutting:
                setup += b"SET CUTTER 1\r\n" if page.cut else b"SET CUTTER OFF\r\n"
                cutting = page.cut
            yield Piece(setup + b"CLS\r\n")
            size, top = bytes_per_row(page.width, 1), 0
            for rows in page.bands(max(1, BYTES // size)):
                head = b"BITMAP 0,%d,%d,%d,0," % (top, size, len(rows))
                close = partial(_print, 1)
                data = head + (~rows).tobytes() + b"\r\n"
                yield Piece(data, len(rows), len(head), size, close, paper=0xFF)
                top += len(rows)
            yield Piece(_print(page.copies))

    def _setup(self, page: Page) -> bytes:
        """The beginning of a label. Where it begins and which way up (1: the top comes out first) is
        stated, because a printer keeps what other programs said of it."""
        _within("a label's height", page.height, 1, MOST_DOTS)
        if self.unit == "dot":
            size = f"SIZE {page.width} dot,{page.height} dot\r\n"
        elif page.dpi is None:
            raise UsageError("tspl: unit = mm needs the page's dpi; give it, or unit = dot")
        else:
            across, down = page.width / page.dpi[0] * 25.4, page.height / page.dpi[1] * 25.4
            size = f"SIZE {across:.2f} mm,{down:.2f} mm\r\n"
        setup = size.encode() + MEDIA[self.media] + b"DIRECTION 1,0\r\nREFERENCE 0,0\r\n"
        if self.speed:
            setup += b"SPEED %d\r\n" % self.speed
        if page.density is not None:
            _within("density", page.density, 0, DARKEST)
            setup += b"DENSITY %d\r\n" % page.density
        return setup

    @classmethod
    def decode(cls, data: bytes, limit: int = LIMIT) -> list[Frame]:
        return Decoder(cls.name, data, limit).frames()

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        return bool(re.match(rb"\s*(SIZE \d|CLS\r?\n|\x1b!\?\s*SIZE )", head))

    def parse_status(self, reply: bytes) -> Status | None:
        """The last byte that came is the answer."""
        if not reply:
            return None
        return Status(frozenset(reason for bit, reason in STATES.items() if reply[-1] & bit))


def _print(copies: int) -> bytes:
    return b"PRINT 1,%d\r\n" % copies


def _within(what: str, value: int, least: int, most: int) -> None:
    if not least <= value <= most:
        raise UsageError(f"tspl: {what} = {value}; allowed: {least} … {most}")


_LENGTH = rb"\d{1,5}(?:\.\d{1,4})?"
BITMAP = re.compile(rb" ?(\d{1,5}),(\d{1,5}),(\d{1,5}),(\d{1,5}),([01]),")
SETTINGS = {
    b"GAP": ("gap", re.compile(rb"(%s(?: mm)?, ?%s(?: mm)?)" % (_LENGTH, _LENGTH))),
    b"BLINE": ("mark", re.compile(rb"(%s(?: mm)?, ?%s(?: mm)?)" % (_LENGTH, _LENGTH))),
    b"OFFSET": ("offset", re.compile(rb"(-?%s(?: mm)?)" % _LENGTH)),
    b"DENSITY": ("density", re.compile(rb"(\d|1[0-5])")),
    b"SPEED": ("speed", re.compile(rb"(\d{1,2}(?:\.\d)?)")),
    b"DIRECTION": ("direction", re.compile(rb"([01](?:,[01])?)")),
    b"SHIFT": ("shift", re.compile(rb"(-?\d{1,3}(?:,-?\d{1,3})?)")),
    b"SET": ("", re.compile(rb"(?:CUTTER|PEEL|TEAR|RIBBON|REPRINT) (?:ON|OFF|BATCH|\d{1,5})")),
}
"""Commands that lay nothing: what they are called in a frame's report, and their parameters."""
SIZE = re.compile(rb"(?:(\d{1,5}) dot, ?(\d{1,5}) dot|%s(?: mm)?, ?%s(?: mm)?)" % (_LENGTH, _LENGTH))
REFERENCE = re.compile(rb"(\d{1,5}), ?(\d{1,5})")
PRINT = re.compile(rb"(\d{1,6})(?:, ?(\d{1,6}))?")
LINE = re.compile(rb"([^\r\n]{0,80})\r?\n")


class Decoder(Labels):
    """The labels of a stream. A label whose SIZE is in dots is that wide and high; another (its dots
    a millimetre are not said) is what its bitmaps need. The label stays until CLS: PRINT may repeat it.
    """

    def frames(self) -> list[Frame]:
        reader = self.reader
        while reader.left:
            place = reader.place
            if reader.peek(1).isspace():
                reader.take(1, "a command")
            elif reader.peek(3) == Tspl.status_query:
                reader.take(3, "a command")
            elif reader.peek(7) in (b"BITMAP ", b"BITMAP,"):
                reader.take(6, "a command")
                self._bitmap(place)
            else:
                self._line(place)
        if not reader.data.strip():
            reader.fail("a TSPL command expected")
        return self.made

    def _line(self, place: int) -> None:
        found = LINE.match(self.reader.data, place)
        if not found:
            self.reader.fail("a command that ends with its line expected")
        name, _, rest = found[1].partition(b" ")
        rest = rest.strip()
        if name == b"CLS" and not rest:
            self.laid = []
        elif name == b"SIZE":
            size = self._match(SIZE, rest, place)
            self.size = int(size[1] or 0), int(size[2] or 0)
        elif name == b"REFERENCE":
            home = self._match(REFERENCE, rest, place)
            self.home = int(home[1]), int(home[2])
        elif name == b"PRINT":
            count = self._match(PRINT, rest, place)
            self.print(int(count[1]) * int(count[2] or 1), "PRINT", place)
        elif name in SETTINGS:
            key, pattern = SETTINGS[name]
            value = self._match(pattern, rest, place)
            if key:
                self.settings[key] = int(value[1]) if value[1].isdigit() else value[1].decode()
        else:
            self.reader.fail(f"unknown command {name[:20]!r}")
        self.reader.place = found.end()

    def _match(self, pattern: re.Pattern[bytes], text: bytes, place: int) -> re.Match[bytes]:
        found = pattern.fullmatch(text)
        if not found:
            self.reader.fail(f"parameters {text[:20]!r}", place)
        return found

    def _bitmap(self, place: int) -> None:
        reader = self.reader
        found = BITMAP.match(reader.data, reader.place)
        if not found:
            reader.fail("BITMAP with five numbers and mode 0 or 1 expected")
        self.lay(found, place, over=found[5] == b"0")
