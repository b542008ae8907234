"""The kernels of the rasteriser and of the shading passes, compiled and as plain Python."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from halftone._jit import kernels
from halftone.scene import fast, render, shadow, shapes  # noqa: F401 - registers all kernels
from halftone.scene.model import Camera, Light, Material, Mesh, Scene

FLOOR = shapes.plane(4.0, 4.0)
PAINT = (
    Material(specular=(0.5,) * 3, exponent=12),
    Material(diffuse=(0.9, 0.2, 0.1), transparency=0.5, rim=0.1),
    Material(diffuse=(0.1, 0.9, 0.3), two_sided=False),
)


def scenes() -> dict[str, Scene]:
    rng = np.random.default_rng(5)
    soup = Mesh(rng.normal(size=(40, 3)), rng.integers(0, 40, (70, 3)), rng.integers(0, 3, 70))
    torus = shapes.torus(14, 9)
    glassy = replace(torus, material=np.arange(len(torus.faces)) % 2)
    detail = replace(FLOOR, detail=np.array([-1, 0]))
    lights = (
        Light(position=(2, 3, 1), shadows=True, intensity=(0.7, 0.6, 0.5)),
        Light(kind="distant", direction=(-1, -2, -1)),
    )
    return {
        "soup": Scene((soup,), PAINT, lights, Camera((0, 0.2, 2.0))),
        "inside": Scene((soup,), PAINT, lights, Camera((0.1, 0.1, 0.1), (9, 1, 2))),
        "torus": Scene((detail, glassy), PAINT, lights, Camera((0, 2, 2.5)), reflection="phong"),
    }


def digests() -> dict[str, str]:
    found = {}
    for name, scene in scenes().items():
        for shading in ("flat", "gouraud", "phong", "fast-phong"):
            for options in ({}, {"samples": 2}):
                picture = render.render(scene, 23, 17, shading=shading, shadow_resolution=40, **options)
                key = f"{name} {shading} {options}"
                found[key] = hashlib.sha256(
                    picture.radiance.tobytes() + picture.ids.tobytes()
                ).hexdigest()
    return found


def test_plain_python_gives_the_same_bytes():
    code = (
        "import json; from tests.scene.test_render_kernels import digests; print(json.dumps(digests()))"
    )
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
    )
    assert json.loads(done.stdout) == digests()


@pytest.mark.parametrize(
    "kernel",
    [k for k in kernels() if k.python.__module__.startswith("halftone.scene.")],
    ids=lambda k: k.__name__,
)
def test_every_kernel_becomes_object_code(kernel):
    assert kernel.compile()[1] is not None
