"""ZPL II, the language of Zebra's label printers and of many others.

A page is one label, ``^XA … ^XZ``. Its rows are laid in graphic fields (``^GF``) below each other:
a field is limited to 99,999 bytes by the language, and each of them is a whole command, so that
memory is bounded and a job can be broken off between any two bytes.

Source: ZPL II Programming Guide (Zebra 45541L-004 and docs.zebra.com): ^GF, ^LL, ^PQ, ^PR, ~SD, ~HQ,
~HS, "Alternative Data Compression Scheme", "ZB64 Encoding".
"""

from __future__ import annotations

import base64
import binascii
import re
import zlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from devices.languages._acs_kernels import acs
from devices.languages.base import LIMIT, Language, Page, Piece, Rows
from devices.status import Status
from halftone.errors import UsageError, near
from halftone.frame import Frame
from halftone.packing import bytes_per_row

__all__ = ["Zpl"]

Ends = NDArray[np.int64]

MOST_BYTES = 99_999
"""Bytes of a graphic field."""
MOST_DOTS = 32_000
"""Dots to the end of a label across and down (^FO, ^LL)."""
LEVEL = 4
"""Of zlib: on halftones twice as fast as 6 and more, for a hundredth more bytes."""
DARKEST = 30
FASTEST = 14
MEDIA = {"": "", "continuous": "^MNN", "gap": "^MNY", "mark": "^MNM"}
NONE: Ends = np.zeros(0, np.int64)
HEADS = (b"^XA", b"~SD", b"~DG", b"~HQ", b"~HS", b"~HI", b"~TA", b"^MM", b"^FX")
"""What the streams that we know begin with."""


def _end() -> bytes:
    return b"^XZ\n"


@dataclass(frozen=True)
class Field(Piece):
    """A graphic field. ends : where the text of each row ends, if the rows lie in it one by one."""

    ends: Ends = field(default_factory=lambda: NONE, compare=False)

    def accepted(self, sent: int) -> int:
        if not len(self.ends):
            return super().accepted(sent)
        return int(np.searchsorted(self.ends, sent, "right"))

    def abort(self, sent: int) -> bytes:
        """The row that is under way to its end, then ``,`` (paper) for each further row. Compressed
        as a whole, only the rest of the field itself completes it."""
        done = self.accepted(sent)
        if not len(self.ends) or done == self.rows:
            return super().abort(sent)
        start = int(self.ends[done - 1]) if done else self.head
        stop = start
        if sent > start:
            stop, done = int(self.ends[done]), done + 1
        tail = self.data[int(self.ends[-1]) :]
        return self.data[sent:stop] + b"," * (self.rows - done) + tail + self.close()


def _acs(rows: Rows) -> tuple[bytes, Ends]:
    out = np.empty(2 * rows.size, np.uint8)
    ends = np.empty(len(rows), np.int64)
    acs(np.ascontiguousarray(rows), out, ends)
    return out[: ends[-1]].tobytes(), ends


def _hex(rows: Rows) -> tuple[bytes, Ends]:
    text = rows.tobytes().hex().upper().encode()
    return text, np.arange(1, len(rows) + 1) * (2 * rows.shape[1])


def _z64(rows: Rows) -> tuple[bytes, Ends]:
    text = base64.b64encode(zlib.compress(rows.tobytes(), LEVEL))
    return b":Z64:%s:%04X" % (text, binascii.crc_hqx(text, 0)), NONE


COMPRESSIONS: dict[str, Callable[[Rows], tuple[bytes, Ends]]] = {"acs": _acs, "hex": _hex, "z64": _z64}


