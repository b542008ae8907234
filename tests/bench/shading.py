"""Error against run time of the four shadings: ``python -m tests.bench.shading [--md FILE] [--quick]``.

Icospheres of 80 … 81,920 triangles under a point light, in perspective, against the exact sphere: the
exact normal at the point where the ray through the pixel's centre meets it, ray and sphere in float64,
and the same formula of illumination in plain NumPy. Errors are of linear radiance, on the pixels that
both cover. One thread, best of runs in turns.

Vertex normals are the sphere's, so that only the shadings differ; ``--averaged`` has the package's
averages of face normals instead. ``--distant`` has light and viewer at infinity, for which fast Phong
was made: it takes both from the middle of a face. At n_s = 1 the highlight still has over a third of its
strength where the light ends (N·L = 0), a jump that no interpolation follows: the slopes fall.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone.scene import shapes
from halftone.scene.model import Camera, Light, Material, Scene
from halftone.scene.render import Renderer
from halftone.scene.shade import SHADINGS
from tests.bench.table import markdown
from tests.bench.timing import compare

EXPONENTS = (1, 10, 100)
DIVISIONS = (1, 2, 3, 4, 5, 6)
EYE, FOV, HEIGHT, LAMP = 5.0, 26.0, 2.26, (2.0, 3.0, 4.0)
AMBIENT, DIFFUSE, SPECULAR = 0.09, 0.6, 0.3  # 0.1 would be halfway between two of the 16 levels
LEVELS = 16
STATED = {"flat": "1", "gouraud": "1.8", "phong": "1.8 … 2", "fast-phong": "–"}
"""Slopes of RMS error against edge length, scenes.md §4.1, measured there at n_s 10 and 200."""

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Cell:
    """One shading of one sphere. seconds : the whole picture; shading : its stages that only some
    shadings need or that shade; fallen_back : share of the visible faces, of fast Phong only.
    """

    rms: float
    largest: float
    changed: float
    seconds: float
    shading: float
    fallen_back: float | None


def ball(divisions: int, exponent: float, distant: bool = False, averaged: bool = False) -> Scene:
    """A gray, shiny sphere of radius 1, made of triangles."""
    material = Material(ambient=(AMBIENT,), diffuse=(DIFFUSE,), specular=(SPECULAR,), exponent=exponent)
    x, y, z = LAMP
    light = Light("point", (1.0,), position=LAMP)
    if distant:
        light = Light("distant", (1.0,), direction=(-x, -y, -z))
    kind = "parallel" if distant else "perspective"
    return Scene(
        (shapes.icosphere(divisions, exact=not averaged),),
        (material,),
        (light,),
        Camera((0.0, 0.0, EYE), projection=kind, fov=FOV, height=HEIGHT),
        ambient=(1.0,),
        background=(0.0,),
    )


def exact(side: int, exponent: float, distant: bool) -> tuple[Floats, NDArray[np.bool_]]:
    """Radiance (side, side) of the exact sphere, 0 outside it, and where it is."""
    half = np.tan(np.radians(FOV) / 2) if not distant else HEIGHT / 2
    across = (2 * (np.arange(side) + 0.5) / side - 1) * half
    x, y = np.meshgrid(across, -across)
    start, ray = np.zeros((side, side, 3)), np.zeros((side, side, 3))
    start[..., 2], ray[..., 2] = EYE, -1.0
    (start if distant else ray)[..., :2] = np.stack([x, y], axis=-1)
    ray = unit(ray)
    # away : where the ray is nearest to the middle of the sphere, which is the origin.
    away = start - (ray * start).sum(axis=-1)[..., None] * ray
    rest = 1 - (away * away).sum(axis=-1)
    hit = rest > 0
    normal = unit(away - np.sqrt(np.where(hit, rest, 0))[..., None] * ray)
    light, view = np.array(LAMP) - normal, start - normal
    if distant:
        light, view = np.broadcast_to(LAMP, normal.shape), -ray
    light, view = unit(light), unit(view)
    cosine = (normal * light).sum(axis=-1)
    lobe = np.maximum((normal * unit(light + view)).sum(axis=-1), 0)
    radiance = AMBIENT + np.where(cosine > 0, DIFFUSE * cosine + SPECULAR * lobe**exponent, 0)
    return np.where(hit, radiance, 0), hit


def unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def edge_length(scene: Scene) -> float:
    """The mean length of the edges of the scene's mesh."""
    corners = scene.meshes[0].vertices[scene.meshes[0].faces]
    return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).mean())


def level(radiance: Any) -> Any:
    """The nearest of LEVELS equidistant levels of 0 … 1."""
    return np.rint(np.clip(radiance, 0, 1) * (LEVELS - 1))


