"""PWG raster, CUPS raster and URF as they arrive: page after page, in bands of rows, strictly.

Memory is that of a band and of two lines, however long the page. Sources: spec-raster.html of CUPS;
PWG 5102.4-2012; for URF, cups/raster-stream.c.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from devices.languages._runs_kernels import FULL, LINES, LONG, unpack_lines
from devices.languages.base import INK
from devices.languages.raster_start import Opened, Space, opened, page_header
from devices.languages.runs import longest_line
from halftone.frame import Frame
from halftone.packing import Packing, unpack
from halftone.tone.levels import Levels

__all__ = ["RasterPage", "frames", "pages"]

Rows = NDArray[np.uint8]

BAND = 1 << 18
"""Bytes of a band."""
LONG_LINE = 1 << 16
"""Bytes of a line from which on it is not tried again with every few bytes that come."""


@dataclass(eq=False)
class RasterPage:
    """A page whose rows are still to be read.

    header : all fields by CUPS's names (:data:`devices.languages.raster_header.PAGE`), for URF those
    that it has an equivalent of. offset : where it lies in the stream. space : what the
    pixels are. bits : 1, 8 or 24 a pixel. dpi : across and down, None if it does not say.
    """

    header: dict[str, Any]
    offset: int
    space: Space
    bits: int
    width: int
    height: int
    dpi: tuple[float, float] | None
    _stream: Opened = field(repr=False)
    _left: int = field(init=False, repr=False)
    _state: NDArray[np.int64] = field(init=False, repr=False)
    _line: Rows = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._left = self.height
        self._state = np.zeros(5, np.int64)
        self._line = np.zeros(self.size if self._stream.compressed else 0, np.uint8)

    @property
    def size(self) -> int:
        """Bytes of a row."""
        return (self.width * self.bits + 7) // 8

    def bands(self, rows: int | None = None) -> Iterator[Rows]:
        """The rows that were not read yet, uint8 (n, bytes of a row), *rows* at a time.

        As they are in the stream: bits from the highest on, pixels of three bytes. Raises
        :class:`devices.errors.ProtocolError`.
        """
        most = rows or max(1, BAND // self.size)
        while self._left:
            count = min(most, self._left)
            band = self._unpacked(count) if self._stream.compressed else self._raw(count)
            self._left -= count
            yield band

    def _raw(self, count: int) -> Rows:
        data = self._stream.source.take(count * self.size, "rows")
        return np.frombuffer(data, np.uint8).reshape(count, self.size)

    def _unpacked(self, count: int) -> Rows:
        source, state = self._stream.source, self._state
        unit = max(1, self.bits // 8)
        band = np.empty((count, self.size), np.uint8)
        state[1], wanted = 0, 1
        while True:
            state[0] = 0
            data = np.frombuffer(source.peek(wanted), np.uint8)
            unpack_lines(data, band, self._line, state, unit, self.space.paper, self._left)
            why, fault = int(state[3]), int(state[4])
            if why == LONG:
                source.fail("pixels beyond the end of the line", source.place + fault)
            if why == LINES:
                source.fail("lines beyond the end of the page", source.place + fault)
            source.skip(int(state[0]))
            if why == FULL:
                return band
            short = len(data) - int(state[0])
            if source.ended:
                source.fail(f"{self._left - int(state[1])} lines are missing", source.place + short)
            wanted = short + 1  # of a pipe no more than is needed, of a long line twice as much
            if short > LONG_LINE:
                wanted = max(wanted, min(2 * short, longest_line(self.size, unit)))


def pages(
    read: Callable[[int], bytes], language: str | None = None, limit: int | None = None
) -> Iterator[RasterPage]:
    """The pages of a stream of which *read* gives up to so many bytes, none at its end.

    Rows that were not read of a page are passed over when the next is asked for.
    language : ``pwg``, ``cups-raster`` or ``urf``, if it may be only that. limit : pixels
    that the pages may have together.

    Raises :class:`devices.errors.ProtocolError` with the offset of what is wrong, or not read here:
    more than 8 bits a colour, and colour spaces other than black, gray and RGB.
    """
    stream = opened(read, language)
    source, seen = stream.source, 0
    while source.peek(1):
        offset = source.place
        header = page_header(stream, seen)
        page = RasterPage(header.values, offset, *header.picture, stream)
        if limit is not None:
            limit -= page.width * page.height
            if limit < 0:
                source.fail("more pixels than allowed", header.where("cupsHeight"))
        seen += 1
        yield page
        for _ in page.bands():
            pass
    if stream.total and seen != stream.total:
        source.fail(f"{seen} of {stream.total} pages")
    if not seen:
        source.fail("a page expected")


def frames(data: bytes, language: str, limit: int) -> list[Frame]:
    """All pages as level indices. Gray codes that are only black and white become two levels."""
    return [_frame(page, language) for page in pages(BytesIO(data).read, language, limit)]


def _frame(page: RasterPage, language: str) -> Frame:
    if page.bits == 24:
        page._stream.source.fail("pages in colour have no level indices", page.offset)
    ink = page.space.paper == 0
    indices = np.empty((page.height, page.width), np.uint8)
    top = 0
    for band in page.bands():
        part = unpack(band, page.width, INK if ink else Packing(1)) if page.bits == 1 else band
        indices[top : top + len(part)] = ~part if ink and page.bits == 8 else part
        top += len(part)
    count = 2 if page.bits == 1 else 256
    if count == 256 and not ((indices + np.uint8(1)) > 1).any():
        indices >>= 7
        count = 2
    packing = INK if page.bits == 1 else Packing(8)
    said = {name: value for name, value in page.header.items() if np.any(np.array(value, object))}
    report = {"copies": said.get("NumCopies", 0), "cut": "CutMedia" in said, "header": said}
    return Frame(indices, Levels.of(count), "", page.dpi, packing, report)
