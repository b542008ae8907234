"""Pages as compressed lines: the pieces that PWG raster, CUPS raster and URF have in common."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from devices.languages._runs_kernels import pack_lines
from devices.languages.base import Page, Piece
from halftone.packing import Packing, bytes_per_row

__all__ = ["blank_lines", "longest_line", "pieces"]

BYTES = 1 << 15
"""Bytes, as they come and compressed, from which on a piece is complete."""


def longest_line(size: int, unit: int = 1) -> int:
    """The most bytes that a line of *size* can take, however badly it is compressed."""
    return 1 + size + size // unit


def pieces(head: bytes, page: Page, packing: Packing, paper: int) -> Iterator[Piece]:
    """*head* and the page's lines; *paper* is the byte of blank ones. Broken off, the rest is blank."""
    size = bytes_per_row(page.width, packing.bits)
    most = max(1, BYTES // size)
    last = np.empty(size, np.uint8)
    out = np.empty((most + 1) * (size + size // 128 + 2), np.uint8)
    state = np.zeros(3, np.int64)
    made, held, read, left = bytearray(head), 0, 0, page.height
    for rows in page.bands(most, packing):
        read += len(rows)
        pack_lines(np.ascontiguousarray(rows), last, out, state, int(read == page.height))
        made += out[: state[1]].data
        held += int(state[2])
        if len(made) >= BYTES or read == page.height:
            left -= held
            yield Piece(bytes(made), held, close=partial(blank_lines, left, size, paper))
            made, held = bytearray(), 0


def blank_lines(count: int, size: int, paper: int) -> bytes:
    """*count* lines of *size* bytes *paper*."""
    line = bytes([127, paper]) * (size // 128)
    if size % 128:
        line += bytes([size % 128 - 1, paper])
    made = (b"\xff" + line) * (count // 256)
    return made + bytes([count % 256 - 1]) + line if count % 256 else made
