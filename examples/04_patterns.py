"""Families of patterns that evolve dot by dot, and what they show: writes examples/04_patterns.png."""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

import halftone
from halftone.cli.demo import PHOTOGRAPH
from halftone.dithering.patterns import Patterns
from halftone.screens.growth import family

WIDTH, MARGIN, CAPTION, GAP, DOTS, MAGNIFY = 1376, 12, 20, 6, 16, 2
SHEETS = [
    (name, levels)
    for levels in (2, 4)
    for name in ("classic2", "classic3", "4", "8", "8:isolated=4", "8:clustered")
    if levels == 2 or ":" not in name
]

# Each pattern tiled over about 16 × 16 dots, as a flat area of the device shows it.
parts: list[tuple[str, np.ndarray]] = []
for name, levels in SHEETS:
    made = family(name).extended(levels)
    report = made.check()
    assert report.sound
    repeat = DOTS // made.n
    across = (WIDTH - GAP) // (made.n * repeat * MAGNIFY + 2 + GAP)
    sheet = made.sheet(MAGNIFY, repeat, min(across, len(made)), GAP)
    caption = f"{name}, {levels} levels: {report.patterns} patterns"
    if levels == 2:
        caption += f"; no streak before pattern {report.first_streak}"
        caption += f", no isolated dot from pattern {report.joined_from} on"
    parts.append((caption, sheet))

# A photograph in which every pixel became a pattern.
look = {"auto_levels": True, "brightness": 0.2, "width": 336}
shown = [("4", 2), ("8:isolated=4", 2), ("8:clustered", 2), ("4", 4)]
strip = [
    halftone.convert(PHOTOGRAPH, method=Patterns(family(name)), levels=levels, **look).preview()
    for name, levels in shown
]
height = max(picture.shape[0] for picture in strip)
photos = np.full((height + 2 * GAP, WIDTH), 255, np.uint8)
for i, picture in enumerate(strip):
    x = GAP + i * (336 + GAP)
    photos[GAP : GAP + picture.shape[0], x : x + picture.shape[1]] = picture
names = ", ".join(f"{name} on {levels} levels" for name, levels in shown)
parts.append((f"a photograph, every pixel replaced by a pattern: {names}", photos))

# The small families of a level count share a row.
rows: list[list[tuple[str, np.ndarray]]] = [[]]
used = 0
for caption, picture in parts:
    width = max(picture.shape[1], 6 * len(caption)) + 2 * MARGIN
    if rows[-1] and used + width > WIDTH:
        rows.append([])
        used = 0
    rows[-1].append((caption, picture))
    used += width
total = sum(CAPTION + max(picture.shape[0] for _, picture in row) for row in rows)
sheet = Image.new("L", (WIDTH + 2 * MARGIN, total + MARGIN), 255)
draw = ImageDraw.Draw(sheet)
y = MARGIN // 2
for row in rows:
    x = MARGIN
    for caption, picture in row:
        draw.text((x + GAP, y + 4), caption, fill=0)
        sheet.paste(Image.fromarray(picture), (x, y + CAPTION))
        x += max(picture.shape[1], 6 * len(caption)) + 2 * MARGIN
    y += CAPTION + max(picture.shape[0] for _, picture in row)
sheet.save(Path(__file__).with_suffix(".png"), optimize=True)
