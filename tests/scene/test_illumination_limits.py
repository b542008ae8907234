"""Illumination of what is no number, what is refused, parts and threads, and given cosines."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from halftone.errors import InputError
from halftone.scene import illumination
from halftone.scene.illumination import Illumination
from halftone.scene.model import Fresnel, Light, Material
from tests.scene.samples import LAMP, MATT, SHINY, SUN, UP, one, samples, shade


def test_samples_that_are_no_numbers_show_ambient_light():
    lit = Illumination([SHINY], [LAMP, SUN, Light("spot", position=(0, 0, 2))], eye=(0, 0, 6))
    for value in (np.nan, np.inf, -np.inf):
        np.testing.assert_array_equal(
            one(lit, position=(0, value, 0), normal=(np.nan, 0, 1)), np.float32(MATT.ambient)
        )
        assert (one(lit, position=(value, 0, 0)) >= np.float32(MATT.ambient)).all()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (([],), "no material"),
        (([Material(diffuse=(0.1, -0.1, 0.1))],), "diffuse.*0 or more"),
        (([Material(specular=(math.nan, 0, 0))],), "specular"),
        (([Material(ambient=(math.inf, 0, 0))],), "ambient"),
        (([Material(exponent=-1.0)],), "exponent"),
        (([Material(exponent=math.nan)],), "exponent"),
        (([Material(transparency=1.5)],), "transparency"),
        (([Material(fresnel=Fresnel(n=0.0))],), "fresnel.n"),
        (([Material(fresnel=Fresnel("table", angles=(9, 5), shares=(0, 1)))],), "angles"),
        (([Material(diffuse=(0.5,))],), "channels"),
        (([Material()], [], (-1, 0, 0)), "ambient"),
    ],
)
def test_what_is_refused(arguments, words):
    with pytest.raises(InputError, match=words):
        Illumination(*arguments)


def test_names_numbers_and_shapes_that_do_not_fit():
    with pytest.raises(InputError, match="phong"):
        Illumination([MATT], reflection="fong")
    with pytest.raises(InputError, match="one of them"):
        Illumination([MATT], eye=(0, 0, 1), view=UP)
    position, normal, material = samples(0)
    with pytest.raises(InputError, match="material numbers"):
        shade(Illumination([MATT, SHINY]), position, normal, material + 1)
    with pytest.raises(InputError, match="material numbers"):
        shade(Illumination([MATT, SHINY]), position, normal, material - 3)
    lit, material, out = Illumination([SHINY], [SUN]), material * 0, np.empty((3, 200), np.float32)
    with pytest.raises(InputError, match=r"out has shape \(2, 200\); allowed: \(3, 200\)"):
        lit.shade(position, normal, material, out[:2])
    with pytest.raises(InputError, match="position has shape"):
        lit.shade(position[:, 1:], normal, material, out)
    with pytest.raises(InputError, match="normal has shape"):
        lit.shade(position, normal[:2], material, out)
    with pytest.raises(InputError, match=r"lit has shape \(2, 200\); allowed: \(1, 200\)"):
        lit.shade(position, normal, material, out, np.ones((2, 200), np.uint8))
    with pytest.raises(InputError, match="incidence has shape"):
        lit.shade_cosines(position, position[:1], material, out)
    with pytest.raises(InputError, match="no highlight"):
        lit.shade_cosines(position[:1], None, material, out)


# Whole rows and parts of them ----------------------------------------------------------------------


def test_parts_threads_and_empty_rows_give_the_same_bits(monkeypatch):
    position, normal, material = samples(15, 1000)
    lit = Illumination([MATT, SHINY, replace(SHINY, exponent=3.0)], [LAMP, SUN], eye=(0, 0, 6))
    whole = shade(lit, position, normal, material)
    cuts = [(0, 1), (1, 130), (130, 999), (999, 1000)]

    def part(cut):
        return shade(lit, position[:, slice(*cut)], normal[:, slice(*cut)], material[slice(*cut)].copy())

    with ThreadPoolExecutor(2) as pool:
        np.testing.assert_array_equal(np.concatenate(list(pool.map(part, cuts)), axis=1), whole)
    monkeypatch.setattr(illumination, "CHUNK", 128)
    np.testing.assert_array_equal(shade(lit, position, normal, material), whole)
    assert part((0, 0)).shape == (3, 0)


def test_known_cosines_give_what_shade_gives():
    position, normal, _ = samples(16)
    lights = [SUN, replace(SUN, direction=(1.0, 0.0, -1.0)), LAMP]
    lit = Illumination([SHINY], lights[:2], view=UP)
    incidence, highlight = (np.empty((2, 200), np.float32) for _ in range(2))
    for i in range(2):
        toward, half = lit.constant(i)
        incidence[i], highlight[i] = toward @ normal, half @ normal
    out = np.empty((3, 200), np.float32)
    lit.shade_cosines(incidence, highlight, np.zeros(200, np.int32), out)
    np.testing.assert_allclose(out, shade(lit, position, normal), atol=4e-6)
    assert Illumination([SHINY], lights, eye=(0, 0, 9)).constant(2) == (None, None)


def test_known_cosines_are_limited_and_may_need_positions():
    lit = Illumination([SHINY], [SUN])
    out = np.empty((3, 4), np.float32)
    cosines = np.array([[np.nan, -1.0, 2.0, 1.0]], np.float32)
    lit.shade_cosines(cosines, cosines, np.zeros(4, np.int32), out)
    ambient, whole = (
        np.float32(SHINY.ambient),
        np.add(np.add(SHINY.ambient, SHINY.diffuse), SHINY.specular),
    )
    np.testing.assert_array_equal(out[:, :2], np.stack([ambient, ambient], axis=1))
    np.testing.assert_allclose(out[:, 2:], np.stack([whole, whole], axis=1), rtol=1e-6)
    fading = Illumination([SHINY], [replace(LAMP, attenuation=(1, 0, 1))])
    assert fading.needs_position
    assert not lit.needs_position
    with pytest.raises(InputError, match="no position"):
        fading.shade_cosines(cosines, cosines, np.zeros(4, np.int32), out)
    fading.shade_cosines(
        cosines, cosines, np.zeros(4, np.int32), out, position=np.zeros((3, 4), np.float32)
    )
    light = np.multiply(LAMP.intensity, np.add(SHINY.diffuse, SHINY.specular)) / (1 + 21)
    np.testing.assert_allclose(out[:, 3], SHINY.ambient + light, rtol=1e-6)


# The plan ------------------------------------------------------------------------------------------
