"""A camera and lights for a scene that brings none: a three-quarter view of all of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from halftone.errors import UsageError
from halftone.scene.model import Camera, Light, Mesh, Scene, Vector

__all__ = ["camera_for", "framed"]

DIRECTION = np.array([0.55, 0.42, 1.0])  # from the middle to the eye: from the right, above, in front
FOV = 35.0
MARGIN = 1.08


def framed(scene: Scene, aspect: float = 1.0) -> Scene:
    """*scene* with a camera and lights where it has none.

    aspect : width over height of the picture, in which all vertices that are finite and used by a
    face will lie. The lights are a key light from the upper left and a weaker fill from the right.
    """
    if not 0 < aspect < np.inf:
        raise UsageError(f"aspect={aspect!r}; allowed: a finite width over height, above 0")
    camera = scene.camera or camera_for(scene.meshes, aspect)
    lights = tuple(scene.lights) or _lights(camera, len(tuple(scene.ambient)))
    return replace(scene, camera=camera, lights=lights)


def camera_for(meshes: Sequence[Mesh], aspect: float = 1.0) -> Camera:
    """A perspective camera that has all *meshes* in its picture, as large as they fit."""
    points = _points(meshes)
    toward = DIRECTION / np.linalg.norm(DIRECTION)
    if not len(points):
        return Camera(eye=_vector(5 * toward), fov=FOV)
    low, high = points.min(axis=0), points.max(axis=0)
    centre = low / 2 + high / 2
    scale = float((high / 2 - low / 2).max()) or 1.0
    points = (points - centre) / scale
    side = np.cross([0.0, 1.0, 0.0], toward)
    side /= np.linalg.norm(side)
    above = np.cross(toward, side)
    x, y, z = points @ side, points @ above, points @ toward
    # |y|·margin ≤ slope·(distance − z), and the same across: the least distance that fits all.
    slope = np.tan(np.radians(FOV) / 2)
    reach = MARGIN * np.maximum(np.abs(y), np.abs(x) / aspect) / slope
    distance = max(float((reach + z).max()), 1.05 * float(z.max()), 0.1)
    return Camera(eye=_vector(centre + scale * distance * toward), target=_vector(centre), fov=FOV)


def _points(meshes: Sequence[Mesh]) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """The finite vertices that faces use, one under the other."""
    parts = []
    for mesh in meshes:
        vertices = np.asarray(mesh.vertices, np.float64).reshape(-1, 3)
        index = np.asarray(mesh.faces).ravel()
        used = np.zeros(len(vertices), bool)
        used[index[(index >= 0) & (index < len(vertices))]] = True
        parts.append(vertices[used & np.isfinite(vertices).all(axis=1)])
    return np.concatenate(parts) if parts else np.zeros((0, 3))


def _lights(camera: Camera, channels: int) -> tuple[Light, ...]:
    view = np.subtract(camera.target, camera.eye)
    view = view / np.abs(view).max()  # squares of tiny lengths would be 0
    view = view / np.linalg.norm(view)
    side = np.cross(view, camera.up)
    side /= np.linalg.norm(side)
    up = np.cross(side, view)
    key, fill = view + 0.7 * side - 0.9 * up, view - 0.9 * side - 0.1 * up
    return (
        Light("distant", (0.65,) * channels, direction=_vector(key / np.linalg.norm(key))),
        Light("distant", (0.12,) * channels, direction=_vector(fill / np.linalg.norm(fill))),
    )


def _vector(array: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> Vector:
    x, y, z = (float(v) for v in array)
    return x, y, z
