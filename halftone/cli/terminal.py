"""Pictures on a terminal: half blocks with 24-bit colours, two pixels a cell, or a ramp of ASCII."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import BAND_ROWS, Light
from halftone._parallel import bands

__all__ = ["columns_of_terminal", "lines", "reduced", "shows_blocks"]

RAMP = " .:-=+*#%@"
"""From black to white, as on a dark terminal."""

UPPER = "\N{UPPER HALF BLOCK}"
RESET = "\x1b[0m"
GAP = 1
"""Cells between two pictures."""


def shows_blocks(stream: Any = None) -> bool:
    """Whether the terminal can be trusted with colours and block elements (https://no-color.org)."""
    stream = sys.stdout if stream is None else stream
    if os.environ.get("NO_COLOR") or os.environ.get("TERM", "dumb") == "dumb":
        return False
    return "utf" in (getattr(stream, "encoding", None) or "").lower()


def columns_of_terminal() -> int:
    """Its width in cells; 80 where it does not say."""
    return max(1, shutil.get_terminal_size().columns)


def lines(pictures: Sequence[Light], columns: int, blocks: bool, aspect: float = 1.0) -> Iterator[str]:
    """Lines of text that show *pictures* of one shape, linear light (M, N), beside each other.

    columns : cells there are; each picture gets its share of them, and no more than N. blocks : half
    blocks, which are about square, with sRGB colours; else characters, each as high as two pixels.
    aspect : dots per inch across over down.
    """
    height, width = pictures[0].shape
    share = (columns - GAP * (len(pictures) - 1)) // len(pictures)
    across = max(1, min(share, width))
    down = max(1, round(height * across / width * aspect))
    down += down % 2  # two pixels a cell
    small = [reduced(picture, down, across) for picture in pictures]
    cells = [_blocks(part) if blocks else _characters(part) for part in small]
    for parts in zip(*cells, strict=True):
        yield (" " * GAP).join(parts)


def reduced(light: Light, rows: int, columns: int) -> NDArray[np.float64]:
    """Mean light of the area of every new pixel, (rows, columns); pixels at its rim count by share."""
    height = len(light)
    narrow = np.empty((height, columns))
    for start, stop in bands(height, BAND_ROWS):
        narrow[start:stop] = _means(light[start:stop].T, columns).T
    return _means(narrow, rows)


def _means(light: NDArray[np.floating[Any]], count: int) -> NDArray[np.float64]:
    """Means over *count* equal parts of the first axis, by the integral up to each part's rim."""
    size = len(light)
    total = np.zeros((size + 1, *light.shape[1:]))
    np.cumsum(light, axis=0, dtype=np.float64, out=total[1:])
    rim = np.arange(count + 1) * size / count
    whole = np.minimum(rim.astype(np.int64), size - 1)
    until = total[whole] + (rim - whole)[:, None] * light[whole]
    means: NDArray[np.float64] = np.diff(until, axis=0) * (count / size)
    return means


def _codes(light: NDArray[np.float64]) -> list[list[int]]:
    from devices.preview import srgb

    codes: list[list[int]] = srgb(light).tolist()
    return codes


def _blocks(light: NDArray[np.float64]) -> Iterator[str]:
    """The upper pixel is the block's colour, the lower one its ground; each is set as it changes."""
    codes = _codes(light)
    for upper, lower in zip(codes[::2], codes[1::2], strict=True):
        text, ink, ground = [], -1, -1
        for a, b in zip(upper, lower, strict=True):
            if a != ink:
                text.append(f"\x1b[38;2;{a};{a};{a}m")
            if b != ground:
                text.append(f"\x1b[48;2;{b};{b};{b}m")
            text.append(UPPER)
            ink, ground = a, b
        yield "".join(text) + RESET


def _characters(light: NDArray[np.float64]) -> Iterator[str]:
    for row in _codes((light[::2] + light[1::2]) / 2):
        yield "".join(RAMP[code * len(RAMP) // 256] for code in row)
