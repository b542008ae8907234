"""The methods on two levels, on a photograph and a gradient: writes examples/02_methods.png."""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

import halftone
from halftone.cli.demo import PHOTOGRAPH
from halftone.dithering.registry import NAMES

WIDTH, PHOTO, RAMP, CAPTION, GAP, ACROSS = 240, 160, 24, 18, 8, 6

# ImageMagick's and netpbm's maps have a picture of their own, 05_screens.
names = [n for n, family in NAMES.items() if family != "screened" or n[0] in "bs"]
names += ["fs:warm", "fs:noise=0.4", "fs:edges=2"]

look = {"levels": 256, "method": "none", "auto_levels": True, "brightness": 0.2}
photo = halftone.convert(PHOTOGRAPH, width=WIDTH, **look).luminance
ramp = np.tile(np.linspace(0, 1, WIDTH, dtype=np.float32), (RAMP, 1))
light = np.vstack([photo, ramp])
assert light.shape == (PHOTO + RAMP, WIDTH)
cell = (WIDTH + GAP, PHOTO + RAMP + CAPTION + GAP)
rows = -(-len(names) // ACROSS)
sheet = Image.new("L", (ACROSS * cell[0] + GAP, rows * cell[1] + GAP), 255)
draw = ImageDraw.Draw(sheet)
for i, name in enumerate(names):
    method = halftone.method(name)
    x, y = GAP + i % ACROSS * cell[0], GAP + i // ACROSS * cell[1]
    # A method that shows each pixel as n x n takes a picture n times smaller.
    small = light[:: method.scale, :: method.scale]
    shown = halftone.dither(small, method).preview()[: PHOTO + RAMP, :WIDTH]
    sheet.paste(Image.fromarray(shown), (x, y))
    draw.text((x, y + PHOTO + RAMP + 2), f"{name} (tone: {method.claim})", fill=0)
sheet.save(Path(__file__).with_suffix(".png"), optimize=True)
