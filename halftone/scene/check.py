"""Are the numbers of a scene such that they can be shown? Meshes are mended by sanitise instead."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NoReturn

import numpy as np

from halftone.errors import InputError, near
from halftone.scene.model import Camera, Fresnel, Light, Material, Scene

__all__ = ["checked"]

LIGHTS = ("point", "distant", "spot", "warn")
FRESNELS = ("dielectric", "conductor", "schlick", "table")
PROJECTIONS = ("perspective", "parallel")
REFLECTIONS = ("phong", "blinn")
NORMALS = ("uniform", "angle", "area")
OVERFLOWS = ("none", "clamp", "divide", "scale")

PARALLEL = 1e-9  # sine of the angle between view and up below which up says nothing


def checked(scene: Scene) -> int:
    """The number of colour channels of *scene*; InputError names the first number that is wrong."""
    channels = len(_tuple(scene.ambient, "ambient"))
    _colour(scene.ambient, "ambient", channels)
    _colour(scene.background, "background", channels)
    _name(scene.reflection, REFLECTIONS, "reflection")
    _name(scene.normals, NORMALS, "normals")
    _name(scene.overflow, OVERFLOWS, "overflow")
    for i, material in enumerate(scene.materials):
        _material(material, f"materials[{i}] '{material.name}': ", channels)
    for i, light in enumerate(scene.lights):
        _light(light, f"lights[{i}]: ", channels)
    if scene.camera is not None:
        _camera(scene.camera)
    return channels


def _material(material: Material, at: str, channels: int) -> None:
    _colour(material.ambient, f"{at}ambient", channels)
    _colour(material.diffuse, f"{at}diffuse", channels)
    _colour(material.specular, f"{at}specular", channels)
    if not _real(material.exponent) >= 0:
        _refuse(f"{at}exponent", material.exponent, "0 … infinity")
    _share(material.transparency, f"{at}transparency")
    if material.rim is not None:
        _share(material.rim, f"{at}rim")
    _positive(material.rim_exponent, f"{at}rim_exponent")
    if material.fresnel is not None:
        _fresnel(material.fresnel, f"{at}fresnel.")


def _fresnel(fresnel: Fresnel, at: str) -> None:
    _name(fresnel.kind, FRESNELS, f"{at}kind")
    _positive(fresnel.n, f"{at}n")
    _not_negative(fresnel.k, f"{at}k")
    _share(fresnel.f0, f"{at}f0")
    if fresnel.kind != "table":
        return
    angles, shares = _tuple(fresnel.angles, f"{at}angles"), _tuple(fresnel.shares, f"{at}shares")
    if len(angles) != len(shares) or not angles:
        raise InputError(
            f"{at}angles has {len(angles)} numbers and {at}shares {len(shares)}; "
            "allowed: as many of both, at least one. Give one share for each angle"
        )
    for share in shares:
        _share(share, f"{at}shares")
    rising = all(a < b for a, b in pairwise(angles))
    if not rising or not all(0 <= _real(a) <= 90 for a in angles):
        _refuse(f"{at}angles", angles, "0 … 90 degrees, each larger than the one before")


def _light(light: Light, at: str, channels: int) -> None:
    _name(light.kind, LIGHTS, f"{at}kind")
    _colour(light.intensity, f"{at}intensity", channels)
    _vector(light.position, f"{at}position")
    direction = _vector(light.direction, f"{at}direction")
    if light.kind != "point" and not any(direction):
        _refuse(f"{at}direction", light.direction, "any but the zero vector, which points nowhere")
    for value in _vector(light.attenuation, f"{at}attenuation"):
        _not_negative(value, f"{at}attenuation")
    if not 0 < _real(light.cutoff) <= 90:
        _refuse(f"{at}cutoff", light.cutoff, "above 0 and at most 90 degrees")
    if light.inner is not None and not 0 <= _real(light.inner) <= light.cutoff:
        _refuse(f"{at}inner", light.inner, f"0 … the cutoff, {light.cutoff} degrees")
    if not _real(light.exponent) >= 0:
        _refuse(f"{at}exponent", light.exponent, "0 … infinity")
    flaps = _tuple(light.flaps, f"{at}flaps")
    if len(flaps) != 3:
        _refuse(f"{at}flaps", flaps, "three pairs, [low, high] for x, y and z")
    for axis, pair in zip("xyz", flaps, strict=True):
        flap = _tuple(pair, f"{at}flaps")
        if len(flap) != 2 or not _real(flap[0]) <= _real(flap[1]):
            _refuse(f"{at}flaps", flap, f"[low, high] with low ≤ high for {axis}; ±inf for no flap")


def _camera(camera: Camera) -> None:
    eye, target = _vector(camera.eye, "camera.eye"), _vector(camera.target, "camera.target")
    up = _vector(camera.up, "camera.up")
    _name(camera.projection, PROJECTIONS, "camera.projection")
    if not 0 < _real(camera.fov) < 180:
        _refuse("camera.fov", camera.fov, "above 0 and below 180 degrees")
    _positive(camera.height, "camera.height")
    if camera.near is not None:
        _positive(camera.near, "camera.near")
    view = _unit(np.array(target) / 2 - np.array(eye) / 2)
    if not view.any():
        raise InputError(
            f"camera.eye and camera.target are both {eye}; allowed: two points. "
            "Move the eye away from what it looks at"
        )
    if not np.linalg.norm(np.cross(view, _unit(np.array(up)))) > PARALLEL:
        raise InputError(
            f"camera.up={up} is parallel to the view from {eye} to {target}, or zero; allowed: any "
            "other direction. For a view straight down give up = [0, 0, -1]"
        )


def _unit(vector: Any) -> Any:
    """*vector* of length 1, at any scale; a zero vector stays."""
    most = np.abs(vector).max()
    if most == 0:
        return vector
    vector = vector / most
    return vector / np.linalg.norm(vector)


def _name(value: Any, allowed: Sequence[str], place: str) -> None:
    if value not in allowed:
        raise InputError(near(str(value), allowed, place))


def _colour(value: Any, place: str, channels: int) -> None:
    colour = _tuple(value, place)
    if len(colour) != channels or not colour:
        raise InputError(
            f"{place}={colour} has {len(colour)} channels; allowed: {channels}, as many as the "
            "scene's ambient has. Give all colours of a scene the same number of channels"
        )
    for part in colour:
        _not_negative(part, place)


def _vector(value: Any, place: str) -> tuple[float, ...]:
    vector = _tuple(value, place)
    if len(vector) != 3 or not all(math.isfinite(_real(v)) for v in vector):
        _refuse(place, vector, "three finite numbers, [x, y, z]")
    return vector


def _share(value: Any, place: str) -> None:
    if not 0 <= _real(value) <= 1:
        _refuse(place, value, "0 … 1")


def _positive(value: Any, place: str) -> None:
    if not 0 < _real(value) < math.inf:
        _refuse(place, value, "a finite number above 0")


def _not_negative(value: Any, place: str) -> None:
    if not 0 <= _real(value) < math.inf:
        _refuse(place, value, "finite numbers, 0 or more")


def _tuple(value: Any, place: str) -> tuple[Any, ...]:
    try:
        return tuple(value)
    except TypeError:
        _refuse(place, value, "a list of numbers")


def _real(value: Any) -> float:
    """*value* as a number; anything else as NaN, which no range allows."""
    if isinstance(value, bool):
        return math.nan
    try:
        return float(value) if not isinstance(value, str) else math.nan
    except (TypeError, ValueError, OverflowError):
        return math.nan


def _refuse(place: str, value: Any, allowed: str) -> NoReturn:
    raise InputError(f"{place}={value!r}; allowed: {allowed}")
