"""PCL's rasters as they are read: rows restored from their compression, laid on a page."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from devices.languages.base import INK
from devices.languages.packbits import unpacked
from devices.languages.reader import Reader
from halftone.frame import Frame
from halftone.tone.levels import Levels

__all__ = ["Raster", "compose", "restored"]

CHUNK = 1 << 20
"""Bytes of rows that are laid on the page at a time."""


@dataclass
class Raster:
    """Rows with their top left corner at the dot (x, y) of the page, *dpi* dots in an inch.

    width, height : as stated, or None. rows : number and bytes of those that were sent.
    next : how many rows there are so far. seed : the last of them. longest : bytes of the longest.
    """

    x: int
    y: int
    dpi: int
    width: int | None
    height: int | None
    rows: list[tuple[int, bytes]] = field(default_factory=list)
    next: int = 0
    seed: bytes = b""
    longest: int = 0

    def add(self, row: bytes) -> bool:
        """A row below the others; whether all of its ink lies within the width that is stated."""
        if self.width is not None:
            size, spare = (self.width + 7) // 8, -self.width % 8
            if any(row[size:]) or (spare and len(row) >= size and row[size - 1] & (1 << spare) - 1):
                return False
            row = row[:size]
        self.rows.append((self.next, row))
        self.next += 1
        self.seed = row
        self.longest = max(self.longest, len(row))
        return True

    def skip(self, count: int) -> None:
        """Leave rows blank, which makes a blank row the last one."""
        self.next += count
        self.seed = b""

    @property
    def right(self) -> int:
        """The first column of the page to the right of it."""
        return self.x + (8 * self.longest if self.width is None else self.width)

    @property
    def bottom(self) -> int:
        """How many rows it has; those that a stated height has and that were not sent are blank."""
        return self.next if self.height is None else self.height


def restored(reader: Reader, mode: int, size: int, seed: bytes, most: int) -> bytes:
    """The row that the next *size* bytes of the reader hold, of at most *most* bytes.

    mode : 0 plain, 1 pairs of a count less one and a byte, 2 PackBits, 3 changes to *seed*.
    """
    if mode == 2:
        return unpacked(reader, size, most)
    start = reader.place
    data = reader.take(size, "a row")
    if mode == 3:
        return _changed(reader, start, data, seed, most)
    if mode == 1:
        if size % 2:
            reader.fail("a count without a byte", start + size - 1)
        if sum(data[::2]) + size // 2 > most:
            reader.fail(f"a row of more than {most} bytes", start)
        return b"".join(data[i + 1 : i + 2] * (data[i] + 1) for i in range(0, size, 2))
    if size > most:
        reader.fail(f"a row of more than {most} bytes", start)
    return data


def _changed(reader: Reader, start: int, data: bytes, seed: bytes, most: int) -> bytes:
    """A delta row: *seed* with the replacements of its commands."""
    if not data:
        return seed
    row, place, x = bytearray(seed), 0, 0
    while place < len(data):
        command = place
        count, skip = (data[place] >> 5) + 1, data[place] & 31
        place += 1
        x += skip
        more = 255 if skip == 31 else 0
        while more == 255 and place < len(data):
            more = data[place]
            x += more
            place += 1
        if more == 255 or place + count > len(data):
            reader.fail("a change that the row ends within", start + command)
        if x + count > most:
            reader.fail(f"a row of more than {most} bytes", start + command)
        if x + count > len(row):
            row += bytes(x + count - len(row))
        row[x : x + count] = data[place : place + count]
        place += count
        x += count
    return bytes(row)


def compose(reader: Reader, rasters: list[Raster], limit: int, offset: int, copies: int) -> Frame:
    """The page with these rasters, from its top left corner to their furthest edges."""
    width = max((raster.right for raster in rasters), default=0)
    height = max((raster.y + raster.bottom for raster in rasters), default=0)
    if not width or not height:
        reader.fail("a page without a picture", offset)
    if width * height > limit:
        reader.fail(f"a page of more than {limit} pixels", offset)
    dpi = rasters[0].dpi
    if any(raster.dpi != dpi for raster in rasters):
        reader.fail("a page with rasters of several resolutions", offset)
    paper = np.ones((height, width), np.uint8)
    for raster in rasters:
        _lay(raster, paper)
    return Frame(paper, Levels.of(2), "", (float(dpi), float(dpi)), INK, {"copies": copies})


def _lay(raster: Raster, paper: NDArray[np.uint8]) -> None:
    """Burn the dots of *raster*: 0 where there is ink, what is below stays."""
    size = max(raster.longest, 1)
    width = raster.right - raster.x
    step = max(1, CHUNK // size)
    for first in range(0, len(raster.rows), step):
        part = raster.rows[first : first + step]
        joined = b"".join(row.ljust(size, b"\0") for _, row in part)
        dots = np.unpackbits(np.frombuffer(joined, np.uint8).reshape(-1, size), axis=1)
        dots = dots[:, :width]
        rows = raster.y + np.array([number for number, _ in part])
        paper[rows, raster.x : raster.x + dots.shape[1]] &= dots ^ 1
