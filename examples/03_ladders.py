"""Four levels placed by four ladders, halftoned and as nearest level: writes examples/03_ladders.png."""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

import halftone
from halftone.cli.demo import PHOTOGRAPH

WIDTH, CAPTION, GAP = 300, 18, 6
LADDERS = ("4", "uniform-linear:4", "lstar:4", "log:0.02:4")

look = {"auto_levels": True, "brightness": 0.2}
light = halftone.convert(PHOTOGRAPH, width=WIDTH, levels=256, method="none", **look).luminance
height = light.shape[0]
sheet = Image.new("L", (len(LADDERS) * (WIDTH + GAP) + GAP, 2 * (height + CAPTION + GAP) + GAP), 255)
draw = ImageDraw.Draw(sheet)
for row, method in enumerate(("none", "floyd-steinberg")):
    for column, levels in enumerate(LADDERS):
        frame = halftone.dither(light, method, levels=levels)
        x, y = GAP + column * (WIDTH + GAP), GAP + row * (height + CAPTION + GAP)
        sheet.paste(Image.fromarray(frame.preview()), (x, y))
        shown = " ".join(f"{v:.3f}" for v in np.asarray(frame.levels.luminance))
        draw.text((x, y + height + 2), f"{levels} = {shown}, {method}", fill=0)
sheet.save(Path(__file__).with_suffix(".png"), optimize=True)
