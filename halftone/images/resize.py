"""Resizing linear light, before it is halftoned: halftones must never be resampled."""

from __future__ import annotations

import numpy as np

from halftone._arrays import Light
from halftone.errors import UsageError

__all__ = ["FITS", "cells", "parse_size", "place", "resize", "target_size"]

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


def resize(light: Light, width: int, height: int) -> Light:
    """Linear light (M, N) or (M, N, 3) at *width* × *height*, with anti-aliasing (Pillow).

    Lanczos for pictures within 0 … 1; with highlights above 1, whose lobes would ring black around
    them, the Hamming window, which never leaves the range of its input.
    """
    from PIL import Image

    if (light.shape[1], light.shape[0]) == (width, height):
        return light
    if light.ndim == 3:
        planes = [resize(light[:, :, c], width, height) for c in range(light.shape[2])]
        return np.stack(planes, axis=2)
    in_range = float(light.max()) <= 1 and float(light.min()) >= 0
    filter = Image.Resampling.LANCZOS if in_range else Image.Resampling.HAMMING
    picture = Image.fromarray(np.ascontiguousarray(light, np.float32))
    return np.asarray(picture.resize((width, height), filter))


def place(
    light: Light,
    width: int,
    height: int,
    fit: str = "contain",
    background: float = 1.0,
    aspect: float = 1.0,
) -> Light:
    """*light* at *width* × *height* by one of :data:`FITS`; *aspect* as in :func:`target_size`."""
    check_fit(fit)
    rows, columns = light.shape[:2]
    free = target_size(rows, columns, width, None, aspect)
    if fit == "stretch" or free == (width, height):
        return resize(light, width, height)
    across, down = width / columns, height * aspect / rows
    ratio = min(across, down) if fit == "contain" else max(across, down)
    inner = (max(1, round(columns * ratio)), max(1, round(rows * ratio / aspect)))
    if fit == "contain":
        inner = (min(inner[0], width), min(inner[1], height))
        canvas = np.full((height, width, *light.shape[2:]), background, np.float32)
        y, x = (height - inner[1]) // 2, (width - inner[0]) // 2
        canvas[y : y + inner[1], x : x + inner[0]] = resize(light, *inner)
        return canvas
    inner = (max(inner[0], width), max(inner[1], height))
    # Only what will be kept is resized: a strip of 1 × 65,000 may be cut from a wide picture.
    keep_rows = min(rows, max(1, round(height * rows / inner[1])))
    keep_columns = min(columns, max(1, round(width * columns / inner[0])))
    y, x = (rows - keep_rows) // 2, (columns - keep_columns) // 2
    return resize(light[y : y + keep_rows, x : x + keep_columns], width, height)


def cells(light: Light, n: int) -> Light:
    """Mean light of blocks of n × n pixels; those at the right and bottom rim repeat the edge."""
    if n == 1:
        return light
    rows, columns = light.shape
    wide = np.pad(light, ((0, -rows % n), (0, -columns % n)), mode="edge")
    blocks = wide.reshape(wide.shape[0] // n, n, wide.shape[1] // n, n)
    means: Light = blocks.mean(axis=(1, 3), dtype=np.float64).astype(np.float32)
    return means


def check_fit(fit: str) -> None:
    if fit not in FITS:
        raise UsageError(f"fit '{fit}'; allowed: {', '.join(FITS)}")
