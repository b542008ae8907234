"""Eye models: what a viewer makes of dots at a distance, as small filters.

LMS7 is the 7 × 7 filter that Guo & Liu trained by least mean squares between pictures and halftones
of them, and with which most published HPSNR figures were made. It sums to 1 and is not quite
symmetric.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["LMS7", "lms7", "seen"]

LMS7 = (
    (-0.001743412, 0.001445723, 0.007113962, 0.00882646, 0.006254165, -0.000353216, -0.003116813),
    (0.000833244, 0.009929635, 0.023728512, 0.029311034, 0.022933593, 0.009711988, 0.000118289),
    (0.005842017, 0.023691596, 0.048267152, 0.059043883, 0.046412889, 0.023315857, 0.00565178),
    (0.009138026, 0.03289413, 0.064200407, 0.07877393, 0.060303292, 0.029523382, 0.00756588),
    (0.007942508, 0.028669495, 0.053826022, 0.065024427, 0.050496807, 0.023933323, 0.005585837),
    (0.002404652, 0.014542416, 0.029730907, 0.035492112, 0.027318902, 0.011351292, 0.001239805),
    (-0.001666554, 0.002380156, 0.009867343, 0.012292728, 0.00921621, 0.002268413, -0.001534185),
)
"""Guo & Liu, "Improved dot diffusion by diffused matrix and class matrix co-optimization", 2009."""


def lms7() -> NDArray[np.float64]:
    """The 7 × 7 LMS filter, float64."""
    return np.array(LMS7)


def seen(light: NDArray[np.floating], kernel: NDArray[np.float64]) -> NDArray[np.float64]:
    """*light* (M, N) correlated with an eye's *kernel* of odd sides, in float64.

    The border is mirrored without repeating the edge (reflect-101), as in the published figures; a
    picture smaller than the kernel's reach is mirrored again and again.
    """
    up, left = kernel.shape[0] // 2, kernel.shape[1] // 2
    wide = np.pad(np.asarray(light, np.float64), ((up, up), (left, left)), mode="reflect")
    out = np.zeros(light.shape)
    height, width = light.shape
    for (dy, dx), weight in np.ndenumerate(kernel):
        out += weight * wide[dy : dy + height, dx : dx + width]
    return out
