"""Intensities beyond 1 brought into range (Hearn & Baker: set to the maximum, normalised, or scaled).

``clamp`` and ``divide`` work on the terms of one sample (ambient, and the diffuse and the specular
term of each light) and belong to :class:`halftone.scene.illumination.Illumination`; ``scale`` needs
the range of the whole picture, and its two functions are here.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

__all__ = ["RULES", "extent", "scaled"]

Light = NDArray[np.float32]
Extent = tuple[float, float]

RULES = ("none", "clamp", "divide", "scale")


def extent(parts: Iterable[Light]) -> Extent:
    """The least and the largest intensity of all *parts* (bands, channels); (0, 0) if there are none."""
    ranges = [(float(part.min()), float(part.max())) for part in parts if part.size]
    if not ranges:
        return 0.0, 0.0
    return min(low for low, _ in ranges), max(high for _, high in ranges)


def scaled(light: Light, of: Extent) -> Light:
    """*light* by the affine map that brings the extent *of* the scene to 0 … 1.

    Nothing changes where the extent is within 0 … 1 already. A scene of one intensity beyond 1
    becomes 1 everywhere.
    """
    low, high = of
    if low >= 0 and high <= 1:
        return light
    if high == low:
        return np.full_like(light, 1.0 if high > 1 else 0.0)
    return ((light.astype(np.float64) - low) / (high - low)).astype(np.float32)
