"""Materials, lights and random surface samples for the tests of illumination."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import strategies as st

from halftone.scene.model import Light, Material

SEEDS = st.integers(0, 2**32 - 1)
UP = (0.0, 0.0, 1.0)
MATT = Material(ambient=(0.1, 0.2, 0.3), diffuse=(0.7, 0.5, 0.25))
SHINY = replace(MATT, specular=(0.6, 0.4, 0.2), exponent=20.0)
SUN = Light("distant", direction=(-1.0, -2.0, -3.0))
LAMP = Light(position=(1.0, 2.0, 4.0), intensity=(0.9, 0.8, 0.7))


def samples(seed, count=200):
    """Positions and unit normals, float32 (3, count), and numbers below 3, int32."""
    random = np.random.default_rng(seed)
    normal = random.normal(size=(3, count))
    normal /= np.sqrt((normal**2).sum(0))
    material = random.integers(0, 3, count).astype(np.int32)
    return random.normal(size=(3, count)).astype(np.float32), normal.astype(np.float32), material


def shade(made, position, normal, material=None, lit=None):
    position = np.ascontiguousarray(position, np.float32)
    normal = np.ascontiguousarray(normal, np.float32)
    count = normal.shape[1]
    out = np.full((made.channels, count), np.nan, np.float32)
    material = np.zeros(count, np.int32) if material is None else material
    made.shade(position, normal, material, out, lit)
    assert np.isfinite(out).all()
    return out


def one(lit, position=(0, 0, 0), normal=UP):
    return shade(lit, np.array([position]).T, np.array([normal]).T)[:, 0]
