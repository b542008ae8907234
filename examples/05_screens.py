"""Ten screens on two levels, on a gradient and a photograph: writes examples/05_screens.png."""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

import halftone
from halftone.cli.demo import PHOTOGRAPH
from halftone.dithering.screened import screened

WIDTH, PHOTO, RAMP, CAPTION, GAP, ACROSS = 280, 190, 36, 18, 8, 5

SCREENS = (
    ("bayer8", "dispersed dots"),
    ("blue-noise", "void-and-cluster"),
    ("blue-noise:dot=2", "dots of 2 x 2 pixels"),
    ("h8x8a", "ImageMagick's map"),
    ("cluster3", "netpbm's map"),
    ("screen:round@45:50lpi:dpi=203", "50 lpi"),
    ("screen:euclidean@15:6px", "dots, then holes"),
    ("screen:ellipse@75:5px", "joins along 75 degrees"),
    ("screen:line@-30:5px", "lines"),
    ("screen:round@45:9px", "coarse"),
)

picture = halftone.convert(
    PHOTOGRAPH, width=420, levels=256, method="none", auto_levels=True, brightness=0.2
)
photo = picture.luminance[10 : 10 + PHOTO, 100 : 100 + WIDTH]
ramp = np.tile(np.linspace(0, 1, WIDTH, dtype=np.float32), (RAMP, 1))
light = np.ascontiguousarray(np.vstack([ramp, photo]))
cell = (WIDTH + GAP, PHOTO + RAMP + CAPTION + GAP)
rows = -(-len(SCREENS) // ACROSS)
sheet = Image.new("L", (ACROSS * cell[0] + GAP, rows * cell[1] + GAP), 255)
draw = ImageDraw.Draw(sheet)
for i, (text, caption) in enumerate(SCREENS):
    x, y = GAP + i % ACROSS * cell[0], GAP + i // ACROSS * cell[1]
    frame = halftone.dither(light, screened(text))
    sheet.paste(Image.fromarray(frame.preview()), (x, y))
    draw.text((x, y + PHOTO + RAMP + 3), f"{text}  ({caption})", fill=0)
sheet.save(Path(__file__).with_suffix(".png"), optimize=True)
