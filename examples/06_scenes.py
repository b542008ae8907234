"""One scene on three devices, each with its own dots and levels: writes examples/06_scenes.png."""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

import halftone
from devices import profile

HERE = Path(__file__).parent
WIDTH, HEIGHT, CAPTION, GAP = 400, 300, 18, 8

DEVICES = (
    ("receipt-80mm", "receipt printer: black dots on paper"),
    ("epaper-4gray", "e-paper: 4 grays"),
    ("framebuffer-16", "frame buffer: 16 levels"),
)

picture = halftone.render(HERE / "scenes" / "still_life.toml", WIDTH, HEIGHT, samples=3, workers=0)
sheet = np.full((HEIGHT + CAPTION + GAP, 3 * WIDTH + 2 * GAP), 255, np.uint8)
for i, (name, _) in enumerate(DEVICES):
    frame = halftone.convert(picture.radiance, profile=profile.load(name), width=WIDTH, height=HEIGHT)
    x = i * (WIDTH + GAP)
    sheet[:HEIGHT, x : x + WIDTH] = frame.preview()
image = Image.fromarray(sheet)
draw = ImageDraw.Draw(image)
for i, (name, caption) in enumerate(DEVICES):
    draw.text((i * (WIDTH + GAP), HEIGHT + 4), f"{name}  ({caption})", fill=0)
image.save(Path(__file__).with_suffix(".png"), optimize=True)
