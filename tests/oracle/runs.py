"""The line compression of PWG raster, CUPS raster and URF, byte by byte: slow and plain to read."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["pack_line", "pack_lines", "unpack_lines"]


def pack_line(line: Sequence[int]) -> list[int]:
    """The packets of one line, in units of a byte."""
    packets: list[int] = []
    literals: list[int] = []

    def end_literals() -> None:
        if len(literals) == 1:
            packets.extend([0, literals[0]])
        elif literals:
            packets.extend([257 - len(literals), *literals])
        literals.clear()

    x = 0
    while x < len(line):
        run = 1
        while run < 128 and x + run < len(line) and line[x + run] == line[x]:
            run += 1
        if run >= 3 or (run == 2 and not literals):
            end_literals()
            packets.extend([run - 1, line[x]])
            x += run
            continue
        literals.append(line[x])
        x += 1
        if len(literals) == 128:
            end_literals()
    end_literals()
    return packets


def pack_lines(rows: Sequence[Sequence[int]]) -> bytes:
    """All lines of a page, equal neighbours together, at most 256 of them."""
    made: list[int] = []
    y = 0
    while y < len(rows):
        count = 1
        while count < 256 and y + count < len(rows) and rows[y + count] == rows[y]:
            count += 1
        made += [count - 1, *pack_line(rows[y])]
        y += count
    return bytes(made)


def unpack_lines(data: bytes, height: int, size: int, unit: int, paper: int) -> tuple[list[bytes], int]:
    """The lines of a page and how many bytes they took.

    Raises ValueError with what is wrong (*more*, *long* or *lines*) and where.
    """
    lines: list[bytes] = []
    place = 0
    while len(lines) < height:
        if place >= len(data):
            raise ValueError("more", len(data))
        count = data[place] + 1
        if len(lines) + count > height:
            raise ValueError("lines", place)
        place += 1
        line = b""
        while len(line) < size:
            if place >= len(data):
                raise ValueError("more", len(data))
            packet = data[place]
            if packet == 128:
                line += bytes([paper]) * (size - len(line))
                place += 1
                continue
            units = packet + 1 if packet < 128 else 257 - packet
            if len(line) + units * unit > size:
                raise ValueError("long", place)
            given = data[place + 1 : place + 1 + (unit if packet < 128 else units * unit)]
            if len(given) < (unit if packet < 128 else units * unit):
                raise ValueError("more", len(data))
            line += given * units if packet < 128 else given
            place += 1 + len(given)
        lines += [line] * count
    return lines, place
