"""Slow twins: tone-dependent weights, modulated thresholds, and the Hilbert curve."""

from __future__ import annotations

import numpy as np

from tests.oracle.diffusion import nearest, scan
from tests.oracle.point import noise as random

f32 = np.float32


def decision(v_in, distinct, width, edges, r) -> tuple[int, int, np.float32]:
    """(low, tone, threshold) of one pixel; width of the noise by tone, r its random number."""
    low = 0
    while low < len(distinct) - 2 and v_in >= distinct[low + 1]:
        low += 1
    base = float(distinct[low])
    step = float(distinct[low + 1]) - base
    share = min(max((float(v_in) - base) / step, 0.0), 1.0)
    tone = int(np.rint(share * 255))
    shift = -edges * (share - 0.5)
    if np.any(width):
        shift += (float(f32(r)) - 0.5) * float(width[tone] if np.ndim(width) else width)
    if share == 0:
        shift = max(shift, 0.0)
    if share == 1:
        shift = min(shift, 0.0)
    return low, tone, f32(base + (0.5 + shift) * step)


def diffuse_toned(
    light, levels, places, weights, serpentine, from_right, width=0.0, edges=0.0, seed=0
) -> np.ndarray:
    """weights[tone][k] for the taps places[k]; a tap (0, 1) or (0, 2) is in the row."""
    distinct, first = np.unique(np.asarray(levels, f32), return_index=True)
    height, columns = light.shape
    out = np.zeros(light.shape, np.uint8)
    widest = float(np.max(width)) / 2 + abs(edges) / 2
    reach = f32(0.5 + widest if widest else -1.0)
    errors, tones, steps = [], [], []
    for y in range(height):
        step, order = scan(y, columns, serpentine, from_right)
        row, marks = [f32(0)] * columns, [0] * columns
        for x in order:
            light_here = min(max(light[y, x], distinct[0]), distinct[-1])
            low, tone, threshold = decision(light_here, distinct, width, edges, random(seed, y, x))
            carry = f32(0)
            for above in range(max(0, y - 8), y):
                for k, (dy, dx) in enumerate(places):
                    sender = x - steps[above] * dx
                    if dy and above + dy == y and 0 <= sender < columns:
                        share = f32(weights[tones[above][sender]][k])
                        carry = f32(carry + f32(share * errors[above][sender]))
            v = f32(carry + light_here)
            for back in (2, 1):
                sender = x - step * back
                if (0, back) in places and 0 <= sender < columns:
                    share = f32(weights[marks[sender]][places.index((0, back))])
                    v = f32(v + f32(share * row[sender]))
            gap = f32(distinct[low + 1] - distinct[low])
            if distinct[low] - f32(reach * gap) <= v <= distinct[low + 1] + f32(reach * gap):
                i = low + int(v > threshold)
            else:
                i = nearest(v, distinct)
            row[x], marks[x] = f32(v - distinct[i]), tone
            out[y, x] = first[i]
        errors.append(row)
        tones.append(marks)
        steps.append(step)
    return out


def hilbert_point(d: int, side: int) -> tuple[int, int]:
    """(row, column) of place d on the Hilbert curve, by the bits of d."""
    x = y = 0
    s = 1
    while s < side:
        rx = 1 & (d // 2)
        ry = 1 & (d ^ rx)
        if ry == 0:
            if rx == 1:
                x, y = s - 1 - x, s - 1 - y
            x, y = y, x
        x += s * rx
        y += s * ry
        d //= 4
        s *= 2
    return y, x


def diffuse_along(light, levels, weights, side=256) -> np.ndarray:
    """Strips of *side* rows, each block by block along the curve; weights from the oldest."""
    distinct, first = np.unique(np.asarray(levels, f32), return_index=True)
    height, width = light.shape
    curve = [hilbert_point(d, side) for d in range(side * side)]
    out = np.zeros(light.shape, np.uint8)
    for top in range(0, height, side):
        recent = [f32(0)] * len(weights)
        for block in range(0, width, side):
            for dy, dx in curve:
                y, x = top + dy, block + dx
                if y < height and x < width:
                    v = min(max(light[y, x], distinct[0]), distinct[-1])
                    for w, e in zip(weights, recent, strict=True):
                        v = f32(v + f32(w * e))
                    i = nearest(v, distinct)
                    recent = [*recent[1:], f32(v - distinct[i])]
                    out[y, x] = first[i]
    return out
