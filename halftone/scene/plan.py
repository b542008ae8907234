"""The plan: which stages a scene needs, which it does without, and why."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halftone.scene.illumination import Illumination
from halftone.scene.light_stages import Stage
from halftone.scene.model import Light, Scene
from halftone.scene.view import View

if TYPE_CHECKING:
    from halftone.scene.geometry import Geometry

__all__ = [
    "LUMINANCE",
    "Needs",
    "Plan",
    "Target",
    "clear_faces",
    "illumination_of",
    "needs_of",
    "plan_of",
]

LUMINANCE = (0.2126, 0.7152, 0.0722)
"""Weights of linear R, G, B of Rec. ITU-R BT.709."""


@dataclass(frozen=True)
class Target:
    """What the picture is for: its size in pixels, its channels (None: the scene's), and *why*, the
    reason that the plan states for fewer channels or this size.
    """

    width: int
    height: int
    channels: int | None = None
    why: str = ""


@dataclass(frozen=True)
class Plan:
    """Stages in their order. ``str(plan)`` is a table of them."""

    stages: tuple[Stage, ...]

    def __str__(self) -> str:
        size = max(len(stage.name) for stage in self.stages)
        return "\n".join(
            f"{s.name:{size}}  {'used    ' if s.used else 'left out'}  {s.reason}" for s in self.stages
        )

    @property
    def left_out(self) -> dict[str, str]:
        """Name and reason of what is left out."""
        return {stage.name: stage.reason for stage in self.stages if not stage.used}


@dataclass(frozen=True)
class Needs:
    """What of the geometry's stages a scene needs.

    single : whether one channel of luminance is shaded; reduced : whether three are, and their
    luminance is taken at the end.
    """

    clear: bool
    rim: bool
    details: bool
    shadows: bool
    single: bool
    reduced: bool
    scale: bool


def clear_faces(scene: Scene, materials: NDArray[np.int32]) -> NDArray[np.bool_] | None:
    """bool (F,): faces that let light through; None where there are none."""
    through = np.array([m.transparency > 0 or (m.rim or 0) > 0 for m in scene.materials])
    clear = through[materials]
    return clear if clear.any() else None


def casts(light: Light) -> bool:
    """Whether *light* casts shadows that can be seen."""
    return light.shadows and any(light.intensity)


def needs_of(
    scene: Scene,
    geometry: Geometry,
    target: Target,
    clear: NDArray[np.bool_] | None,
    used: NDArray[np.int64],
) -> Needs:
    """What a sanitised *scene* needs for *target*. clear : see :func:`clear_faces`. used : the numbers
    of its materials that faces have.
    """
    gray = target.channels == 1 and len(scene.background) == 3
    single = gray and scene.overflow == "none"
    return Needs(
        clear=clear is not None,
        rim=clear is not None and any(scene.materials[i].rim is not None for i in used),
        details=geometry.detail is not None,
        shadows=any(casts(light) for light in scene.lights),
        single=single,
        reduced=gray and not single,
        scale=scene.overflow == "scale",
    )


def illumination_of(scene: Scene, view: View, needs: Needs, force_all: bool) -> Illumination:
    """The illumination of a sanitised *scene*."""
    eye, back = (tuple(float(v) for v in vector) for vector in (view.eye, -view.forwards))
    return Illumination(
        scene.materials,
        scene.lights,
        scene.ambient,
        reflection=scene.reflection,
        overflow="none" if scene.overflow == "scale" else scene.overflow,
        eye=eye if view.perspective else None,  # type: ignore[arg-type]
        view=None if view.perspective else back,  # type: ignore[arg-type]
        weights=LUMINANCE if needs.single else None,
        force_all=force_all,
    )


def plan_of(
    scene: Scene,
    geometry: Geometry,
    view: View,
    target: Target,
    needs: Needs,
    light: Illumination,
    *,
    shading: str,
    samples: int,
    clipped: int,
    force_all: bool = False,
) -> Plan:
    """The plan of a sanitised *scene*."""
    stages = []

    def add(name: str, used: bool, yes: str, no: str) -> None:
        stages.append(
            Stage(name, used or force_all, yes if used else f"forced: {no}" if force_all else no)
        )

    size = f"{target.width} × {target.height} pixels"
    stages.append(Stage("projection", True, f"{size}{': ' if target.why else ''}{target.why}"))
    add("clipping", clipped > 0, f"{clipped} faces reach behind the near plane or far beyond the sides",
        "no face reaches behind the near plane or far beyond the sides")  # fmt: skip
    stages.append(Stage("hidden surfaces", True, f"{len(geometry.faces)} faces"))
    add("layers", needs.clear, "materials that let light through", "all materials are opaque")
    add("detail polygons", needs.details, "faces that lie on others", "no face lies on another")
    count = sum(casts(one) for one in scene.lights)
    add("shadow maps", needs.shadows, f"{count} lights cast shadows", "no light casts shadows")
    add("edge samples", samples > 1, f"{samples} × {samples} a pixel at edges", "one sample a pixel")
    why = {
        "flat": "one colour a face", "gouraud": "colours of corners, interpolated",
        "phong": "normals interpolated", "fast-phong": "second-degree polynomials of N·L and N·H",
    }  # fmt: skip
    for name, text in why.items():
        if name == shading:
            stages.append(Stage(f"{name} shading", True, text))
    for stage in light.stages():
        why_not = stage.name == "channels" and not stage.used and target.why
        stages.append(stage._replace(reason=f"{target.why}: {stage.reason}") if why_not else stage)
    if needs.reduced:
        stages.append(
            Stage("luminance", True, f"{target.why or 'one channel'}: taken after the colours")
        )
    add("range scale", needs.scale, "intensities scaled to the range of the picture",
        f"overflow rule is {scene.overflow}")  # fmt: skip
    return Plan(tuple(stages))
