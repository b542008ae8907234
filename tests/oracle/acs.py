"""Slow twin of ZPL's alternative data compression, and its reading."""

from __future__ import annotations

from itertools import groupby

SMALL = "_GHIJKLMNOPQRSTUVWXY"
LARGE = "_ghijklmnopqrstuvwxyz"


def count(n: int) -> str:
    """The letters that say *n* times."""
    return "z" * (n // 400) + LARGE[n % 400 // 20].strip("_") + SMALL[n % 20].strip("_")


def run(digits: str) -> str:
    """A run of one digit."""
    return digits if len(digits) < 3 else count(len(digits)) + digits[0]


def row_text(row: bytes, above: bytes | None) -> str:
    """One row, knowing the one above it."""
    kept = row.rstrip(b"\x00")
    if kept and row == above:
        return ":"
    mark = "," if len(kept) < len(row) else ""
    return "".join(run("".join(same)) for _, same in groupby(kept.hex().upper())) + mark


def encode(rows: list[bytes]) -> list[str]:
    """The text of every row."""
    return [row_text(row, rows[i - 1] if i else None) for i, row in enumerate(rows)]
