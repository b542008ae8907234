"""Fast Phong shading, which watches itself: faces whose normals differ too much are shaded exactly."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halftone.scene import _fast_kernels as kernels
from halftone.scene._shade_kernels import scatter
from halftone.scene.model import Light
from halftone.scene.raster import run, stretch
from halftone.scene.shade import Ids, Phong, Rows

__all__ = ["ANGLE", "STEEP", "FastPhong"]

ANGLE = 20.0
"""Degrees between two normals of a face up to which it is expanded: the error is below 1/40 there."""
STEEP = 1.25
"""Ratio of the distances of a face's corners from the eye up to which it is expanded."""


class FastPhong(Phong):
    """N·L and N·H by polynomials of second degree about each face's centroid, and two additions a
    pixel along the rows; light and viewer are those of the centroid (Bishop & Weimer, SIGGRAPH 86).

    lights, reflection, eye (x, y, z, w) : what the illumination has been built from. angle : ANGLE.
    After :meth:`prepare`, fallen_back and visible are numbers of faces.
    """

    lights: tuple[Light, ...]
    places: NDArray[np.float64]
    eye: NDArray[np.float64]
    mirror: bool
    angle: float = ANGLE
    fallen_back = 0
    visible = 0

    def aim(
        self, lights: tuple[Light, ...], eye: NDArray[np.float64], reflection: str, angle: float
    ) -> None:
        """Say where lights and viewer are."""
        self.lights, self.eye, self.angle = lights, eye, angle
        self.mirror = reflection == "phong"
        self.places = np.zeros((len(lights), 4))
        for row, light in zip(self.places, lights, strict=True):
            if light.kind == "distant":
                towards = np.array(light.direction, np.float64)
                row[:3] = -towards / np.abs(towards).max()
            else:
                row[:3], row[3] = light.position, 1.0

    def prepare(self, seen: NDArray[np.uint8]) -> None:
        g, made = self.samples.geometry, self.samples.made
        visible = np.flatnonzero(seen).astype(np.int32)
        count = len(visible)
        self.slot = np.zeros(len(seen), np.int32)
        self.slot[visible] = np.arange(count, dtype=np.int32)
        self.centre = np.empty((count, 2))
        self.table = np.empty((len(self.lights), count, 13))
        exact = np.empty(count, np.uint8)

        def work(start: int, stop: int) -> None:
            kernels.expand(
                visible, start, stop, seen, g.faces, g.corners, made.h, g.attributes, g.materials,
                self.samples.two_sided, self.places, self.eye, int(self.mirror),
                float(np.cos(np.radians(self.angle))), STEEP, self.centre, self.table, exact,
            )  # fmt: skip

        if count:
            run(work, count, stretch(count), self.workers)
        self.exact = np.zeros(len(seen), bool)
        self.exact[visible] = exact != 0
        self.single = bool(count) and bool((g.materials == g.materials[0]).all())
        self.visible, self.fallen_back = count, int(np.count_nonzero(exact))

    def paint(self, ids: Ids, x0: float, y0: float, pitch: float, fill: bool, out: Rows) -> None:
        if self.fallen_back and self.fallen_back == self.visible:  # nothing to part
            super().paint(ids, x0, y0, pitch, fill, out)
            return
        if self.fallen_back:
            exact = np.where(self.exact[np.maximum(ids, 0)], ids, np.int32(-1))
            if (exact >= 0).any():
                super().paint(exact, x0, y0, pitch, fill, out)
                ids = np.where(exact >= 0, np.int32(-1), ids)
                fill = False
        self._fast(ids, x0, y0, pitch, fill, out)

    def _fast(self, ids: Ids, x0: float, y0: float, pitch: float, fill: bool, out: Rows) -> None:
        take, count = self.samples.scratch.take, int(np.count_nonzero(ids >= 0))
        cosines = take("cosines", (len(self.lights), count))
        lobes = take("lobes", (len(self.lights), count))
        for light in range(len(self.lights)):
            kernels.forward(
                ids, x0, y0, pitch, self.slot, self.centre, self.table[light], int(self.mirror),
                cosines[light], lobes[light],
            )  # fmt: skip
        colours = take("colours", (self.channels, count))
        if self.needs_places:
            position, normal, material = self.samples.gather(ids, x0, y0, pitch, count)
            lit = None if self.shadows is None else self.shadows.lit(position, normal)
            self.light.shade_cosines(cosines, lobes, material, colours, position=position, lit=lit)
        else:
            materials = self.samples.geometry.materials
            material = take("material", (count,), np.int32)
            if self.single:
                material.fill(materials[0])
            else:
                np.take(materials, ids[ids >= 0], out=material)
            self.light.shade_cosines(cosines, lobes, material, colours)
        scatter(ids, colours, self.background, int(fill), out)

    @property
    def needs_places(self) -> bool:
        """Whether the place of each pixel matters, for shadows, distances, cones or flaps."""
        if self.shadows is not None or self.light.force_all:
            return True
        return any(
            light.kind in ("spot", "warn")
            or tuple(light.attenuation) != (1.0, 0.0, 0.0)
            or np.isfinite(light.flaps).any()
            for light in self.lights
        )
