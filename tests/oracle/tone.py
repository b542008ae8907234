"""Slow twins of halftone.tone: one number at a time, by the formulas as printed."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import pairwise

Curve = Callable[[float], float]


def single(value: float) -> float:
    """*value* rounded once to float32, to even at ties."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


# --- ladders


def log_ladder(i0: float, n: int) -> list[float]:
    """I_k = r^k · I0 with r = (1/I0)^(1/n)."""
    r = math.pow(1 / i0, 1 / n)
    return [math.pow(r, k) * i0 for k in range(n + 1)]


def uniform_ladder(n: int) -> list[float]:
    return [k / n for k in range(n + 1)]


def lstar_ladder(n: int) -> list[float]:
    return [luminance(100 * k / n) for k in range(n + 1)]


def lightness(y: float) -> float:
    """L* = 116·f(Y) − 16 with the cube root above (24/116)³ and its tangent below."""
    f = y ** (1 / 3) if y > (24 / 116) ** 3 else 841 / 108 * y + 16 / 116
    return 116 * f - 16


def luminance(lstar: float) -> float:
    f = (lstar + 16) / 116
    return f * f * f if f > 24 / 116 else (f - 16 / 116) * 108 / 841


def nearest_arithmetic(light: float, levels: Sequence[float]) -> int:
    """By exact differences; the darker of two that are equally near."""
    best = 0
    for k, level in enumerate(levels):
        if abs(Fraction(light) - Fraction(level)) < abs(Fraction(light) - Fraction(levels[best])):
            best = k
    return best


def nearest_ratio(light: float, levels: Sequence[float]) -> int:
    """By exact quotients, the larger over the smaller; the darker of two that are equally near."""
    if light == 0:
        return 0
    best, least = 0, None
    for k, level in enumerate(levels):
        quotient = Fraction(max(light, level)) / Fraction(min(light, level))
        if least is None or quotient < least:
            best, least = k, quotient
    return best


def visible_steps(levels: Sequence[float], threshold: float = 5.0) -> int:
    count = 0
    for low, high in pairwise(levels):
        if lightness(high / levels[-1]) - lightness(low / levels[-1]) > threshold:
            count += 1
    return count


# --- tables


def voltage(intensity: float, gamma: float, a: float = 1.0) -> float:
    return math.pow(intensity / a, 1 / gamma)


def gamma_table(size: int, gamma: float, a: float = 1.0) -> list[float]:
    return [voltage(k / (size - 1), gamma, a) for k in range(size)]


def combined_table(
    size: int, levels: Sequence[float], gamma: float, a: float = 1.0, by: str = "ratio"
) -> list[float]:
    find = nearest_ratio if by == "ratio" else nearest_arithmetic
    return [voltage(levels[find(k / (size - 1), levels)], gamma, a) for k in range(size)]


def to_dac(volts: float, bits: int) -> int:
    return round(min(max(volts, 0.0), 1.0) * (2**bits - 1))


def wrong_codes(size: int, gamma: float, bits: int, pixel_bits: int) -> int:
    table = [to_dac(volts, bits) for volts in gamma_table(size, gamma)]
    wrong = 0
    for value in range(2**pixel_bits):
        light = value / (2**pixel_bits - 1)
        if table[round(light * (size - 1))] != to_dac(voltage(light, gamma), bits):
            wrong += 1
    return wrong


# --- encodings


def srgb_to_light(v: float) -> float:
    return v / 12.92 if v <= 0.04045 else math.pow((v + 0.055) / 1.055, 2.4)


def light_to_srgb(light: float) -> float:
    return light * 12.92 if light <= 0.0031308 else 1.055 * math.pow(light, 1 / 2.4) - 0.055


def bt709_constants() -> tuple[float, float]:
    """α, β of BT.2020-2 table 4: 4.5β = αβ^0.45 − α + 1 and 4.5 = 0.45αβ^−0.55, by bisection."""
    low, high = 0.01, 0.03
    for _ in range(200):
        beta = (low + high) / 2
        if 5.5 * beta - 10 * math.pow(beta, 0.55) + 1 > 0:  # α = 10·β^0.55 put into the first
            low = beta
        else:
            high = beta
    return 10 * math.pow(beta, 0.55), beta


def light_to_bt709(light: float) -> float:
    alpha, beta = 1.09929682680944, 0.018053968510807
    return light * 4.5 if light < beta else alpha * math.pow(light, 0.45) - (alpha - 1)


def bt709_to_light(v: float) -> float:
    alpha, beta = 1.09929682680944, 0.018053968510807
    return v / 4.5 if v < 4.5 * beta else math.pow((v + (alpha - 1)) / alpha, 1 / 0.45)


def decoder(name: str) -> Curve:
    """code → light of ``srgb``, ``bt709``, ``linear`` or ``gamma:G``."""
    if name.startswith("gamma:"):
        gamma = float(name.removeprefix("gamma:"))
        return lambda v: math.pow(v, gamma)
    return {"srgb": srgb_to_light, "bt709": bt709_to_light, "linear": lambda v: v}[name]


# --- range rules, in exact arithmetic up to the power


def clip(light: float, darkest: float, lightest: float) -> float:
    if light < darkest:
        return darkest
    return lightest if light > lightest else light


def scale(light: float, brightest: float, lightest: float) -> float:
    """Light over the brightest light times the lightest level."""
    return float(Fraction(light) * Fraction(lightest) / Fraction(brightest))


def compress(light: float, lightest: float) -> float:
    """k + (w−k)·t/(1+t), t = (v−k)/(w−k), above k = 0.8·w."""
    w = Fraction(lightest)
    knee = Fraction(4, 5) * w
    if light <= knee:
        return light
    t = (Fraction(light) - knee) / (w - knee)
    return float(knee + (w - knee) * t / (1 + t))


# --- adjustments


def brightness(light: float, amount: float) -> float:
    return light * math.pow(4, amount)


def contrast(light: float, amount: float) -> float:
    return 0.18 * math.pow(max(light, 0.0) / 0.18, math.pow(4, amount))


def histogram(lights: Sequence[float]) -> list[int]:
    """Pixels per 8-bit sRGB code: the nearest, by rounding the encoded light."""
    counts = [0] * 256
    for light in lights:
        code = 255 * light_to_srgb(min(max(light, 0.0), 1.0))
        counts[math.ceil(code - 0.5)] += 1
    return counts


def auto_levels(lights: Sequence[float], share: float = 0.005) -> list[float]:
    """(v − black)/(white − black): more than *share* lie at or beyond either code."""
    counts = histogram(lights)
    most = share * len(lights)
    low, below = 0, counts[0]
    while below <= most:
        low += 1
        below += counts[low]
    high, above = 255, counts[255]
    while above <= most:
        high -= 1
        above += counts[high]
    black, white = single(srgb_to_light(low / 255)), single(srgb_to_light(high / 255))
    if white <= black:
        return list(lights)
    return [single((light - black) / (white - black)) for light in lights]
