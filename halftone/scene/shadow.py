"""Shadows: a hidden-surface pass at each light, and the question whether a sample is what it sees.

A map has *resolution* × *resolution* pixels (Williams, SIGGRAPH 78). A distant light looks in parallel
at the sphere around the scene; a point light in one frustum around that sphere, or, where it is too
near for 120°, in six of 90°; a spot in its cone if that is narrower. Before it is asked for, a sample
is moved OFFSET map pixels along its normal, and it counts as lit if what the map shows is nearer by
less than BIAS map pixels: a surface does not shade itself, and shadows end that much too early.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halftone.scene import _shadow_kernels as kernels
from halftone.scene.geometry import Geometry
from halftone.scene.model import Camera, Light
from halftone.scene.raster import Visibility, projected
from halftone.scene.view import View, view_of

__all__ = ["BIAS", "OFFSET", "RESOLUTION", "Shadows", "looks"]

RESOLUTION = 2048
OFFSET = 1.5
BIAS = 1.0
WIDEST = 60.0
"""Half-angle in degrees up to which one frustum serves."""


@dataclass(frozen=True, eq=False)
class _Map:
    view: View
    depth: NDArray[np.float64]


def looks(light: Light, centre: NDArray[np.float64], radius: float) -> list[Camera]:
    """The cameras at *light* that see the sphere about *centre*."""
    middle = _vector(centre)
    if light.kind == "distant":
        direction = np.array(light.direction, np.float64)
        direction /= np.abs(direction).max()
        start = _vector(centre - direction / np.linalg.norm(direction) * 2 * radius)
        return [Camera(start, middle, projection="parallel", height=2.02 * radius)]
    place = np.array(light.position, np.float64)
    distance = float(np.linalg.norm(centre - place))
    around = float(np.degrees(np.arcsin(radius / distance))) if distance > radius else 180.0
    least = max(distance - radius, 1e-4 * radius) * 0.99
    eye = light.position
    if light.kind == "spot" and light.cutoff < min(around, WIDEST):
        axis = np.array(light.direction, np.float64)
        axis /= np.abs(axis).max()
        towards = _vector(place + axis / np.linalg.norm(axis) * max(radius, distance))
        return [Camera(eye, towards, fov=2.02 * light.cutoff, near=least)]
    if around < WIDEST:
        return [Camera(eye, middle, fov=2.02 * around, near=least)]
    steps = [sign * axis * radius for axis in np.eye(3) for sign in (1, -1)]
    return [Camera(eye, _vector(place + step), fov=90.5, near=1e-4 * radius) for step in steps]


def _vector(array: NDArray[np.float64]) -> tuple[float, float, float]:
    return float(array[0]), float(array[1]), float(array[2])


class Shadows:
    """Maps of the *lights*. clear : bool (F,), faces that cast no shadow. force_all : make the maps of
    lights without shadows, too, and let them change nothing.
    """

    def __init__(
        self,
        geometry: Geometry,
        lights: Sequence[Light],
        *,
        resolution: int = RESOLUTION,
        workers: int = 1,
        clear: NDArray[np.bool_] | None = None,
        force_all: bool = False,
    ) -> None:
        self.lights, self.maps = tuple(lights), list[list[_Map]]()
        used = geometry.vertices[np.unique(geometry.faces)] if len(geometry.faces) else np.zeros((1, 3))
        centre = (used.min(axis=0) + used.max(axis=0)) / 2
        radius = float(np.linalg.norm(used - centre, axis=1).max())
        for light in lights:
            found = []
            if radius > 0 and (light.shadows or force_all):
                for camera in looks(light, centre, radius):
                    view = view_of(camera, resolution, resolution)
                    seen = Visibility(
                        projected(geometry, view, workers, clear=clear), geometry, depth=True
                    )
                    seen.all(workers)
                    assert seen.depth is not None
                    found.append(_Map(view, seen.depth))
            self.maps.append(found)

    def lit(self, position: NDArray[np.float32], normal: NDArray[np.float32]) -> NDArray[np.uint8]:
        """(lights, K) uint8: 0 where something stands between a light and a sample."""
        lit = np.ones((len(self.lights), position.shape[1]), np.uint8)
        for light, maps, row in zip(self.lights, self.maps, lit, strict=True):
            for each in maps:
                view = each.view
                kernels.ask_map(
                    position, normal, view.eye, view.rows, int(view.perspective), view.width / 2,
                    1 / view.scale, OFFSET, BIAS, each.depth, row,
                )  # fmt: skip
            if not light.shadows:
                row[:] = 1
        return lit
