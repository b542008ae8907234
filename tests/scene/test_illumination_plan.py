"""What illumination leaves out: why, that it is not compiled, and that it changes nothing."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halftone.scene.illumination import Illumination
from halftone.scene.model import Fresnel, Light
from tests.scene.samples import LAMP, MATT, SEEDS, SHINY, SUN, samples, shade


def stages(*arguments, **options):
    return {s.name: (s.used, s.reason) for s in Illumination(*arguments, **options).stages()}


def test_what_is_left_out_and_why():
    barest = stages([MATT], [SUN])
    assert barest["specular"] == (False, "no specular coefficient")
    assert barest["attenuation"] == (False, "all lights are distant")
    assert barest["lights"] == (True, "one light")
    assert barest["shadows"] == (False, "no light casts shadows")
    assert stages([MATT], [LAMP])["attenuation"] == (False, "no attenuation: a1 = a2 = 0")
    assert stages([MATT])["diffuse"] == (False, "no light")
    assert stages([SHINY], [SUN])["halfway vector of each sample"] == (
        False,
        "light and viewer at infinity: H is the same everywhere",
    )
    assert stages([SHINY], [SUN], eye=(0, 0, 1))["halfway vector of each sample"][0]
    assert stages([replace(SHINY, fresnel=Fresnel())], [SUN])["fresnel"] == (True, "1 of 1 material")
    matt_glass = stages([replace(MATT, fresnel=Fresnel()), SHINY], [SUN])
    assert matt_glass["fresnel"] == (False, "no material that shines has a Fresnel share")
    assert stages([MATT], [SUN, replace(SUN, intensity=(0,) * 3)])["lights"] == (
        True,
        "2 lights, of which 1 show on no material",
    )
    forced = stages([MATT], [SUN], force_all=True)
    assert forced["cone"] == (True, "forced (no spotlight)")
    assert not forced["shadows"][0]


MATERIALS = [MATT, SHINY, replace(SHINY, fresnel=Fresnel()), replace(MATT, exponent=math.inf)]
LIGHTS = [
    LAMP,
    SUN,
    replace(LAMP, attenuation=(0.2, 0.1, 0.3)),
    Light("spot", position=(0.0, 0.0, 3.0), cutoff=35.0, inner=20.0),
    Light("warn", position=(0.0, 1.0, 3.0), exponent=4.0, flaps=((-1.0, 1.0), (-9.0, 0.5), (-9.0, 9.0))),
    replace(SUN, intensity=(0.0, 0.0, 0.0)),
    replace(LAMP, shadows=True),
]


@given(
    seed=SEEDS,
    materials=st.lists(st.sampled_from(MATERIALS), min_size=1, max_size=3),
    lights=st.lists(st.sampled_from(LIGHTS), max_size=3),
    reflection=st.sampled_from(["blinn", "phong"]),
    overflow=st.sampled_from(["none", "clamp", "divide"]),
    seen=st.sampled_from([{"eye": (0.0, 0.0, 6.0)}, {"view": (0.0, 1.0, 2.0)}]),
)
@settings(max_examples=60, deadline=None)
def test_everything_forced_gives_the_same_bits(seed, materials, lights, reflection, overflow, seen):
    position, normal, material = samples(seed)
    material %= len(materials)
    options = {"reflection": reflection, "overflow": overflow} | seen
    lit = np.random.default_rng(seed).integers(0, 2, (len(lights), 200)).astype(np.uint8)
    plan, every = (
        shade(
            Illumination(materials, lights, force_all=force, **options), position, normal, material, lit
        )
        for force in (False, True)
    )
    np.testing.assert_array_equal(plan.view(np.int32), every.view(np.int32))


RUN = """
import numpy as np
from halftone._jit import kernels
from halftone.scene.illumination import Illumination
from halftone.scene.model import Light, Material
rows = np.ones((3, 8), np.float32)
made = Illumination([Material({material})], [Light({light})])
made.shade(rows, rows, np.zeros(8, np.int32), rows.copy())
print(*sorted(k.__name__ for k in kernels() if k.origin != "not loaded"))
"""


@pytest.mark.parametrize(
    ("material", "light", "used"),
    [
        ("", "intensity=(0, 0, 0)", ""),
        ("", "'distant'", "add facing"),
        ("", "", "add incidence"),
        ("specular=(1, 1, 1)", "", "add halfway incidence sharpen"),
        ("specular=(1, 1, 1)", "'distant'", "add facing sharpen"),
        ("", "attenuation=(1, 1, 1)", "add attenuate incidence"),
        ("", "'warn', exponent=2", "add incidence off_axis sharpen"),
    ],
)
def test_what_is_left_out_is_not_compiled(material, light, used):
    code = RUN.format(material=material, light=light)
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=dict(os.environ) | {"NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == used
