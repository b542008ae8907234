"""Polygons cut into triangles: convex ones as a fan, concave ones by clipping ears."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["triangles"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def triangles(sides: Ints, vertices: Floats, corners: Ints) -> tuple[Ints, Ints]:
    """Triangles of polygons that follow one another in *corners*.

    sides : the number of corners of each polygon, 3 or more. vertices : (V, 3).
    corners : the vertex of each corner; those out of range count as the origin.

    Returns (positions in *corners*, (T, 3); the polygon of each triangle, (T,)), in the polygons'
    order; the triangles turn as their polygon does.
    """
    first = np.cumsum(sides) - sides
    if len(sides) and sides.min() == sides.max() == 3:
        return np.arange(3 * len(sides)).reshape(-1, 3), np.arange(len(sides))
    pieces = sides - 2
    owner = np.repeat(np.arange(len(sides)), pieces)
    start = np.cumsum(pieces) - pieces
    out = np.empty((len(owner), 3), np.int64)
    for size in np.unique(sides):
        which = np.flatnonzero(sides == size)
        local = _cut(int(size), first[which], vertices, corners)  # (polygons, size − 2, 3)
        rows = start[which, None] + np.arange(size - 2)
        out[rows] = first[which, None, None] + local
    return out, owner


def _cut(size: int, first: Ints, vertices: Floats, corners: Ints) -> Ints:
    """Triangles of polygons of *size* corners each, as corner numbers from 0."""
    step = np.arange(1, size - 1)
    fan = np.stack([np.zeros_like(step), step, step + 1], axis=1)
    local = np.broadcast_to(fan, (len(first), size - 2, 3)).copy()
    if size == 3:
        return local
    index = corners[first[:, None] + np.arange(size)]
    inside = (index >= 0) & (index < len(vertices))
    points = np.zeros((*index.shape, 3))
    points[inside] = vertices[index[inside]]
    with np.errstate(all="ignore"):
        points = points - points[:, :1]
        points /= np.abs(points).max(axis=(1, 2), keepdims=True)
        normal = np.cross(points, np.roll(points, -1, axis=1)).sum(axis=1)  # Newell: twice the area
        ahead = np.roll(points, -1, axis=1) - points
        turns = np.einsum("pcx,px->pc", np.cross(ahead, np.roll(ahead, -1, axis=1)), normal)
        concave = ~(turns >= 0).all(axis=1) & np.isfinite(points).all(axis=(1, 2))
    for polygon in np.flatnonzero(concave):
        local[polygon] = _ears(_flat(points[polygon], normal[polygon]))
    return local


def _flat(points: Floats, normal: Floats) -> list[tuple[float, float]]:
    """*points* seen against their *normal*, so that they turn counter-clockwise."""
    axis = int(np.abs(normal).argmax())
    x, y = points[:, (axis + 1) % 3], points[:, (axis + 2) % 3]
    if normal[axis] < 0:
        x = -x
    return list(zip(x.tolist(), y.tolist(), strict=True))


def _ears(points: list[tuple[float, float]]) -> list[tuple[int, int, int]]:
    """Triangles of a simple polygon: a convex corner whose triangle holds no other corner is cut off."""
    ring = list(range(len(points)))
    found: list[tuple[int, int, int]] = []
    at, misses = 0, 0
    while len(ring) > 3:
        count = len(ring)
        a, b, c = ring[at - 1], ring[at], ring[(at + 1) % count]
        # A ring that crosses itself has no ear: it is cut all the same, so that this ends.
        if misses > count or _is_ear(points, ring, a, b, c):
            found.append((a, b, c))
            del ring[at]
            at, misses = (at - 1) % (count - 1), 0
        else:
            at, misses = (at + 1) % count, misses + 1
    return [*found, (ring[0], ring[1], ring[2])]


def _is_ear(points: list[tuple[float, float]], ring: list[int], a: int, b: int, c: int) -> bool:
    p, q, r = points[a], points[b], points[c]
    if not _turn(p, q, r) > 0:
        return False
    for other in ring:
        s = points[other]
        if other in (a, b, c) or s in (p, q, r):
            continue
        if _turn(p, q, s) >= 0 and _turn(q, r, s) >= 0 and _turn(r, p, s) >= 0:
            return False
    return True


def _turn(p: Any, q: Any, r: Any) -> float:
    """Twice the area of a triangle: above 0 where it turns counter-clockwise."""
    return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))
