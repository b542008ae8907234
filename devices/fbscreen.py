"""What a Linux frame buffer's driver says of its memory (linux/fb.h), and pixels in that layout."""

from __future__ import annotations

import mmap
import struct
import sys
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halftone.errors import DeviceFaultError, UsageError
from halftone.packing import Packing, bytes_per_row, pack, unpack

__all__ = ["FIX", "VAR", "Field", "Screen"]

MONO01, MONO10, TRUECOLOR, PSEUDOCOLOR, DIRECTCOLOR, STATIC_PSEUDOCOLOR = range(6)
"""The visuals. MONO01: 1 is black. MONO10: 1 is white."""
VISUALS = ("MONO01", "MONO10", "TRUECOLOR", "PSEUDOCOLOR", "DIRECTCOLOR", "STATIC_PSEUDOCOLOR", "FOURCC")
PACKED_PIXELS = 0
REVERSED_IN_BYTE, WRAPS = 2, 256
"""Bits of nonstd and of vmode."""

FIX = struct.Struct("@16sL4I3HILIIH2H0L")
"""fb_fix_screeninfo."""
VAR = struct.Struct("@40I")
"""fb_var_screeninfo, of whose numbers these are some:"""
OFFSETS, BITS, GRAYSCALE, FIELDS, NONSTD, ACTIVATE, VMODE = 4, 6, 7, 8, 20, 21, 33

Words = NDArray[np.uint32]
"""One pixel each, in its lowest bits."""


@dataclass(frozen=True)
class Field:
    """The bits of a pixel that hold one thing (fb_bitfield); bit 0 is the lowest."""

    offset: int
    length: int
    msb_right: int = 0

    @property
    def top(self) -> int:
        return (1 << self.length) - 1

    def put(self, codes: ArrayLike) -> Words:
        """Codes 0 … 1 as the nearest values of the field, in place."""
        values = np.rint(np.asarray(codes, np.float64) * self.top).astype(np.uint32)
        return self._turned(values) << np.uint32(self.offset)

    def get(self, words: Words) -> Words:
        """The field's values in pixels."""
        return self._turned(words >> np.uint32(self.offset) & np.uint32(self.top))

    def seen(self, words: Words) -> NDArray[np.uint8]:
        """The field's values in pixels, as the nearest codes of 8 bits."""
        table = np.rint(np.arange(self.top + 1) * (255 / max(self.top, 1))).astype(np.uint8)
        codes: NDArray[np.uint8] = table[self.get(words)]
        return codes

    def _turned(self, values: Words) -> Words:
        """With the highest bit at the right, where the driver says so."""
        if not self.msb_right:
            return values
        turned = np.zeros_like(values)
        for bit in range(self.length):
            turned |= (values >> np.uint32(bit) & np.uint32(1)) << np.uint32(self.length - 1 - bit)
        return turned


