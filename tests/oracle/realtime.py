"""Taking real-time commands out of ESC/POS pictures, byte by byte and dot by dot, in plain Python."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["calm", "calm_columns", "calm_rows", "pairs"]

SECOND = (0x04, 0x05, 0x14)


def pairs(data: Sequence[int]) -> list[int]:
    """Where DLE EOT, DLE ENQ and DLE DC4 begin."""
    return [i for i in range(len(data) - 1) if data[i] == 0x10 and data[i + 1] in SECOND]


def calm(before: int, data: Sequence[int]) -> list[int]:
    """*data*, which follows the byte *before* of a header, with one dot moved for each pair: the
    lowest of the first byte that may be changed, to the next higher place."""
    stream = [before, *data]
    out = list(stream)
    for i in pairs(stream):
        place = max(i, 1)
        dot = stream[place] & -stream[place]
        out[place] = stream[place] - dot + 2 * dot
    return out[1:]


def calm_rows(dots: Sequence[Sequence[int]], heights: Sequence[int], before: int) -> list[list[int]]:
    """Rows of dots, 8 to a byte, that are sent in commands of so many rows."""
    size = (len(dots[0]) + 7) // 8
    done: list[list[int]] = []
    for height in heights:
        part = dots[len(done) : len(done) + height]
        data = [_byte(row[x : x + 8]) for row in part for x in range(0, len(row), 8)]
        data = calm(before, data)
        for y in range(height):
            bits = [bit for byte in data[y * size : (y + 1) * size] for bit in _bits(byte)]
            done.append(bits[: len(dots[0])])
    return done


def calm_columns(dots: Sequence[Sequence[int]], before: int) -> list[list[int]]:
    """The same in bands of 24 rows, column by column, 3 bytes each."""
    done: list[list[int]] = []
    for top in range(0, len(dots), 24):
        part = dots[top : top + 24]
        columns = [[row[x] for row in part] for x in range(len(part[0]))]
        data = [_byte(column[y : y + 8]) for column in columns for y in (0, 8, 16)]
        bits = [bit for byte in calm(before, data) for bit in _bits(byte)]
        done += [[bits[x * 24 + y] for x in range(len(columns))] for y in range(len(part))]
    return done


def _byte(bits: Sequence[int]) -> int:
    return sum(bit << 7 - place for place, bit in enumerate(bits))


def _bits(byte: int) -> list[int]:
    return [byte >> 7 - place & 1 for place in range(8)]
