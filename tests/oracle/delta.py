"""PCL's delta rows command by command, in plain Python: slow and plain to read."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["delta_row", "undelta_row"]


def delta_row(row: Sequence[int], seed: Sequence[int]) -> list[int]:
    """The commands that make *row* of *seed*, which is as long."""
    commands: list[int] = []
    free = x = 0
    while x < len(row):
        if row[x] == seed[x]:
            x += 1
            continue
        changed = []
        while x + len(changed) < len(row) and len(changed) < 8:
            at = x + len(changed)
            if row[at] == seed[at]:
                break
            changed.append(row[at])
        skip = x - free
        commands.append((len(changed) - 1) << 5 | min(skip, 31))
        if skip >= 31:
            whole, last = divmod(skip - 31, 255)
            commands += [255] * whole + [last]
        commands += changed
        x = free = x + len(changed)
    return commands


def undelta_row(commands: Sequence[int], seed: Sequence[int]) -> list[int]:
    row, rest, x = list(seed), list(commands), 0
    while rest:
        command = rest.pop(0)
        x += command & 31
        more = 255 if command & 31 == 31 else 0
        while more == 255:
            more = rest.pop(0)
            x += more
        for _ in range((command >> 5) + 1):
            row[x] = rest.pop(0)
            x += 1
    return row
