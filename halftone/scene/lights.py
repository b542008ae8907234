"""Lights made ready for the kernels: homogeneous float32 places, and which stages each light needs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone.errors import InputError
from halftone.scene.model import Light

__all__ = ["Lamp", "canonical", "direction_to", "lamp", "place_of"]

Row = NDArray[np.float32]

NO_CONE = (-2.0, -2.0)
FAR = 2.0**16  # farther away, a place is scaled so that squares of distances stay within float32


@dataclass(frozen=True, eq=False)
class Lamp:
    """A light as the kernels want it.

    place : x, y, z, w, scale (see _light_kernels). axis : unit x, y, z, cosines of the outer and the
    inner half-angle of the cone, exponent about the axis. attenuation : a0, a1, a2. limits : (3, 2).
    The names after them tell which stages change anything.
    """

    place: Row
    axis: Row
    attenuation: Row
    limits: Row
    distant: bool
    attenuated: bool
    cone: bool
    lobe: bool
    flaps: bool
    shadows: bool


def lamp(light: Light, name: str = "light") -> Lamp:
    """*light* made ready; InputError for options that contradict its kind, or a0 = a1 = a2 = 0."""
    _check(light, name)
    distant = light.kind == "distant"
    place = direction_to(light.direction, -1) if distant else place_of(light.position)
    directed = light.kind in ("spot", "warn")
    axis = _unit(light.direction) if directed else np.zeros(3)
    # Warn's lights have a cone where their cutoff is narrowed; a spot always has one.
    cone = light.kind == "spot" or (light.kind == "warn" and light.cutoff < 90)
    outer, inner = NO_CONE
    if cone:
        outer = _cosine(light.cutoff)
        inner = outer if light.inner is None else _cosine(light.inner)
    exponent = light.exponent if directed else 0.0
    a0, a1, a2 = light.attenuation
    limits = np.array(light.flaps, np.float64)
    return Lamp(
        place,
        _row([*axis, outer, inner, exponent]),
        _row([a0, a1, a2]),
        _row(limits),
        distant,
        a1 > 0 or a2 > 0 or a0 > 1,
        cone,
        exponent > 0,
        bool(np.isfinite(limits).any()),
        light.shadows,
    )


def canonical(light: Light) -> tuple[Any, ...]:
    """A key that puts lights in one order, so that sums do not depend on how they were listed."""
    inner = light.cutoff if light.inner is None else light.inner
    return tuple(repr(_numbers(value)) for value in vars(replace(light, inner=inner)).values())


def place_of(point: Any) -> Row:
    """x, y, z, w, scale of a point."""
    far = float(np.abs(np.asarray(point, np.float64)).max())
    scale = 2.0 ** np.floor(np.log2(far)) if far > FAR else 1.0
    x, y, z = (float(v) / scale for v in point)
    return _row([x, y, z, 1 / scale, scale])


def direction_to(direction: Any, sign: int = 1) -> Row:
    """x, y, z, w = 0, scale of a place at infinity towards *sign* · *direction*."""
    return _row([*(sign * _unit(direction)), 0.0, 1.0])


def _check(light: Light, name: str) -> None:
    plain = Light()
    if not any(light.attenuation):
        raise InputError(
            f"{name}: attenuation={light.attenuation}; allowed: a0, a1, a2 ≥ 0, not all of them 0. "
            "Give (1, 0, 0) for a light that does not fade with distance"
        )
    unfit = []
    if light.kind == "distant" and tuple(light.attenuation) != plain.attenuation:
        unfit.append("attenuation")
    if light.kind in ("point", "distant"):
        cone = ("cutoff", "inner", "exponent")
        unfit += [key for key in cone if getattr(light, key) != getattr(plain, key)]
    if unfit:
        raise InputError(
            f"{name}: a {light.kind} light has no {' and no '.join(unfit)}. "
            "Leave it out, or choose another kind (point has attenuation; spot and warn have all)"
        )


def _unit(vector: Any) -> NDArray[np.float64]:
    v = np.asarray(vector, np.float64)
    v = v / np.abs(v).max()
    unit: NDArray[np.float64] = v / np.sqrt((v * v).sum())
    return unit


def _cosine(degrees: float) -> float:
    return float(np.cos(np.radians(degrees))) if degrees != 90 else 0.0


def _row(values: Any) -> Row:
    """float32, with ±3.4e38 for what is beyond, so that infinity times 0 cannot arise."""
    row = np.clip(np.asarray(values, np.float64), -3.4e38, 3.4e38)
    return row.astype(np.float32)


def _numbers(value: Any) -> Any:
    if isinstance(value, tuple | list):
        return tuple(_numbers(v) for v in value)
    return float(value) if not isinstance(value, str | bool) else value
