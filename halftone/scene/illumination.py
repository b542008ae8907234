"""The illumination of surface samples: ambient light and, of each light, a diffuse and a specular term.

    I = k_a·I_a + Σ f(d)·I_l·[k_d·(N·L) + W(θ)·k_s·(N·H)^n]

by channel (Hearn & Baker, ch. 14, with its errata: f(d) = min(1, 1/(a0 + a1·d + a2·d²)), W of the
angle of incidence, the exponent on the angle to the mirror direction). With ``reflection="phong"``
the highlight is (V·R)^n. Only the stages that the materials and lights need are run and compiled.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone.errors import InputError
from halftone.scene import _light_kernels as kernels
from halftone.scene import fresnel
from halftone.scene.check import checked
from halftone.scene.light_stages import Stage, stages
from halftone.scene.lights import Lamp, canonical, direction_to, lamp, place_of
from halftone.scene.model import Colour, Light, Material, Scene, Vector
from halftone.scene.transparency import transparency

__all__ = ["Illumination"]

Rows = NDArray[np.float32]

CHUNK = 32768
"""Samples shaded at a time: their rows of intermediate results stay in the cache."""


@dataclass(frozen=True, eq=False)
class _Source:
    """A light with its colours on every material: (C, materials)."""

    index: int
    lamp: Lamp
    diffuse: Rows
    specular: Rows
    toward: Rows | None  # L and 1/|L| of a distant light
    half: Rows | None  # H and 1/|H| where it is the same for all samples


class Illumination:
    """Materials under lights, seen from one place. Built once, used for any number of samples.

    eye : where the viewer is; or *view*, the direction towards a viewer at infinity (default +z).
    weights : where given, the one channel that is shaded is the sum of the colours' channels by these
    weights (luminance); not with the overflow rules clamp, divide and scale, which are not linear.
    force_all : run every stage, needed or not; the results are the same to the bit.

    Raises InputError for coefficients that are negative or not finite, names that are unknown and
    options that do not apply. The order in which the lights are listed does not matter.
    """

    def __init__(
        self,
        materials: Sequence[Material],
        lights: Sequence[Light] = (),
        ambient: Colour = (1.0, 1.0, 1.0),
        *,
        reflection: str = "blinn",
        overflow: str = "none",
        eye: Vector | None = None,
        view: Vector | None = None,
        weights: Sequence[float] | None = None,
        force_all: bool = False,
    ) -> None:
        if not materials:
            raise InputError("no material was given; allowed: at least one. Give Material()")
        if eye is not None and view is not None:
            raise InputError("both eye and view were given; allowed: one of them")
        checked(
            Scene(
                materials=materials,
                lights=lights,
                ambient=ambient,
                background=(0.0,) * len(ambient),
                reflection=reflection,
                overflow=overflow,
            )
        )
        if weights is not None and (len(weights) != len(ambient) or overflow != "none"):
            raise InputError(
                f"weights={tuple(weights)} for {len(ambient)} channels and overflow='{overflow}'; "
                "allowed: one weight a channel, and overflow='none'"
            )
        self.reflection, self.overflow, self.force_all = reflection, overflow, force_all
        self.eye = direction_to((0, 0, 1) if view is None else view) if eye is None else place_of(eye)
        self.exponents = np.array([min(m.exponent, 3.4e38) for m in materials], np.float32)
        self.materials = tuple(materials)
        self._weights = weights
        self.ambient = self._colours([m.ambient for m in materials], ambient)
        self.channels = len(self.ambient)
        order = sorted(range(len(lights)), key=lambda i: canonical(lights[i]))
        self._sources = [self._source(i, lights[i]) for i in order]
        self._sources = [s for s in self._sources if force_all or s.diffuse.any() or s.specular.any()]
        self._given = len(lights)
        self.has_diffuse = any(s.diffuse.any() for s in self._sources)
        self.has_specular = any(s.specular.any() for s in self._sources)
        self._specular = self.has_specular or (force_all and bool(self._sources))
        coated = any(m.fresnel is not None and any(m.specular) for m in materials)
        self.has_fresnel = self.has_specular and coated
        self._fresnel = self._specular and (coated or force_all)
        self._shares = np.zeros(0, np.float32)
        if self._fresnel:
            self._shares = np.concatenate([fresnel.nodes(m.fresnel) for m in materials])

    def shade(
        self, position: Rows, normal: Rows, material: NDArray[np.int32], out: Rows, lit: Any = None
    ) -> None:
        """Write the radiance of K samples to *out*, float32 (C, K).

        position, normal : float32 (3, K); normals of length 1 that face the viewer. material : int32
        (K,). lit : uint8 (lights, K), 0 where a light that casts shadows does not reach; or None.
        """
        _check_shapes(material, (3,), position=position, normal=normal)
        self._run(material, out, lit, position, normal, None, None)

    def shade_cosines(
        self,
        incidence: Rows,
        highlight: Rows | None,
        material: NDArray[np.int32],
        out: Rows,
        *,
        position: Rows | None = None,
        lit: Any = None,
    ) -> None:
        """As :meth:`shade`, from cosines that are known: float32 (lights, K), as the lights are listed.

        incidence : N·L. highlight : N·H (blinn) or V·R (phong), or None without specular terms.
        Cosines that are NaN, negative or above 1 are limited as in shade. position : needed where
        :attr:`needs_position` says so.
        """
        if position is None and self.needs_position and not self.force_all:
            raise InputError("no position was given, but a light is a spot, fades or has flaps; give it")
        if highlight is None and self._specular:
            raise InputError("no highlight cosines were given, but a material shines; give them")
        _check_shapes(material, (self._given,), incidence=incidence, highlight=highlight)
        _check_shapes(material, (3,), position=position)
        self._run(material, out, lit, position, None, incidence, highlight)

    def constant(self, light: int) -> tuple[Rows | None, Rows | None]:
        """L and H of unit length where they are the same for all samples, else None: float32 (3,)."""
        for source in self._sources:
            if source.index == light:
                toward = source.lamp.place[:3].copy() if source.lamp.distant else None
                half = source.half
                return toward, None if half is None else half[:3] * half[3]
        return None, None

    def stages(self) -> list[Stage]:
        """The stages in their order: name, whether it is used, and why (not)."""
        channels = len(self.materials[0].ambient)
        return stages(self, self._given, None if self._weights is None else channels)

    @property
    def lamps(self) -> tuple[Lamp, ...]:
        """The lights that show on any material."""
        return tuple(source.lamp for source in self._sources)

    @property
    def constant_halfway(self) -> tuple[bool, ...]:
        """Of each of these lights with a highlight, whether H is the same for all samples."""
        return tuple(s.half is not None for s in self._sources if s.specular.any())

    @property
    def needs_position(self) -> bool:
        """Whether :meth:`shade_cosines` needs positions: light that fades, cones, lobes or flaps."""
        placed = (any((p.attenuated, p.cone, p.lobe, p.flaps)) for p in self.lamps)
        return self.force_all or any(placed)

    def transparency(self, material: NDArray[np.int32], n_z: Rows) -> Rows:
        """k_t of each sample: :func:`halftone.scene.transparency.transparency`."""
        return transparency(self.materials, material, n_z, force_all=self.force_all)

    def _source(self, index: int, light: Light) -> _Source:
        made = lamp(light, f"lights[{index}]")
        diffuse = self._colours([m.diffuse for m in self.materials], light.intensity)
        specular = self._colours([m.specular for m in self.materials], light.intensity)
        constant = made.distant and self.eye[3] == 0 and self.reflection == "blinn"
        half = _halfway(made.place, self.eye) if constant else None
        toward = _with_inverse(made.place[:3]) if made.distant else None
        return _Source(index, made, diffuse, specular, toward, half)

    def _colours(self, surfaces: Sequence[Colour], light: Colour) -> Rows:
        """surface · light of each channel and material, float32 (C, materials)."""
        made = np.array(surfaces, np.float64) * np.array(light, np.float64)
        if self._weights is not None:
            made = (made * np.array(self._weights, np.float64)).sum(axis=1, keepdims=True)
        return np.ascontiguousarray(np.minimum(made.T, 3.4e38), np.float32)

    def _run(
        self,
        material: NDArray[np.int32],
        out: Rows,
        lit: Any,
        position: Rows | None,
        normal: Rows | None,
        incidence: Rows | None,
        highlight: Rows | None,
    ) -> None:
        count = material.shape[0]
        _check_shapes(material, (self.channels,), out=out)
        _check_shapes(material, (self._given,), lit=lit)
        if count and not 0 <= int(material.min()) <= int(material.max()) < len(self.materials):
            raise InputError(
                f"material numbers {material.min()} … {material.max()} for {len(self.materials)} "
                f"materials; allowed: 0 … {len(self.materials) - 1}"
            )
        with np.errstate(all="ignore"):  # where kernels run as plain Python
            for start in range(0, count, CHUNK):
                work = _Work(start, min(start + CHUNK, count), material, out)
                self._start(work)
                for source in self._sources:
                    given = None if incidence is None else incidence[source.index]
                    self._incidence(work, source, position, normal, given)
                    factor = self._factor(work, source, position, lit)
                    self._add(work, source.diffuse, work.incidence, factor)
                    if self.force_all or source.specular.any():
                        given = None if highlight is None else highlight[source.index]
                        self._highlight(work, source, position, normal, given)
                        self._add(work, source.specular, work.highlight, factor)
                self._finish(work)

    def _start(self, work: _Work) -> None:
        """Ambient light, and what all lights need of the materials."""
        ambient = np.minimum(self.ambient, 1) if self.overflow == "clamp" else self.ambient
        single = len(self.materials) == 1
        if single and not self.force_all:
            work.shown[...] = ambient
        else:
            work.shown[...] = 0
            work.weight.fill(1)
            kernels.add(work.start, work.material, ambient, work.weight, work.out)
        if self.overflow == "divide":
            work.top.fill(0)
            work.weight.fill(1)
            kernels.largest(work.start, work.material, ambient.max(axis=0), work.weight, work.top)
        if self._specular:
            if single:
                work.exponent.fill(self.exponents[0])
            else:
                np.take(self.exponents, work.samples, out=work.exponent, mode="clip")

    def _incidence(
        self, work: _Work, source: _Source, position: Any, normal: Any, given: Rows | None
    ) -> None:
        if given is not None:
            np.fmax(given[work.start : work.stop], 0, out=work.incidence)
            np.minimum(work.incidence, 1, out=work.incidence)
        elif source.toward is not None and not self.force_all:
            kernels.facing(work.start, normal, source.toward, work.incidence)
        else:
            kernels.incidence(work.start, position, normal, source.lamp.place, work.incidence)

    def _highlight(
        self, work: _Work, source: _Source, position: Any, normal: Any, given: Rows | None
    ) -> None:
        cosine = work.cosine
        if given is not None:
            cosine = given[work.start : work.stop]
        elif source.half is not None and not self.force_all:
            kernels.facing(work.start, normal, source.half, cosine)
        else:
            angle = kernels.halfway if self.reflection == "blinn" else kernels.mirrored
            angle(work.start, position, normal, source.lamp.place, self.eye, cosine)
        kernels.sharpen(work.incidence, cosine, work.exponent, work.highlight)
        if self._fresnel:
            kernels.reflect(work.start, work.incidence, work.material, self._shares, work.highlight)

    def _factor(self, work: _Work, source: _Source, position: Any, lit: Any) -> Rows | None:
        """What is left of the light on its way to each sample; None for all of it."""
        lamp, every = source.lamp, self.force_all and position is not None
        shadowed = lit is not None and lamp.shadows
        if not (every or shadowed or lamp.attenuated or lamp.cone or lamp.lobe or lamp.flaps):
            return None
        where = (work.start, position, lamp.place)
        work.factor.fill(1)
        if lamp.attenuated or every:
            kernels.attenuate(*where, lamp.attenuation, work.factor)
        if lamp.cone or every:
            kernels.cone(*where, lamp.axis, work.factor)
        if lamp.lobe or every:
            kernels.off_axis(*where, lamp.axis, work.cosine)
            work.weight.fill(lamp.axis[5])
            kernels.sharpen(work.incidence, work.cosine, work.weight, work.highlight)
            np.multiply(work.factor, work.highlight, out=work.factor)
        if lamp.flaps or every:
            kernels.flaps(work.start, position, lamp.limits, work.factor)
        if shadowed:
            np.multiply(work.factor, lit[source.index, work.start : work.stop], out=work.factor)
        return work.factor

    def _add(self, work: _Work, colour: Rows, row: Rows, factor: Rows | None) -> None:
        """Add the term colour · row · factor by the overflow rule."""
        if not (self.force_all or colour.any()):
            return
        if factor is not None:
            row = np.multiply(row, factor, out=work.weight)
        add = kernels.add_clamped if self.overflow == "clamp" else kernels.add
        add(work.start, work.material, colour, row, work.out)
        if self.overflow == "divide":
            kernels.largest(work.start, work.material, colour.max(axis=0), row, work.top)

    def _finish(self, work: _Work) -> None:
        if self.overflow == "clamp":
            np.minimum(work.shown, 1, out=work.shown)
        elif self.overflow == "divide":
            np.divide(work.shown, np.maximum(work.top, 1), out=work.shown)


def _check_shapes(material: NDArray[np.int32], first: tuple[int], **rows: Any) -> None:
    """Refuse rows that have not as many samples as *material*: kernels do not look."""
    wanted = first + material.shape
    for name, array in rows.items():
        if array is not None and array.shape != wanted:
            raise InputError(f"{name} has shape {array.shape}; allowed: {wanted}, as material has")


class _Spare(threading.local):
    """Memory for rows of intermediate results; each thread has its own, and keeps it."""

    def __init__(self) -> None:
        self.rows = np.empty((7, CHUNK), np.float32)


_SPARE = _Spare()


class _Work:
    """Some of the samples, with rows of intermediate results."""

    def __init__(self, start: int, stop: int, material: NDArray[np.int32], out: Rows) -> None:
        self.start, self.stop, self.material, self.out = start, stop, material, out
        self.samples, self.shown = material[start:stop], out[:, start:stop]
        rows = [row[: stop - start] for row in _SPARE.rows]
        self.incidence, self.cosine, self.highlight, self.exponent = rows[:4]
        self.factor, self.weight, self.top = rows[4:]


def _with_inverse(vector: Rows) -> Rows:
    """x, y, z and 1/length, rounded as the kernels round it."""
    x, y, z = vector
    return np.array([x, y, z, np.float32(1) / np.sqrt((x * x + y * y) + z * z)], np.float32)


def _halfway(light: Rows, eye: Rows) -> Rows:
    """H between two directions, as the kernel :func:`blinn` finds it; NaN where they are opposite."""
    (x, y, z), (u, v, w) = light[:3], eye[:3]
    t = np.sqrt(((x * x + y * y) + z * z) / ((u * u + v * v) + w * w))
    with np.errstate(all="ignore"):
        return _with_inverse(np.array([x + u * t, y + v * t, z + w * t], np.float32))
