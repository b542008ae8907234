"""Hidden surfaces: a visibility buffer, the face that each pixel shows, by bands of rows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from halftone._parallel import bands, side_by_side
from halftone.scene import _raster_kernels as kernels
from halftone.scene.geometry import Geometry
from halftone.scene.scratch import Scratch
from halftone.scene.view import View

__all__ = ["BAND", "GUARD", "Bins", "Projected", "Visibility", "binned", "projected", "run", "stretch"]

BAND = 64
"""Rows of a band. The result does not depend on it."""
GUARD = 131072.0
"""Pixels from the middle of the picture that a snapped corner may have; beyond it faces are clipped."""
PARTS = 16
"""Stretches that vertices and faces are worked on in, at most."""
LEAST = 65536
"""Vertices or faces of a stretch: fewer are done sooner than a thread starts."""


def run(work: Callable[[int, int], None], count: int, size: int, workers: int) -> None:
    """work(start, stop) over *count* things, *size* at a time, over *workers* threads.

    Each thread takes the next stretch when it is ready: one task a thread, not one a stretch, since a
    task costs as much as a small stretch.
    """
    parts = list(bands(count, size))
    if workers <= 1 or len(parts) <= 1:
        for start, stop in parts:
            work(start, stop)
        return
    left = iter(parts)  # next() of a list's iterator is one step of the interpreter

    def take(_thread: int) -> None:
        for start, stop in left:
            work(start, stop)

    side_by_side(take, min(workers, len(parts)), parts.clear)


def stretch(count: int) -> int:
    """How many of *count* vertices or faces are worked on at a time."""
    return max(LEAST, -(-count // PARTS))


class Bins(NamedTuple):
    """The faces of every band: faces[starts[band] : starts[band + 1]], int32 and int64."""

    faces: NDArray[np.int32]
    starts: NDArray[np.int64]

    def only(self, wanted: NDArray[np.bool_]) -> Bins:
        """Those for which *wanted*, (Q,), is true."""
        keep = wanted[self.faces]
        return Bins(
            self.faces[keep], np.concatenate([[0], np.cumsum(keep, dtype=np.int64)])[self.starts]
        )

    def sorted(self, level: NDArray[np.int64]) -> Bins:
        """Each band's faces in the order of *level*, (Q,), those of one level in their own order."""
        band = np.repeat(np.arange(len(self.starts) - 1), np.diff(self.starts))
        return Bins(self.faces[np.lexsort((level[self.faces], band))], self.starts)

    def joined(self, other: Bins) -> Bins:
        """These and after them the *other* ones, band by band."""
        band = [np.repeat(np.arange(len(b.starts) - 1), np.diff(b.starts)) for b in (self, other)]
        order = np.argsort(np.concatenate(band), kind="stable")
        return Bins(np.concatenate([self.faces, other.faces])[order], self.starts + other.starts)


@dataclass(eq=False)
class Projected:
    """Faces in the picture: h float64 (V, 3), snapped int32 (P, 2), key float64 (P,), faces int32
    (Q, 3) into them, and owner int32 (Q,), the scene's face. P and Q exceed V and F by clipped pieces.
    rows : of a band. solid, layers, details : the faces that are opaque, that let light through, and
    that lie on others. clipped : how many faces had to be clipped.
    """

    view: View
    rows: int
    h: NDArray[np.float64]
    snapped: NDArray[np.int32]
    key: NDArray[np.float64]
    faces: NDArray[np.int32]
    owner: NDArray[np.int32]
    solid: Bins
    layers: Bins | None = None
    details: Bins | None = None
    clipped: int = 0


def projected(
    geometry: Geometry,
    view: View,
    workers: int = 1,
    rows: int = BAND,
    clear: NDArray[np.bool_] | None = None,
    force_all: bool = False,
) -> Projected:
    """The faces of *geometry* in *view*, clipped, snapped and sorted into bands of *rows* rows.

    clear : bool (F,), the faces that let light through; None where there are none. force_all : make
    the lists of layers and details, and clip, even if there is nothing in them.
    """
    vertices, faces = geometry.vertices, geometry.faces
    count, total = len(vertices), len(faces)
    h, snapped = np.empty((count, 3)), np.empty((count, 2), np.int32)
    key, outside = np.empty(count), np.empty(count, np.uint8)
    matrix = view.rows

    def project(start: int, stop: int) -> None:
        kernels.project(
            vertices, view.eye, matrix, int(view.perspective), view.width / 2, view.height / 2, GUARD,
            start, stop, h, snapped, key, outside,
        )  # fmt: skip

    if count:
        run(project, count, stretch(count), workers)
    nothing = Bins(np.zeros(0, np.int32), np.zeros(1, np.int64))
    made = Projected(view, rows, h, snapped, key, faces, np.arange(total, dtype=np.int32), nothing)
    made.solid, to_clip = binned(made, outside, 0, total, workers)
    if len(to_clip) or force_all:
        from halftone.scene.clip import add_clipped

        add_clipped(made, geometry, to_clip, workers)
    _parted(made, geometry, clear, force_all)
    return made


