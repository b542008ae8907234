"""From ids to pixels: the background, the opaque faces, layers that let light through, and samples."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from halftone.scene import _shade_kernels as kernels
from halftone.scene.illumination import Illumination
from halftone.scene.raster import Visibility
from halftone.scene.scratch import Scratch
from halftone.scene.shade import Ids, Rows, Shading

__all__ = ["Composer"]


class Composer:
    """Bands of pixels. job : the rendering, whose samples, needs, scene and force_all are read."""

    def __init__(self, job: Any, way: Shading, visibility: Visibility, light: Illumination) -> None:
        self.samples, self.force_all, self.rim = job.samples, job.force_all, job.needs.rim
        self.back = -job.view.forwards.astype(np.float32)
        self.geometry, self.way, self.visibility = job.geometry, way, visibility
        self.light, self.scratch = light, Scratch()
        self.left, self.top = -job.view.width / 2, -job.view.height / 2

    def band(self, radiance: Rows, shares: Rows | None) -> Callable[[int, int], None]:
        """What is to be done for the rows of samples *top* … *bottom*."""
        if shares is not None and (self.samples > 1 or self.force_all):
            return lambda top, bottom: self._sampled(top, bottom, radiance, shares)
        return lambda top, bottom: self._plain(top, bottom, radiance, shares)

    def _plain(self, top: int, bottom: int, radiance: Rows, shares: Rows | None) -> None:
        ids, layers = self.visibility.ids[top:bottom], self.visibility.layers.get(top, [])
        self._paint(ids, layers, top, 1, radiance[top:bottom])
        if shares is not None:
            covered = ids >= 0
            for layer in layers:
                covered |= layer >= 0
            shares[top:bottom] = covered

    def _sampled(self, top: int, bottom: int, radiance: Rows, shares: Rows) -> None:
        """A pixel whose samples all show the same is shaded once, at its middle; others sample by
        sample.
        """
        n = self.samples
        every = [self.visibility.ids[top:bottom], *self.visibility.layers.get(top, [])]
        blocks = [each.reshape(each.shape[0] // n, n, -1, n) for each in every]
        same = np.ones((blocks[0].shape[0], blocks[0].shape[2]), bool)
        covered = np.zeros(blocks[0].shape, bool)
        for block in blocks:
            same &= (block == block[:, :1, :, :1]).all(axis=(1, 3))
            covered |= block >= 0
        nothing = np.int32(-1)
        first, last = top // n, bottom // n
        alone = [np.where(same, block[:, 0, :, 0], nothing) for block in blocks]
        self._paint(alone[0], alone[1:], top, n, radiance[first:last])
        shares[first:last] = covered.sum(axis=(1, 3)) / np.float32(n * n)
        if same.all():
            return
        apart = [
            np.where(same[:, None, :, None], nothing, block).reshape(each.shape)
            for block, each in zip(blocks, every, strict=True)
        ]
        fine = self.scratch.take("fine", (*every[0].shape, self.light.channels))
        self._paint(apart[0], apart[1:], top, 1, fine)
        parts = fine.reshape(last - first, n, -1, n, self.light.channels)
        total = np.zeros((int(np.count_nonzero(~same)), self.light.channels), np.float32)
        for y in range(n):
            for x in range(n):
                total += parts[:, y, :, x][~same]
        radiance[first:last][~same] = total / np.float32(n * n)

    def _paint(self, ids: Ids, layers: list[Ids], top: int, pitch: int, out: Rows) -> None:
        """Faces *ids* before the background and *layers*, nearest first, before them."""
        where = (self.left + pitch / 2, self.top + top + pitch / 2, float(pitch))
        self.way.paint(ids, *where, True, out)
        for layer in reversed(layers):
            painted = self.scratch.take("layer", out.shape)
            self.way.paint(layer, *where, False, painted)
            kernels.blend(layer, painted, self._share(layer, where), out)

    def _share(self, ids: Ids, where: tuple[float, float, float]) -> Rows:
        """k_t of the covered pixels."""
        material = self.geometry.materials[ids[ids >= 0]]
        if not (self.rim or self.force_all):
            return self.light.transparency(material, np.zeros(len(material), np.float32))
        _, normal, _ = self.way.samples.gather(ids, *where, len(material))
        x, y, z = self.back
        return self.light.transparency(material, (normal[0] * x + normal[1] * y) + normal[2] * z)
