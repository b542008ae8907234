"""Mach bands (P9 of scenes.md): the eye enhances steps and kinks of brightness where faces meet.

Measured as the largest second difference of radiance over three pixels in a row or a column that lie
in two faces with an edge in common. Flat shading has a step there, Gouraud a kink, Phong a weaker kink.
"""

from __future__ import annotations

import numpy as np
import pytest

from halftone.scene import shapes
from halftone.scene.model import Camera, Light, Material, Mesh, Scene
from halftone.scene.render import render

SIDE = 256
MESHES = {"ball": shapes.icosphere(2), "ring": shapes.torus(20, 12)}
FACING = 0.5
"""Cosine to the viewer of the faces that count; towards the outline all shadings change fast."""


def bands(mesh: Mesh, shading: str, side: int) -> float:
    """The largest second difference across edges that faces share."""
    scene = Scene(
        (mesh,),
        (Material(ambient=(0.1,), diffuse=(0.9,), specular=(0.0,)),),
        (Light("distant", (1.0,), direction=(-0.3, -0.5, -1.0)),),
        Camera((0.0, 0.0, 5.0), projection="parallel", height=3.0),
        ambient=(1.0,),
        background=(0.0,),
    )
    picture = render(scene, side, side, shading=shading)
    value = picture.radiance[..., 0].astype(np.float64)
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    facing = normal[:, 2] > FACING * np.linalg.norm(normal, axis=1)
    seen = np.where((picture.ids >= 0) & facing[picture.ids], picture.ids, -1)
    return max(across(value, seen, mesh.faces), across(value.T, seen.T, mesh.faces))


def across(value: np.ndarray, ids: np.ndarray, faces: np.ndarray) -> float:
    """The largest of rows: of triples of pixels in exactly two faces, which share two vertices."""
    first, middle, last = ids[:, :-2], ids[:, 1:-1], ids[:, 2:]
    two = ((first == middle) != (middle == last)) & (first >= 0) & (middle >= 0) & (last >= 0)
    one, other = faces[first[two]], faces[last[two]]
    neighbours = (one[:, :, None] == other[:, None, :]).sum(axis=(1, 2)) == 2
    assert np.count_nonzero(neighbours) > 1000
    second = value[:, :-2] - 2 * value[:, 1:-1] + value[:, 2:]
    return float(np.abs(second[two][neighbours]).max())


if __name__ == "__main__":
    for name, mesh in MESHES.items():
        for side in (256, 512, 1024):
            print(name, side, *(f"{s} {bands(mesh, s, side):.2e}" for s in ("flat", "gouraud", "phong", "fast-phong")))
