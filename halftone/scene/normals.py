"""Normals of faces, and of vertices as averages of the faces around them.

Source: Gouraud, IEEE Trans. Computers C-20(6), 1971.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halftone.errors import UsageError, near

__all__ = ["WEIGHTINGS", "corner_angles", "face_normals", "unit", "vertex_normals"]

Floats = NDArray[np.float64]

WEIGHTINGS = ("angle", "area", "uniform")


def unit(vectors: Floats) -> Floats:
    """Vectors (K, 3) brought to length 1; those of length 0, or not finite, become 0."""
    size = np.abs(vectors).max(axis=1, keepdims=True, initial=0.0)
    usable = np.isfinite(size) & (size > 0)
    scaled = np.where(usable, vectors, 0.0) / np.where(usable, size, 1.0)
    length = np.sqrt((scaled * scaled).sum(axis=1, keepdims=True))
    return np.asarray(scaled / np.where(length > 0, length, 1.0))


def face_normals(vertices: Floats, faces: NDArray[np.int64]) -> Floats:
    """Normals (F, 3) whose lengths are twice the faces' areas, out of the front."""
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    return np.cross(b - a, c - a)


def corner_angles(vertices: Floats, faces: NDArray[np.int64]) -> Floats:
    """The angle of a face at each of its corners, radians (F, 3)."""
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    u, v, w = unit(b - a), unit(c - b), unit(a - c)

    def between(p: Floats, q: Floats) -> Floats:
        # Well-conditioned near 0 and π, where an arc cosine is not (Kahan).
        return np.asarray(2 * np.arctan2(np.linalg.norm(p - q, axis=1), np.linalg.norm(p + q, axis=1)))

    return np.stack([between(u, -w), between(v, -u), between(w, -v)], axis=1)


def vertex_normals(
    vertices: Floats,
    faces: NDArray[np.int64],
    weighting: str = "angle",
    smooth: NDArray[np.bool_] | None = None,
) -> Floats:
    """Averages of the normals of the faces around each vertex: float64 (V, 3), of length 1 or 0.

    weighting : ``uniform`` (each face counts alike), ``angle`` (by its angle at the vertex) or
    ``area``. smooth : the faces that take part (None: all). A vertex whose normals cancel has 0.
    """
    if weighting not in WEIGHTINGS:
        raise UsageError(near(weighting, WEIGHTINGS, "way to average normals"))
    if smooth is not None:
        faces = faces[smooth]
    normals = face_normals(vertices, faces)
    if weighting != "area":
        normals = unit(normals)
    weights = corner_angles(vertices, faces) if weighting == "angle" else np.ones(faces.shape)
    total = np.empty((len(vertices), 3))
    index = faces.ravel()
    largest = np.zeros(len(vertices))
    for axis in range(3):
        share = (normals[:, axis, None] * weights).ravel()
        total[:, axis] = np.bincount(index, share, len(vertices))
        largest += np.bincount(index, np.abs(share), len(vertices))
    # What is left of normals that cancel is rounding, not a direction.
    total[np.abs(total).max(axis=1, initial=0.0) <= 1e-12 * largest] = 0.0
    return unit(total)
