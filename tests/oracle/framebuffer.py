"""A frame buffer pixel by pixel, in plain Python: slow and plain to read."""

from __future__ import annotations

import math
from collections.abc import Sequence

__all__ = [
    "bit_field_bytes",
    "ghosted",
    "light_of_voltage",
    "on_time",
    "plane_bytes",
    "srgb_to_light",
    "through_table",
]

FieldPlace = tuple[int, int, bool]
"""Offset, length, whether the most significant bit is the lowest."""


def light_of_voltage(volts: float, gamma: float, a: float, dac_bits: int) -> float:
    """I = a·V^γ, V being the nearest step of the converter."""
    top = 2**dac_bits - 1
    return a * math.pow(round(volts * top) / top, gamma)


def through_table(
    codes: Sequence[int], table: Sequence[float], gamma: float, a: float, dac_bits: int, black: float
) -> list[float]:
    """Light of every code: table, converter, response, and black added below."""
    shown = []
    for code in codes:
        light = light_of_voltage(table[code], gamma, a, dac_bits)
        shown.append(black + (1 - black) * light)
    return shown


def on_time(value: int, planes: int = 11) -> int:
    """Of a LED for an 8-bit value, in steps of 1/(2^planes − 1), by CIE 1931."""
    lightness = value * 100 / 255
    if lightness <= 8:
        light = lightness / 902.3
    else:
        light = ((lightness + 16) / 116) ** 3
    return math.floor(light * (2**planes - 1) + 0.5)


def ghosted(targets: Sequence[float], start: float, g: float) -> float:
    """What is seen after partial refreshes to each of *targets*."""
    seen = start
    for target in targets:
        seen = (1 - g) * target + g * seen
    return seen


def bit_field_bytes(rgb: Sequence[int], bits: int, places: Sequence[FieldPlace], big: bool) -> list[int]:
    """Bytes of one pixel, set bit by bit."""
    word = 0
    for value, (offset, length, msb_right) in zip(rgb, places, strict=True):
        for bit in range(length):
            if value // 2**bit % 2:
                word += 2 ** (offset + (length - 1 - bit if msb_right else bit))
    data = [word // 256**k % 256 for k in range(bits // 8)]
    return data[::-1] if big else data


def plane_bytes(row: Sequence[int], plane: int) -> list[int]:
    """One row of the plane that holds bit *plane* of every level, the leftmost in the high bit."""
    packed = [0] * ((len(row) + 7) // 8)
    for x, level in enumerate(row):
        if level // 2**plane % 2:
            packed[x // 8] += 128 // 2 ** (x % 8)
    return packed


def srgb_to_light(code: int) -> float:
    v = code / 255
    return v / 12.92 if v <= 0.04045 else math.pow((v + 0.055) / 1.055, 2.4)