def cells(scene: Scene, reference: tuple[Floats, NDArray[np.bool_]], runs: int) -> dict[str, Cell]:
    """Every shading of one sphere, against the *reference* of :func:`exact`."""
    want, hit = reference
    side = len(want)
    renderer, out = Renderer(scene), np.empty((side, side, 1), np.float32)
    best = dict.fromkeys(SHADINGS, np.inf)

    def draw(shading: str) -> None:
        seconds = renderer.render(side, side, shading=shading, out=out).report["seconds"]
        best[shading] = min(best[shading], seconds.get("faces", 0.0) + seconds["shading"])

    times = compare({shading: partial(draw, shading) for shading in SHADINGS}, runs)
    found = {}
    for shading in SHADINGS:
        picture = renderer.render(side, side, shading=shading)
        both = hit & (picture.ids >= 0)
        got = picture.radiance[..., 0].astype(np.float64)[both]
        error = got - want[both]
        counts = picture.report["counts"]
        found[shading] = Cell(
            float(np.sqrt(np.mean(error * error))),
            float(np.abs(error).max()),
            float(np.mean(level(got) != level(want[both]))),
            min(times[shading]),
            best[shading],
            counts["fallen_back"] / counts["visible"] if "visible" in counts else None,
        )
    return found


def slope(edges: list[float], errors: list[float]) -> float:
    """The exponent p of error = c · edge^p, by least squares of the logarithms."""
    return float(np.polyfit(np.log(edges), np.log(errors), 1)[0])


def table(found: dict[int, list[dict[str, Cell]]], edges: list[float], divisions: list[int]) -> str:
    """One row a sphere and exponent, a column a shading, and rows of slopes."""
    rows = []
    for exponent, spheres in found.items():
        for cut, edge, sphere in zip(divisions, edges, spheres, strict=True):
            texts = [
                f"{c.rms:.1e} / {c.largest:.1e} / {100 * c.changed:.2g} % / {c.seconds * 1e3:.1f}"
                for c in sphere.values()
            ]
            back = sphere["fast-phong"].fallen_back or 0.0
            rows.append(
                [str(exponent), f"{20 * 4**cut:,}", f"{edge:.3f}", *texts, f"{100 * back:.3g} %"]
            )
        fits = [
            f"**{slope(edges, [s[shading].rms for s in spheres]):.2f}** / "
            f"{slope(edges, [s[shading].largest for s in spheres]):.2f} (stated {STATED[shading]})"
            for shading in SHADINGS
        ]
        rows.append([str(exponent), "slope", "", *fits, ""])
    heads = ["n_s", "triangles", "mean edge"]
    heads += [f"{s}: RMS / max / levels changed / ms" for s in SHADINGS]
    return markdown([*heads, "faces fallen back"], rows)


def ratios(found: dict[int, list[dict[str, Cell]]], divisions: list[int]) -> str:
    """P10 of scenes.md: costs of the shading stages as multiples of Gouraud's."""
    parts = []
    for place, cut in enumerate(divisions):
        totals = {s: sum(spheres[place][s].shading for spheres in found.values()) for s in SHADINGS}
        fast, phong = (totals[s] / totals["gouraud"] for s in ("fast-phong", "phong"))
        parts.append(f"{20 * 4**cut:,} triangles {fast:.2f} and {phong:.2f}")
    return (
        "Cost of the shading stages, fast Phong and Phong over Gouraud (Bishop & Weimer: about 2 and "
        f"6 … 7): {'; '.join(parts)}."
    )


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.bench.shading", description=__doc__)
    parser.add_argument("--md", type=Path, help="also write the Markdown to this file")
    parser.add_argument("--quick", action="store_true", help="256², up to 1,280 triangles, 3 runs")
    parser.add_argument("--distant", action="store_true", help="light and viewer at infinity")
    parser.add_argument("--averaged", action="store_true", help="vertex normals averaged")
    parser.add_argument("--side", type=int, default=512)
    parser.add_argument("--runs", type=int, default=15)
    given = parser.parse_args(arguments)
    side, runs = (256, 3) if given.quick else (given.side, given.runs)
    divisions = list(DIVISIONS[:3] if given.quick else DIVISIONS)
    edges = [edge_length(ball(cut, 1)) for cut in divisions]
    found: dict[int, list[dict[str, Cell]]] = {}
    for n in EXPONENTS:
        reference = exact(side, n, given.distant)
        scenes = [ball(cut, n, given.distant, given.averaged) for cut in divisions]
        found[n] = [cells(scene, reference, runs) for scene in scenes]
    text = f"{table(found, edges, divisions)}\n\n{ratios(found, divisions)}\n"
    print(text)
    if given.md:
        given.md.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
