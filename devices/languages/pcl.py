"""PCL 5: raster graphics for laser printers, each row in the compression that makes it shortest.

Sources: HP, PCL 5 Printer Language Technical Reference Manual, chapter 15 (raster graphics: the seed
row is set by every row whatever its mode, and zeroed by a vertical offset and at the start); PJL
Technical Reference Manual (universal exit language).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from devices.languages.base import LIMIT, Language, Page, Piece
from devices.languages.packbits import packed_rows
from halftone.errors import UsageError
from halftone.frame import Frame
from halftone.packing import bytes_per_row

__all__ = ["MODES", "RESOLUTIONS", "UEL", "Pcl"]

RESOLUTIONS = (75, 100, 150, 200, 300, 600, 1200)
"""Dots per inch that ``ESC * t # R`` may state; which of them a printer has is its own matter."""
MODES = ("best", "0", "2", "3")
UEL = b"\x1b%-12345X"
BYTES = 1 << 15
"""Bytes of a piece at most, but for a single row that is longer."""
COMMAND = len(b"\x1b*b3m32767W")

Rows = NDArray[np.uint8]


@dataclass(frozen=True)
class Pcl(Language):
    """PCL 5.

    mode : of compression: 0 plain, 2 PackBits, 3 what has changed since the row before, or best,
    the shortest of them for each row. dpi : of pages that do not say theirs. pjl : whether the job
    begins and ends with the universal exit language and names PCL to the printer's job language.
    """

    mode: str = "best"
    dpi: int = 300
    pjl: bool = False

    name = "pcl"
    title = "PCL 5, laser printers"
    media_type = "application/vnd.hp-pcl"
    native_copies = True
    widest = 32_767

    def __post_init__(self) -> None:
        if self.mode not in MODES:
            raise UsageError(f"pcl: mode '{self.mode}'; allowed: {', '.join(MODES)}")
        _resolution((self.dpi, self.dpi))

    def encode(self, pages: Iterable[Page]) -> Iterator[Piece]:
        head = UEL + b"@PJL ENTER LANGUAGE=PCL\r\n" if self.pjl else b""
        head += b"\x1bE"
        tail = b"\x1bE" + (UEL if self.pjl else b"")
        close = partial(bytes, b"\x1b*rC\f" + tail)
        for page in pages:
            begin = head + self._begin(page)
            size = bytes_per_row(page.width, 1)
            coder = _Coder(self.mode, size)
            left = page.height
            for rows in page.bands(max(1, BYTES // (COMMAND + size + (size + 7) // 8))):
                left -= len(rows)
                data = begin + coder.code(rows)
                if left:
                    yield Piece(data, len(rows), close=close)
                else:
                    yield Piece(data + b"\x1b*rC\f", len(rows), close=partial(bytes, tail))
                begin = b""
            head = b""
        yield Piece(head + tail)

    def _begin(self, page: Page) -> bytes:
        """What comes before the rows of a page: its copies, no margins, and its raster's size."""
        if page.density is not None or page.cut:
            raise UsageError("pcl knows no density and no cutter")
        if page.width > self.widest or page.height > self.widest:
            raise UsageError(
                f"a page of {page.width} × {page.height} dots; pcl states at most {self.widest}"
            )
        dpi = _resolution(page.dpi or (self.dpi, self.dpi))
        unit = f"\x1b&u{dpi}D" if dpi >= 600 else ""  # 600 and more are for printers that know it
        text = f"\x1b&l{page.copies}x0l0E{unit}\x1b*p0x0Y\x1b*t{dpi}R"
        return (text + f"\x1b*r0f{page.width}s{page.height}T\x1b*r1A").encode()

    @classmethod
    def decode(cls, data: bytes, limit: int = LIMIT) -> list[Frame]:
        from devices.languages._pcl_decode import decode

        return decode(data, limit)

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        return head.startswith((b"\x1bE", UEL, b"\x1b&l", b"\x1b*t"))


def _resolution(dpi: tuple[float, float]) -> int:
    if dpi[0] != dpi[1] or dpi[0] not in RESOLUTIONS:
        allowed = ", ".join(map(str, RESOLUTIONS))
        raise UsageError(f"pcl: {dpi[0]:g} × {dpi[1]:g} dpi; allowed, across and down alike: {allowed}")
    return int(dpi[0])


class _Coder:
    """The rows of one raster as commands; remembers the row before and the mode that is set."""

    def __init__(self, mode: str, size: int) -> None:
        self.allowed = [0, 2, 3] if mode == "best" else [int(mode)]
        self.seed = np.zeros(size, np.uint8)
        self.mode: int | None = None

    def code(self, rows: Rows) -> bytes:
        """Commands for *rows*; blank ones, which leave a blank seed row either way, are moved over."""
        bodies = {mode: BODIES[mode](rows, self.seed) for mode in self.allowed}
        self.seed = rows[-1].copy()
        parts: list[bytes] = []
        blank = 0
        darkest: Rows = rows.max(axis=1)
        for r, ink in enumerate(darkest.tolist()):
            if not ink:
                blank += 1
                continue
            if blank:
                parts.append(b"\x1b*b%dY" % blank)
                blank = 0
            best, least = -1, 1 << 30
            for mode, (_, starts) in bodies.items():
                cost = starts[r + 1] - starts[r] + (0 if mode == self.mode else 2)
                if cost < least:
                    best, least = mode, cost
            data, starts = bodies[best]
            body = data[starts[r] : starts[r + 1]]
            if best == self.mode:
                parts.append(b"\x1b*b%dW%b" % (len(body), body))
            else:
                parts.append(b"\x1b*b%dm%dW%b" % (best, len(body), body))
                self.mode = best
        if blank:
            parts.append(b"\x1b*b%dY" % blank)
        return b"".join(parts)


def _plain(rows: Rows, seed: Rows) -> tuple[bytes, list[int]]:
    """Mode 0: the rows without the zeros at their end, and where each begins."""
    size = rows.shape[1]
    kept = size - (rows[:, ::-1] != 0).argmax(axis=1)
    kept[~rows.any(axis=1)] = 0
    lengths = np.concatenate([np.zeros(1, np.int64), kept])
    shown = np.arange(size) < kept[:, None]
    return rows[shown].tobytes(), lengths.cumsum().tolist()


def _packbits(rows: Rows, seed: Rows) -> tuple[bytes, list[int]]:
    return packed_rows(rows, trim=True)


def _delta(rows: Rows, seed: Rows) -> tuple[bytes, list[int]]:
    from devices.languages._delta_kernels import delta_rows

    n, size = rows.shape
    out = np.empty(n * (size + (size + 7) // 8), np.uint8)
    ends = np.zeros(n + 1, np.int64)
    delta_rows(np.ascontiguousarray(rows), seed, out, ends[1:])
    return out[: ends[-1]].tobytes(), ends.tolist()


BODIES = {0: _plain, 2: _packbits, 3: _delta}
