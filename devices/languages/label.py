"""Labels on which images are laid at places, as the decoders of label printers need them."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from devices.languages.reader import Reader, Sheet
from halftone.frame import Frame
from halftone.packing import bytes_per_row

__all__ = ["Image", "Labels", "Rows", "compose", "fewest"]

Rows = NDArray[np.uint8]
"""Packed rows (n, bytes a row), 1 = ink."""


class Image(NamedTuple):
    """Packed rows at a place on a label. offset : of their command. over : paper covers what lies
    below, otherwise only ink is laid."""

    x: int
    y: int
    offset: int
    rows: Rows
    over: bool = False


def compose(
    reader: Reader, laid: list[Image], size: tuple[int, int], limit: int, place: int | None
) -> Sheet:
    """A label of *size* (width, height; 0 is what the images need) with its images laid one by one.

    Ink outside of it is an error at the image's command; more pixels than *limit* one at *place*.
    """
    width = size[0] or max(image.x + 8 * image.rows.shape[1] for image in laid)
    height = size[1] or max(image.y + len(image.rows) for image in laid)
    sheet = Sheet(reader, limit)
    sheet.check(width, height, place)
    label = np.zeros((height, bytes_per_row(width, 1)), np.uint8)
    for x, y, offset, rows, over in laid:
        below, right = max(0, height - y), max(0, label.shape[1] - x // 8)
        ink = _shifted(rows, x % 8)
        if ink[below:].any() or ink[:, right:].any():
            reader.fail(f"ink outside of the label of {width} × {height} dots", offset)
        inside = label[y : y + len(ink), x // 8 : x // 8 + ink.shape[1]]
        if over:
            inside &= ~_shifted(np.full_like(rows, 255), x % 8)[:below, :right]
        inside |= ink[:below, :right]
    sheet.add(label, width, place)
    return sheet


def _shifted(rows: Rows, dots: int) -> Rows:
    """*rows* moved to the right by 0 … 7 dots."""
    if not dots:
        return rows
    wide = np.zeros((len(rows), rows.shape[1] + 1), np.uint8)
    wide[:, :-1] = rows >> dots
    wide[:, 1:] |= rows << (8 - dots)
    return wide


def fewest(rows: int, size: int) -> int:
    """The fewest pixels that need *rows* of *size* bytes."""
    return rows * (8 * size - 7)


class Labels:
    """The labels of a stream whose bitmaps lie as they are, 0 where a dot is burnt. They stay on the
    label until it is cleared: it may be printed again.

    size, home : of the label and of its origin in dots, 0 where nothing states them. pixels : of all
    bitmaps so far; left : that the labels to come may have.
    """

    def __init__(self, language: str, data: bytes, limit: int) -> None:
        self.reader, self.limit, self.left = Reader(language, data), limit, limit
        self.size, self.home, self.pixels = (0, 0), (0, 0), 0
        self.settings: dict[str, object] = {}
        self.laid: list[Image] = []
        self.made: list[Frame] = []

    def lay(self, found: re.Match[bytes], place: int, over: bool = False) -> None:
        """A bitmap; the first numbers *found* are its x, y, bytes a row and rows, which follow them."""
        reader = self.reader
        x, y, size, height = (int(found[i]) for i in range(1, 5))
        if not size or not height:
            reader.fail("a bitmap without dots", found.start(3))
        self.pixels += fewest(height, size)
        if self.pixels > self.limit:
            reader.fail(f"bitmaps of more than {self.limit} pixels", place)
        reader.place = found.end()
        rows = np.frombuffer(reader.take(size * height, "rows"), np.uint8).reshape(height, size)
        self.laid.append(Image(self.home[0] + x, self.home[1] + y, place, ~rows, over))

    def print(self, copies: int, command: str, place: int) -> None:
        """The label as it is now, by the command at *place*."""
        if not copies:
            self.reader.fail("0 copies", place)
        if not self.laid:
            self.reader.fail(f"{command} without a bitmap", place)
        sheet = compose(self.reader, self.laid, self.size, self.left, place)
        self.left -= sheet.width * sheet.height
        self.made.append(sheet.frame(None, copies=copies, **self.settings))
