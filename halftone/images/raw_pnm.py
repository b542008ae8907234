"""PBM, PGM and PPM in their raw forms, P4, P5 and P6 (netpbm), read a few rows at a time.

OpenImageIO reads such a file whole, and rounds values down where its maxval is not 255 or 65535.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from io import BufferedReader
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone.errors import InputFileError
from halftone.images.rows import piece_rows

__all__ = ["RawPnm", "raw_pnm"]

_GAP = rb"(?:\s|#[^\n\r]*[\n\r])+"
_SIZE = (_GAP + rb"(\d{1,9})") * 2
_HEADER = re.compile(rb"P(?:4|([56]))" + _SIZE + rb"(?(1)" + _GAP + rb"(\d{1,5}))\s")
_CHANNELS = {b"P4": 1, b"P5": 1, b"P6": 3}


@dataclass(frozen=True)
class RawPnm:
    """What a file's header says; *start* is the place of its first row."""

    kind: bytes
    width: int
    height: int
    maxval: int
    start: int

    @property
    def channels(self) -> int:
        return _CHANNELS[self.kind]

    @property
    def table(self) -> NDArray[Any] | None:
        """Codes over the full range of their type for the values, None where these are such codes.

        Exact: where no whole multiple of a value is its code, codes have 16 bits.
        """
        full = 255 if self.maxval < 256 else 65535
        if self.maxval == full:
            return None
        values = np.minimum(np.arange(full + 1), self.maxval)
        if full % self.maxval:
            return np.rint(values * (65535 / self.maxval)).astype(np.uint16)
        return (values * (full // self.maxval)).astype(np.uint8 if full == 255 else np.uint16)

    @property
    def dtype(self) -> np.dtype[Any]:
        table = self.table
        return np.dtype(np.uint8 if self.maxval < 256 else np.uint16) if table is None else table.dtype

    def pieces(self, path: str, name: str) -> Iterator[NDArray[Any]]:
        """Consecutive rows (n, width, channels) as codes; InputFileError where they end too soon."""
        samples = self.width * self.channels
        stored = np.dtype(np.uint8 if self.maxval < 256 else ">u2")
        size = -(-self.width // 8) if self.kind == b"P4" else samples * stored.itemsize
        table = self.table
        step = piece_rows(self.width, 64)
        with _opened(path, name) as file:
            file.seek(self.start)
            there = (os.fstat(file.fileno()).st_size - self.start) // size
            if there < self.height:
                raise InputFileError(f"{name} is damaged or cut off: it ends in row {there}")
            for top in range(0, self.height, step):
                rows = np.empty((min(step, self.height - top), size), np.uint8)
                if file.readinto(rows.data) != rows.size:
                    raise InputFileError(f"{name} is damaged or cut off: it became shorter")
                if self.kind == b"P4":
                    bits = np.unpackbits(rows, axis=1, count=self.width)
                    codes: NDArray[Any] = np.subtract(bits, 1, out=bits)  # 1 is black
                else:
                    codes = rows.view(stored)
                    if table is not None:
                        codes = np.take(table, codes)
                    elif stored.itemsize == 2:
                        codes = codes.astype(np.uint16)
                yield codes.reshape(-1, self.width, self.channels)


def _opened(path: str, name: str) -> BufferedReader:
    try:
        return open(path, "rb")
    except OSError as error:  # it was there when its header was read
        raise InputFileError(f"{name} cannot be read: {error.strerror}") from None


def raw_pnm(head: bytes) -> RawPnm | None:
    """The header of a raw PNM from the first KiB of a file, None for any other file."""
    found = _HEADER.match(head)
    if found is None:
        return None
    width, height, maxval = int(found[2]), int(found[3]), int(found[4] or 255)
    if not (width and height and 1 <= maxval <= 65535):
        return None
    return RawPnm(head[:2], width, height, maxval, found.end())
