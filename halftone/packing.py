"""Level indices to the bytes of a frame buffer or a raster row, and back.

Every row starts on a byte; the bits after its last pixel are 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import mapped
from halftone.errors import UsageError

__all__ = ["Packing", "bytes_per_row", "pack", "unpack"]

Bytes = NDArray[np.uint8]

BITS = (1, 2, 4, 8)
ORDERS = ("msb", "lsb")


@dataclass(frozen=True)
class Packing:
    """How a device wants its pixels.

    bits : 1, 2, 4 or 8 a pixel. order : ``msb``, the leftmost pixel in the highest bits of a byte,
    or ``lsb``. codes : the device code of every level index, or None where they are the same; a
    printer on which 1 is ink has (1, 0).
    """

    bits: int
    order: str = "msb"
    codes: tuple[int, ...] | None = None

    def __post_init__(self) -> None:
        if self.bits not in BITS:
            raise UsageError(f"packing with {self.bits!r} bits; allowed: 1, 2, 4, 8")
        if self.order not in ORDERS:
            raise UsageError(f"bit order '{self.order}'; allowed: {', '.join(ORDERS)}")
        for code in self.codes or ():
            if not 0 <= code < 1 << self.bits:
                raise UsageError(f"device code {code} does not fit into {self.bits} bits")
        if self.codes is not None and len(set(self.codes)) != len(self.codes):
            raise UsageError(f"device codes {self.codes} name one code twice")


def bytes_per_row(width: int, bits: int) -> int:
    """Bytes of a row of *width* pixels."""
    return (width * bits + 7) // 8


def pack(indices: NDArray[np.uint8], packing: Packing, levels: int = 256) -> Bytes:
    """Level indices (M, N), known to be below *levels*, to packed rows (M, bytes_per_row)."""
    bits = packing.bits
    top = levels - 1
    if top >= (1 << bits if packing.codes is None else len(packing.codes)):
        top = int(indices.max(initial=0))
    if packing.codes is not None and top >= len(packing.codes):
        raise UsageError(f"level {top} has no device code: {len(packing.codes)} are given")
    if packing.codes is None and top >= 1 << bits:
        raise UsageError(f"level {top} does not fit into {bits} bits a pixel")
    if bits == 1:
        return _pack_bits(indices, packing)
    if packing.codes is not None:
        indices = mapped(np.array(packing.codes, np.uint8), indices)
    if bits == 8:
        return np.ascontiguousarray(indices)
    per_byte = 8 // bits
    rows, width = indices.shape
    padded = indices
    if width % per_byte:
        padded = np.zeros((rows, bytes_per_row(width, bits) * per_byte), np.uint8)
        padded[:, :width] = indices
    packed = np.zeros((rows, padded.shape[1] // per_byte), np.uint8)
    for place, shift in enumerate(_shifts(packing)):
        packed |= padded[:, place::per_byte] << np.uint8(shift)
    return packed


def _pack_bits(indices: NDArray[np.uint8], packing: Packing) -> Bytes:
    """Bits of levels 0 and 1, complemented afterwards where level 0 has the code 1."""
    order = packing.order
    packed = np.packbits(indices, axis=1, bitorder="big" if order == "msb" else "little")
    if packing.codes is not None and packing.codes[0] == 1:
        np.invert(packed, out=packed)
        spare = -indices.shape[1] % 8
        if spare and packed.shape[1]:
            packed[:, -1] &= np.uint8(0xFF << spare & 0xFF if order == "msb" else 0xFF >> spare)
    return packed


def unpack(packed: Bytes, width: int, packing: Packing) -> NDArray[np.uint8]:
    """Packed rows back to level indices (M, width): the inverse of :func:`pack`."""
    bits = packing.bits
    rows, size = packed.shape
    if size != bytes_per_row(width, bits):
        raise UsageError(f"rows of {size} bytes; {width} pixels need {bytes_per_row(width, bits)}")
    if bits == 8:
        codes = packed.copy()
    elif bits == 1:
        order = "big" if packing.order == "msb" else "little"
        codes = np.unpackbits(packed, axis=1, count=width, bitorder=order)  # type: ignore[call-overload]
    else:
        per_byte = 8 // bits
        wide = np.empty((rows, size * per_byte), np.uint8)
        for place, shift in enumerate(_shifts(packing)):
            wide[:, place::per_byte] = (packed >> np.uint8(shift)) & np.uint8((1 << bits) - 1)
        codes = wide[:, :width].copy()
    if packing.codes is None:
        return codes
    level = np.full(256, 255, np.uint8)
    level[list(packing.codes)] = np.arange(len(packing.codes))
    indices = level[codes]
    if (indices == 255).any() and len(packing.codes) < 256:
        bad = int(codes[indices == 255][0])
        raise UsageError(f"device code {bad} belongs to no level; allowed: {packing.codes}")
    return indices


def _shifts(packing: Packing) -> Sequence[int]:
    shifts = range(0, 8, packing.bits)
    return shifts if packing.order == "lsb" else shifts[::-1]
