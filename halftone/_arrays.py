"""Pictures on their way to a method: checked arrays that give float32 light, band by band.

A :class:`Source` never changes the array it was made from and never holds a float copy of integer
codes: it decodes the band that is asked for. What a code means is said by the caller, as a table.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from halftone.errors import InputError, UsageError

__all__ = [
    "BAND_ROWS",
    "LUMINANCE",
    "Light",
    "PixelRows",
    "Pixels",
    "Source",
    "as_pixels",
    "check_finite",
    "check_policy",
    "mapped",
    "share",
    "shortest",
    "whole",
]

Light = NDArray[np.float32]
Codes = NDArray[Any]


class PixelRows(Protocol):
    """What bands of rows need of an array: rows, which are read or made when they are asked for."""

    @property
    def shape(self) -> tuple[int, ...]: ...
    @property
    def ndim(self) -> int: ...
    @property
    def dtype(self) -> np.dtype[Any]: ...
    @property
    def nbytes(self) -> int: ...
    def __getitem__(self, rows: slice, /) -> Codes: ...


Pixels = Codes | PixelRows

BAND_ROWS = 64
"""Rows handled at a time: small enough for the cache, large enough to hide the call."""

LUMINANCE = (0.2126, 0.7152, 0.0722)
"""Luminance of linear R, G, B with the BT.709 primaries and D65 white (ITU-R BT.709-6, item 3.2)."""

NONFINITE = ("error", "clip")


def as_pixels(image: Any) -> Codes:
    """*image* as an array of shape (M, N) or (M, N, 3): uint8, uint16, uint32 or float32 codes.

    PIL images, NumPy arrays and nested lists of floats are taken; bool becomes uint8 0 or 255.
    Nothing is rescaled. Raises :class:`InputError` for any other type or shape, or for 0 pixels.
    """
    if hasattr(image, "getbands") and hasattr(image, "mode"):  # a PIL image, without importing PIL
        image = _from_pil(image)
    try:
        array = np.asarray(image)
    except ValueError as error:
        raise InputError(f"the picture is not an array: {error}") from error
    if array.ndim == 3 and array.shape[2] == 1:
        array = array[:, :, 0]
    if array.ndim not in (2, 3) or (array.ndim == 3 and array.shape[2] != 3):
        raise InputError(
            f"a picture of shape {array.shape} was given; allowed: (M, N) gray or (M, N, 3) RGB. "
            "Composite an alpha channel over a background first, or give halftone.convert the file"
        )
    if array.size == 0:
        raise InputError(f"the picture has no pixels: its shape is {array.shape}")
    kind = array.dtype.kind
    if kind == "b":
        return np.where(array, np.uint8(255), np.uint8(0))
    if kind == "f":
        with np.errstate(over="ignore"):  # a float64 beyond float32 becomes inf: judged as such
            return array.astype(np.float32, copy=False)
    if array.dtype in (np.uint8, np.uint16, np.uint32):
        return array
    raise InputError(
        f"a picture of type {array.dtype} was given; allowed: uint8, uint16, uint32 codes or floats "
        "of linear light. Convert with .astype(np.uint8), or divide by the white value"
    )


def _from_pil(image: Any) -> Codes:
    mode = image.mode
    if "transparency" in image.info:
        mode = f"{mode} with transparency"
    if mode in ("1", "L", "I;16", "F", "RGB"):
        array = np.asarray(image)
        return array.astype(np.uint16) if mode == "I;16" else array
    if mode in ("P", "CMYK", "YCbCr", "LAB", "HSV"):
        return np.asarray(image.convert("RGB"))
    raise InputError(
        f"a PIL image of mode {mode} was given; allowed: 1, L, I;16, F, P, RGB, CMYK, YCbCr. "
        "Composite an alpha channel over a background first, or give halftone.convert the file"
    )


@dataclass(frozen=True)
class Source:
    """A gray or RGB picture that gives linear light.

    pixels : (M, N) or (M, N, 3), float32 light, or codes that *table* decodes.
    They are an array, or rows of a file that are read when they are asked for.
    table : float32 light of every code, or None where pixels are light already.
    decode : light of rows of pixels, of which the first has the number given; instead of a table.
    cover : alpha as stored, (M, N), or None. Light lies over *paper* by it, and is weighted by it
    already where *premultiplied* says so.
    steps : functions applied to the light of each band, in order (range, brightness, …).
    """

    pixels: Pixels
    table: Light | None = None
    cover: Pixels | None = None
    paper: float = 1.0
    premultiplied: bool = False
    steps: tuple[Callable[[Light], Light], ...] = ()
    decode: Callable[[Codes, int], Light] | None = None

    @property
    def shape(self) -> tuple[int, int]:
        return self.pixels.shape[0], self.pixels.shape[1]

    def codes(self) -> tuple[Pixels, Light] | None:
        """Codes of shape (M, N) with the light of each, all steps applied; None if light varies."""
        if self.table is None or self.pixels.ndim != 2 or self.cover is not None:
            return None
        light = self.table
        for step in self.steps:
            light = step(light)
        return self.pixels, light

    def band(self, start: int, stop: int) -> Light:
        """Light of rows start … stop−1: float32, (rows, N), C-contiguous, not to be changed."""
        light = self.colours(start, stop)
        if light.ndim == 3:
            # In float64, so that a neutral pixel keeps its value to the last bit.
            red, green, blue = (light[:, :, c].astype(np.float64) for c in range(3))
            weighted = LUMINANCE[0] * red + LUMINANCE[1] * green + LUMINANCE[2] * blue
            light = weighted.astype(np.float32)
        for step in self.steps:
            light = step(light)
        return np.ascontiguousarray(light, np.float32)

    def colours(self, start: int, stop: int) -> Light:
        """Light of rows start … stop−1 over the paper, gray or RGB as the picture is, no steps."""
        rows = self.pixels[start:stop]
        if self.table is not None:
            light = np.take(self.table, rows)
        else:
            light = rows if self.decode is None else self.decode(rows, start)
        if self.cover is None:
            return light
        cover = share(self.cover[start:stop])
        if light.ndim == 3:
            cover = cover[:, :, None]
        if not self.premultiplied:
            light = light * cover
        return light + (np.float32(1) - cover) * np.float32(self.paper)

    def then(self, *steps: Callable[[Light], Light]) -> Source:
        """The same picture with further steps; a table takes them at once, once for all pixels."""
        if self.codes() is not None:
            table = self.table
            for step in (*self.steps, *steps):
                table = step(table)  # type: ignore[arg-type]
            return Source(self.pixels, table)
        return replace(self, steps=self.steps + steps)


def share(codes: Codes) -> Light:
    """Integer codes as shares of their full range; floats clipped to 0 … 1, NaN as 0."""
    if codes.dtype.kind == "f":
        return np.clip(np.nan_to_num(codes.astype(np.float32)), 0, 1)
    return (codes / np.float64(np.iinfo(codes.dtype).max)).astype(np.float32)


def check_finite(source: Source, policy: str) -> Source:
    """*source* without NaN and infinity, by *policy*, whenever its rows are asked for.

    ``error`` refuses them and names the first; ``clip`` makes NaN black and ±inf the lightest and
    the darkest light a float32 holds, which the range rule then brings to white and black.
    """
    check_policy(policy)
    if source.pixels.dtype.kind != "f":
        return source
    tidy = _clipped if policy == "clip" else _refused
    decode = source.decode
    if decode is None:
        return replace(source, decode=tidy)
    return replace(source, decode=lambda rows, start: tidy(decode(rows, start), start))


def _clipped(light: Light, start: int) -> Light:
    limit = float(np.finfo(np.float32).max)
    return np.nan_to_num(light, nan=0.0, posinf=limit, neginf=-limit)


def _refused(light: Light, start: int) -> Light:
    finite = np.isfinite(light)
    if finite.all():
        return light
    row, column = (int(i) for i in np.argwhere(~finite)[0][:2])
    raise InputError(
        f"the picture holds NaN or infinity: {light[row, column]} at row {start + row}, "
        f"column {column}; allowed: finite light. Give nonfinite='clip' (--nonfinite clip) to show "
        "NaN as black and infinite light as white"
    )


def whole(name: str, value: Any, low: int, high: int) -> int:
    """*value* as an int within low … high; a float, a bool or text is refused."""
    try:
        number = operator.index(value)
    except TypeError:
        number = low - 1
    if isinstance(value, bool) or not low <= number <= high:
        raise UsageError(f"{name}={value!r}; allowed: {low} … {high}, a whole number")
    return number


def shortest(value: float) -> str:
    """The shortest text that gives *value* again."""
    text = f"{value:g}"
    return text if float(text) == value else repr(float(value))


def mapped(table: NDArray[Any], indices: NDArray[np.unsignedinteger[Any]]) -> NDArray[Any]:
    """table[indices], by bands: NumPy widens the indices to 8 bytes a pixel."""
    out = np.empty(indices.shape, table.dtype)
    for start in range(0, indices.shape[0], BAND_ROWS):
        out[start : start + BAND_ROWS] = np.take(table, indices[start : start + BAND_ROWS])
    return out


def check_policy(policy: str) -> None:
    """Refuse a name that is no policy for NaN and infinity."""
    if policy not in NONFINITE:
        raise UsageError(f"nonfinite='{policy}' is unknown; allowed: {', '.join(NONFINITE)}")
