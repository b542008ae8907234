"""PackBits byte by byte, in plain Python: slow and plain to read."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["pack_row", "unpack_row"]


def pack_row(row: Sequence[int], trim: bool = False) -> list[int]:
    """The packets of a row: runs of three and more, and of two where no single bytes came before."""
    row = list(row)
    while trim and row and row[-1] == 0:
        row.pop()
    packed: list[int] = []
    single: list[int] = []
    while row:
        run = 1
        while run < min(128, len(row)) and row[run] == row[0]:
            run += 1
        if run >= 3 or (run == 2 and not single):
            packed += [*literal(single), 257 - run, row[0]]
            single = []
        else:
            single += row[:run]
        row = row[run:]
    return packed + literal(single)


def literal(single: list[int]) -> list[int]:
    """Packets of at most 128 single bytes."""
    packed = []
    for start in range(0, len(single), 128):
        part = single[start : start + 128]
        packed += [len(part) - 1, *part]
    return packed


def unpack_row(packed: Sequence[int]) -> list[int]:
    row: list[int] = []
    rest = list(packed)
    while rest:
        control = rest.pop(0)
        if control < 128:
            row, rest = row + rest[: control + 1], rest[control + 1 :]
        elif control > 128:
            row += [rest.pop(0)] * (257 - control)
    return row