def _parted(
    made: Projected, geometry: Geometry, clear: NDArray[np.bool_] | None, force_all: bool
) -> None:
    """Move layers and details from the solid faces to lists of their own."""
    detail = geometry.detail
    every = made.solid
    if detail is not None or force_all:
        if detail is None:
            detail = np.full(len(geometry.faces), -1, np.int32)
        lies = (detail >= 0)[made.owner]
        level = np.zeros(len(detail), np.int64)
        parent = detail
        while (parent >= 0).any():  # details on details come after what they lie on
            level += parent >= 0
            parent = np.where(parent >= 0, detail[parent], -1)
        made.details = every.only(lies).sorted(level[made.owner])
        made.solid = every.only(~lies)
    if clear is not None or force_all:
        through = np.zeros(len(made.owner), bool) if clear is None else clear[made.owner]
        made.layers = made.solid.only(through)
        made.solid = made.solid.only(~through)


def binned(
    made: Projected, outside: NDArray[np.uint8], first: int, last: int, workers: int
) -> tuple[Bins, NDArray[np.int32]]:
    """Faces *first* … *last* sorted into bands, each list in the faces' order, and those to clip."""
    view, count = made.view, last - first
    number = -(-view.height // made.rows)
    if not count:
        return Bins(np.zeros(0, np.int32), np.zeros(number + 1, np.int64)), np.zeros(0, np.int32)
    size = stretch(count)
    counts = np.zeros((-(-count // size), number + 1), np.int32)
    span = np.empty((last, 2), np.int32)

    def sort(start: int, stop: int) -> None:
        kernels.sort_faces(
            made.faces, made.snapped, outside, first + start, first + stop, view.width, view.height,
            made.rows, span, counts[start // size],
        )  # fmt: skip

    run(sort, count, size, workers)
    starts = np.concatenate([[0], np.cumsum(counts.sum(axis=0, dtype=np.int64))])
    at = starts[:-1] + np.cumsum(counts, axis=0, dtype=np.int64) - counts
    faces = np.empty(int(starts[-1]), np.int32)

    def fill(start: int, stop: int) -> None:
        kernels.bin_faces(span, first + start, first + stop, at[start // size], faces)

    run(fill, count, size, workers)
    return Bins(faces[: starts[-2]], starts[:-1]), faces[starts[-2] :]


class Visibility:
    """The visibility buffer: ids int32 (M, N), the face that each pixel shows, or −1; and layers, for
    every band with faces that let light through before its solid ones, such buffers, nearest first.
    """

    def __init__(self, made: Projected, geometry: Geometry, depth: bool = False) -> None:
        self.made, self.geometry = made, geometry
        shape = (made.view.height, made.view.width)
        self.ids = np.empty(shape, np.int32)
        self.depth = np.empty(shape) if depth else None
        self.layers: dict[int, list[NDArray[np.int32]]] = {}
        self._scratch = Scratch()

    def band(self, top: int, bottom: int) -> None:
        """Work out rows *top* … *bottom*, which must be a band of the bins."""
        made, ids = self.made, self.ids[top:bottom]
        depth = self._scratch.take("depth", ids.shape, np.float64)
        if self.depth is not None:
            depth = self.depth[top:bottom]
        kernels.clear(ids, depth)
        self._cover(kernels.SURFACE, made.solid, top, ids, depth)
        if made.layers is not None:
            self._peel(made.layers, top, ids, depth)
        if made.details is not None and self.geometry.detail is not None:
            for buffer in [ids, *self.layers.get(top, [])]:
                self._cover(kernels.DETAIL, made.details, top, buffer, depth)

    def all(self, workers: int = 1) -> NDArray[np.int32]:
        """Every row."""
        run(self.band, self.made.view.height, self.made.rows, workers)
        return self.ids

    def _cover(
        self,
        mode: int,
        bins: Bins,
        top: int,
        ids: NDArray[np.int32],
        depth: NDArray[np.float64],
        front: tuple[NDArray[np.int32], NDArray[np.float64]] | None = None,
        solid: tuple[NDArray[np.int32], NDArray[np.float64]] | None = None,
    ) -> None:
        made, g, at = self.made, self.geometry, top // self.made.rows
        kernels.cover(
            mode, bins.faces, int(bins.starts[at]), int(bins.starts[at + 1]), made.faces, made.owner,
            made.snapped, made.key, top, top + len(ids), made.view.width, ids, depth,
            *(front or (ids, depth)), *(solid or (ids, depth)),
            made.owner if g.plane is None else g.plane, made.owner if g.detail is None else g.detail,
        )  # fmt: skip

    def _peel(self, bins: Bins, top: int, solid: NDArray[np.int32], depth: NDArray[np.float64]) -> None:
        """Layers before the *solid* faces, from the nearest on, until one is empty."""
        front_ids, front_depth = np.full(solid.shape, -1, np.int32), np.full(solid.shape, np.inf)
        while True:
            ids, key = np.empty_like(solid), np.empty_like(depth)
            kernels.clear(ids, key)
            front = front_ids, front_depth
            self._cover(kernels.LAYER, bins, top, ids, key, front, (solid, depth))
            if not (ids >= 0).any():
                return
            front_ids, front_depth = ids.copy(), key
            self.layers.setdefault(top, []).append(ids)
