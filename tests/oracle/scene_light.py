"""Slow twins of scene/_light_kernels.py, sample by sample; and the formulas in float64.

The twins round every operation to float32, as the kernels do: their results are the same to the bit.
"""

from __future__ import annotations

import cmath
import math

import numpy as np

F = np.float32
LARGE = F(3.4e38)
LOG2 = [1.4426950036521387, -0.7213473468007835, 0.4809106430162682, -0.3607036830926482]
LOG2 += [0.287916245662061, -0.23894481295734776, 0.215715623843481, -0.20726981791952753]
LOG2 += [0.12583705907448742]
EXP2 = [1.0, 0.6931472028552119, 0.24022647913615663, 0.05550332470782865, 0.009618437358224374]
EXP2 += [0.001339887455736566, 0.0001535336206662288]


def horner(coefficients, x):
    total = F(coefficients[-1])
    for a in reversed(coefficients[:-1]):
        total = total * x + F(a)
    return total


def power(x, n):
    """x^n = 2^(n·log2 x)."""
    if x > F(2.0**-126):
        mantissa, e = math.frexp(float(x))
        if F(mantissa) < F(math.sqrt(0.5)):
            mantissa, e = 2 * mantissa, e - 1
        f = F(mantissa) - F(1)
        log2 = F(e) + horner(LOG2, f) * f
    else:
        log2 = -LARGE
    y = n * log2
    if not y > F(-126):
        return F(0)
    i = int(y - F(0.5))
    return F(math.ldexp(float(horner(EXP2, y - F(i))), i))


def within(x):
    return F(min(x, F(1))) if x > 0 else F(0)


def dot(a, b):
    return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]


def to(place, p):
    return [place[i] - place[3] * p[i] for i in range(3)]


def facing(start, normal, direction, cosine):
    for k in range(len(cosine)):
        cosine[k] = within(dot(normal[:, start + k], direction) * direction[3])


def incidence(start, position, normal, light, cosine):
    for k in range(len(cosine)):
        toward = to(light, position[:, start + k])
        cosine[k] = within(dot(normal[:, start + k], toward) * (F(1) / np.sqrt(dot(toward, toward))))


def halfway(start, position, normal, light, eye, cosine):
    for k in range(len(cosine)):
        p, n = position[:, start + k], normal[:, start + k]
        toward, view = to(light, p), to(eye, p)
        t = np.sqrt(dot(toward, toward) / dot(view, view))
        half = [a + b * t for a, b in zip(toward, view, strict=True)]
        cosine[k] = within(dot(n, half) * (F(1) / np.sqrt(dot(half, half))))


def mirrored(start, position, normal, light, eye, cosine):
    for k in range(len(cosine)):
        p, n = position[:, start + k], normal[:, start + k]
        toward, view = to(light, p), to(eye, p)
        s = F(1) / np.sqrt(dot(toward, toward) * dot(view, view))
        two = F(2) * dot(n, toward)
        mirror = [two * a - b for a, b in zip(n, toward, strict=True)]
        cosine[k] = within(dot(mirror, view) * s)


def sharpen(incidence, cosine, exponent, row):
    for k in range(len(row)):
        c = within(cosine[k])
        row[k] = power(c, exponent[k]) if c > 0 and incidence[k] > 0 else 0


def reflect(start, incidence, material, share, row):
    steps = 4096
    for k in range(len(row)):
        c = incidence[k]
        u = (F(9) * c) / (F(8) * c + F(1)) * F(steps)
        i = min(int(u), steps - 1)
        table = share[material[start + k] * (steps + 1) :]
        row[k] *= within(table[i] + (u - F(i)) * (table[i + 1] - table[i]))


def attenuate(start, position, light, a, factor):
    for k in range(len(factor)):
        toward = to(light, position[:, start + k])
        d = np.sqrt(dot(toward, toward)) * light[4]
        f = F(1) / ((a[2] * d + a[1]) * d + a[0])
        factor[k] *= f if f < 1 else F(1)


def from_axis(start, k, position, light, axis):
    away = [light[3] * position[i, start + k] - light[i] for i in range(3)]
    return dot(away, axis) / np.sqrt(dot(away, away))


def cone(start, position, light, axis, factor):
    outer, inner = axis[3], axis[4]
    for k in range(len(factor)):
        c = from_axis(start, k, position, light, axis)
        if c < outer:
            factor[k] *= F(0)
        elif c < inner:
            t = within((c - outer) / (inner - outer))
            factor[k] *= (t * t) * (F(3) - F(2) * t)


def off_axis(start, position, light, axis, cosine):
    for k in range(len(cosine)):
        cosine[k] = within(from_axis(start, k, position, light, axis)) if axis[5] > 0 else 1


def flaps(start, position, limits, factor):
    for k in range(len(factor)):
        p = position[:, start + k]
        inside = all(limits[i, 0] <= p[i] <= limits[i, 1] for i in range(3))
        factor[k] *= F(inside)


def add(start, material, colour, row, out):
    for k in range(len(row)):
        for c in range(len(out)):
            out[c, start + k] += colour[c, material[start + k]] * row[k]


def add_clamped(start, material, colour, row, out):
    for k in range(len(row)):
        for c in range(len(out)):
            out[c, start + k] += min(colour[c, material[start + k]] * row[k], F(1))


def largest(start, material, peak, row, top):
    for k in range(len(row)):
        top[k] = max(top[k], peak[material[start + k]] * row[k])


def unit(v):
    v = np.asarray(v, np.float64)
    return v / np.linalg.norm(v)


def reflectance(cosine, n, k=0.0):
    """Fresnel's share from complex refraction angles: another way than scene/fresnel.py goes."""
    m = complex(n, -k)
    sine = math.sqrt(1 - cosine * cosine) / m
    t = cmath.sqrt(1 - sine * sine)
    s = (cosine - m * t) / (cosine + m * t)
    p = (m * cosine - t) / (m * cosine + t)
    return (abs(s) ** 2 + abs(p) ** 2) / 2


def illuminate(material, lights, ambient, position, normal, viewer, reflection="blinn", share=None):
    """The formula of the books for one sample in float64; *viewer* is V. Point and distant lights."""
    total = np.array(material.ambient) * ambient
    for light in lights:
        away = np.subtract(light.position, position)
        distance = np.linalg.norm(away)
        toward = unit(away) if light.kind != "distant" else -unit(light.direction)
        a0, a1, a2 = light.attenuation
        f = min(1.0, 1 / (a0 + a1 * distance + a2 * distance**2)) if light.kind != "distant" else 1.0
        facing = float(np.dot(normal, toward))
        if facing <= 0:
            continue
        if reflection == "blinn":
            c = np.dot(normal, unit(toward + viewer))
        else:
            c = np.dot(viewer, 2 * facing * np.asarray(normal) - toward)
        shine = max(0.0, c) ** material.exponent if c > 0 else 0.0
        w = 1.0 if share is None else share(facing)
        colour = np.array(material.diffuse) * facing + w * np.array(material.specular) * shine
        total = total + f * np.array(light.intensity) * colour
    return total
