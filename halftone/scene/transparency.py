"""k_t, the share of what lies behind a surface that is seen through it, without refraction.

A sample shows (1 − k_t) of its own light and k_t of the light behind it (Newell, Newell & Sancha
1972), with k_t falling or rising towards the rim of a curved surface (Kay & Greenberg 1979).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from halftone.scene import _light_kernels as kernels
from halftone.scene.model import Material

__all__ = ["transparency"]

Row = NDArray[np.float32]


def transparency(
    materials: Sequence[Material], material: NDArray[np.int32], n_z: Row, *, force_all: bool = False
) -> Row:
    """k_t = rim + (middle − rim)·(1 − (1 − |N_z|)^m) of each sample, float32 (K,), within 0 … 1.

    material : int32 (K,) into *materials*. n_z : float32 (K,), the component of the unit normal
    towards the viewer; NaN counts as 0. Where a material has no rim, k_t is its transparency.
    """
    middle = np.array([m.transparency for m in materials], np.float32)[material]
    if not force_all and all(m.rim is None for m in materials):
        return middle
    ends = [m.transparency if m.rim is None else m.rim for m in materials]
    rim = np.array(ends, np.float32)[material]
    exponent = np.array([m.rim_exponent for m in materials], np.float32)[material]
    slope = np.float32(1) - np.fmin(np.fmax(np.abs(n_z), np.float32(0)), np.float32(1))
    edge = np.empty_like(middle)
    with np.errstate(over="ignore"):  # where the kernel runs as plain Python
        kernels.sharpen(np.ones_like(middle), slope, exponent, edge)
    # The end itself at the rim: middle + (rim − middle) may miss it by its rounding.
    return np.where(edge == 1, rim, middle + (rim - middle) * edge)
