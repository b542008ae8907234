"""What every printer language is: pages to pieces of bytes, and bytes back to frames.

A language is a frozen dataclass whose fields are its options. It does no input or output and
remembers nothing: the same pages give the same bytes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from devices.status import Status
from halftone.errors import UsageError
from halftone.frame import Bands, Frame
from halftone.packing import Packing, bytes_per_row
from halftone.tone.levels import Levels

__all__ = ["INK", "LIMIT", "Language", "Page", "Piece"]

Rows = NDArray[np.uint8]

INK = Packing(1, "msb", (1, 0))
"""Bilevel printers: the leftmost dot in the highest bit, 1 burns a dot, spare bits are 0 (paper)."""

LIMIT = 1 << 28
"""Pixels that a decoder makes at most, unless it is told otherwise."""


def _nothing() -> bytes:
    return b""


@dataclass(frozen=True, eq=False)
class Page:
    """One picture on its way to a language.

    width, height : dots. rows : packed rows, uint8 (n, bytes a row), from the top, in bands of any
    height that together have *height* rows; they can be read once. levels : what they show.
    dpi : across and down. copies : how often it is printed. density : in the device's own numbers,
    None leaves it as it is. cut : whether to cut the paper after it.
    """

    width: int
    height: int
    rows: Iterable[Rows]
    levels: Levels
    dpi: tuple[float, float] | None = None
    copies: int = 1
    density: int | None = None
    cut: bool = False

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise UsageError(f"a page of {self.width} × {self.height} dots; allowed: 1 × 1 and more")
        if not 1 <= self.copies <= 9999:
            raise UsageError(f"{self.copies} copies; allowed: 1 … 9999")

    def bands(self, most: int, packing: Packing = INK) -> Iterator[Rows]:
        """The rows again, in bands of exactly *most* rows but for the last; checked and counted."""
        size, kept, held, done = bytes_per_row(self.width, packing.bits), [], 0, 0
        for given in self.rows:
            if given.ndim != 2 or given.shape[1] != size or given.dtype != np.uint8:
                raise UsageError(f"rows of shape {given.shape}, {given.dtype}; a row has {size} bytes")
            top = 0
            while top < len(given):
                taken = given[top : top + most - held]
                kept.append(taken)
                held, top, done = held + len(taken), top + len(taken), done + len(taken)
                if held == most:
                    yield kept[0] if len(kept) == 1 else np.concatenate(kept)
                    kept, held = [], 0
        if done != self.height:
            raise UsageError(f"a page of {self.height} rows was given {done}")
        if kept:
            yield kept[0] if len(kept) == 1 else np.concatenate(kept)


@dataclass(frozen=True)
class Piece:
    """Bytes that begin and end with a command of the language, and how to break off within them.

    data : the bytes. rows : the rows of the page they hold, 0 for commands.
    head, stride : where the rows begin and how many bytes each has, if they lie there as they are;
    stride 0 if they are compressed. paper : the byte of eight dots of paper.
    close : what the device needs after this piece, if nothing else will follow, to be done with the
    job and ready for the next; it is called only when a job is broken off.
    """

    data: bytes
    rows: int = 0
    head: int = 0
    stride: int = 0
    close: Callable[[], bytes] = _nothing
    paper: int = 0

    def accepted(self, sent: int) -> int:
        """Rows that *sent* bytes of the piece hold whole."""
        if self.stride:
            return min(self.rows, max(0, sent - self.head) // self.stride)
        return self.rows if sent >= len(self.data) else 0

    def abort(self, sent: int) -> bytes:
        """What follows the first *sent* bytes of the piece to complete its open command exactly, with
        paper where rows lie as they are, and to leave the device ready for the next job."""
        rest = self.data[sent:]
        if self.stride and rest:
            start = max(0, self.head - sent)  # what is still missing of the header
            end = self.head + self.rows * self.stride - sent
            blank = bytes([self.paper]) * max(0, end - start)
            rest = rest[:start] + blank + rest[max(0, end) :]
        return rest + self.close()


class Language(ABC):
    """A printer language or a raster file format."""

    name: ClassVar[str]
    title: ClassVar[str]
    media_type: ClassVar[str]
    widest: ClassVar[int] = 65_535
    """The most dots of a row that its headers can state."""
    native_copies: ClassVar[bool] = False
    """Whether it has a command for copies; where it has none, the caller sends the page again."""
    cuts: ClassVar[bool] = False
    """Whether it has a command that cuts the paper."""
    status_query: ClassVar[bytes] = b""
    """What asks the device how it is, between two commands; empty if the language has no such thing."""

    def packing(self, levels: Levels) -> Packing:
        """How rows of these levels are packed for it. Raises UsageError for levels it cannot show."""
        if len(levels) != 2:
            raise UsageError(f"{self.name} shows 2 levels, not {len(levels)}")
        return INK

    @abstractmethod
    def encode(self, pages: Iterable[Page]) -> Iterator[Piece]:
        """The job of these pages, piece by piece, reading rows only as pieces are asked for.

        The memory it takes is that of a piece and of a band. Raises UsageError for a page that the
        language cannot express.
        """

    @classmethod
    @abstractmethod
    def decode(cls, data: bytes, limit: int = LIMIT) -> list[Frame]:
        """The pages of a whole job: level indices, levels and dpi as far as the bytes say them.

        What else they say (copies, density, cut, …) is in each frame's report. limit : pixels of
        all pages; more are refused before they are made. Raises
        :class:`devices.errors.ProtocolError`, which names the offset of what is wrong.
        """

    @classmethod
    @abstractmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether a stream with this beginning (1 KiB is enough) is of this language."""

    def parse_status(self, reply: bytes) -> Status | None:
        """What the device answered to ``status_query``; None while the answer is not complete.

        Bytes that are no answer (noise, late answers) are passed over.
        """
        return None

    def unsolicited(self, received: bytes) -> Status | None:
        """What bytes that the device sent by itself say, or None if they say nothing."""
        return None


def encoded(language: Language, *frames: Frame | Bands) -> bytes:
    """The bytes of a job with these frames as pages."""
    pages = (page_of(language, frame) for frame in frames)
    return b"".join(piece.data for piece in language.encode(pages))


def page_of(
    language: Language,
    picture: Frame | Bands,
    *,
    copies: int = 1,
    density: int | None = None,
    cut: bool = False,
) -> Page:
    """*picture* as a page for *language*, packed band by band."""
    bands = picture.bands() if isinstance(picture, Frame) else picture
    packing = language.packing(bands.levels)
    height, width = bands.shape
    if width > language.widest:
        raise UsageError(f"{language.name} has rows of at most {language.widest} dots, not {width}")
    rows = (part.packed(packing) for part in bands)
    return Page(width, height, rows, bands.levels, bands.dpi, copies, density, cut)
