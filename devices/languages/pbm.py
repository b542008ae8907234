"""PBM (netpbm, raw form P4): the plainest stream of black and white rows, one picture after another.

Source: the format's manual page, https://netpbm.sourceforge.net/doc/pbm.html.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import partial

from devices.languages.base import LIMIT, Language, Page, Piece
from devices.languages.reader import Reader, Sheet
from halftone.errors import UsageError
from halftone.frame import Frame
from halftone.packing import bytes_per_row

__all__ = ["Pbm"]

BYTES = 1 << 16
"""Bytes of rows in a piece."""
SPACE = b" \t\n\v\f\r"


@dataclass(frozen=True)
class Pbm(Language):
    """PBM."""

    name = "pbm"
    title = "PBM, netpbm's bilevel pictures"
    media_type = "image/x-portable-bitmap"
    widest = 1 << 24

    def encode(self, pages: Iterable[Page]) -> Iterator[Piece]:
        for page in pages:
            if page.copies > 1 or page.density is not None:
                raise UsageError("pbm knows no copies and no density")
            size = bytes_per_row(page.width, 1)
            head = f"P4\n{page.width} {page.height}\n".encode()
            left = page.height
            for rows in page.bands(max(1, BYTES // size)):
                left -= len(rows)
                close = partial(bytes, left * size)  # the rows that are missing, as paper
                yield Piece(head + rows.tobytes(), len(rows), len(head), size, close)
                head = b""

    @classmethod
    def decode(cls, data: bytes, limit: int = LIMIT) -> list[Frame]:
        reader = Reader(cls.name, data)
        frames: list[Frame] = []
        while reader.left or not frames:
            reader.expect(b"P4", "'P4'")
            width, height = _number(reader, "width"), _number(reader, "height")
            reader.take(1, "white space")
            sheet = Sheet(reader, limit)
            sheet.check(width, height)
            start = reader.place
            sheet.add_bytes(reader.take(height * bytes_per_row(width, 1), "rows"), width, start)
            limit -= width * height
            frames.append(sheet.frame())
        return frames

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        return head[:2] == b"P4" and head[2:3] in (b"#", *(SPACE[i : i + 1] for i in range(6)))


def _number(reader: Reader, what: str) -> int:
    """A decimal number after white space and comments."""
    if reader.peek(1) not in (b"#",) and reader.peek(1).strip(SPACE):
        reader.fail(f"white space before the {what} expected")
    while reader.left and (reader.peek(1) == b"#" or not reader.peek(1).strip(SPACE)):
        if reader.byte(what) == ord("#"):
            while reader.byte("a comment") not in b"\r\n":
                pass
    digits = b""
    while reader.peek(1).isdigit() and len(digits) < 10:
        digits += reader.take(1, what)
    if not digits or not int(digits):
        reader.fail(f"{what} of at least 1 expected")
    return int(digits)
