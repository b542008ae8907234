"""Shading what is seen: face by face (flat), corner by corner (Gouraud) or pixel by pixel (Phong).

Gouraud's colours and Phong's normals are interpolated correctly in perspective, not linearly in the
picture, so that they do not swim as the view turns.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from halftone.scene import _shade_kernels as kernels
from halftone.scene.geometry import Geometry
from halftone.scene.illumination import Illumination
from halftone.scene.raster import Projected, run, stretch
from halftone.scene.scratch import Scratch

__all__ = ["SHADINGS", "Flat", "Gouraud", "Phong", "Samples", "Shading"]

Ids = NDArray[np.int32]
Rows = NDArray[np.float32]

SHADINGS = ("flat", "gouraud", "phong", "fast-phong")

_SIGNS = np.repeat(np.array([[1, 1, 1], [1, -1, 0], [1, 1, 1]], np.float32), (3, 3, 2), axis=0).T
SIDES = np.append(_SIGNS, np.arange(8, dtype=np.float32))
"""What a corner's numbers are multiplied by on fronts, backs of two-sided materials and other backs;
then 0 … 7.
"""


class Shade(Protocol):
    """Which lights reach the samples: (lights, K) uint8, or None where all do."""

    def lit(self, position: Rows, normal: Rows) -> NDArray[np.uint8] | None: ...


class Samples:
    """Positions, normals and materials of the pixels that a band of ids shows."""

    def __init__(self, geometry: Geometry, made: Projected, two_sided: NDArray[np.uint8]) -> None:
        self.geometry, self.made, self.two_sided = geometry, made, two_sided
        self.scratch = Scratch()

    def gather(self, ids: Ids, x0: float, y0: float, pitch: float, count: int) -> tuple[Rows, Rows, Ids]:
        """(position, normal, material) of the *count* covered pixels of *ids*."""
        g, take = self.geometry, self.scratch.take
        position, normal = take("position", (3, count)), take("normal", (3, count))
        material = take("material", (count + kernels.WIDE,), np.int32)
        kernels.gather_samples(
            ids, x0, y0, pitch, g.faces, g.corners, self.made.h, g.table, SIDES, g.materials,
            self.two_sided, take("edge", (2 * kernels.WIDE,)),
            take("row", (kernels.WIDE * (ids.shape[1] + kernels.WIDE),)), take("scale", ids.shape[1:]),
            position, normal, material,
        )  # fmt: skip
        return position, normal, material[:count]


class Shading:
    """A way of shading the pixels of a band.

    background : float32 (C,), what pixels get that show no face.
    """

    def __init__(
        self, samples: Samples, light: Illumination, shade: Shade | None, background: Rows, workers: int
    ) -> None:
        self.samples, self.light, self.shadows = samples, light, shade
        self.background, self.workers = background, workers
        self.channels = light.channels

    def prepare(self, seen: NDArray[np.uint8]) -> None:
        """Work that is done once a picture. seen : (F,), 1 where a face's front is seen, 2 its back."""

    def paint(self, ids: Ids, x0: float, y0: float, pitch: float, fill: bool, out: Rows) -> None:
        """What *ids* (rows, N) show to out (rows, N, C), and the background elsewhere if *fill*.

        x0, y0, pitch : see :func:`halftone.scene._shade_kernels.gather_samples`.
        """
        raise NotImplementedError

    def lighten(self, position: Rows, normal: Rows, material: Ids, out: Rows) -> Rows:
        """The colours of samples, shadows included."""
        lit = None if self.shadows is None else self.shadows.lit(position, normal)
        self.light.shade(position, normal, material, out, lit=lit)
        return out


class Phong(Shading):
    """Normals interpolated and brought to length 1 at every pixel (Phong, CACM 18(6), 1975)."""

    def paint(self, ids: Ids, x0: float, y0: float, pitch: float, fill: bool, out: Rows) -> None:
        count = int(np.count_nonzero(ids >= 0))
        position, normal, material = self.samples.gather(ids, x0, y0, pitch, count)
        colours = self.samples.scratch.take("colours", (self.channels, count))
        self.lighten(position, normal, material, colours)
        kernels.scatter(ids, colours, self.background, int(fill), out)


class Flat(Shading):
    """One colour a face, that of its centre (Bouknight, CACM 13(9), 1970)."""

    slot: Ids
    table: Rows

    def prepare(self, seen: NDArray[np.uint8]) -> None:
        g, made = self.samples.geometry, self.samples
        visible = np.flatnonzero(seen).astype(np.int32)
        self.slot = np.empty(len(seen), np.int32)
        self.slot[visible] = np.arange(len(visible), dtype=np.int32)
        self.table = np.empty((len(visible), self.channels), np.float32)

        def work(start: int, stop: int) -> None:
            take, count = made.scratch.take, stop - start
            position, normal = take("position", (3, count)), take("normal", (3, count))
            material = take("material", (count,), np.int32)
            kernels.sample_faces(
                visible, start, seen, g.faces, g.vertices, g.materials, made.two_sided, position,
                normal, material,
            )  # fmt: skip
            colours = take("colours", (self.channels, count))
            self.table[start:stop] = self.lighten(position, normal, material, colours).T

        if len(visible):
            run(work, len(visible), stretch(len(visible)), self.workers)

    def paint(self, ids: Ids, x0: float, y0: float, pitch: float, fill: bool, out: Rows) -> None:
        kernels.paint_faces(ids, self.slot, self.table, self.background, int(fill), out)


class Gouraud(Shading):
    """Colours of corners, interpolated (Gouraud, IEEE TC C-20(6), 1971), correctly in perspective."""

    fronts: Rows
    backs: Rows

    def prepare(self, seen: NDArray[np.uint8]) -> None:
        g = self.samples.geometry
        total = len(g.attributes)
        sides = np.where(self.samples.two_sided, np.float32(-1), np.float32(0))
        self.fronts = np.empty((total, self.channels), np.float32)
        self.backs = np.empty_like(self.fronts) if (seen == 2).any() else self.fronts

        def work(start: int, stop: int) -> None:
            rows = np.ascontiguousarray(g.attributes[start:stop].T)
            material = g.attribute_material[start:stop]
            colours = np.empty((self.channels, stop - start), np.float32)
            self.fronts[start:stop] = self.lighten(rows[:3], rows[3:], material, colours).T
            if self.backs is not self.fronts:
                rows[3:] *= sides[material]
                self.backs[start:stop] = self.lighten(rows[:3], rows[3:], material, colours).T

        if total:
            run(work, total, stretch(total), self.workers)

    def paint(self, ids: Ids, x0: float, y0: float, pitch: float, fill: bool, out: Rows) -> None:
        g = self.samples.geometry
        kernels.paint_corners(
            ids, x0, y0, pitch, g.faces, g.corners, self.samples.made.h, self.fronts, self.backs,
            self.background, int(fill), out,
        )  # fmt: skip
