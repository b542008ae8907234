"""What the scene does not need is neither computed nor compiled, and the pixels are the same (§6)."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from halftone.scene import shapes
from halftone.scene.model import Camera, Fresnel, Light, Material, Scene
from halftone.scene.plan import Target
from halftone.scene.render import Renderer, plan, render

CAMERA = Camera((0, 2.0, 2.5))
BARE = Scene(
    (shapes.torus(24, 12),), (Material(),), (Light(kind="distant", direction=(-1, -2, -1.0)),), CAMERA
)
SHINY = (Material(specular=(0.4,) * 3, exponent=20, fresnel=Fresnel()),)
SCENES = {
    "bare": BARE,
    "dark": replace(BARE, lights=()),
    "empty": replace(BARE, meshes=()),
    "shiny": replace(
        BARE, materials=SHINY, lights=(Light(position=(2, 3, 4), attenuation=(1, 0.1, 0)),)
    ),
    "shadows": replace(BARE, lights=(Light(position=(2, 3, 1), shadows=True), *BARE.lights)),
    "glass": replace(BARE, materials=(Material(transparency=0.5, rim=0.1),)),
    "spot": replace(
        BARE, lights=(Light(kind="spot", position=(0, 4, 0), direction=(0, -1, 0), cutoff=25.0),)
    ),
    "scaled": replace(BARE, overflow="scale"),
}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("shading", ["flat", "gouraud", "phong", "fast-phong"])
def test_the_forced_full_plan_gives_the_same_bytes(name, shading):
    renderer = Renderer(SCENES[name])
    for options in ({}, {"samples": 2}, {"channels": 1}):
        lean = renderer.render(60, 45, shading=shading, **options)
        full = renderer.render(60, 45, shading=shading, shadow_resolution=64 if name == "bare" else 2048,
                               force_all=True, **options)  # fmt: skip
        assert lean.radiance.tobytes() == full.radiance.tobytes()
        assert lean.coverage.tobytes() == full.coverage.tobytes()


def test_the_plan_names_what_is_left_out_and_why():
    bare = plan(BARE, Target(60, 45, 1, "bilevel device: luminance only")).left_out
    assert bare["layers"] == "all materials are opaque"
    assert bare["shadow maps"] == "no light casts shadows"
    assert bare["channels"].startswith("bilevel device: luminance only")
    assert {"clipping", "detail polygons", "edge samples", "specular", "attenuation"} <= set(bare)
    assert "layers" not in plan(SCENES["glass"], Target(60, 45)).left_out
    assert "shadow maps" not in plan(SCENES["shadows"], Target(60, 45)).left_out
    assert "clipping" not in plan(replace(BARE, camera=Camera((1, 0, 0))), Target(60, 45)).left_out
    assert "edge samples" not in plan(BARE, Target(60, 45), samples=2).left_out
    assert not {"layers", "shadow maps", "specular"} & set(
        plan(BARE, Target(60, 45), force_all=True).left_out
    )


@pytest.mark.parametrize("name", ["bare", "shadows", "glass", "scaled"])
def test_the_plan_is_what_the_rendering_reports(name):
    picture = render(SCENES[name], 60, 45)
    assert str(picture.report["plan"]) == str(plan(SCENES[name], Target(60, 45)))


ASK = """
import json, sys
from halftone._jit import kernels
from tests.scene.test_plan import SCENES
from halftone.scene.render import render
picture = render(SCENES[sys.argv[1]], 60, 45, shading=sys.argv[2], force_all=sys.argv[3] == "True")
names = [k.__name__ for k in kernels() if ".scene." in k.python.__module__ and k.origin != "not loaded"]
print(json.dumps([names, sorted(m for m in sys.modules if m.startswith("halftone.scene."))]))
"""


def loaded(name: str, shading: str, force_all: bool = False) -> tuple[set[str], set[str]]:
    """Names of the kernels and modules that a rendering in a fresh process has loaded."""
    done = subprocess.run(
        [sys.executable, "-c", ASK, name, shading, str(force_all)],
        capture_output=True, text=True, check=True, env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
    )  # fmt: skip
    names, modules = json.loads(done.stdout)
    return set(names), set(modules)


def test_kernels_of_what_is_left_out_stay_uncompiled():
    bare, modules = loaded("bare", "phong")
    assert {"project", "cover", "gather_samples", "scatter", "add"} <= bare
    assert not {"ask_map", "blend", "expand", "forward", "paint_corners", "paint_faces", "mark"} & bare
    assert not {"blinn", "phong", "reflect", "attenuate", "cone", "lobe", "flaps"} & bare
    assert not {f"halftone.scene.{m}" for m in ("shadow", "fast", "clip")} & modules
    assert len(bare) <= 10
    full, _ = loaded("bare", "phong", force_all=True)
    assert {"ask_map", "attenuate", "cone", "flaps"} <= full
    assert "ask_map" in loaded("shadows", "flat")[0]
    assert "blend" in loaded("glass", "gouraud")[0]


def test_leaving_out_is_less_work(monkeypatch):
    """Counted in calls of kernels, which do not depend on the machine; tests/bench has the times."""
    from halftone._jit import Kernel

    calls: list[str] = []
    original = Kernel.__call__

    def counted(self, *arguments):
        calls.append(self.__name__)
        original(self, *arguments)

    monkeypatch.setattr(Kernel, "__call__", counted)
    renderer = Renderer(BARE)
    renderer.render(60, 45, shadow_resolution=64)
    lean = len(calls)
    calls.clear()
    renderer.render(60, 45, shadow_resolution=64, force_all=True)
    assert len(calls) > 1.5 * lean


def test_no_nan_leaves_the_renderer():
    rng = np.random.default_rng(0)
    for seed in range(5):
        mesh = shapes.icosphere(1)
        vertices = mesh.vertices.copy()
        vertices[rng.integers(0, len(vertices), 3)] = rng.choice(
            [np.nan, np.inf, -np.inf, 1e300, 0.0], (3, 3)
        )
        scene = replace(SCENES["shiny"], meshes=(replace(mesh, vertices=vertices),))
        for shading in ("flat", "gouraud", "phong", "fast-phong"):
            assert np.isfinite(render(scene, 30, 30, shading=shading).radiance).all(), seed
