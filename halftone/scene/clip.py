"""Clipping: faces that cross the near plane or reach far beyond the sides, cut to what can be seen.

Each plane cuts a triangle to none, one or two (Sutherland & Hodgman, CACM 17(1), 1974). An edge that
two faces share is always cut from its same end, so both get the same new corner.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halftone.scene.geometry import Geometry
from halftone.scene.raster import GUARD, Projected, binned

__all__ = ["add_clipped", "clipped", "cut"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def cut(corners: Floats, owner: Ints, plane: Floats) -> tuple[Floats, Ints]:
    """Triangles (K, 3, 4) where corner · plane[:4] + plane[4] ≥ 0, and their owners (K,)."""
    height = corners @ plane[:4] + plane[4]
    inside = height >= 0
    count = inside.sum(axis=1)
    whole = count == 3
    out = [corners[whole]]
    names = [owner[whole]]
    for many in (1, 2):
        some = count == many
        if not some.any():
            continue
        # Turn the triangle until the odd corner, alone on its side, is first.
        odd = np.argmax(inside[some] if many == 1 else ~inside[some], axis=1)
        turn = (odd[:, None] + np.arange(3)) % 3
        p = np.take_along_axis(corners[some], turn[:, :, None], axis=1)
        e = np.take_along_axis(height[some], turn, axis=1)
        new = [_between(p[:, 0], e[:, 0], p[:, other], e[:, other]) for other in (1, 2)]
        if many == 1:
            out.append(np.stack([p[:, 0], new[0], new[1]], axis=1))
            names.append(owner[some])
        else:
            out.append(np.stack([new[0], p[:, 1], p[:, 2]], axis=1))
            out.append(np.stack([new[0], p[:, 2], new[1]], axis=1))
            names += [owner[some]] * 2
    return np.concatenate(out), np.concatenate(names)


def _between(p: Floats, ep: Floats, q: Floats, eq: Floats) -> Floats:
    """Where the line from p to q, at heights ep and eq of other signs, has height 0."""
    swap = np.zeros(len(p), bool)
    tied = np.ones(len(p), bool)
    for axis in range(p.shape[1]):
        swap |= tied & (p[:, axis] > q[:, axis])
        tied &= p[:, axis] == q[:, axis]
    a, b = np.where(swap[:, None], q, p), np.where(swap[:, None], p, q)
    ea, eb = np.where(swap, eq, ep), np.where(swap, ep, eq)
    share = (ea / (ea - eb))[:, None]
    return np.asarray(a + share * (b - a))


def clipped(corners: Floats, owner: Ints, near: float, guard: float) -> tuple[Floats, Ints]:
    """Triangles of (h0, h1, h2, distance) cut by the near plane and by four planes *guard* pixels from
    the middle.
    """
    planes = [] if near == -np.inf else [np.array([0.0, 0.0, 0.0, 1.0, -near])]
    for axis in range(2):
        for sign in (1.0, -1.0):
            plane = np.zeros(5)
            plane[axis] = sign
            plane[2] = guard
            planes.append(plane)
    for plane in planes:
        corners, owner = cut(corners, owner, plane)
    return corners, owner


def add_clipped(made: Projected, geometry: Geometry, faces: NDArray[np.int32], workers: int) -> None:
    """Cut *faces* and add what is left to *made* and its bins."""
    view = made.view
    corners = view.homogeneous(geometry.vertices[geometry.faces[faces].ravel()]).reshape(-1, 3, 4)
    pieces, owner = clipped(corners, faces.astype(np.int64), view.near, GUARD)
    made.clipped = len(faces)
    points = pieces.reshape(-1, 4)
    middle = np.array([view.width / 2, view.height / 2])
    snapped = np.floor((points[:, :2] / points[:, 2:3] + middle) * 256 + 0.5).astype(np.int32)
    key = 1 / points[:, 2] if view.perspective else -points[:, 3]
    first, last = len(made.faces), len(made.faces) + len(pieces)
    new = np.arange(len(points), dtype=np.int32).reshape(-1, 3) + np.int32(len(made.snapped))
    made.snapped = np.concatenate([made.snapped, snapped])
    made.key = np.concatenate([made.key, key])
    made.faces = np.concatenate([made.faces, new])
    made.owner = np.concatenate([made.owner, owner.astype(np.int32)])
    bins, _ = binned(made, np.zeros(len(made.snapped), np.uint8), first, last, workers)
    made.solid = made.solid.joined(bins)
