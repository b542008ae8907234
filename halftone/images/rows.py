"""Rows of a picture file that is read forward: an array of which only a window is held."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone.errors import InputFileError

__all__ = ["LOOK_BACK", "Rows", "Window", "piece_rows"]

Codes = NDArray[Any]

LOOK_BACK = 384
"""Rows kept behind the last one read: a strip of 256 and two bands (curves, warm starts, dots)."""

PIECE_PIXELS = 1 << 21
"""Pixels read in one call, but at least a row: Ctrl-C is heard between two calls."""


def piece_rows(width: int, most: int) -> int:
    """Rows of *width* pixels to handle at a time, 1 … *most*."""
    return max(1, min(most, PIECE_PIXELS // width))


class Window:
    """The last rows of a file, (n, N, C), for any number of threads.

    open : starts at the top and gives consecutive pieces of rows; it is called anew when rows are
    asked for that were let go, so that a second pass needs no code of its own.
    keep : how many rows are held at least, behind the last one read.
    seconds : spent reading so far.
    """

    def __init__(self, open: Callable[[], Iterator[Codes]], height: int, keep: int) -> None:
        self.height, self.keep = height, keep
        self.seconds = 0.0
        self._open = open
        self._lock = threading.Lock()
        self._pieces: deque[tuple[int, Codes]] = deque()
        self._next = 0
        self._file: Iterator[Codes] = iter(())
        self._trouble = ""  # what stopped the reading: the same for every thread that comes to it

    def rows(self, start: int, stop: int) -> Codes:
        """Rows start … stop−1, not to be changed."""
        with self._lock:
            begin = time.perf_counter()
            try:
                return self._rows(start, stop)
            finally:
                self.seconds += time.perf_counter() - begin

    def _rows(self, start: int, stop: int) -> Codes:
        if self._next == 0 or (self._pieces and start < self._pieces[0][0]):
            self._pieces.clear()
            self._next = 0
            self._file = self._open()
        while self._next < stop:
            piece = self._piece()
            self._pieces.append((self._next, piece))
            self._next += len(piece)
            needed = min(start, self._next - self.keep)
            while self._pieces[0][0] + len(self._pieces[0][1]) <= needed:
                self._pieces.popleft()
        parts = [
            piece[max(0, start - first) : stop - first]
            for first, piece in self._pieces
            if first < stop and first + len(piece) > start
        ]
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def _piece(self) -> Codes:
        """The next rows; InputFileError where there are none, and ever after."""
        if self._trouble:
            raise InputFileError(self._trouble)
        try:
            piece = next(self._file, None)
        except InputFileError as error:
            self._trouble = str(error)
            raise
        if piece is None:
            self._trouble = f"the picture ends at row {self._next} of {self.height}"
            raise InputFileError(self._trouble)
        return piece

    def close(self) -> None:
        """Let all rows go, and the file."""
        with self._lock:
            self._pieces.clear()
            self._file, self._next, self._open = iter(()), 0, lambda: iter(())


class Rows:
    """What an array of shape (M, N) or (M, N, 3) offers, as far as bands of rows need it.

    Made by *pick* from the rows of a window, which hold all channels of the file.
    """

    def __init__(
        self, window: Window, pick: Callable[[Codes], Codes], shape: tuple[int, ...], dtype: Any
    ) -> None:
        self.window, self.pick = window, pick
        self.shape = shape
        self.dtype: np.dtype[Any] = np.dtype(dtype)
        self.ndim = len(shape)

    @property
    def nbytes(self) -> int:
        """Bytes held, not those of the whole picture."""
        held = min(self.shape[0], self.window.keep + 2 * piece_rows(self.shape[1], 64))
        return held * math.prod(self.shape[1:]) * self.dtype.itemsize

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, rows: slice) -> Codes:
        start, stop, step = rows.indices(self.shape[0])
        if step != 1:
            raise IndexError(f"rows in steps of {step}; allowed: 1")
        if stop <= start:
            return np.empty((0, *self.shape[1:]), self.dtype)
        return self.pick(self.window.rows(start, stop))
