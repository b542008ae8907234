"""Screens from a file or an array, and dots of at least a given size."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from halftone.errors import UsageError
from halftone.screens.order import Screen, from_ranks

__all__ = ["is_even", "mask", "minimum_dot"]

LARGEST = 2048
LARGEST_DOT = 16

_TEXTS = (".txt", ".csv")
_ARRAYS = (".npy", ".npz")
_PICTURES = (".png", ".tif", ".tiff", ".pgm")

Numbers = NDArray[Any]


def mask(source: str | Path | Any, name: str | None = None) -> Screen:
    """A screen from *source*: an array (h, w), or a file with one.

    Whole numbers are ranks 0 … n−1, each taken equally often; a place turns light the earlier the
    lower its rank. Fractions are thresholds, above 0 and below 1. Files: ``.npy``; ``.npz`` with
    one array, or one named ranks or thresholds; ``.txt`` and ``.csv``, a row a line, numbers
    divided by blanks or commas, ``#`` begins a comment; gray pictures (``.png``, ``.tif``,
    ``.pgm``), whose 8-bit or 16-bit codes c become thresholds (c + ½)/256 or (c + ½)/65,536.

    Raises :class:`UsageError` for anything else, and says what is wrong.
    """
    if isinstance(source, str | Path):
        path = Path(source)
        name = name or f"mask:{source}"
        array, steps = _read(path, name)
        what = f"file {path.name}"
    else:
        name = name or "mask"
        array, steps, what = _numbers(source, name), 0, "given array"
    if array.ndim != 2 or not array.size or max(array.shape) > LARGEST:
        raise UsageError(
            f"screen '{name}': an array of shape {array.shape}; allowed: (h, w), both 1 … {LARGEST}"
        )
    if steps:
        return Screen(((array + 0.5) / steps).astype(np.float32), name, what)
    if array.dtype.kind in "iu":
        _check_ranks(array, name)
        return from_ranks(array, name, what)
    _check_thresholds(array, name)
    # Just below 1 is 1 in float32, which would turn white black.
    limits = np.finfo(np.float32).smallest_normal, np.nextafter(np.float32(1), np.float32(0))
    return Screen(np.clip(array.astype(np.float32), *limits), name, what)


def minimum_dot(screen: Screen, width: int, height: int | None = None) -> Screen:
    """*screen* with every threshold over *width* × *height* pixels; the height is the width if left out.

    Wherever the picture does not change within such a block, its pixels are alike, so that no dot
    is smaller than a block, for printers that cannot hold a single pixel. The number of tones
    stays; the screen becomes as much coarser. Blocks start at the picture's first row and column.
    """
    height = width if height is None else height
    for side in (width, height):
        if isinstance(side, bool) or not isinstance(side, int) or not 1 <= side <= LARGEST_DOT:
            raise UsageError(f"a dot of {width!r} × {height!r} pixels; allowed: 1 … {LARGEST_DOT} each")
    if width == height == 1:
        return screen
    thresholds = np.repeat(np.repeat(screen.thresholds, height, axis=0), width, axis=1)
    return Screen(thresholds, f"{screen.name}:dot={width}x{height}", screen.source)


def is_even(screen: Screen) -> bool:
    """Whether the tones of *screen* lie at equal steps: then a patch shows its light, within half one.

    A mask may hold any thresholds; an uneven one changes tone, as a curve does.
    """
    values, rank = screen.ranked
    count = np.bincount(rank.ravel(), minlength=values.size)
    share = np.cumsum(count) / screen.thresholds.size
    half = count / 2 / screen.thresholds.size
    return bool((np.abs(values - (share - half)) <= half + 1e-6).all())


def _numbers(values: Any, name: str) -> Numbers:
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise UsageError(f"screen '{name}': not an array of numbers: {error}") from error
    if array.dtype.kind not in "iuf":
        raise UsageError(
            f"screen '{name}': an array of {array.dtype}; allowed: whole numbers (ranks) or "
            "fractions (thresholds)"
        )
    return array


def _read(path: Path, name: str) -> tuple[Numbers, int]:
    """The array in a file, and for a picture how many codes there are."""
    suffix = path.suffix.lower()
    if suffix not in _ARRAYS + _TEXTS + _PICTURES:
        kinds = ", ".join(_ARRAYS + _TEXTS + _PICTURES)
        raise UsageError(f"screen '{name}': a file '{suffix}' is no mask; allowed: {kinds}")
    if not path.is_file():
        raise UsageError(f"screen '{name}': no such file: {path}")
    try:
        if suffix in _PICTURES:
            return _read_picture(path, name)
        if suffix in _TEXTS:
            return _read_text(path, name), 0
        return _read_array(path, name), 0
    except (OSError, ValueError, SyntaxError, EOFError, OverflowError, BadZipFile) as error:
        if isinstance(error, UsageError):
            raise
        raise UsageError(f"screen '{name}': {path.name} cannot be read: {error}") from error


def _read_array(path: Path, name: str) -> Numbers:
    with path.open("rb") as file:
        stored = np.load(file, allow_pickle=False)
        if isinstance(stored, np.ndarray):
            return _numbers(stored, name)
        names = list(stored.files)
        chosen = [n for n in ("ranks", "thresholds") if n in names] or names
        if len(chosen) != 1:
            raise UsageError(
                f"screen '{name}': {path.name} holds the arrays {', '.join(names) or 'none'}; "
                "allowed: one array, or one named ranks or thresholds"
            )
        return _numbers(stored[chosen[0]], name)


def _read_text(path: Path, name: str) -> Numbers:
    lines = (
        line.partition("#")[0].replace(",", " ").split() for line in path.read_text("utf-8").splitlines()
    )
    rows = [line for line in lines if line]
    widths = {len(row) for row in rows}
    if len(widths) != 1:
        raise UsageError(
            f"screen '{name}': rows of {', '.join(map(str, sorted(widths))) or 'no'} numbers in "
            f"{path.name}; allowed: as many in every row"
        )
    whole = all(number.lstrip("+-").isdecimal() for row in rows for number in row)
    return np.array(rows).astype(np.int64 if whole else np.float64)


def _read_picture(path: Path, name: str) -> tuple[Numbers, int]:
    from PIL import Image

    try:
        opened = Image.open(path)
    except Image.DecompressionBombError as error:
        raise UsageError(f"screen '{name}': {path.name} is too large: {error}") from error
    with opened as picture:
        mode, (width, height) = picture.mode, picture.size
        steps = {"L": 1 << 8, "I": 1 << 16}.get(mode.partition(";")[0])
        if steps is None:
            raise UsageError(
                f"screen '{name}': {path.name} is a picture of mode {mode}; allowed: gray of 8 or "
                "16 bits, without alpha"
            )
        if max(width, height) > LARGEST:
            return np.empty((height, width), np.uint8), steps
        return np.asarray(picture).astype(np.int64), steps


def _check_ranks(array: Numbers, name: str) -> None:
    low, high = int(array.min()), int(array.max())
    if low < 0 or high >= array.size:
        ones = low == 1 and high == array.size
        hint = "subtract 1: ranks start with 0" if ones else "every rank 0 … n−1 equally often"
        raise UsageError(
            f"screen '{name}': ranks {low} … {high} for {array.size} places; allowed: {hint}"
        )


def _check_thresholds(array: Numbers, name: str) -> None:
    wrong = ~((array > 0) & (array < 1))
    if wrong.any():
        row, column = (int(i) for i in np.argwhere(wrong)[0])
        raise UsageError(
            f"screen '{name}': the threshold {array[row, column]:g} at row {row}, column {column}, and "
            f"{int(wrong.sum()) - 1} more; allowed: above 0 and below 1, so that black stays black and "
            "white white. For n ranks give whole numbers 0 … n−1"
        )
