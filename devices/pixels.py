"""Pixel formats of frame buffers: level indices or R, G, B codes to bytes, and back.

Three kinds: :class:`Indexed`, 1 … 8 bits that name a level or a palette's colour; :class:`Fields`, words
with a bit field for each of R, G, B, as Linux describes them; :class:`Planes`, every bit of a level in a
picture of its own. Every row starts on a byte.

Sources: linux/fb.h (fb_bitfield, FB_VISUAL_MONO01, FB_VISUAL_MONO10); drivers of e-paper panels for the
order of nibbles and planes.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import whole
from halftone.errors import UsageError, near
from halftone.packing import Packing, bytes_per_row, pack, unpack

__all__ = ["FORMATS", "Field", "Fields", "Indexed", "PixelFormat", "Planes", "pixel_format"]

Bytes = NDArray[np.uint8]
Codes = NDArray[Any]


class PixelFormat(Protocol):
    """channels : 1, level indices (M, N), or 3, codes (M, N, 3)."""

    @property
    def channels(self) -> int: ...
    @property
    def bits_per_channel(self) -> tuple[int, ...]: ...
    def packed_shape(self, rows: int, width: int) -> tuple[int, ...]:
        """Shape of what :meth:`pack` makes of *rows* rows of *width* pixels; the last is bytes."""

    def pack(self, pixels: Codes) -> Bytes: ...
    def unpack(self, packed: Bytes, width: int) -> Codes: ...


@dataclass(frozen=True)
class Indexed:
    """Pixels of 1, 2, 4 or 8 bits by a :class:`halftone.packing.Packing`."""

    packing: Packing
    channels = 1

    @property
    def bits_per_channel(self) -> tuple[int, ...]:
        return (self.packing.bits,)

    def packed_shape(self, rows: int, width: int) -> tuple[int, ...]:
        return rows, bytes_per_row(width, self.packing.bits)

    def pack(self, pixels: Codes) -> Bytes:
        return pack(pixels.astype(np.uint8, copy=False), self.packing)

    def unpack(self, packed: Bytes, width: int) -> Codes:
        return unpack(_checked(packed, self, width), width, self.packing)


@dataclass(frozen=True)
class Field:
    """Where a channel lies in a word. offset : of its lowest bit, from the word's lowest. length : bits.
    msb_right : whether its most significant bit is the lowest one, as fb_bitfield may say."""

    offset: int
    length: int
    msb_right: bool = False

    def __post_init__(self) -> None:
        whole("offset of a bit field", self.offset, 0, 31)
        whole("length of a bit field", self.length, 1, 16)

    def placed(self, codes: Codes) -> NDArray[np.uint32]:
        """The codes at their place in words."""
        ordered = self._reversed(codes) if self.msb_right else codes
        return ordered.astype(np.uint32) << np.uint32(self.offset)

    def taken(self, words: NDArray[np.uint32]) -> Codes:
        """The codes out of words."""
        codes = words >> np.uint32(self.offset) & np.uint32((1 << self.length) - 1)
        return self._reversed(codes) if self.msb_right else codes

    def _reversed(self, codes: Codes) -> Codes:
        every = np.arange(1 << self.length)
        turned = np.zeros_like(every)
        for bit in range(self.length):
            turned |= (every >> bit & 1) << (self.length - 1 - bit)
        return turned[codes].astype(codes.dtype)


@dataclass(frozen=True)
class Fields:
    """Words of 8, 16, 24 or 32 bits with a bit field for each of R, G, B; other bits are 0.

    big_endian : whether the high byte of a word comes first, as LCD controllers on SPI want it; a PC's
    frame buffer has the low byte first.
    """

    bits: int
    red: Field
    green: Field
    blue: Field
    big_endian: bool = False
    channels = 3

    def __post_init__(self) -> None:
        if self.bits not in (8, 16, 24, 32):
            raise UsageError(f"pixels of {self.bits!r} bits with bit fields; allowed: 8, 16, 24, 32")
        taken = 0
        for name, field in self._named:
            mask = (1 << field.length) - 1 << field.offset
            if mask >> self.bits:
                raise UsageError(
                    f"{name} lies at bits {field.offset} … {field.offset + field.length - 1} "
                    f"of a pixel of {self.bits} bits"
                )
            if mask & taken:
                raise UsageError(f"the bit field of {name} overlaps another one's")
            taken |= mask

    @property
    def _named(self) -> tuple[tuple[str, Field], ...]:
        return ("red", self.red), ("green", self.green), ("blue", self.blue)

    @property
    def bits_per_channel(self) -> tuple[int, ...]:
        return self.red.length, self.green.length, self.blue.length

    def packed_shape(self, rows: int, width: int) -> tuple[int, ...]:
        return rows, width * self.bits // 8

    def pack(self, pixels: Codes) -> Bytes:
        words = np.zeros(pixels.shape[:2], np.uint32)
        for channel, (_, field) in enumerate(self._named):
            words |= field.placed(pixels[..., channel])
        size = self.bits // 8
        parts = words.astype("<u4").view(np.uint8).reshape(*words.shape, 4)[..., :size]
        if self.big_endian:
            parts = parts[..., ::-1]
        return np.ascontiguousarray(parts).reshape(len(words), -1)

    def unpack(self, packed: Bytes, width: int) -> Codes:
        packed = _checked(packed, self, width)
        size = self.bits // 8
        parts = np.ascontiguousarray(packed).reshape(packed.shape[0], width, size)
        if self.big_endian:
            parts = parts[..., ::-1]
        wide = np.zeros((*parts.shape[:2], 4), np.uint8)
        wide[..., :size] = parts
        words = wide.view("<u4")[..., 0].astype(np.uint32)
        kind = np.uint8 if max(self.bits_per_channel) <= 8 else np.uint16
        return np.stack([field.taken(words).astype(kind) for _, field in self._named], axis=-1)


@dataclass(frozen=True)
class Planes:
    """Every bit of a level in a picture of 1 bit a pixel, uint8 (count, M, bytes a row).

    count : planes, 1 … 16. order : as in a Packing. high_first : whether the first plane holds the most
    significant bits.
    """

    count: int
    order: str = "msb"
    high_first: bool = True
    channels = 1

    def __post_init__(self) -> None:
        whole("planes", self.count, 1, 16)
        Packing(1, self.order)

    @property
    def bits_per_channel(self) -> tuple[int, ...]:
        return (self.count,)

    @property
    def _shifts(self) -> range:
        return range(self.count)[::-1] if self.high_first else range(self.count)

    def packed_shape(self, rows: int, width: int) -> tuple[int, ...]:
        return self.count, rows, bytes_per_row(width, 1)

    def pack(self, pixels: Codes) -> Bytes:
        packing = Packing(1, self.order)
        return np.stack([pack((pixels >> s & 1).astype(np.uint8), packing) for s in self._shifts])

    def unpack(self, packed: Bytes, width: int) -> Codes:
        packed = _checked(packed, self, width)
        kind = np.uint8 if self.count <= 8 else np.uint16
        levels = np.zeros((packed.shape[1], width), np.int64)
        for plane, shift in zip(packed, self._shifts, strict=True):
            levels |= unpack(plane, width, Packing(1, self.order)).astype(np.int64) << shift
        return levels.astype(kind)


def _checked(packed: Bytes, form: PixelFormat, width: int) -> Bytes:
    expected = form.packed_shape(packed.shape[-2] if packed.ndim > 1 else 0, width)
    if packed.dtype != np.uint8 or packed.shape != expected:
        raise UsageError(
            f"packed pixels are {packed.dtype} of shape {packed.shape}; {width} pixels a row need "
            f"uint8 of shape {expected}"
        )
    return packed


def _rgb(bits: int, red: int, green: int, blue: int, high: str) -> Fields:
    """Fields of those lengths side by side; *high* lies in the highest bits."""
    if high == "red":
        return Fields(bits, Field(blue + green, red), Field(blue, green), Field(0, blue))
    return Fields(bits, Field(0, red), Field(red, green), Field(red + green, blue))


FORMATS: dict[str, PixelFormat] = {
    "mono10": Indexed(Packing(1)),
    "mono01": Indexed(Packing(1, "msb", (1, 0))),
    **{f"index{bits}": Indexed(Packing(bits)) for bits in (1, 2, 4, 8)},
    **{f"index{bits}-lsb": Indexed(Packing(bits, "lsb")) for bits in (1, 2, 4)},
    "rgb332": _rgb(8, 3, 3, 2, "red"),
    "rgb555": _rgb(16, 5, 5, 5, "red"),
    "bgr555": _rgb(16, 5, 5, 5, "blue"),
    "rgb565": _rgb(16, 5, 6, 5, "red"),
    "bgr565": _rgb(16, 5, 6, 5, "blue"),
    "rgb888": _rgb(24, 8, 8, 8, "red"),
    "bgr888": _rgb(24, 8, 8, 8, "blue"),
    "xrgb8888": _rgb(32, 8, 8, 8, "red"),
    "xbgr8888": _rgb(32, 8, 8, 8, "blue"),
}
"""By name. rgb…: red in the highest bits of the word, whose low byte comes first; with ``-be`` after the
name the high byte does. mono10: 1 is white; mono01: 1 is black."""

_ALLOWED = (*FORMATS, "NAME-be", "planesN", "planesN-lsb")
_PLANES = re.compile(r"planes(\d{1,2})(-lsb)?")


def pixel_format(name: str) -> PixelFormat:
    """The format called *name*: one of :data:`FORMATS`, an rgb one with ``-be``, or ``planesN``."""
    text = name.strip().lower()
    if text in FORMATS:
        return FORMATS[text]
    plain = FORMATS.get(text.removesuffix("-be"))
    if isinstance(plain, Fields):
        return Fields(plain.bits, plain.red, plain.green, plain.blue, big_endian=True)
    planes = _PLANES.fullmatch(text)
    if planes:
        return Planes(int(planes[1]), "lsb" if planes[2] else "msb")
    raise UsageError(near(name, _ALLOWED, "pixel format"))
