"""From codes to light and back: the encodings of files, and the response of displays.

Light is linear, 0 = none, 1 = white. Codes run from 0 to 1. All functions work in float64 on arrays
of any shape and return float64; only the tables are rounded to float32, once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halftone._arrays import shortest
from halftone.errors import UsageError, near

__all__ = ["ENCODINGS", "Encoding", "encoding", "intensity", "voltage"]

Float = NDArray[np.float64]

ENCODINGS = ("srgb", "bt709", "gamma:G", "linear")
"""Names that :func:`encoding` takes; G is a number, as in ``gamma:2.2``."""


@dataclass(frozen=True)
class Encoding:
    """A named pair of curves, ``decode(code) → light`` and ``encode(light) → code``.

    Both are odd functions, so that codes below 0 (which scene-referred files hold) stay defined;
    above 1 they go on by the same formula.
    """

    name: str
    _decode: Callable[[Float], Float] = field(repr=False, compare=False)
    _encode: Callable[[Float], Float] = field(repr=False, compare=False)

    def decode(self, code: ArrayLike) -> Float:
        """Light of *code*, both as fractions of white."""
        return _odd(self._decode, code)

    def encode(self, light: ArrayLike) -> Float:
        """Code of *light*, both as fractions of white."""
        return _odd(self._encode, light)

    def table(self, size: int) -> NDArray[np.float32]:
        """Light of the codes 0 … size−1 as float32; the last is white. Read-only, made once."""
        return _table(self, size)


def encoding(spec: str | Encoding) -> Encoding:
    """The encoding called *spec*: ``srgb``, ``bt709``, ``linear``, or ``gamma:G`` with 0.01 ≤ G ≤ 100.

    srgb : IEC 61966-2-1. bt709 : ITU-R BT.709-6, item 1.2, with the constants that make its two
    branches meet (BT.2020-2, table 4). gamma : light = code^G.
    """
    if isinstance(spec, Encoding):
        return spec
    text = str(spec).strip().lower()
    name = "".join(c for c in text if c not in "-_. ")
    name = {"rec709": "bt709", "709": "bt709", "lin": "linear", "light": "linear"}.get(name, name)
    if name in _NAMED:
        return _NAMED[name]
    try:
        return _power(text.removeprefix("gamma").removeprefix(":"))
    except UsageError:
        if text.startswith("gamma"):
            raise
        raise UsageError(near(str(spec), ENCODINGS, "encoding")) from None


def intensity(voltage: ArrayLike, gamma: float, a: float = 1.0) -> Float:
    """Light of a display driven with *voltage*: I = a · V^γ (Hearn & Baker, monitor response)."""
    gamma, a = check_gamma(gamma), _check_scale(a)
    return a * _non_negative(voltage, "voltage") ** gamma


def voltage(intensity: ArrayLike, gamma: float, a: float = 1.0) -> Float:
    """Voltage for which a display shows *intensity*: V = (I / a)^(1/γ)."""
    gamma, a = check_gamma(gamma), _check_scale(a)
    return (_non_negative(intensity, "intensity") / a) ** (1.0 / gamma)


def check_gamma(gamma: Any) -> float:
    """*gamma* as a float within 0.01 … 100."""
    try:
        value = math.nan if "_" in str(gamma) else float(gamma)
    except (TypeError, ValueError):
        value = math.nan
    if not 0.01 <= value <= 100:
        raise UsageError(f"gamma={gamma!r}; allowed: 0.01 … 100 (displays: 1.8 … 2.6)")
    return value


def _check_scale(a: float) -> float:
    if not (math.isfinite(a) and a > 0):
        raise UsageError(f"a={a!r}, the intensity at voltage 1; allowed: finite and above 0")
    return float(a)


def _non_negative(values: ArrayLike, what: str) -> Float:
    array = np.asarray(values, np.float64)
    if not (array >= 0).all():
        raise UsageError(f"{what} below 0 or NaN; allowed: 0 and above")
    return array


def _power(text: str) -> Encoding:
    gamma = check_gamma(text)
    return Encoding(f"gamma:{shortest(gamma)}", lambda v: v**gamma, lambda v: v ** (1.0 / gamma))


def _odd(curve: Callable[[Float], Float], values: ArrayLike) -> Float:
    array = np.asarray(values, np.float64)
    return np.copysign(curve(np.abs(array)), array)


@lru_cache(maxsize=32)
def _table(spec: Encoding, size: int) -> NDArray[np.float32]:
    table = spec.decode(np.arange(size) / (size - 1)).astype(np.float32)
    table.flags.writeable = False
    return table


def _srgb_decode(v: Float) -> Float:
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


def _srgb_encode(v: Float) -> Float:
    return np.where(v <= 0.0031308, v * 12.92, 1.055 * v ** (1 / 2.4) - 0.055)


_ALPHA, _BETA = 1.09929682680944, 0.018053968510807


def _bt709_decode(v: Float) -> Float:
    return np.where(v < 4.5 * _BETA, v / 4.5, ((v + (_ALPHA - 1)) / _ALPHA) ** (1 / 0.45))


def _bt709_encode(v: Float) -> Float:
    return np.where(v < _BETA, v * 4.5, _ALPHA * v**0.45 - (_ALPHA - 1))


def _same(v: Float) -> Float:
    return v


_NAMED = {
    "srgb": Encoding("srgb", _srgb_decode, _srgb_encode),
    "bt709": Encoding("bt709", _bt709_decode, _bt709_encode),
    "linear": Encoding("linear", _same, _same),
}
