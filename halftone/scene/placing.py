"""Meshes moved to their place, and meshes that stand in the scene file itself."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone.errors import InputError
from halftone.scene.model import Mesh
from halftone.scene.polygons import triangles

__all__ = ["inline", "placed"]

MOST = 1 << 62  # what int64 holds

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def placed(mesh: Mesh, steps: Mapping[str, Any], at: str) -> Mesh:
    """*mesh* scaled (by one number, or by one for each axis), rotated and translated, in this order.

    rotate : degrees about x, then y, then z, counter-clockwise seen from the axis' tip.
    A mirrored mesh keeps its fronts outside. Raises InputError with the place *at*.
    """
    if not steps:
        return mesh
    scale = steps.get("scale", 1.0)
    parts = _numbers(scale if isinstance(scale, list) else [scale] * 3, f"{at}.scale")
    if not parts.all():
        raise InputError(f"{at}.scale={scale!r}; allowed: finite numbers other than 0")
    turn = _rotation(_numbers(steps.get("rotate", [0.0, 0.0, 0.0]), f"{at}.rotate"))
    shift = _numbers(steps.get("translate", [0.0, 0.0, 0.0]), f"{at}.translate")
    with np.errstate(over="ignore", invalid="ignore"):  # sanitise drops and counts what overflows
        vertices = (mesh.vertices * parts) @ turn.T + shift
    normals = mesh.normals
    if normals is not None:
        with np.errstate(all="ignore"):  # inverse transpose, up to a factor
            normals = (normals * (np.abs(parts).min() / parts)) @ turn.T
    mesh = replace(mesh, vertices=vertices, normals=normals)
    if np.sign(parts).prod() > 0:
        return mesh
    index = mesh.normal_index
    return replace(
        mesh,
        faces=np.ascontiguousarray(mesh.faces[:, ::-1]),
        normal_index=None if index is None else np.ascontiguousarray(index[:, ::-1]),
    )


def inline(table: Mapping[str, Any], at: str) -> Mesh:
    """A mesh of ``vertices``, ``faces`` of 3 or more corners, and ``detail``.

    detail : for each face the number of the face that it lies on, or −1.
    The mesh's ``material`` holds, for now, the listed face that each triangle is of.
    """
    vertices = _rows(table["vertices"], f"{at}.vertices")
    given = table.get("faces")
    if not isinstance(given, list) or not all(_is_face(face) for face in given):
        raise InputError(
            f"{at}.faces: allowed: a list of faces, each of 3 or more vertex numbers from 0"
        )
    sides = np.array([len(face) for face in given], np.int64)
    corners = np.array([corner for face in given for corner in face], np.int64)
    cut, owner = triangles(sides, vertices, corners)
    faces, detail = corners[cut], None
    if "detail" in table:
        on = table["detail"]
        fits = isinstance(on, list) and len(on) == len(given)
        if not fits or not all(isinstance(o, int) and -1 <= o < len(given) for o in on):
            raise InputError(
                f"{at}.detail={on!r}; allowed: {len(given)} numbers, for each face the face it lies "
                "on, or -1"
            )
        faces, owner, detail = _on_triangles(faces, owner, on)
    return Mesh(vertices, np.ascontiguousarray(faces), owner, detail=detail)


def _on_triangles(faces: Ints, owner: Ints, on: list[int]) -> tuple[Ints, Ints, Ints]:
    """Faces again, with those on a polygon of several triangles once for each of them."""
    pieces = np.bincount(owner, minlength=len(on)).tolist()
    copies = [
        (triangle, polygon, copy)
        for triangle, polygon in enumerate(owner.tolist())
        for copy in range(pieces[on[polygon]] if on[polygon] >= 0 else 1)
    ]
    first: dict[int, list[int]] = {}
    for new, (_, polygon, copy) in enumerate(copies):
        if copy == 0:
            first.setdefault(polygon, []).append(new)
    detail = [first[on[polygon]][copy] if on[polygon] >= 0 else -1 for _, polygon, copy in copies]
    which = np.array([triangle for triangle, _, _ in copies], np.int64)
    return faces[which], owner[which], np.array(detail, np.int64)


def _is_face(face: Any) -> bool:
    if not isinstance(face, list) or len(face) < 3:
        return False
    return all(isinstance(c, int) and not isinstance(c, bool) and abs(c) < MOST for c in face)


def _rows(given: Any, place: str) -> Floats:
    if not isinstance(given, list):
        raise InputError(f"{place}={given!r}; allowed: a list of [x, y, z]")
    rows = [_numbers(row, f"{place}[{i}]", finite=False) for i, row in enumerate(given)]
    return np.array(rows, np.float64).reshape(-1, 3)


def _numbers(given: Any, place: str, finite: bool = True) -> Floats:
    """Three numbers. NaN and infinity are let through for vertices, which sanitise drops and counts."""
    fits = isinstance(given, list) and len(given) == 3
    if fits and all(isinstance(g, int | float) and not isinstance(g, bool) for g in given):
        try:
            values = [float(g) for g in given]
        except OverflowError:
            values = [math.inf]
        if not finite or all(math.isfinite(v) for v in values):
            return np.array(values, np.float64)
    raise InputError(f"{place}={given!r}; allowed: three {'finite ' * finite}numbers, [x, y, z]")


def _rotation(degrees: Floats) -> Floats:
    turn = np.eye(3)
    for axis, angle in enumerate(np.radians(degrees)):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        one = np.eye(3)
        one[a, a] = one[b, b] = np.cos(angle)
        one[a, b], one[b, a] = -np.sin(angle), np.sin(angle)
        turn = one @ turn
    return turn
