"""W(θ), the share of light that a surface reflects specularly, by the angle of incidence θ.

Fresnel 1823 for dielectrics (average of both polarisations) and conductors; Schlick 1994; tables.
All in float64 over c = cos θ within 0 … 1; the kernels interpolate a float32 table of it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from halftone.scene.model import Fresnel

__all__ = ["STEPS", "conductor", "dielectric", "nodes", "schlick", "share", "tabulated"]

Cosines = NDArray[np.float64]

STEPS = 4096
"""Steps of a table, as the kernel :func:`reflect` has them."""


def dielectric(cosine: Cosines, n: float) -> Cosines:
    """½(r_s² + r_p²) of light that meets a medium of relative index *n*; total reflection is 1."""
    c = _limited(cosine)
    g = np.sqrt(np.maximum(n * n - 1 + c * c, 0.0))  # n·cos θt; 0 at and beyond the critical angle
    with np.errstate(invalid="ignore", divide="ignore"):
        s = (c - g) / (c + g)
        p = (n * n * c - g) / (n * n * c + g)
    whole = 0.5 * (s * s + p * p)
    return np.where((g == 0) | (c == 0), 1.0 if n != 1 else 0.0, whole)


def conductor(cosine: Cosines, n: float, k: float) -> Cosines:
    """½(r_s² + r_p²) of a metal of index *n* and extinction *k*, met from vacuum."""
    c = _limited(cosine)
    if k == 0:
        return dielectric(c, n)
    cc, ss = c * c, 1 - c * c
    t = n * n - k * k - ss
    both = np.sqrt(t * t + (2 * n * k) ** 2)  # a² + b² of the complex cosine's a + ib
    a = np.sqrt(np.maximum((both + t) / 2, 0.0))
    s = (both + cc - 2 * a * c) / (both + cc + 2 * a * c)
    p = (both * cc + ss * ss - 2 * a * c * ss) / (both * cc + ss * ss + 2 * a * c * ss)
    return 0.5 * (s + s * p)


def schlick(cosine: Cosines, f0: float) -> Cosines:
    """F0 + (1 − F0)(1 − c)⁵."""
    return f0 + (1 - f0) * (1 - _limited(cosine)) ** 5


def tabulated(cosine: Cosines, angles: Sequence[float], shares: Sequence[float]) -> Cosines:
    """*shares* at ascending *angles* in degrees, constant beyond the first and the last.

    Linear in the cosine between them, as W itself is level at upright light.
    """
    at = np.cos(np.radians(np.asarray(angles, np.float64)))
    return np.interp(-_limited(cosine), -at, shares)


def share(fresnel: Fresnel, cosine: Cosines) -> Cosines:
    """W of *fresnel*, within 0 … 1."""
    if fresnel.kind == "dielectric":
        found = dielectric(cosine, fresnel.n)
    elif fresnel.kind == "conductor":
        found = conductor(cosine, fresnel.n, fresnel.k)
    elif fresnel.kind == "schlick":
        found = schlick(cosine, fresnel.f0)
    else:
        found = tabulated(cosine, fresnel.angles, fresnel.shares)
    return np.clip(found, 0.0, 1.0)


def nodes(fresnel: Fresnel | None) -> NDArray[np.float32]:
    """The table that the kernel interpolates: W where 9c/(8c + 1) = i/STEPS; ones for None.

    Interpolated in float32 it is off by at most 4e-7 for indices from 1.01 on, metals with
    |n + ik| ≥ 1, and Schlick (tests/scene/test_fresnel.py). Below 1 there is a critical angle, where
    W rises to 1 with an infinite slope: within one step of it, 0.0022 of the cosine, the table is off
    by as much as W changes there.
    """
    if fresnel is None:
        return np.ones(STEPS + 1, np.float32)
    u = np.arange(STEPS + 1) / STEPS
    return share(fresnel, u / (9 - 8 * u)).astype(np.float32)


def _limited(cosine: Cosines) -> Cosines:
    return np.clip(np.asarray(cosine, np.float64), 0.0, 1.0)
