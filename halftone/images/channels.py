"""Which channels of a file are colours and which is alpha, and which way up they lie."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone.errors import InputFileError

__all__ = ["Channels", "channels_of", "encoding_of", "orientation_of", "upright"]

Codes = NDArray[Any]


@dataclass(frozen=True)
class Channels:
    """How rows (n, N, C) of a file are taken apart.

    colours : 1 or 3. alpha : the place of the alpha channel, or None. divide : codes are weighted by
    alpha as codes. mirrored : rows run from right to left.
    """

    colours: int
    alpha: int | None
    dtype: np.dtype[Any]
    premultiplied: bool
    divide: bool
    mirrored: bool

    def body(self, rows: Codes) -> Codes:
        """(n, N) or (n, N, 3) of uint8, uint16, uint32 or float32."""
        body = rows[:, :, :3] if self.colours == 3 else rows[:, :, 0]
        if self.divide:
            assert self.alpha is not None
            body = _divided(body, rows[:, :, self.alpha])
        return self._facing(body.astype(self.dtype, copy=False))

    def cover(self, rows: Codes) -> Codes:
        """The alpha channel (n, N) as stored."""
        assert self.alpha is not None
        return self._facing(rows[:, :, self.alpha])

    def _facing(self, rows: Codes) -> Codes:
        return rows[:, ::-1] if self.mirrored else rows


def channels_of(spec: Any, stored: np.dtype[Any], name: str, format_name: str) -> Channels:
    """What OpenImageIO's *spec* says; *stored* is the type of the pixels that it gives."""
    names = [str(c).upper().rpartition(".")[2] for c in spec.channelnames]
    place = names.index("A") if "A" in names else 0
    alpha = place if place in (1, 3) else None
    dtype = np.dtype(np.float32) if stored.kind == "f" else stored
    if dtype not in (np.uint8, np.uint16, np.uint32, np.float32):
        raise InputFileError(f"{name} holds {dtype} pixels; allowed: unsigned or float")
    # Only these formats weight pixels by alpha; of the others, readers do not always say so.
    weighted = format_name in ("openexr", "tiff") or dtype.kind == "f"
    premultiplied = weighted and not spec.get_int_attribute("oiio:UnassociatedAlpha", 0)
    # Integer codes are weighted as codes (TIFF 6.0, ExtraSamples 1), not as light.
    divide = premultiplied and alpha is not None and dtype.kind != "f"
    return Channels(
        colours=3 if spec.nchannels >= 3 and place != 1 else 1,
        alpha=alpha,
        dtype=dtype,
        premultiplied=premultiplied and not divide,
        divide=divide,
        mirrored=orientation_of(spec) == 2,
    )


def upright(pixels: Codes, spec: Any) -> Codes:
    """Undo the EXIF orientation 1 … 8 (TIFF 6.0, tag 274) but 2, which is undone row by row."""
    orientation = orientation_of(spec)
    if orientation in (5, 6, 7, 8):
        pixels = pixels.swapaxes(0, 1)
    if orientation in (3, 4, 7, 8):
        pixels = pixels[::-1]
    if orientation in (3, 6, 7):
        pixels = pixels[:, ::-1]
    return np.ascontiguousarray(pixels)


def encoding_of(spec: Any, dtype: np.dtype[Any]) -> str:
    """What the file says of its codes; integers are sRGB and floats are light unless it does."""
    if dtype.kind == "f":
        return "linear"
    space = spec.get_string_attribute("oiio:ColorSpace", "").lower()
    if space.startswith("lin"):
        return "linear"
    gamma = spec.get_float_attribute("oiio:Gamma", 0.0)
    if space[:1] == "g" and 0.01 <= gamma <= 100:  # gamma…, or g22_rec709_scene
        return f"gamma:{gamma:.4g}"
    if space[:1] == "g" and space[1:3].isdigit():
        return f"gamma:{int(space[1:3]) / 10}"
    return "srgb"


def orientation_of(spec: Any) -> int:
    """How the picture lies, 1 … 8."""
    return int(spec.get_int_attribute("Orientation", 1))


def _divided(codes: Codes, alpha: Codes) -> Codes:
    """Codes divided by their alpha, rounded; where alpha is 0 the code does not matter."""
    full = np.iinfo(codes.dtype).max
    out = np.empty_like(codes)
    for row in range(codes.shape[0]):
        cover = np.maximum(alpha[row].astype(np.float64), 1)
        cover = cover[:, None] if codes.ndim == 3 else cover
        out[row] = np.rint(np.minimum(codes[row] * (full / cover), full))
    return out
