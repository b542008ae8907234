"""Hidden surfaces by brute force: every face at every pixel, in integers and fractions."""

from __future__ import annotations

from fractions import Fraction

import numpy as np


def inside(corners, x: int, y: int):
    """The three weights of pixel (x, y) in a face of snapped *corners*, or None where it is outside.

    A centre on an edge belongs to the face if the edge is its top (level, the face below it) or one
    of its left ones.
    """
    (x0, y0), (x1, y1), (x2, y2) = [(int(a), int(b)) for a, b in corners]
    area = (x1 - x0) * (y2 - y0) - (y1 - y0) * (x2 - x0)
    if area == 0:
        return None
    sign = 1 if area > 0 else -1
    px, py = 256 * x + 128, 256 * y + 128
    weights = []
    for (ax, ay), (bx, by) in (((x1, y1), (x2, y2)), ((x2, y2), (x0, y0)), ((x0, y0), (x1, y1))):
        dx, dy = sign * (bx - ax), sign * (by - ay)
        value = dx * (py - ay) - dy * (px - ax)
        counts = dy < 0 or (dy == 0 and dx > 0)
        if value < 0 or (value == 0 and not counts):
            return None
        weights.append(Fraction(value, abs(area)))
    return weights


def visible(faces, snapped, key, owner, width: int, height: int):
    """(ids, depths): the owner of the nearest face at every pixel, −1 where none, of equally near
    ones the lowest; and for every pixel the list of (depth, owner) of all faces there.
    """
    ids = np.full((height, width), -1, np.int32)
    depths: dict[tuple[int, int], list[tuple[Fraction, int]]] = {}
    for face, me in zip(faces, owner, strict=True):
        xs, ys = [int(snapped[i][0]) for i in face], [int(snapped[i][1]) for i in face]
        for y in range(max(0, min(ys) // 256), min(height, max(ys) // 256 + 1)):
            for x in range(max(0, min(xs) // 256), min(width, max(xs) // 256 + 1)):
                weights = inside([snapped[i] for i in face], x, y)
                if weights is not None:
                    z = sum(w * Fraction(float(key[i])) for w, i in zip(weights, face, strict=True))
                    depths.setdefault((y, x), []).append((z, int(me)))
    for (y, x), found in depths.items():
        ids[y, x] = max(found, key=lambda pair: (pair[0], -pair[1]))[1]
    return ids, depths
