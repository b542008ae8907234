"""Reading a byte stream strictly: every failure names the offset of what is wrong."""

from __future__ import annotations

from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from devices.errors import ProtocolError
from devices.languages.base import INK
from halftone.frame import Frame
from halftone.packing import bytes_per_row, unpack
from halftone.tone.levels import Levels

__all__ = ["Reader", "Sheet"]


class Reader:
    """A place in *data* that moves forward only."""

    def __init__(self, language: str, data: bytes, place: int = 0) -> None:
        self.language, self.data, self.place = language, data, place

    @property
    def left(self) -> int:
        return len(self.data) - self.place

    def fail(self, what: str, offset: int | None = None) -> NoReturn:
        raise ProtocolError(self.language, self.place if offset is None else offset, what)

    def peek(self, size: int) -> bytes:
        """Up to *size* bytes that are not taken."""
        return self.data[self.place : self.place + size]

    def take(self, size: int, what: str) -> bytes:
        """The next *size* bytes, of *what*; fails at the end of the stream if it has fewer."""
        if size > self.left:
            self.fail(f"{what}: {size} bytes expected, {self.left} left", len(self.data))
        self.place += size
        return self.data[self.place - size : self.place]

    def byte(self, what: str) -> int:
        return self.take(1, what)[0]

    def little(self, size: int, what: str) -> int:
        """An unsigned number, low byte first."""
        return int.from_bytes(self.take(size, what), "little")

    def big(self, size: int, what: str) -> int:
        """An unsigned number, high byte first."""
        return int.from_bytes(self.take(size, what), "big")

    def expect(self, allowed: bytes, what: str) -> None:
        """Take *allowed*, or fail where the stream first differs from it."""
        got = self.peek(len(allowed))
        if got != allowed:
            same = next(
                (i for i, (a, b) in enumerate(zip(got, allowed, strict=False)) if a != b), len(got)
            )
            self.fail(f"{what} expected", self.place + same)
        self.place += len(allowed)


class Sheet:
    """Rows of dots that a decoder lays on a page, 1 = ink; grows downwards up to a limit of pixels."""

    def __init__(self, reader: Reader, limit: int) -> None:
        self.reader, self.left = reader, limit
        self.parts: list[NDArray[np.uint8]] = []
        self.width = self.height = 0

    def check(self, width: int, height: int, offset: int | None = None) -> None:
        """Refuse *height* more rows of *width* dots if the page would have more pixels than allowed."""
        if max(self.width, width) * (self.height + height) > self.left:
            self.reader.fail(f"a page of more than {self.left} pixels", offset)

    def add(self, packed: NDArray[np.uint8], width: int, offset: int | None = None) -> None:
        """Packed rows (n, bytes a row) below what is there; narrower rows have paper to their right."""
        self.check(width, len(packed), offset)
        spare = -width % 8
        if spare and packed.size and (packed[:, -1] & ((1 << spare) - 1)).any():
            self.reader.fail("ink to the right of the last dot", offset)
        self.parts.append(packed)
        self.width, self.height = max(self.width, width), self.height + len(packed)

    def add_bytes(self, data: bytes, width: int, offset: int | None = None) -> None:
        """As :meth:`add`, for the bytes of whole rows."""
        size = bytes_per_row(width, 1)
        self.add(np.frombuffer(data, np.uint8).reshape(-1, size), width, offset)

    def frame(self, dpi: tuple[float, float] | None = None, **report: object) -> Frame:
        """The page as level indices: 0 where there is ink, 1 where there is paper."""
        size = bytes_per_row(self.width, 1)
        packed = np.zeros((self.height, size), np.uint8)
        top = 0
        for part in self.parts:
            packed[top : top + len(part), : part.shape[1]] = part
            top += len(part)
        indices = unpack(packed, self.width, INK)
        return Frame(indices, Levels.of(2), "", dpi, INK, dict(report))
