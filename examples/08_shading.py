"""Flat, Gouraud, Phong and fast Phong shading of coarse meshes: writes examples/08_shading.png."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

import halftone
from halftone.scene import shapes
from halftone.scene.model import Camera, Light, Material, Scene

WIDTH, HEIGHT, CAPTION, GAP = 232, 174, 16, 8
SHADINGS = ("flat", "gouraud", "phong", "fast-phong")
GLAZE = Material(ambient=(0.12,) * 3, diffuse=(0.5,) * 3, specular=(0.6,) * 3, exponent=40)


def scene(fineness: int) -> Scene:
    ball = shapes.sphere(4 * fineness, 2 * fineness, 0.8)
    ring = shapes.torus(6 * fineness, 3 * fineness, 0.55, 0.27)
    return Scene(
        meshes=(
            replace(ball, vertices=ball.vertices - np.array([0.95, 0, 0])),
            replace(ring, vertices=ring.vertices + np.array([0.95, 0, 0])),
        ),
        materials=(GLAZE,),
        lights=(Light(position=(-4, 5, 6)),),
        camera=Camera(eye=(0, 1.6, 4.9), target=(0, -0.05, 0), fov=31),
        background=(0.01,) * 3,
    )


cell = (WIDTH + GAP, HEIGHT + CAPTION + GAP)
sheet = Image.new("L", (4 * cell[0] - GAP, 2 * cell[1] - GAP), 255)
draw = ImageDraw.Draw(sheet)
for down, fineness in enumerate((3, 8)):
    made = scene(fineness)
    count = sum(len(mesh.faces) for mesh in made.meshes)
    for across, shading in enumerate(SHADINGS):
        picture = halftone.render(made, WIDTH, HEIGHT, shading=shading, workers=0)
        shown = halftone.convert(picture.radiance, levels=256, method="none").preview()
        x, y = across * cell[0], down * cell[1]
        sheet.paste(Image.fromarray(shown), (x, y))
        draw.text((x, y + HEIGHT + 2), f"{shading}, {count} triangles", fill=0)
sheet.save(Path(__file__).with_suffix(".png"), optimize=True)
