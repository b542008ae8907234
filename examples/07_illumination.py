"""Terms of the illumination, exponents, Warn lights: writes examples/07_illumination.png."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

import halftone
from halftone.scene import shapes
from halftone.scene.model import Camera, Light, Material, Mesh, Scene

WIDTH, HEIGHT, CAPTION, GAP = 232, 174, 16, 8
INF = float("inf")
OPEN = (-INF, INF)


def gray(value: float) -> tuple[float, float, float]:
    return (value, value, value)


def at(mesh: Mesh, x: float, y: float, z: float, material: int = 0) -> Mesh:
    place = np.full(len(mesh.faces), material)
    return replace(mesh, vertices=mesh.vertices + np.array([x, y, z]), material=place)


GLAZE = Material(ambient=gray(0.12), diffuse=gray(0.45), specular=gray(0.5), exponent=30)
KEY = Light(position=(-4, 5, 6), intensity=gray(1.0))
SOLIDS = Scene(
    meshes=(
        at(shapes.sphere(96, 48, 0.8), -0.95, 0, 0),
        at(shapes.torus(96, 48, 0.55, 0.27), 0.95, 0, 0),
    ),
    lights=(KEY,),
    camera=Camera(eye=(0, 1.6, 4.9), target=(0, -0.05, 0), fov=31),
    background=gray(0.01),
)


def solids(material: Material, **more: object) -> Scene:
    return replace(SOLIDS, materials=(material,), **more)  # type: ignore[arg-type]


def terms() -> list[tuple[str, Scene]]:
    """The books' figures of a surface lit by one term after another."""
    no = gray(0.0)
    return [
        ("ambient only", solids(replace(GLAZE, ambient=gray(0.3), diffuse=no, specular=no))),
        ("diffuse only", solids(replace(GLAZE, ambient=no, specular=no))),
        ("ambient + diffuse", solids(replace(GLAZE, specular=no))),
        ("ambient + diffuse + specular", solids(GLAZE)),
    ]


def exponents() -> list[tuple[str, Scene]]:
    return [(f"exponent {n}", solids(replace(GLAZE, exponent=n))) for n in (5, 20, 100, 500)]


def warn() -> list[tuple[str, Scene]]:
    """One lamp above a wall and a floor."""
    wall = replace(shapes.plane(6, 4, 2, 2), name="wall")
    upright = replace(wall, vertices=wall.vertices[:, [0, 2, 1]] * [1, -1, 1])
    studio = Scene(
        meshes=(
            at(shapes.plane(6, 4), 0, -1, 0),
            at(upright, 0, 1, -1),
            at(shapes.sphere(64, 32, 0.5), 0.5, -0.5, 0.2),
        ),
        materials=(Material(ambient=gray(0.05), diffuse=gray(0.75)),),
        camera=Camera(eye=(0, 0.7, 5.6), target=(0, 0.1, 0), fov=28),
    )
    lamp = Light("warn", gray(1.3), (-0.6, 1.5, 2.2), (0.35, -0.75, -1.0), exponent=1)
    return [
        ("Warn light, exponent 4", replace(studio, lights=(replace(lamp, exponent=4),))),
        ("exponent 40", replace(studio, lights=(replace(lamp, exponent=40),))),
        (
            "exponent 4, flaps on x and y",
            replace(studio, lights=(replace(lamp, exponent=4, flaps=((-0.9, 0.9), (-2, 0.6), OPEN)),)),
        ),
        (
            "spotlight of 24 degrees",
            replace(studio, lights=(replace(lamp, kind="spot", cutoff=24.0, inner=20.0),)),
        ),
    ]


def further() -> list[tuple[str, Scene]]:
    """Two planes that overlap, with and without attenuation; shadows; transparency."""
    planes = Scene(
        meshes=(
            at(shapes.plane(1.6, 2.2), -0.3, 0, 0),
            at(shapes.plane(1.6, 2.2), 0.4, -1.2, 0),
        ),
        materials=(Material(ambient=gray(0.05), diffuse=gray(0.8)),),
        lights=(Light(position=(0.2, 2.2, 0.4)),),
        camera=Camera(eye=(0, 6, 0.01), up=(0, 0, -1), fov=27),
        background=gray(0.01),
    )
    faded = replace(planes.lights[0], attenuation=(0.4, 0.25, 0.1))
    floor = at(shapes.plane(7, 7), 0, -0.8, 0, 1)
    plaster = Material(ambient=gray(0.08), diffuse=gray(0.55))
    lit = replace(
        SOLIDS,
        meshes=(*SOLIDS.meshes, floor),
        materials=(GLAZE, plaster),
        lights=(replace(KEY, shadows=True),),
    )
    glass = replace(
        GLAZE, ambient=gray(0.05), diffuse=gray(0.2), transparency=0.7, rim=0.1, rim_exponent=3
    )
    return [
        ("two planes, no attenuation", planes),
        ("attenuation tells them apart", replace(planes, lights=(faded,))),
        ("shadows", lit),
        ("transparency, less at the rim", replace(lit, materials=(glass, plaster))),
    ]


def code(light: np.ndarray) -> np.ndarray:
    """8-bit sRGB of linear light."""
    return halftone.convert(light, levels=256, method="none").preview()


def main() -> None:
    rows = (terms(), exponents(), warn(), further())
    cell = (WIDTH + GAP, HEIGHT + CAPTION + GAP)
    sheet = Image.new("L", (4 * cell[0] - GAP, len(rows) * cell[1] - GAP), 255)
    draw = ImageDraw.Draw(sheet)
    for down, row in enumerate(rows):
        for across, (caption, scene) in enumerate(row):
            picture = halftone.render(scene, WIDTH, HEIGHT, samples=3, workers=0)
            x, y = across * cell[0], down * cell[1]
            sheet.paste(Image.fromarray(code(picture.radiance)), (x, y))
            draw.text((x, y + HEIGHT + 2), caption, fill=0)
    sheet.save(Path(__file__).with_suffix(".png"), optimize=True)


main()
