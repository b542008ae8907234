"""Error of a halftone against its picture, raw and as an eye sees it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halftone.errors import InputError
from halftone.vision import lms7, seen

__all__ = ["hpsnr", "psnr"]


def psnr(shown: ArrayLike, light: ArrayLike) -> float:
    """10·log10(1/MSE) in dB of two pictures (M, N) whose white is 1; infinite where they agree."""
    return _decibels(_difference(shown, light))


def hpsnr(shown: ArrayLike, light: ArrayLike, kernel: NDArray[np.float64] | None = None) -> float:
    """PSNR after the *difference* was filtered by an eye model, in dB.

    shown : luminance of the halftone, (M, N). light : the picture, (M, N), white 1. kernel : of odd
    sides; None is the 7 × 7 LMS filter. Figures made with different kernels cannot be compared, nor
    those of pictures in light with those of codes taken as light.
    """
    eye = lms7() if kernel is None else kernel
    return _decibels(seen(_difference(shown, light), eye))


def _difference(shown: ArrayLike, light: ArrayLike) -> NDArray[np.float64]:
    first, second = np.asarray(shown, np.float64), np.asarray(light, np.float64)
    if first.shape != second.shape or first.ndim != 2 or first.size == 0:
        raise InputError(f"pictures of shapes {first.shape} and {second.shape}; allowed: (M, N) twice")
    return first - second


def _decibels(difference: NDArray[np.float64]) -> float:
    error = float(np.mean(difference**2))
    return float(-10 * np.log10(error)) if error > 0 else float("inf")
