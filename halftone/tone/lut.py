"""Video look-up tables: what a display must be told so that it shows the intensity meant.

Three paths (Hearn & Baker, gamma correction): a table of voltages for linear pixel values; one that
first goes to the nearest level of a ladder; and, for displays whose amplifiers already turn linear
input into intensity, the ladder itself, so that gamma is not applied twice.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halftone.errors import UsageError
from halftone.tone.ladder import nearest
from halftone.tone.transfer import voltage

__all__ = ["combined_table", "gamma_table", "hardware_table", "to_dac", "wrong_codes"]

Float = NDArray[np.float64]


def gamma_table(size: int, gamma: float, a: float = 1.0) -> Float:
    """Voltages (k/(size−1)/a)^(1/γ) for the pixel values k = 0 … size−1, which mean light k/(size−1)."""
    return voltage(_pixel_values(size), gamma, a)


def combined_table(
    size: int, ladder: ArrayLike, gamma: float, a: float = 1.0, by: str = "ratio"
) -> Float:
    """Voltages for pixel values 0 … size−1, each brought to the nearest level of *ladder* first.

    Equal to the two steps done one after the other; ``by`` as in :func:`halftone.tone.nearest`.
    """
    levels = np.asarray(ladder, np.float64)
    return voltage(levels[nearest(_pixel_values(size), levels, by)], gamma, a)


def hardware_table(ladder: ArrayLike) -> Float:
    """What to store where the amplifiers correct for gamma themselves: the intensities as they are."""
    return np.array(ladder, np.float64)


def to_dac(voltages: ArrayLike, bits: int) -> NDArray[np.uint16]:
    """Voltages 0 … 1 as the nearest codes of a converter with *bits* bits; above 1 is full scale."""
    if not 1 <= bits <= 16:
        raise UsageError(f"bits={bits}; allowed: 1 … 16")
    top = (1 << bits) - 1
    return np.rint(np.clip(np.asarray(voltages, np.float64), 0, 1) * top).astype(np.uint16)


def wrong_codes(size: int, gamma: float, bits: int = 8, pixel_bits: int = 12) -> int:
    """How many of the 2^pixel_bits linear pixel values a table of *size* entries sends wrong.

    The table's nearest entry is looked up and rounded to a DAC code of *bits* bits; wrong is a code
    that differs from the one computed without a table. A table as large as the range of pixel
    values sends none wrong.
    """
    light = _pixel_values(1 << pixel_bits)
    entry = np.rint(light * (size - 1)).astype(np.int64)
    through = to_dac(gamma_table(size, gamma)[entry], bits)
    return int((through != to_dac(voltage(light, gamma), bits)).sum())


def _pixel_values(size: int) -> Float:
    if isinstance(size, bool) or size != int(size) or not 2 <= size <= 65536:
        raise UsageError(f"a table of size {size!r}; allowed: 2 … 65536")
    return np.arange(int(size)) / (int(size) - 1)
