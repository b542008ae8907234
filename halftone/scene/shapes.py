"""Generated meshes: torus, sphere, box, plane and cone, closed ones with their fronts outside.

All are centred at the origin, y points up, and neighbouring faces share their vertices, so that
averaged normals are smooth. Exact normals are set with ``exact=True`` instead.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import whole
from halftone.errors import UsageError
from halftone.scene.model import Mesh

__all__ = ["SHAPES", "box", "cone", "icosphere", "plane", "sphere", "torus"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST = 1 << 14  # divisions along one direction
QUADS = 1 << 22


def torus(
    u: int = 64, v: int = 32, radius: float = 1.0, tube: float = 0.4, *, exact: bool = False
) -> Mesh:
    """A ring about the y axis of u × v quads, 2·u·v triangles.

    radius : from the centre to the middle of the tube; tube : the tube's own radius.
    """
    u, v = _divisions(u, v, 3, 3)
    around, across = np.meshgrid(_turn(u), _turn(v), indexing="ij")
    out = np.stack(
        [np.cos(across) * np.cos(around), np.sin(across), -np.cos(across) * np.sin(around)], axis=-1
    )
    ring = np.stack([np.cos(around), np.zeros_like(around), -np.sin(around)], axis=-1)
    points = _length("radius", radius) * ring + _length("tube", tube) * out
    i, j = np.meshgrid(np.arange(u), np.arange(v), indexing="ij")
    following, above = (i + 1) % u, (j + 1) % v
    faces = _quads(i * v + j, following * v + j, following * v + above, i * v + above)
    return _mesh("torus", points.reshape(-1, 3), faces, out.reshape(-1, 3) if exact else None)


def sphere(u: int = 64, v: int = 32, radius: float = 1.0, *, exact: bool = False) -> Mesh:
    """A ball of u meridians and v zones, with triangles at the poles: 2·u·(v − 1) in all."""
    u, v = _divisions(u, v, 3, 2)
    polar = np.pi * np.arange(1, v)[:, None] / v
    around = _turn(u)[None, :]
    rings = np.stack(
        [
            np.sin(polar) * np.cos(around),
            np.broadcast_to(np.cos(polar), (v - 1, u)),
            -np.sin(polar) * np.sin(around),
        ],
        axis=-1,
    ).reshape(-1, 3)
    unit = np.concatenate([[[0.0, 1.0, 0.0]], rings, [[0.0, -1.0, 0.0]]])
    column = np.arange(u)
    following, last = (column + 1) % u, len(unit) - 1
    lowest = 1 + (v - 2) * u
    top = np.stack([np.zeros(u, np.int64), 1 + column, 1 + following], axis=1)
    bottom = np.stack([np.full(u, last), lowest + following, lowest + column], axis=1)
    start = 1 + u * np.arange(v - 2)[:, None]
    low = start + u
    middle = _quads(start + column, low + column, low + following, start + following)
    faces = np.concatenate([top, middle, bottom])
    return _mesh("sphere", _length("radius", radius) * unit, faces, unit if exact else None)


def icosphere(divisions: int = 3, radius: float = 1.0, *, exact: bool = False) -> Mesh:
    """A ball of nearly equal triangles: an icosahedron, each face cut in 4 *divisions* times."""
    divisions = whole("divisions", divisions, 0, 9)
    g = (1 + 5**0.5) / 2
    corners = [[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0], [0, -1, g], [0, 1, g], [0, -1, -g]]
    corners += [[0, 1, -g], [g, 0, -1], [g, 0, 1], [-g, 0, -1], [-g, 0, 1]]
    text = "0b5 051 017 07a 0ab 159 5b4 ba2 a76 718 394 342 326 368 389 495 24b 62a 867 981"
    faces = np.array([[int(c, 16) for c in t] for t in text.split()])
    unit = np.array(corners) / np.sqrt(1 + g * g)
    for _ in range(divisions):
        unit, faces = _cut_in_four(unit, faces)
        unit = unit / np.linalg.norm(unit, axis=1, keepdims=True)
    return _mesh("icosphere", _length("radius", radius) * unit, faces, unit if exact else None)


def box(width: float = 1.0, height: float = 1.0, depth: float = 1.0) -> Mesh:
    """A box of 12 triangles with 8 vertices; its edges are sharp."""
    size = (_length("width", width), _length("height", height), _length("depth", depth))
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2.0
    quads = np.array(
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    )
    mesh = _mesh("box", corners * size, _quads(*quads.T), None)
    return replace(mesh, smooth=np.zeros(12, bool))


def plane(width: float = 1.0, depth: float = 1.0, u: int = 1, v: int = 1) -> Mesh:
    """A rectangle in the plane y = 0 whose front looks up, of u × v quads."""
    u, v = _divisions(u, v, 1, 1)
    x, z = np.meshgrid(np.arange(u + 1) / u - 0.5, np.arange(v + 1) / v - 0.5, indexing="ij")
    points = np.stack([x * _length("width", width), 0 * x, z * _length("depth", depth)], axis=-1)
    i, j = np.meshgrid(np.arange(u), np.arange(v), indexing="ij")
    first = i * (v + 1) + j
    faces = _quads(first, first + 1, first + v + 2, first + v + 1)
    return _mesh("plane", points.reshape(-1, 3), faces, None)


def cone(u: int = 32, radius: float = 1.0, height: float = 1.0) -> Mesh:
    """A cone that stands on its base, the apex up: u triangles round the side and u in the base.

    The side has exact normals (each triangle its own at the apex), the base's rim is sharp.
    """
    u = whole("u", u, 3, MOST)
    radius, height = _length("radius", radius), _length("height", height)
    angle = _turn(u)
    rim = np.stack([radius * np.cos(angle), np.full(u, -height / 2), -radius * np.sin(angle)], axis=1)
    points = np.concatenate([rim, [[0, height / 2, 0], [0, -height / 2, 0]]])
    column = np.arange(u)
    following = (column + 1) % u
    side = np.stack([column, following, np.full(u, u)], axis=1)
    base = np.stack([following, column, np.full(u, u + 1)], axis=1)
    halves = _turn(2 * u)  # at the rim's vertices and between them
    normals = np.stack(
        [height * np.cos(halves), np.full(2 * u, radius), -height * np.sin(halves)], axis=1
    )
    normals = np.concatenate([normals / np.hypot(radius, height), [[0.0, -1.0, 0.0]]])
    index = np.concatenate(
        [
            np.stack([2 * column, 2 * following, 2 * column + 1], axis=1),
            np.full((u, 3), 2 * u),
        ]
    )
    return replace(_mesh("cone", points, np.concatenate([side, base]), normals), normal_index=index)


SHAPES: dict[str, Callable[..., Mesh]] = {
    "torus": torus,
    "sphere": sphere,
    "icosphere": icosphere,
    "box": box,
    "plane": plane,
    "cone": cone,
}
"""What a scene file may name as the ``shape`` of a mesh."""


def _turn(count: int) -> Floats:
    return 2 * np.pi * np.arange(count) / count


def _divisions(u: int, v: int, least_u: int, least_v: int) -> tuple[int, int]:
    u = whole("u", u, least_u, MOST)
    return u, whole("v", v, least_v, min(MOST, QUADS // u))


def _length(name: str, value: float) -> float:
    if not 0 < value <= sys.float_info.max:
        raise UsageError(f"{name}={value!r}; allowed: a finite length above 0")
    return float(value)


def _quads(a: Any, b: Any, c: Any, d: Any) -> Ints:
    """Two triangles a quad: (a, b, c) and (a, c, d)."""
    return np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)


def _cut_in_four(points: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Each triangle cut at the middles of its edges, which neighbours share."""
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    own, index = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    middles = (points[own[:, 0]] + points[own[:, 1]]) / 2
    ab, bc, ca = (len(points) + index.reshape(-1, 3)).T
    a, b, c = faces.T
    parts = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=-1).reshape(-1, 3)
    return np.concatenate([points, middles]), parts


def _mesh(name: str, points: Floats, faces: Ints, normals: Floats | None) -> Mesh:
    faces = np.ascontiguousarray(faces, np.int64)
    points = np.ascontiguousarray(points, np.float64)
    none = np.zeros(len(faces), np.int64)
    if normals is None:
        return Mesh(points, faces, none, name=name)
    return Mesh(points, faces, none, np.ascontiguousarray(normals, np.float64), faces, name=name)
