"""Rendering: from a scene to float32 linear radiance, band by band."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import whole
from halftone._parallel import count_workers
from halftone.errors import InputError, UsageError, near
from halftone.scene import _raster_kernels
from halftone.scene.compose import Composer
from halftone.scene.geometry import geometry_of
from halftone.scene.illumination import Illumination
from halftone.scene.model import Scene
from halftone.scene.overflow import extent, scaled
from halftone.scene.plan import (
    LUMINANCE,
    Plan,
    Target,
    clear_faces,
    illumination_of,
    needs_of,
    plan_of,
)
from halftone.scene.raster import BAND, GUARD, Projected, Visibility, projected, run, stretch
from halftone.scene.sanitise import sanitised
from halftone.scene.shade import SHADINGS, Flat, Gouraud, Phong, Samples, Shading
from halftone.scene.view import View, view_of

__all__ = ["Picture", "Renderer", "plan", "render"]

MOST_SAMPLES = 16
WIDE_BAND = 2 * BAND
"""Rows of a band for shadings that keep little for each pixel."""
Band = Callable[[int, int], None]


@dataclass(frozen=True, eq=False)
class Picture:
    """What was rendered.

    radiance : float32 (M, N, C), linear. ids : int32 (M, N), the opaque face that each pixel shows at
    its middle, or −1, counted over all meshes. shares : float32 (M, N) or None, see coverage. report :
    ``seconds`` of each stage, ``counts`` of repaired, dropped, clipped and other faces, ``left_out``
    with the reasons, and the ``plan``.
    """

    radiance: NDArray[np.float32]
    ids: NDArray[np.int32]
    shares: NDArray[np.float32] | None = None
    report: dict[str, Any] = field(default_factory=dict)

    @property
    def coverage(self) -> NDArray[np.float32]:
        """The share of each pixel's samples that a surface covers, float32 (M, N)."""
        return (self.ids >= 0).astype(np.float32) if self.shares is None else self.shares


def render(scene: Scene, width: int, height: int, **options: Any) -> Picture:
    """*scene* as its camera sees it, *width* × *height* pixels: see :meth:`Renderer.render`."""
    begun = perf_counter()
    renderer = Renderer(scene)
    seconds = perf_counter() - begun
    picture = renderer.render(width, height, **options)
    picture.report["seconds"] = {"scene": seconds, **picture.report["seconds"]}
    return picture


def plan(scene: Scene, target: Target, **options: Any) -> Plan:
    """What :func:`render` with the same options will do for *target*, and what it leaves out."""
    return Renderer(scene).plan(target, **options)


