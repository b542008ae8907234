"""Spectra of flat patches: worms, checkerboards and periods show as peaks."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halftone.errors import InputError

__all__ = ["WINDOW", "periodogram", "tonal_peak"]

WINDOW = 128


def periodogram(patch: ArrayLike, window: int = WINDOW) -> NDArray[np.float64]:
    """Mean of |DFT|²/N over disjoint windows of a patch (M, N), each less its mean, no taper."""
    dots = np.asarray(patch, np.float64)
    if dots.ndim != 2 or window < 1 or min(dots.shape) < window:
        raise InputError(f"a patch of shape {dots.shape}; allowed: at least {window} × {window}")
    rows, columns = (side // window for side in dots.shape)
    tiles = dots[: rows * window, : columns * window].reshape(rows, window, columns, window)
    blocks = tiles.transpose(0, 2, 1, 3).reshape(-1, window, window)
    centred = blocks - blocks.mean(axis=(1, 2), keepdims=True)
    power: NDArray[np.float64] = np.mean(np.abs(np.fft.fft2(centred)) ** 2, axis=0) / window**2
    return power


def tonal_peak(patch: ArrayLike, tone: float, window: int = WINDOW) -> float:
    """Highest peak of the periodogram of dots 0 and 1 over their variance tone·(1 − tone).

    White noise gives 2.1 to 2.5 on a 512² patch; worms and checkerboards give hundreds. A pattern
    whose period divides the window has all its power in a few lines.
    """
    if not 0 < tone < 1:
        raise InputError(f"tone={tone}; allowed: above 0 and below 1")
    return float(periodogram(patch, window).max() / (tone * (1 - tone)))
