"""The picture that everything is timed on, the same on every machine."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

__all__ = ["picture"]

PARTS = ("camera", "astronaut", "coffee", "chelsea", "coins", "moon", "page", "brick", "grass", "rocket")
TILE = 500


@lru_cache
def picture(height: int, width: int) -> NDArray[np.uint8]:
    """8-bit gray codes: a mosaic of photographs, text and gradients with noise of σ = 1.5 codes.

    Photographs are those that scikit-image brings along, repeated to tiles of 500 × 500 pixels; every
    fourth tile is a gradient of another direction. Not to be written to.
    """
    from skimage import data

    photographs = [_tile(np.asarray(getattr(data, name)())) for name in PARTS]
    y, x = np.mgrid[0:TILE, 0:TILE] / (TILE - 1)
    rows, columns = -(-height // TILE), -(-width // TILE)
    whole = np.empty((rows * TILE, columns * TILE), np.float32)
    for place in range(rows * columns):
        row, column = divmod(place, columns)
        angle = 0.7 * place
        slope = 0.5 + (x - 0.5) * np.cos(angle) + (y - 0.5) * np.sin(angle)
        tile = 255 * slope if place % 4 == 3 else photographs[(place - place // 4) % len(photographs)]
        whole[row * TILE : (row + 1) * TILE, column * TILE : (column + 1) * TILE] = tile
    whole = whole[:height, :width]
    whole += np.random.default_rng(1).normal(0, 1.5, whole.shape).astype(np.float32)
    codes: NDArray[np.uint8] = np.ascontiguousarray(whole.round().clip(0, 255).astype(np.uint8))
    codes.flags.writeable = False
    return codes


def _tile(pixels: NDArray[np.uint8]) -> NDArray[np.float32]:
    gray = pixels.astype(np.float32)
    if gray.ndim == 3:
        gray = gray[:, :, :3].mean(axis=2)
    times = (-(-TILE // gray.shape[0]), -(-TILE // gray.shape[1]))
    return np.tile(gray, times)[:TILE, :TILE]