class Renderer:
    """A scene made ready once, to be rendered any number of times."""

    def __init__(self, scene: Scene) -> None:
        self.scene, self.counts = sanitised(scene)
        self.geometry = geometry_of(self.scene)
        self.used = np.flatnonzero(np.bincount(self.geometry.materials, minlength=1))
        self.clear = clear_faces(self.scene, self.geometry.materials)

    def _view(self, width: int, height: int) -> View:
        if self.scene.camera is None:
            raise InputError("the scene has no camera; give one, or use framed(scene)")
        return view_of(self.scene.camera, width, height)

    def plan(
        self, target: Target, *, shading: str = "phong", samples: int = 1, force_all: bool = False
    ) -> Plan:
        """See :func:`plan`."""
        _check(shading, samples)
        scene, g = self.scene, self.geometry
        view, needs = (
            self._view(target.width, target.height),
            needs_of(scene, g, target, self.clear, self.used),
        )
        h = view.homogeneous(g.vertices)
        seen = (h[:, 3] >= view.near) & (np.abs(h[:, :2]) <= GUARD * h[:, 2:3]).all(axis=1)
        clipped = int(np.count_nonzero(~seen[g.faces].all(axis=1)))
        light = illumination_of(scene, view, needs, force_all)
        return plan_of(
            scene, g, view, target, needs, light, shading=shading, samples=samples, clipped=clipped,
            force_all=force_all,
        )  # fmt: skip

    def render(
        self,
        width: int,
        height: int,
        *,
        shading: str = "phong",
        samples: int = 1,
        channels: int | None = None,
        why: str = "",
        angle: float = 20.0,
        shadow_resolution: int = 2048,
        workers: int = 1,
        force_all: bool = False,
        band: int | None = None,
        out: NDArray[np.float32] | None = None,
    ) -> Picture:
        """The picture of *width* × *height* pixels; the same bytes for any number of workers.

        shading : ``flat``, ``gouraud``, ``phong`` or ``fast-phong``. samples : n × n a pixel, shaded
        apart where they show different faces. channels : 1 for the luminance (BT.709) of a scene of
        R, G, B, for the reason *why*. angle : degrees between normals of a face above which fast
        Phong shades it exactly. shadow_resolution : pixels a side of a light's map. workers : threads,
        0 for one a processor. force_all : run every stage, needed or not; the pixels are the same.
        band : rows at a time, None for what is fastest. out : float32 (height, width, C) to write to.

        Raises UsageError for unknown names and InputError for scenes that have no meaning.
        """
        _check(shading, samples)
        width, height = whole("width", width, 1, 1 << 17), whole("height", height, 1, 1 << 17)
        if channels not in (None, 1, len(self.scene.background)):
            raise UsageError(
                f"channels={channels}; allowed: {len(self.scene.background)}, as the scene has, or 1"
            )
        whole("shadow_resolution", shadow_resolution, 1, 1 << 14)
        job = _Job(self, Target(width, height, channels, why), shading, samples, count_workers(workers))
        rows = WIDE_BAND if shading in ("flat", "gouraud") else BAND
        rows = rows if band is None else whole("band", band, 1, 1 << 17)
        job.band = max(1, rows // samples) * samples
        job.force_all = force_all
        return job.run(angle, shadow_resolution, out)


def _check(shading: str, samples: int) -> None:
    if shading not in SHADINGS:
        raise UsageError(near(shading, SHADINGS, "shading"))
    whole("samples", samples, 1, MOST_SAMPLES)


class _Job:
    """One rendering: the stages in their order, and their times."""

    band = BAND
    force_all = False

    def __init__(
        self, renderer: Renderer, target: Target, shading: str, samples: int, workers: int
    ) -> None:
        self.scene, self.geometry, self.repairs = renderer.scene, renderer.geometry, renderer.counts
        self.clear = renderer.clear
        self.target, self.shading, self.samples, self.workers = target, shading, samples, workers
        self.needs = needs_of(self.scene, self.geometry, target, renderer.clear, renderer.used)
        self.view = renderer._view(target.width * samples, target.height * samples)
        self.seconds: dict[str, float] = {}
        self._begun = perf_counter()

    def lap(self, name: str) -> None:
        now = perf_counter()
        self.seconds[name] = self.seconds.get(name, 0.0) + now - self._begun
        self._begun = now

    def run(self, angle: float, resolution: int, out: NDArray[np.float32] | None) -> Picture:
        scene, g, needs, force = self.scene, self.geometry, self.needs, self.force_all
        clear = self.clear
        light = illumination_of(scene, self.view, needs, force)
        shadows = None
        if needs.shadows or force:
            from halftone.scene.shadow import Shadows

            shadows = Shadows(
                g,
                scene.lights,
                resolution=resolution,
                workers=self.workers,
                clear=clear,
                force_all=force,
            )
            self.lap("shadow maps")
        made = projected(g, self.view, self.workers, self.band, clear, force)
        self.lap("projection")
        visibility = Visibility(made, g)
        way = self._way(light, shadows, made, angle)
        radiance = self._radiance(light, out)
        shade = Composer(self, way, visibility, light).band(radiance, self.shares)
        if self.shading == "phong":
            self._at_once(visibility.band, shade)
        else:
            way.prepare(self._seen(made, visibility))
            self.lap("faces")
            run(shade, self.view.height, self.band, self.workers)
            self.lap("shading")
        if needs.scale or force:
            limits = extent([radiance])
            if needs.scale:
                radiance[...] = scaled(radiance, limits)
            self.lap("range")
        if needs.reduced:
            radiance = _luminance(radiance)
            self.lap("luminance")
        return self._picture(radiance, visibility, made, way, light)

    def _way(self, light: Illumination, shadows: Any, made: Projected, angle: float) -> Shading:
        two_sided = np.array([m.two_sided for m in self.scene.materials], np.uint8)
        samples = Samples(self.geometry, made, two_sided)
        background = np.array(self.scene.background, np.float64)
        if self.needs.single:
            background = (background * LUMINANCE).sum(keepdims=True)
        given = (samples, light, shadows, background.astype(np.float32), self.workers)
        if self.shading == "fast-phong":
            from halftone.scene.fast import FastPhong

            fast = FastPhong(*given)
            eye = (
                np.append(self.view.eye, 1.0)
                if self.view.perspective
                else np.append(-self.view.forwards, 0.0)
            )
            fast.aim(tuple(self.scene.lights), eye, self.scene.reflection, angle)
            return fast
        kind = {"flat": Flat, "gouraud": Gouraud, "phong": Phong}[self.shading]
        return kind(*given)

    def _at_once(self, see: Band, shade: Band) -> None:
        """Both of every band, one after the other while it is in the cache; the time is shared out."""
        parts: list[tuple[float, float]] = []

        def work(top: int, bottom: int) -> None:
            begun = perf_counter()
            see(top, bottom)
            seen = perf_counter()
            shade(top, bottom)
            parts.append((seen - begun, perf_counter() - seen))

        run(work, self.view.height, self.band, self.workers)
        first, second = (sum(times) for times in zip(*parts, strict=True))
        self.lap("shading")
        self.seconds["visibility"] = self.seconds["shading"] * first / (first + second)
        self.seconds["shading"] -= self.seconds["visibility"]

    def _seen(self, made: Projected, visibility: Visibility) -> NDArray[np.uint8]:
        """See every row. (F,) uint8: 1 for faces seen from the front, 2 from the back, 0 for others."""
        g, seen = self.geometry, np.zeros(len(self.geometry.faces) + 1, np.uint8)

        def see(top: int, bottom: int) -> None:
            visibility.band(top, bottom)
            for ids in [visibility.ids[top:bottom], *visibility.layers.get(top, [])]:
                _raster_kernels.mark(ids, seen)

        def turn(start: int, stop: int) -> None:
            _raster_kernels.turn(start, stop, g.faces, made.h, seen[1:])

        run(see, self.view.height, self.band, self.workers)
        self.lap("visibility")
        if len(g.faces):
            run(turn, len(g.faces), stretch(len(g.faces)), self.workers)
        return seen[1:]

    def _radiance(self, light: Illumination, out: NDArray[np.float32] | None) -> NDArray[np.float32]:
        """Where the picture goes; the shares of its pixels go to self.shares, where they are needed."""
        shape = (self.target.height, self.target.width, light.channels)
        radiance = np.empty(shape, np.float32) if out is None else out
        if radiance.shape != shape or radiance.dtype != np.float32 or not radiance.flags.c_contiguous:
            raise InputError(
                f"out is {radiance.dtype}{radiance.shape}; contiguous float32{shape} is needed"
            )
        needed = self.samples > 1 or self.needs.clear or self.force_all
        self.shares = np.empty(shape[:2], np.float32) if needed else None
        return radiance

    def _picture(
        self,
        radiance: NDArray[np.float32],
        visibility: Visibility,
        made: Projected,
        way: Shading,
        light: Illumination,
    ) -> Picture:
        half = self.samples // 2
        ids = visibility.ids[half :: self.samples, half :: self.samples]
        found = plan_of(
            self.scene, self.geometry, self.view, self.target, self.needs, light, shading=self.shading,
            samples=self.samples, clipped=made.clipped, force_all=self.force_all,
        )  # fmt: skip
        counts = {
            **self.repairs.as_dict(),
            "clipped_faces": made.clipped,
            "zero_normals": self.geometry.zero_normals,
            "layers": max((len(layers) for layers in visibility.layers.values()), default=0),
        }
        for name in ("visible", "fallen_back"):
            if hasattr(way, name):
                counts[name] = getattr(way, name)
        report = {"seconds": self.seconds, "counts": counts, "left_out": found.left_out, "plan": found}
        return Picture(radiance, ids, self.shares, report)


def _luminance(radiance: NDArray[np.float32]) -> NDArray[np.float32]:
    return (radiance @ np.array(LUMINANCE, np.float64)).astype(np.float32)[..., None]
