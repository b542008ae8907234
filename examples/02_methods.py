"""Every method on two levels, on a photograph and a gradient: writes examples/02_methods.png."""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

import halftone
from halftone.cli.demo import PHOTOGRAPH

WIDTH, PHOTO, RAMP, CAPTION, GAP, ACROSS = 240, 160, 24, 18, 8, 5

names = list(halftone.methods())
photo = halftone.convert(
    PHOTOGRAPH, width=WIDTH, levels=256, method="none", auto_levels=True, brightness=0.2
)
light = np.vstack([photo.luminance, np.tile(np.linspace(0, 1, WIDTH, dtype=np.float32), (RAMP, 1))])
assert light.shape == (PHOTO + RAMP, WIDTH)
cell = (WIDTH + GAP, PHOTO + RAMP + CAPTION + GAP)
rows = -(-len(names) // ACROSS)
sheet = Image.new("L", (ACROSS * cell[0] + GAP, rows * cell[1] + GAP), 255)
draw = ImageDraw.Draw(sheet)
for i, name in enumerate(names):
    x, y = GAP + i % ACROSS * cell[0], GAP + i // ACROSS * cell[1]
    sheet.paste(Image.fromarray(halftone.dither(light, name).preview()), (x, y))
    draw.text((x, y + PHOTO + RAMP + 2), f"{name} (tone: {halftone.methods()[name].claim})", fill=0)
sheet.save(Path(__file__).with_suffix(".png"), optimize=True)