@dataclass(frozen=True)
class Zpl(Language):
    """ZPL II.

    compression : ``acs`` (run lengths; every ZPL II printer knows it), ``hex`` (none), ``z64`` (zlib
    in base64 with a CRC; the shortest, but a field is accepted as a whole or not at all).
    max_bytes : of rows in a field before compression, 1 … 99,999; a longer row is a field for itself.
    x, y : where the picture begins on the label, in dots from its left and top edge.
    speed : inches a second, 1 … 14. media : ``continuous``, ``gap`` or ``mark`` tells the printer
    what is loaded. 0 and empty leave them as they are set.

    Width and height with *x* and *y* are at most 32,000 dots. A page's density is 0 … 30 (~SD).
    """

    name = "zpl"
    title = "ZPL II, Zebra and compatible label printers"
    media_type = "application/vnd.zebra-zpl"
    cuts = True
    native_copies = True
    widest = MOST_DOTS
    status_query = b"~HQES\n"

    compression: str = "acs"
    max_bytes: int = 32_768
    x: int = 0
    y: int = 0
    speed: int = 0
    media: str = ""

    def __post_init__(self) -> None:
        if self.compression not in COMPRESSIONS:
            raise UsageError(near(self.compression, COMPRESSIONS, "compression of 'zpl'"))
        if self.media not in MEDIA:
            raise UsageError(near(self.media, [m for m in MEDIA if m], "media of 'zpl'"))
        _within("max_bytes", self.max_bytes, 1, MOST_BYTES)
        _within("x", self.x, 0, MOST_DOTS - 1)
        _within("y", self.y, 0, MOST_DOTS - 1)
        _within("speed", self.speed, 0, FASTEST)

    def encode(self, pages: Iterable[Page]) -> Iterator[Piece]:
        cutting = False
        for page in pages:
            setup = self._setup(page)
            if page.cut or cutting:
                setup += "^MMC" if page.cut else "^MMT"
                cutting = page.cut
            yield Piece(f"{setup}\n".encode(), close=_end)
            size = bytes_per_row(page.width, 1)
            top = self.y
            for rows in page.bands(max(1, self.max_bytes // size)):
                head = b"^FO%d,%d^GFA,%d,%d,%d," % (self.x, top, rows.size, rows.size, size)
                text, ends = COMPRESSIONS[self.compression](rows)
                data = head + text + b"^FS\n"
                yield Field(data, len(rows), len(head), close=_end, ends=ends + len(head))
                top += len(rows)
            yield Piece(b"^PQ%d^XZ\n" % page.copies)

    def _setup(self, page: Page) -> str:
        """The beginning of a label. Where it lies and which way up is stated, because a printer keeps
        what other programs said of it (CUPS and LPrint turn labels by 180°)."""
        width, height = self.x + page.width, self.y + page.height
        _within("a label's width (picture and x)", width, 1, MOST_DOTS)
        _within("a label's height (picture and y)", height, 1, MOST_DOTS)
        setup = ""
        if page.density is not None:
            _within("density", page.density, 0, DARKEST)
            setup += f"~SD{page.density:02d}"
        setup += f"^XA^PON^LH0,0^PW{width}^LL{height}{MEDIA[self.media]}"
        if self.speed:
            setup += f"^PR{self.speed}"
        return setup

    @classmethod
    def decode(cls, data: bytes, limit: int = LIMIT) -> list[Frame]:
        from devices.languages._zpl_decode import Decoder

        return Decoder(cls.name, data, limit).frames()

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        return head.lstrip(b" \t\r\n")[:3] in HEADS

    def parse_status(self, reply: bytes) -> Status | None:
        """The last whole answer to ``~HQES`` (errors and warnings as bits) or ``~HS`` (three strings).

        A printer with an error need not answer ``~HS``; that is why ``~HQES`` is asked.
        """
        found = [*ERRORS_ANSWER.finditer(reply), *STATUS_ANSWER.finditer(reply)]
        if not found:
            return None
        last = max(found, key=lambda match: match.end())
        return _flags(last) if last.re is STATUS_ANSWER else _bits(last)


def _within(what: str, value: int, least: int, most: int) -> None:
    if not least <= value <= most:
        raise UsageError(f"zpl: {what} = {value}; allowed: {least} … {most}")


_WORD = rb"\s+([01])\s+[0-9A-Fa-f]{8}\s+([0-9A-Fa-f]{8})"
ERRORS_ANSWER = re.compile(rb"ERRORS:" + _WORD + rb"\s+WARNINGS:" + _WORD)
STATUS_ANSWER = re.compile(
    rb"\x02(\d{3}(?:,\d{1,5}){11})\x03\s*\x02(\d{3}(?:,\w{1,8}){10})\x03\s*\x02\w{1,8},\d\x03"
)
ERRORS = {
    0x00001: "media-empty-error",
    0x00002: "marker-supply-empty-error",
    0x00004: "cover-open-error",  # the head is open
    0x00008: "marker-failure-error",  # cutter
    0x00030: "fuser-over-temp-error",  # head, motor
    0x000C0: "marker-failure-error",  # a bad or undetected head
    0x00200: "marker-failure-error",  # thermistor
    0x0D000: "media-jam-error",  # clear paper path failed, paper feed, jam during retract
    0x20000: "media-jam-error",  # retract timed out
    0xC0000: "media-needed-error",  # no black mark, black mark calibration
    0x10000: "paused-error",
}
"""Bits of ~HQES's errors; others are faults without a name."""
WARNINGS = {0x8: "media-low-warning", 0x4: "marker-failure-warning", 0x3: "other-warning"}
"""Bits of ~HQES's warnings: paper low, replace the head, clean it or calibrate; others are sensors."""
FLAGS = (
    (1, "media-empty-error"),
    (2, "paused-error"),
    (5, "spool-area-full-report"),
    (9, "other-error"),  # settings lost
    (10, "other-warning"),  # too cold
    (11, "fuser-over-temp-error"),
    (14, "cover-open-error"),
    (15, "marker-supply-empty-error"),
)
"""Which of the 12 + 11 values of ~HS's first two strings is a flag of what."""


def _bits(answer: re.Match[bytes]) -> Status:
    reasons = set()
    for flag, word, names, rest in (
        (answer[1], answer[2], ERRORS, "other-error"),
        (answer[3], answer[4], WARNINGS, ""),
    ):
        bits = int(word, 16)
        reasons |= {reason for mask, reason in names.items() if bits & mask}
        unknown = bits & ~sum(names)
        if rest and (unknown or (flag == b"1" and not bits)):
            reasons.add(rest)
    return Status(frozenset(reasons))


def _flags(answer: re.Match[bytes]) -> Status:
    values = answer[1].split(b",") + answer[2].split(b",")
    return Status(frozenset(reason for i, reason in FLAGS if values[i].strip(b"0")))
