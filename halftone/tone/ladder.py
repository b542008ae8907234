"""Ladders of intensities: which luminances n levels should have, and which level is nearest.

Equal steps of perceived brightness need equal *ratios* of intensity: from 0.20 to 0.22 looks the
same as from 0.80 to 0.88 (Hearn & Baker, intensity levels). L* steps are the CIE 1976 refinement.
"""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halftone.errors import UsageError

__all__ = [
    "lightness",
    "log_ladder",
    "lstar_ladder",
    "luminance",
    "nearest",
    "ratio",
    "uniform_ladder",
    "visible_steps",
]

Float = NDArray[np.float64]

USUAL_BLACK = (0.005, 0.025)
"""The usual range of I0, the light of a display that shows black."""


def log_ladder(i0: float | ArrayLike, n: int) -> Float:
    """The n + 1 intensities I_k = I0^((n−k)/n), k = 0 … n, from I0 to 1 in equal ratios.

    i0 : the darkest intensity, 0 < I0 < 1; usually 0.005 … 0.025. One number, or one per colour
    component, which gives shape (n + 1, components).
    n : number of steps, at least 1.

    >>> log_ladder(1 / 8, 3)
    array([0.125, 0.25 , 0.5  , 1.   ])
    """
    black = _check_black(i0)
    k = np.arange(_check_steps(n) + 1)
    exponent = (n - k) / n
    return np.asarray(black ** exponent.reshape(-1, *[1] * black.ndim), np.float64)


def ratio(i0: float, n: int) -> float:
    """The ratio r = (1/I0)^(1/n) between neighbouring intensities of :func:`log_ladder`."""
    return float((1.0 / _check_black(i0)) ** (1.0 / _check_steps(n)))


def uniform_ladder(n: int) -> Float:
    """The n + 1 intensities k/n, in equal differences of light."""
    return np.arange(_check_steps(n) + 1) / n


def lstar_ladder(n: int) -> Float:
    """The n + 1 intensities of L* = 100·k/n, in equal steps of CIE 1976 lightness."""
    return luminance(np.arange(_check_steps(n) + 1) * (100.0 / n))


def lightness(y: ArrayLike) -> Float:
    """CIE 1976 L* (0 … 100) of a luminance relative to white (CIE 15:2018, eq. 8.5)."""
    array = np.asarray(y, np.float64)
    linear = array <= (6 / 29) ** 3
    return np.where(linear, array * (29 / 3) ** 3, 116 * np.cbrt(np.maximum(array, 0)) - 16)


def luminance(lstar: ArrayLike) -> Float:
    """Luminance relative to white of a CIE 1976 L* (0 … 100)."""
    array = np.asarray(lstar, np.float64)
    return np.where(array <= 8, array * (3 / 29) ** 3, ((array + 16) / 116) ** 3)


def nearest(light: ArrayLike, levels: ArrayLike, by: str = "arithmetic") -> NDArray[np.uint8]:
    """Index of the level nearest to each value of *light*; a tie goes to the darker level.

    levels : ascending luminances, at most 256; above 0 for ``by="ratio"``.
    by : ``arithmetic`` (the smaller difference) or ``ratio`` (the smaller quotient).
    """
    ladder = np.asarray(levels, np.float64)
    if ladder.ndim != 1 or not 1 <= ladder.size <= 256 or not (np.diff(ladder) > 0).all():
        raise UsageError("levels are not 1 … 256 ascending luminances in one row")
    return np.searchsorted(borders(ladder, by), np.asarray(light, np.float64)).astype(np.uint8)


def borders(ladder: Float, by: str = "arithmetic") -> Float:
    """The light above which the next level of an ascending *ladder* is nearer."""
    if by == "arithmetic":
        return (ladder[:-1] + ladder[1:]) / 2
    if by == "ratio":
        if ladder[0] <= 0:
            raise UsageError(
                f"the darkest level is {ladder[0]:g}: a ratio needs levels above 0. "
                "Use by='arithmetic', or a ladder that starts at the device's black, as log:0.02:4"
            )
        return np.sqrt(ladder[:-1] * ladder[1:])
    raise UsageError(f"by={by!r}; allowed: arithmetic, ratio")


def visible_steps(levels: ArrayLike, threshold: float = 5.0) -> int:
    """How many steps between neighbouring levels show as contours in a smooth area.

    A step shows when it is above *threshold*, in L* of a display whose lightest level is white.
    The default, 5, agrees with the old rule for photographs: contours at 2, 4 and 8 equal steps of
    brightness, slight ones at 16, hardly any from 32 on. An observer of a noiseless ramp sees
    steps down to L* 1.
    """
    ladder = np.asarray(levels, np.float64)
    return int((np.diff(lightness(ladder / ladder[-1])) > threshold).sum())


def _check_steps(n: int) -> int:
    try:
        whole = int(n)
    except (TypeError, ValueError, OverflowError):
        whole = 0
    if isinstance(n, bool) or whole != n or whole < 1:
        raise UsageError(f"n={n!r} steps; allowed: 1, 2, 3, …")
    return whole


def _check_black(i0: float | ArrayLike) -> Float:
    black = np.asarray(i0, np.float64)
    if not (np.isfinite(black).all() and (black > 0).all() and (black < 1).all()):
        raise UsageError(
            f"I0={i0!r}, the intensity of black; allowed: above 0 and below 1, usually "
            f"{USUAL_BLACK[0]} … {USUAL_BLACK[1]}, as in log:0.02:4. From exactly 0 no ratio exists"
        )
    if (black < 1e-3).any():
        warnings.warn(
            f"I0={float(black.min()):g} is darker than displays are ({USUAL_BLACK[0]} … "
            f"{USUAL_BLACK[1]}): most of the ladder's levels will look black",
            stacklevel=3,
        )
    return black
