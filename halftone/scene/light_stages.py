"""What an :class:`~halftone.scene.illumination.Illumination` does and leaves out, and why, in words."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from halftone.scene.lights import Lamp

if TYPE_CHECKING:
    from halftone.scene.illumination import Illumination

__all__ = ["Stage", "stages"]

UNFORCED = ("channels", "ambient", "lights", "shadows", "overflow")


class Stage(NamedTuple):
    """A stage of the plan: its name, whether it is used, and why (not)."""

    name: str
    used: bool
    reason: str


def stages(of: Illumination, given: int, weighted: int | None) -> list[Stage]:
    """The stages in their order. given : lights of the scene. weighted : channels that become one."""
    lamps, materials, none = of.lamps, of.materials, "no light"
    found = [
        Stage("channels", weighted is None, _channels(of.channels, weighted)),
        _choice("ambient", of.ambient.any(), "k_a · I_a", "no ambient coefficient or no ambient light"),
        Stage("lights", bool(lamps), _lights(len(lamps), given)),
        _choice("diffuse", of.has_diffuse, "k_d · N·L", "no diffuse coefficient" if lamps else none),
        _specular(of),
        *_viewing(of),
        _choice(
            "fresnel",
            of.has_fresnel,
            _some(materials, lambda m: m.fresnel is not None, "material"),
            "no material that shines has a Fresnel share" if of.has_specular else "no specular term",
        ),
        _of_lights("attenuation", lamps, lambda lamp: lamp.attenuated, _no_attenuation(lamps)),
        _of_lights("cone", lamps, lambda lamp: lamp.cone, "no spotlight"),
        _of_lights("lobe", lamps, lambda lamp: lamp.lobe, "no light with an exponent"),
        _of_lights("flaps", lamps, lambda lamp: lamp.flaps, "no light with flaps"),
        _of_lights("shadows", lamps, lambda lamp: lamp.shadows, "no light casts shadows"),
        _choice("overflow", of.overflow != "none", of.overflow, "rule none: left to the display stage"),
        _choice(
            "transparency",
            any(m.transparency or m.rim for m in materials),
            _some(materials, lambda m: bool(m.transparency or m.rim), "material"),
            "all materials are opaque",
        ),
    ]
    if not of.force_all:
        return found
    return [_forced(stage, bool(lamps)) for stage in found]


def _forced(stage: Stage, lit: bool) -> Stage:
    """Stages of lights run where there is any; the others have nothing to do."""
    runs = stage.name == "transparency" or (lit and stage.name not in UNFORCED)
    return stage if stage.used or not runs else Stage(stage.name, True, f"forced ({stage.reason})")


def _choice(name: str, used: object, why: str, why_not: str) -> Stage:
    return Stage(name, bool(used), why if used else why_not)


def _specular(of: Illumination) -> Stage:
    why = "(V·R)^n" if of.reflection == "phong" else "(N·H)^n"
    why_not = "no specular coefficient" if of.lamps else "no light"
    return _choice("specular", of.has_specular, f"k_s · {why}", why_not)


def _viewing(of: Illumination) -> list[Stage]:
    """Whether the halfway vector is found once or for each sample."""
    name = "reflection vector" if of.reflection == "phong" else "halfway vector"
    if not of.has_specular:
        return [Stage(f"{name} of each sample", False, "no specular term")]
    constant = of.constant_halfway
    if all(constant):
        why = "light and viewer at infinity: H is the same everywhere"
    elif of.reflection == "phong":
        why = "R turns with the normal"
    elif of.eye[3] != 0:
        why = "the viewer is near: V varies"
    else:
        why = f"{constant.count(False)} of {len(constant)} lights are near: L varies"
    return [Stage(f"{name} of each sample", not all(constant), why)]


def _of_lights(name: str, lamps: Sequence[Lamp], has: Callable[[Lamp], bool], why_not: str) -> Stage:
    why = _some(lamps, has, "light")
    return _choice(name, any(map(has, lamps)), why, why_not if lamps else "no light")


def _some(items: Sequence[Any], has: Callable[[Any], bool], what: str) -> str:
    plural = "" if len(items) == 1 else "s"
    return f"{sum(map(has, items))} of {len(items)} {what}{plural}"


def _no_attenuation(lamps: Sequence[Lamp]) -> str:
    if all(lamp.distant for lamp in lamps):
        return "all lights are distant"
    return "no attenuation: a1 = a2 = 0"


def _channels(channels: int, weighted: int | None) -> str:
    if weighted is None:
        return f"{channels} channel{'' if channels == 1 else 's'}"
    return f"one channel, the weighted sum of {weighted}"


def _lights(shown: int, given: int) -> str:
    if not given:
        return "no light"
    text = "one light" if given == 1 else f"{given} lights"
    return text if shown == given else f"{text}, of which {given - shown} show on no material"
