"""Resizing linear light, before it is halftoned: halftones must never be resampled."""

from __future__ import annotations

from typing import Any

import numpy as np

from halftone._arrays import BAND_ROWS, Light, PixelRows, Source
from halftone.errors import UsageError
from halftone.images.rows import piece_rows

__all__ = ["FITS", "Cells", "LightRows", "parse_size", "place", "resize", "target_size"]

LANCZOS, HAMMING = 1, 5
"""Pillow's numbers of the filters (PIL.Image.Resampling)."""

FITS = {
    "contain": "the whole picture, over the background where its shape differs",
    "cover": "the middle of the picture, cut so that it fills the size",
    "stretch": "the whole picture, distorted",
}


def parse_size(text: str) -> tuple[int | None, int | None]:
    """``WxH``, ``Wx`` or ``xH`` as (width, height) with None for what follows from the picture."""
    width, cross, height = text.lower().replace("×", "x").partition("x")
    try:
        size = (int(width) if width else None, int(height) if height else None)
    except ValueError:
        size = (None, None)
    if not cross or size == (None, None) or any(v is not None and v < 1 for v in size):
        raise UsageError(f"size '{text}'; allowed: WxH, Wx or xH in pixels, as 576x800, 576x or x800")
    return size


def target_size(
    rows: int, columns: int, width: int | None, height: int | None, aspect: float = 1.0
) -> tuple[int, int]:
    """(width, height) for a picture of *rows* × *columns*, where one or both may be left open.

    aspect : dots per inch across over dots per inch down; 1 for square dots.
    """
    if width is None and height is None:
        width = columns
        if aspect == 1:
            return width, rows
    if width is None:
        assert height is not None
        return max(1, round(height * columns * aspect / rows)), height
    if height is None:
        height = max(1, round(width * rows / (columns * aspect)))
    return width, height


class _Made:
    """Light (M, N), of which bands of rows are made when they are asked for."""

    def __init__(self, shape: tuple[int, int]) -> None:
        self.shape: tuple[int, ...] = shape
        self.ndim, self.nbytes = 2, 0
        self.dtype: np.dtype[Any] = np.dtype(np.float32)


class LightRows(_Made):
    """The light of a source."""

    def __init__(self, source: Source) -> None:
        super().__init__(source.shape)
        self.source = source

    def __getitem__(self, rows: slice) -> Light:
        start, stop, _ = rows.indices(self.shape[0])
        return self.source.band(start, stop)


Picture = Light | PixelRows
Box = tuple[int, int, int, int]
"""First row, first column, rows and columns of a part of a picture."""


def resize(light: Light, width: int, height: int) -> Light:
    """Linear light (M, N) or (M, N, 3) at *width* × *height*, with anti-aliasing (Pillow).

    Lanczos for pictures within 0 … 1; with highlights above 1, whose lobes would ring black around
    them, the Hamming window, which never leaves the range of its input.
    """
    if (light.shape[1], light.shape[0]) == (width, height):
        return light
    out = np.empty((height, width, *light.shape[2:]), np.float32)
    _resize(light, (0, 0, light.shape[0], light.shape[1]), out)
    return out


def _resize(light: Picture, box: Box, out: Light) -> None:
    """The part *box* of *light* at the size of *out*.

    First across, then down, as Pillow does (before 13; since then it takes the cheaper order, which
    rounds otherwise in the last bit). Each goes by parts, which gives the same to the last bit, so
    that *light* is never held whole.
    """
    height, width = out.shape[:2]
    filter = LANCZOS
    across = _across(light, box, width, filter)
    if across is None:
        filter = HAMMING
        across = _across(light, box, width, filter)
    assert across is not None
    step = piece_rows(max(box[2], height), width)
    for x in range(0, width, step):
        columns = across[:, x : x + step]
        out[:, x : x + step] = _scaled(columns, columns.shape[1], height, filter)


def _across(light: Picture, box: Box, width: int, filter: int) -> Light | None:
    """Rows of *box* at the new width; None if light beyond 0 … 1 forbids Lanczos."""
    top, left, rows, columns = box
    across = np.empty((rows, width, *light.shape[2:]), np.float32)
    step = piece_rows(light.shape[1], BAND_ROWS)
    for y in range(0, rows, step):
        band = light[top + y : top + min(y + step, rows)][:, left : left + columns]
        if filter == LANCZOS and not (float(band.max()) <= 1 and float(band.min()) >= 0):
            return None
        across[y : y + step] = _scaled(band, width, len(band), filter)
    return across


def _scaled(light: Light, width: int, height: int, filter: int) -> Light:
    """By Pillow, each channel on its own."""
    from PIL import Image

    if (light.shape[1], light.shape[0]) == (width, height):
        return light
    if light.ndim == 3:
        planes = [_scaled(light[:, :, c], width, height, filter) for c in range(light.shape[2])]
        return np.stack(planes, axis=2)
    picture = Image.fromarray(np.ascontiguousarray(light, np.float32))
    return np.asarray(picture.resize((width, height), Image.Resampling(filter)))


def place(
    light: Picture,
    width: int,
    height: int,
    fit: str = "contain",
    background: float = 1.0,
    aspect: float = 1.0,
) -> Picture:
    """*light* at *width* × *height* by one of :data:`FITS`; *aspect* as in :func:`target_size`.

    It is given back as it is where nothing has to be done.
    """
    check_fit(fit)
    rows, columns = light.shape[:2]
    free = target_size(rows, columns, width, None, aspect)
    if (columns, rows) == (width, height) and (fit == "stretch" or free == (width, height)):
        return light
    canvas = np.full((height, width, *light.shape[2:]), background, np.float32)
    if fit == "stretch" or free == (width, height):
        _resize(light, (0, 0, rows, columns), canvas)
        return canvas
    across, down = width / columns, height * aspect / rows
    ratio = min(across, down) if fit == "contain" else max(across, down)
    inner = (max(1, round(columns * ratio)), max(1, round(rows * ratio / aspect)))
    if fit == "contain":
        inner = (min(inner[0], width), min(inner[1], height))
        y, x = (height - inner[1]) // 2, (width - inner[0]) // 2
        _resize(light, (0, 0, rows, columns), canvas[y : y + inner[1], x : x + inner[0]])
        return canvas
    inner = (max(inner[0], width), max(inner[1], height))
    # Only what will be kept is resized: a strip of 1 × 65,000 may be cut from a wide picture.
    keep_rows = min(rows, max(1, round(height * rows / inner[1])))
    keep_columns = min(columns, max(1, round(width * columns / inner[0])))
    y, x = (rows - keep_rows) // 2, (columns - keep_columns) // 2
    _resize(light, (y, x, keep_rows, keep_columns), canvas)
    return canvas


class Cells(_Made):
    """Mean light of blocks of n × n pixels; those at the right and bottom rim repeat the edge."""

    def __init__(self, light: Picture, n: int) -> None:
        super().__init__((-(-light.shape[0] // n), -(-light.shape[1] // n)))
        self.light, self.n = light, n

    def __getitem__(self, rows: slice) -> Light:
        start, stop, _ = rows.indices(self.shape[0])
        n = self.n
        light = self.light[start * n : stop * n]
        wide = np.pad(light, ((0, -len(light) % n), (0, -light.shape[1] % n)), mode="edge")
        blocks = wide.reshape(wide.shape[0] // n, n, wide.shape[1] // n, n)
        means: Light = blocks.mean(axis=(1, 3), dtype=np.float64).astype(np.float32)
        return means


def check_fit(fit: str) -> None:
    if fit not in FITS:
        raise UsageError(f"fit '{fit}'; allowed: {', '.join(FITS)}")
