"""Times of the scene renderer: ``python -m tests.bench.scene`` prints them as Markdown.

Tori of 64 × 32, 220 × 110 and 950 × 475 quads at 1024², in the four shadings, best and median of runs
in turns; with VTK beside them if it is installed and can draw without a screen (its Phong beside fast
Phong, which it has not; it hands over 8 bits, ours is float32). Then the barest scene by its plan and
by the forced full plan, whose pixels are compared, and the first picture of a process.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from halftone.scene import shapes
from halftone.scene.model import Camera, Light, Material, Mesh, Scene
from halftone.scene.render import Renderer
from halftone.scene.shade import SHADINGS
from tests.bench.timing import best_and_median, compare, process

SIDE = 1024
SIZES = ((64, 32), (220, 110), (950, 475))
EYE = (0.0, 2.65, 2.65)
FIRST = (
    "from tests.bench.scene import torus_scene; from halftone.scene.render import render;"
    "render(torus_scene(220, 110), 1024, 1024)"
)


def torus_scene(u: int, v: int) -> Scene:
    """A shiny torus under one distant light, that covers about 60 % of the picture."""
    material = Material(diffuse=(0.6, 0.5, 0.4), specular=(0.4, 0.4, 0.4), exponent=30)
    light = Light(kind="distant", direction=(-0.3, -1, -0.5))
    return Scene((shapes.torus(u, v),), (material,), (light,), Camera(EYE))


def vtk_frame(mesh: Mesh, shading: str) -> Callable[[], object] | None:
    """A call that draws *mesh* anew with VTK and reads the pixels; None where VTK cannot be used."""
    try:
        import vtk
        from vtk.util import numpy_support
    except ImportError:
        return None
    points, cells = vtk.vtkPoints(), vtk.vtkCellArray()
    points.SetData(numpy_support.numpy_to_vtk(mesh.vertices, deep=True))
    flat = np.column_stack([np.full(len(mesh.faces), 3), mesh.faces]).astype(np.int64).ravel()
    cells.ImportLegacyFormat(numpy_support.numpy_to_vtkIdTypeArray(flat, deep=True))
    data = vtk.vtkPolyData()
    data.SetPoints(points)
    data.SetPolys(cells)
    normals = vtk.vtkPolyDataNormals()
    normals.SetInputData(data)
    normals.SplittingOff()
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(normals.GetOutputPort())
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.SetSpecular(0.4)
    look.SetSpecularPower(30)
    getattr(look, {"flat": "SetInterpolationToFlat", "gouraud": "SetInterpolationToGouraud"}.get(
        shading, "SetInterpolationToPhong"))()  # fmt: skip
    renderer, window = vtk.vtkRenderer(), vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(SIDE, SIDE)
    window.AddRenderer(renderer)
    renderer.AddActor(actor)
    camera = renderer.GetActiveCamera()
    camera.SetPosition(*EYE)
    camera.SetFocalPoint(0, 0, 0)
    camera.SetViewAngle(40)
    renderer.ResetCameraClippingRange()
    pixels = vtk.vtkUnsignedCharArray()

    def draw() -> object:
        camera.Modified()
        window.Render()
        window.GetRGBACharPixelData(0, 0, SIDE - 1, SIDE - 1, 0, pixels)
        return pixels

    return draw


def shadings(runs: int, workers: int) -> list[str]:
    """The table of shadings and sizes."""
    lines = [
        "| quads | triangles | shading | ours, ms (best / median) | VTK, ms |",
        "|---|---|---|---|---|",
    ]
    for u, v in SIZES:
        scene = torus_scene(u, v)
        renderer, out = Renderer(scene), np.empty((SIDE, SIDE, 3), np.float32)
        options: dict[str, Any] = {"workers": workers, "out": out}
        work: dict[str, Callable[[], object]] = {}
        for shading in SHADINGS:
            work[shading] = partial(renderer.render, SIDE, SIDE, shading=shading, **options)
            peer = vtk_frame(scene.meshes[0], shading)
            if peer is not None:
                work["VTK " + shading] = peer
        times = compare(work, runs)
        for shading in SHADINGS:
            ours, peer_times = _both(times[shading]), times.get("VTK " + shading)
            theirs = _both(peer_times) if peer_times else "–"
            lines.append(f"| {u} × {v} | {2 * u * v:,} | {shading} | {ours} | {theirs} |")
    return lines


def leaving_out(runs: int, workers: int) -> list[str]:
    """The barest scene by its plan and by the forced one."""
    scene = Scene((shapes.torus(220, 110),), (Material(),), (Light(kind="distant"),), Camera(EYE))
    renderer = Renderer(scene)
    plans: dict[str, Any] = {"its plan": {}, "the forced full plan": {"force_all": True}}
    pictures = [renderer.render(SIDE, SIDE, shading="flat", **plan).radiance for plan in plans.values()]
    same = "the same bytes" if pictures[0].tobytes() == pictures[1].tobytes() else "DIFFERENT BYTES"
    times = compare(
        {
            name: partial(renderer.render, SIDE, SIDE, shading="flat", workers=workers, **plan)
            for name, plan in plans.items()
        },
        runs,
    )
    lean, full = (min(times[name]) for name in plans)
    lines = [f"| {name} | {_both(times[name])} |" for name in plans]
    return [
        "| barest scene by | ms (best / median) |",
        "|---|---|",
        *lines,
        "",
        f"{full / lean:.1f}×, {same}.",
    ]


def first_picture() -> list[str]:
    """Whole processes: with an empty cache of kernels, and with a full one."""
    with tempfile.TemporaryDirectory() as folder:
        call = process(sys.executable, "-c", FIRST, HALFTONE_CACHE_DIR=folder)
        times = compare({"first": call}, 3)["first"]
    with tempfile.TemporaryDirectory() as folder:
        import time

        start = time.perf_counter()
        process(sys.executable, "-c", FIRST, HALFTONE_CACHE_DIR=folder)()
        cold = time.perf_counter() - start
    return [f"First picture: {min(times):.2f} s with kernels at hand, {cold:.2f} s the first time ever."]


def _both(times: list[float]) -> str:
    best, median = best_and_median(times)
    return f"{best * 1e3:.1f} / {median * 1e3:.1f}"


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.bench.scene", description=__doc__)
    parser.add_argument("--runs", type=int, default=15)
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args(arguments)
    for part in (
        shadings(given.runs, given.workers),
        leaving_out(given.runs, given.workers),
        first_picture(),
    ):
        print("\n".join(part), end="\n\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