@dataclass(frozen=True)
class Screen:
    """The layout, in pixels and bytes.

    memory : bytes to map. origin : where in them the picture memory begins, as a mapping begins with
    a page. stride : bytes of a line. lines : all there are, of which *height* are in view from *top*
    and *left* on. grayscale : 0 colour, 1 gray, else a FOURCC. fields : red, green, blue,
    transparency; on a gray screen the first three are one.
    """

    name: str
    memory: int
    origin: int
    kind: int
    visual: int
    stride: int
    width: int
    height: int
    lines: int
    left: int
    top: int
    bits: int
    grayscale: int
    fields: tuple[Field, Field, Field, Field]
    nonstd: int = 0
    wraps: bool = False

    @classmethod
    def parse(cls, fix: bytes, var: bytes) -> Self:
        """From the two structures as the kernel fills them."""
        name, start, size, kind, _, visual, _, _, _, stride, *_ = FIX.unpack(fix)
        v = VAR.unpack(var)
        red, green, blue, alpha = (Field(*v[k : k + 3]) for k in range(FIELDS, NONSTD, 3))
        if v[GRAYSCALE] == 1:
            red = green = blue = red if red.length else Field(0, v[BITS])
        return cls(
            name=name.partition(b"\0")[0].decode("latin-1"),
            memory=start % mmap.PAGESIZE + size,
            origin=start % mmap.PAGESIZE,
            kind=kind,
            visual=visual,
            stride=stride,
            width=v[0],
            height=v[1],
            lines=v[3],
            left=v[OFFSETS],
            top=v[OFFSETS + 1],
            bits=v[BITS],
            grayscale=v[GRAYSCALE],
            fields=(red, green, blue, alpha),
            nonstd=v[NONSTD],
            wraps=bool(v[VMODE] & WRAPS),
        )

    @property
    def visual_name(self) -> str:
        return VISUALS[self.visual] if self.visual < len(VISUALS) else str(self.visual)

    @property
    def mono(self) -> bool:
        return self.visual in (MONO01, MONO10)

    @property
    def mapped(self) -> bool:
        """Whether a pixel is the number of a colour, which may be ours to choose or not."""
        return self.visual == PSEUDOCOLOR or (self.visual == STATIC_PSEUDOCOLOR and not self.grayscale)

    @property
    def entries(self) -> int:
        """Of the colour map; a true-colour screen has the 16 of its text console."""
        if self.visual == DIRECTCOLOR:
            return max(1 << field.length for field in self.fields[:3])
        return 1 << min(self.fields[0].length or self.bits, self.bits, 8) if self.mapped else 16

    @property
    def order(self) -> str:
        """Which bits of a byte hold the leftmost of several pixels, ``msb`` or ``lsb``, as Linux
        itself draws there (drivers/video/fbdev/core/fb_draw.h)."""
        lowest = (sys.byteorder == "little") != bool(self.nonstd & REVERSED_IN_BYTE)
        return "lsb" if lowest else "msb"

    def check(self) -> None:
        """Raises UsageError for a layout that is not known here, DeviceFaultError for nonsense."""
        bits = (1,) if self.mono else (1, 2, 4, 8) if self.mapped else (8, 16, 24, 32)
        known = self.visual <= STATIC_PSEUDOCOLOR and self.kind == PACKED_PIXELS and self.grayscale <= 1
        if not known or self.bits not in bits:
            raise UsageError(
                f"'{self.name}' has {self.bits} bits a pixel, visual {self.visual_name}, type "
                f"{self.kind}, grayscale {self.grayscale}; allowed: packed pixels that are MONO of 1, "
                "PSEUDOCOLOR of 1, 2, 4, 8, or TRUECOLOR or DIRECTCOLOR of 8, 16, 24, 32 bits. "
                "Another mode (set_mode) may be one"
            )
        last = self.lines if self.wraps else self.top + self.height
        across = bytes_per_row(self.left + self.width, self.bits)
        if across > self.stride or self.origin + last * self.stride > self.memory or not last:
            raise DeviceFaultError(
                f"the driver of '{self.name}' says that {last} lines of {self.stride} bytes, of which "
                f"{across} are used, lie in {self.memory - self.origin} bytes"
            )
        wild = [f for f in self.fields if f.length > 16 or f.offset + f.length > self.bits]
        if wild and not (self.mono or self.mapped):
            raise DeviceFaultError(f"the driver of '{self.name}' has {wild[0]} in {self.bits} bits")

    def starts(self) -> list[int]:
        """Where the lines in view begin in the mapped memory."""
        rows = [self.top + row for row in range(self.height)]
        return [self.origin + (row % self.lines if self.wraps else row) * self.stride for row in rows]

    def store(self, memory: mmap.mmap, words: Words, order: str) -> None:
        """Pixels (height, width) to where they are in view; no other pixel changes."""
        first = self.left * self.bits // 8
        if self.bits < 8:
            packing = Packing(self.bits, order)
            size = bytes_per_row(self.left + self.width, self.bits)
            first, old = 0, self._bytes(memory, 0, size)
            every = unpack(old, size * 8 // self.bits, packing)
            every[:, self.left : self.left + self.width] = words
            rows = pack(every, packing)
        else:
            rows = _as_bytes(words, self.bits // 8)
        for start, row in zip(self.starts(), rows, strict=True):
            memory[start + first : start + first + row.size] = row.tobytes()

    def load(self, memory: mmap.mmap, order: str) -> Words:
        """The pixels in view, (height, width)."""
        if self.bits < 8:
            old = self._bytes(memory, 0, bytes_per_row(self.left + self.width, self.bits))
            every = unpack(old, self.left + self.width, Packing(self.bits, order))
            return every[:, self.left :].astype(np.uint32)
        size = self.bits // 8
        used = self._bytes(memory, self.left * size, self.width * size)
        wide = np.zeros((self.height, self.width, 4), np.uint8)
        wide[:, :, _lowest(size)] = used.reshape(self.height, self.width, size)
        return wide.view(np.uint32)[:, :, 0]

    def _bytes(self, memory: mmap.mmap, first: int, size: int) -> NDArray[np.uint8]:
        joined = b"".join(memory[start + first : start + first + size] for start in self.starts())
        return np.frombuffer(joined, np.uint8).reshape(self.height, size)


def _as_bytes(words: Words, size: int) -> NDArray[np.uint8]:
    wide = np.ascontiguousarray(words).view(np.uint8).reshape(*words.shape, 4)
    return np.ascontiguousarray(wide[:, :, _lowest(size)]).reshape(len(words), -1)


def _lowest(size: int) -> slice:
    """The *size* lowest bytes of four, in this machine's order."""
    return slice(size) if sys.byteorder == "little" else slice(4 - size, 4)
