"""Packing pixel by pixel and bit by bit, in plain Python: slow and plain to read."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["pack_row", "unpack_row"]


def pack_row(indices: Sequence[int], bits: int, order: str, codes: Sequence[int] | None) -> list[int]:
    """Bytes of one row of level indices; *order* is where the leftmost pixel lies, msb or lsb."""
    per_byte = 8 // bits
    packed = []
    for start in range(0, len(indices), per_byte):
        byte = 0
        for place, index in enumerate(indices[start : start + per_byte]):
            code = index if codes is None else codes[index]
            shift = place * bits if order == "lsb" else 8 - bits - place * bits
            byte += code * 2**shift
        packed.append(byte)
    return packed


def unpack_row(
    packed: Sequence[int], width: int, bits: int, order: str, codes: Sequence[int] | None
) -> list[int]:
    """The level indices of one row of bytes."""
    per_byte = 8 // bits
    indices = []
    for x in range(width):
        place = x % per_byte
        shift = place * bits if order == "lsb" else 8 - bits - place * bits
        code = packed[x // per_byte] // 2**shift % 2**bits
        indices.append(code if codes is None else list(codes).index(code))
    return indices
