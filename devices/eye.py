"""The eye: what it makes of light at a distance, band by band.

It is Näsänen's (Visibility of halftone dot textures, IEEE Trans. SMC 14, 1984): sensitivity falls as
exp(−α·f), f in cycles a degree, whose point spread is (α² + (2πq)²)^(−3/2), q in degrees.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone.errors import InputError, UsageError

__all__ = ["FURTHEST", "at_distance", "point_spread", "spread_by", "with_context"]

Light = NDArray[np.float32]

PIECE = 1 << 21
"""Samples taken at a time, but never fewer rows than the point spread reaches over."""
ADAPTED = 100.0
"""Luminance in cd/m² of paper in a well-lit room."""
SPREAD = 0.5
"""Degrees within which the point spread is used: 95 % of its light lies there; scaled to 1."""
FURTHEST = 250_000
"""Samples an inch × inches: the point spread has 4,363 samples a side then."""


def point_spread(dpi: float | tuple[float, float], distance: float) -> NDArray[np.float64]:
    """The eye's point spread for *dpi* samples an inch (or across and down) from *distance* inches:
    float64 of odd sides, above 0, of sum 1."""
    try:
        across, down = (float(d) for d in (dpi if isinstance(dpi, tuple | list) else (dpi, dpi)))
        far = float(distance)
    except (TypeError, ValueError):
        across = down = far = math.nan
    if not (min(across, down, far) > 0 and max(across, down) * far <= FURTHEST):
        raise UsageError(
            f"dpi={dpi!r} from distance={distance!r}; allowed: above 0, and dpi × inches up to "
            f"{FURTHEST:,}. From afar fewer samples do: draw at a lower scale"
        )
    alpha = 1 / (0.525 * math.log(ADAPTED) + 3.91)
    reach = far * math.tan(math.radians(SPREAD))  # inches
    rows, columns = (
        np.degrees(np.arange(-math.floor(reach * d), math.floor(reach * d) + 1) / (d * far))
        for d in (down, across)
    )
    q = np.hypot(rows[:, None], columns)
    spread = (alpha**2 + (2 * np.pi * q) ** 2) ** -1.5
    return np.asarray(spread / spread.sum())


def at_distance(light: Light, dpi: float | tuple[float, float], distance: float) -> Light:
    """What the eye makes of *light* (M, N), float32, from *distance* inches, at *dpi* samples an inch.

    Linear light in and out; beyond its border the picture is mirrored.
    """
    light = np.asarray(light, np.float32)
    if light.ndim != 2 or light.size == 0:
        raise InputError(f"light of shape {light.shape}; allowed: (M, N)")
    rows = max(1, PIECE // light.shape[1])
    parts = (light[top : top + rows] for top in range(0, len(light), rows))
    return np.concatenate(list(spread_by(parts, point_spread(dpi, distance))))


def spread_by(parts: Iterator[Light], spread: NDArray[np.float64]) -> Iterator[Light]:
    """Bands of light convolved with *spread*, piece by piece through the Fourier transform."""
    up, left = spread.shape[0] // 2, spread.shape[1] // 2
    size, transformed = (0, 0), np.empty(0, np.complex64)
    for held, first, last in with_context(_gathered(parts, 2 * up), up):
        missing = max(0, up - first), max(0, up - (len(held) - last))
        rows, columns = held.shape[0] + sum(missing), held.shape[1] + 2 * left
        if size != (_quick(rows), _quick(columns)):
            size = _quick(rows), _quick(columns)
            transformed = np.fft.rfft2(spread.astype(np.float32), size).astype(np.complex64)
        blurred = _product(np.pad(held, (missing, (left, left)), mode="symmetric"), transformed, size)
        # Circular: what wraps round lands in the first rows and columns, which are left out.
        yield blurred[2 * up : rows, 2 * left : columns].astype(np.float32)
        del blurred


def _product(light: Light, transformed: NDArray[np.complex64], size: tuple[int, int]) -> NDArray[Any]:
    made = np.fft.rfft2(light, size)
    made *= transformed
    return np.fft.irfft2(made, size)


def _quick(size: int) -> int:
    """The next size that is quickly transformed: one without a prime factor above 5."""
    rest = size
    for factor in (2, 3, 5):
        while rest % factor == 0:
            rest //= factor
    return size if rest == 1 else _quick(size + 1)


def _gathered(parts: Iterable[Light], rows: int) -> Iterator[Light]:
    """Bands of at least *rows* rows and half a piece, but for the last."""
    waiting: list[Light] = []
    for part in parts:
        waiting.append(part)
        if sum(map(len, waiting)) >= rows and sum(part.size for part in waiting) >= PIECE // 2:
            yield np.concatenate(waiting)
            waiting = []
    if waiting:
        yield np.concatenate(waiting)


def with_context(parts: Iterable[NDArray[Any]], reach: int) -> Iterator[tuple[NDArray[Any], int, int]]:
    """Rows with up to *reach* more before and behind, fewer only where the picture ends; and the
    first and the last + 1 of those that come now."""
    parts = iter(parts)
    held, first = next(parts, None), 0
    if held is None:
        return
    for part in parts:
        last = len(held) - reach
        if last > first:
            yield held, first, last
            past = max(0, last - reach)
            held, first = held[past:], last - past
        held = np.concatenate((held, part))
    yield held, first, len(held)
