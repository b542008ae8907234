"""Mach bands (P9 of scenes.md): the eye enhances steps and kinks of brightness where faces meet.

Measured as the largest second difference of radiance over three pixels in a row or a column that lie
in two faces with an edge in common. Flat shading has a step there, Gouraud a kink, Phong a weaker kink:
a step's second difference does not depend on the size of the pixels, a kink's falls with it.

All that counts is lit. The line where the light ends is a kink of the exact picture too, which Phong
shows and Gouraud blurs; it is no Mach band of the mesh.
"""

from __future__ import annotations

import numpy as np
import pytest

from halftone.scene import shapes
from halftone.scene.model import Camera, Light, Material, Mesh, Scene
from halftone.scene.render import render

MATTE = Material(ambient=(0.1,), diffuse=(0.9,), specular=(0.0,))
SHINY = Material(ambient=(0.1,), diffuse=(0.6,), specular=(0.3,), exponent=10)
FACING = 0.5
"""Cosine to the viewer of the faces that count; towards the outline all shadings change fast."""


def bands(mesh: Mesh, material: Material, shading: str, side: int) -> float:
    """The largest second difference across edges that faces share."""
    scene = Scene(
        (mesh,),
        (material,),
        (Light("distant", (1.0,), direction=(-0.2, -0.3, -1.0)),),
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


@pytest.mark.parametrize("material", [MATTE, SHINY], ids=["matte", "shiny"])
@pytest.mark.parametrize("divisions", [2, 3])
def test_flat_exceeds_gouraud_exceeds_phong(material, divisions):
    ball = shapes.icosphere(divisions)
    flat, gouraud, phong = (bands(ball, material, s, 512) for s in ("flat", "gouraud", "phong"))
    assert flat > gouraud > phong


@pytest.mark.parametrize("shading", ["flat", "gouraud", "phong"])
def test_a_step_stays_and_a_kink_halves_with_the_pixel(shading):
    ball = shapes.icosphere(2)
    coarse, fine = (bands(ball, MATTE, shading, side) for side in (256, 512))
    if shading == "flat":
        assert fine == pytest.approx(coarse, rel=1e-6)
    else:
        assert fine == pytest.approx(coarse / 2, rel=0.1)
