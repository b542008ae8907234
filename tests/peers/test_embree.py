"""Hidden surfaces against Embree, rays through the centres of the pixels: the same face in each.

Two things differ by design. Ours snaps corners to 1/256 pixel, so that an edge moves by at most
√2/512 = 0.0028 pixel; Embree takes corners and rays in float32, about 1e-7 of their size. Pixels may
therefore differ if their centre is within 1/256 pixel of an edge that takes part, found here in
float64, or if both faces are equally deep there to 1e-5.
"""

from __future__ import annotations

import numpy as np
import pytest

from halftone.scene import shapes
from halftone.scene.model import Camera, Mesh, Scene
from halftone.scene.render import render

pytestmark = pytest.mark.peer

WIDTH, HEIGHT, FOV = 640, 480, 40.0
EYE = np.array([0.4, 1.9, 2.7])
NEAR_EDGE, SAME_DEPTH = 1 / 256, 1e-5


def soup(count: int = 600) -> Mesh:
    """Triangles of all sizes that pass through each other."""
    rng = np.random.default_rng(5)
    middle = rng.uniform(-0.8, 0.8, (count, 1, 3))
    corners = middle + rng.normal(0, 1, (count, 3, 3)) * rng.uniform(0.02, 0.3, (count, 1, 1))
    faces = np.arange(3 * count).reshape(count, 3)
    return Mesh(corners.reshape(-1, 3), faces, np.zeros(count, np.int64))


MESHES = {"torus": shapes.torus(96, 48), "icosphere": shapes.icosphere(5), "soup": soup()}


def axes() -> np.ndarray:
    """Rows right, down and forwards of the view from EYE to the origin."""
    forwards = -EYE / np.linalg.norm(EYE)
    right = np.cross(forwards, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forwards, right), forwards])


SCALE = HEIGHT / (2 * np.tan(np.radians(FOV) / 2))


def rays() -> np.ndarray:
    """Directions (HEIGHT, WIDTH, 3) through the pixels' centres, float64."""
    x, y = np.meshgrid(np.arange(WIDTH) + 0.5 - WIDTH / 2, np.arange(HEIGHT) + 0.5 - HEIGHT / 2)
    return np.stack([x, y, np.full_like(x, SCALE)], axis=-1) @ axes() / SCALE


def embree_ids(mesh: Mesh) -> np.ndarray:
    """The nearest face of every pixel, or −1."""
    why = "embreex is not installed (tests/peers/install.sh installs it)"
    rtcore_scene = pytest.importorskip("embreex.rtcore_scene", reason=why)
    construction = pytest.importorskip("embreex.mesh_construction", reason=why)
    scene = rtcore_scene.EmbreeScene(robust=True)
    made = construction.TriangleMesh(
        scene, mesh.vertices.astype(np.float32), mesh.faces.astype(np.int32)
    )
    ways = rays().reshape(-1, 3).astype(np.float32)
    starts = np.ascontiguousarray(np.broadcast_to(EYE.astype(np.float32), ways.shape))
    found = scene.run(starts, ways)
    del made  # the scene needs it up to here
    return np.asarray(found).reshape(HEIGHT, WIDTH)


def edge_distance(mesh: Mesh, face: int, x: float, y: float) -> float:
    """Pixels from the point (x, y) of the picture to the nearest edge of *face*; all is in front."""
    h = (mesh.vertices[mesh.faces[face]] - EYE) @ axes().T
    a = h[:, :2] / h[:, 2:] * SCALE + (WIDTH / 2, HEIGHT / 2)
    along = np.roll(a, -1, axis=0) - a
    to = np.array([x, y]) - a
    share = np.clip((to * along).sum(axis=1) / (along * along).sum(axis=1), 0, 1)
    return float(np.linalg.norm(to - share[:, None] * along, axis=1).min())


def depth(mesh: Mesh, face: int, way: np.ndarray) -> float:
    """How far along *way* the plane of *face* is, in lengths of *way*."""
    a, b, c = mesh.vertices[mesh.faces[face]]
    normal = np.cross(b - a, c - a)
    return float(normal @ (a - EYE) / (normal @ way))


@pytest.mark.parametrize("name", MESHES)
def test_embree(name):
    mesh = MESHES[name]
    theirs = embree_ids(mesh)
    camera = Camera(tuple(EYE), fov=FOV)
    picture = render(Scene((mesh,), camera=camera), WIDTH, HEIGHT, shading="flat")
    ours = picture.ids
    assert picture.report["counts"]["clipped_faces"] == 0
    assert np.count_nonzero(ours >= 0) > 0.2 * ours.size
    ways, at_edge, equally_deep, wrong = rays(), 0, 0, []
    for y, x in np.argwhere(ours != theirs):
        one, other = int(ours[y, x]), int(theirs[y, x])
        near = min(edge_distance(mesh, f, x + 0.5, y + 0.5) for f in (one, other) if f >= 0)
        if near <= NEAR_EDGE:
            at_edge += 1
            continue
        if one >= 0 and other >= 0:
            first, second = depth(mesh, one, ways[y, x]), depth(mesh, other, ways[y, x])
            if abs(first - second) < SAME_DEPTH * abs(second):
                equally_deep += 1
                continue
        wrong.append((x, y, one, other, near))
    covered = np.count_nonzero((ours >= 0) != (theirs >= 0))
    print(
        f"{name}: {at_edge} pixels differ at edges, {equally_deep} equally deep, {covered} of them in "
        f"coverage, of {ours.size}"
    )
    assert not wrong
    assert at_edge + equally_deep <= 0.001 * ours.size
