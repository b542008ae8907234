"""What a scene is: meshes, materials, lights and a camera, as plain data.

Colours have C channels, the same C for all of a scene: 3 for R, G, B, 1 for gray, or any other number.
Light is linear; lengths are in the scene's own units, angles in degrees.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

__all__ = ["Camera", "Colour", "Flap", "Fresnel", "Light", "Material", "Mesh", "Scene"]

Colour = tuple[float, ...]
Vector = tuple[float, float, float]
Flap = tuple[float, float]

BLACK = (0.0, 0.0, 0.0)
WHITE = (1.0, 1.0, 1.0)
UNLIMITED: Flap = (-np.inf, np.inf)


@dataclass(frozen=True)
class Fresnel:
    """W(θ): the share of light that a surface reflects specularly at the angle of incidence θ.

    kind : ``dielectric`` (index n), ``conductor`` (index n, extinction k), ``schlick`` (f0), or
    ``table`` (angles in degrees, ascending, and the share at each).
    """

    kind: str = "dielectric"
    n: float = 1.5
    k: float = 0.0
    f0: float = 0.04
    angles: tuple[float, ...] = ()
    shares: tuple[float, ...] = ()


@dataclass(frozen=True)
class Material:
    """How a surface reflects: k_a, k_d, k_s, n_s and k_t of the books.

    exponent : n_s, 0 … infinity. transparency : k_t, 0 (opaque) … 1; where *rim* is given, it rises
    from *transparency* at the middle to ``rim`` at grazing view as 1 − (1 − |N_z|)^rim_exponent falls.
    fresnel : multiplies k_s by W(θ), or None. two_sided : whether back faces are lit as fronts.
    """

    name: str = "default"
    ambient: Colour = (0.1, 0.1, 0.1)
    diffuse: Colour = (0.8, 0.8, 0.8)
    specular: Colour = BLACK
    exponent: float = 10.0
    transparency: float = 0.0
    rim: float | None = None
    rim_exponent: float = 1.0
    fresnel: Fresnel | None = None
    two_sided: bool = True


@dataclass(frozen=True)
class Light:
    """A light source.

    kind : ``point``, ``distant`` (from *direction*, towards the scene), ``spot`` (a cone about
    *direction* of half-angle *cutoff*, fading from *inner* on) or ``warn`` (intensity · cos^exponent γ
    about *direction*, with flaps). attenuation : a0, a1, a2 of min(1, 1/(a0 + a1·d + a2·d²)), which a
    distant light has not. flaps : on x, y and z of the surface points that are lit.
    """

    kind: str = "point"
    intensity: Colour = WHITE
    position: Vector = (0.0, 0.0, 0.0)
    direction: Vector = (0.0, 0.0, -1.0)
    attenuation: Vector = (1.0, 0.0, 0.0)
    cutoff: float = 90.0
    inner: float | None = None
    exponent: float = 0.0
    flaps: tuple[Flap, Flap, Flap] = (UNLIMITED, UNLIMITED, UNLIMITED)
    shadows: bool = False


@dataclass(frozen=True)
class Camera:
    """Where the scene is seen from.

    projection : ``perspective`` with *fov* degrees from top to bottom, or ``parallel`` with *height*
    scene units from top to bottom. near : the distance of the near plane, or None for a small share
    of the distance to the target.
    """

    eye: Vector = (0.0, 0.0, 5.0)
    target: Vector = (0.0, 0.0, 0.0)
    up: Vector = (0.0, 1.0, 0.0)
    projection: str = "perspective"
    fov: float = 40.0
    height: float = 2.0
    near: float | None = None


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles.

    vertices : float64 (V, 3). faces : int64 (F, 3), counter-clockwise seen from the front.
    normals : float64 (K, 3) or None, and normal_index : int64 (F, 3) into them, −1 where a corner has
    none. material : int64 (F,) into the scene's materials. detail : int64 (F,), the face that a
    surface-detail polygon lies on, which it covers where both are seen, or −1; None for no details.
    smooth : bool (F,) or None: faces whose corners share averaged normals (None: all).
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    material: NDArray[np.int64]
    normals: NDArray[np.float64] | None = None
    normal_index: NDArray[np.int64] | None = None
    detail: NDArray[np.int64] | None = None
    smooth: NDArray[np.bool_] | None = None
    name: str = "mesh"


@dataclass(frozen=True, eq=False)
class Scene:
    """Everything that :func:`halftone.render` needs.

    ambient : I_a. background : radiance where no surface is. reflection : ``phong`` (V·R) or ``blinn``
    (N·H). normals : how vertex normals are averaged, ``uniform``, ``angle`` or ``area``. overflow :
    how intensities beyond 1 are brought into range, ``none`` (left to the display stage), ``clamp``
    (each term), ``divide`` (terms by the largest) or ``scale`` (the range of the whole picture).
    """

    meshes: Sequence[Mesh] = ()
    materials: Sequence[Material] = field(default_factory=lambda: (Material(),))
    lights: Sequence[Light] = ()
    camera: Camera | None = None
    ambient: Colour = (1.0, 1.0, 1.0)
    background: Colour = BLACK
    reflection: str = "blinn"
    normals: str = "angle"
    overflow: str = "none"
    name: str = "scene"
