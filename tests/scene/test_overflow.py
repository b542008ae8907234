"""Intensities beyond 1: each rule, and that none of them changes what fits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halftone.scene import overflow
from halftone.scene.illumination import Illumination
from halftone.scene.model import Light, Material
from tests.scene.test_illumination import LAMP, SHINY, SUN, samples, shade

LIGHTS = [Light("distant", intensity=(6.0, 1.5, 0.5)), LAMP]


def by(rule, materials=(SHINY,), lights=LIGHTS, seed=0):
    position, normal, material = samples(seed)
    lit = Illumination(list(materials), lights, overflow=rule, eye=(0, 0, 6))
    return shade(lit, position, normal, material % len(materials))


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_nothing_changes_where_nothing_overflows(seed):
    dim = [
        Light("distant", intensity=(0.2, 0.3, 0.4)),
        Light(position=(1, 2, 3), intensity=(0.3, 0.1, 0.2)),
    ]
    plain = by("none", lights=dim, seed=seed)
    assert plain.max() < 1
    for rule in ("clamp", "divide", "scale"):
        np.testing.assert_array_equal(by(rule, lights=dim, seed=seed), plain)
    np.testing.assert_array_equal(overflow.scaled(plain, overflow.extent([plain])), plain)


def terms(seed=0):
    """The terms of every sample, (5, C, K): ambient, and diffuse and specular of both lights."""
    dark = Material(ambient=(0.0,) * 3, diffuse=(0.0,) * 3, specular=(0.0,) * 3, exponent=SHINY.exponent)
    parts = [by("none", [Material(SHINY.name, SHINY.ambient, (0.0,) * 3, (0.0,) * 3)], LIGHTS, seed)]
    for light in LIGHTS:
        for key in ("diffuse", "specular"):
            only = Material(**{**vars(dark), key: getattr(SHINY, key)})
            parts.append(by("none", [only], [light], seed))
    return np.array(parts, np.float64)


def test_clamp_limits_each_term_and_their_sum():
    each = terms()
    assert (each > 1).any()
    clamped = by("clamp")
    np.testing.assert_allclose(clamped, np.minimum(1, np.minimum(1, each).sum(axis=0)), atol=1e-6)
    assert clamped.max() == 1


def test_divide_brings_the_largest_term_to_1_and_keeps_the_ratios():
    each = terms()
    largest = np.maximum(1, each.max(axis=(0, 1)))
    divided = by("divide")
    np.testing.assert_allclose(divided, each.sum(axis=0) / largest, rtol=2e-6)
    assert (largest > 1).any()
    assert (each / largest).max() == pytest.approx(1)
    plain = by("none")
    np.testing.assert_allclose(divided[0] * plain[1], divided[1] * plain[0], rtol=1e-5)  # hues stay


def test_rules_know_the_materials():
    materials = [
        SHINY,
        Material(diffuse=(0.1,) * 3),
        Material(diffuse=(1.0, 0.2, 0.0), specular=(1.0,) * 3),
    ]
    position, normal, material = samples(3)
    for rule in ("clamp", "divide"):
        mixed = shade(
            Illumination(materials, LIGHTS, overflow=rule, eye=(0, 0, 6)), position, normal, material
        )
        for i, one in enumerate(materials):
            lit = Illumination([one], LIGHTS, overflow=rule, eye=(0, 0, 6))
            alone = shade(lit, position, normal)
            np.testing.assert_array_equal(mixed[:, material == i], alone[:, material == i])


def test_scale_maps_the_extent_of_the_scene_to_0_and_1():
    light = by("none", lights=[*LIGHTS, SUN])
    parts = [light[:, :50], light[:, 50:]]
    of = overflow.extent(parts)
    assert of == (float(light.min()), float(light.max()))
    scaled = overflow.scaled(light, of)
    assert scaled.dtype == np.float32
    assert (scaled.min(), scaled.max()) == (0, 1)
    order = np.argsort(light.ravel(), kind="stable")
    assert (np.diff(scaled.ravel()[order]) >= 0).all()
    np.testing.assert_array_equal(
        np.concatenate([overflow.scaled(p, of) for p in parts], axis=1), scaled
    )
    np.testing.assert_array_equal(overflow.scaled(scaled, overflow.extent([scaled])), scaled)


def test_scale_of_one_intensity_and_of_nothing():
    flat = np.full((3, 4), 2.5, np.float32)
    np.testing.assert_array_equal(overflow.scaled(flat, overflow.extent([flat])), 1)
    assert overflow.extent([]) == (0.0, 0.0)
    assert overflow.extent([np.empty((3, 0), np.float32)]) == (0.0, 0.0)
