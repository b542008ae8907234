"""A photograph from a receipt printer, without and with the tone correction, as simulated paper.

Above, what the eye makes of it at 30 cm; below, the dots. Writes examples/10_paper.png.
"""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

import halftone
from devices.paper import Paper, at_distance
from devices.profile import load
from halftone.cli.demo import PHOTOGRAPH
from halftone.tone.levels import Levels
from halftone.tone.transfer import encoding

WIDTH, STEPS, WEDGE, CAPTION, GAP = 300, 10, 44, 16, 8
SCALE, CORNER, CROP = 4, (62, 96), (40, 75)  # of the drawn dots: samples a dot, upper left, size
INCHES = 12

printer = load("receipt-80mm")
paper = Paper(printer.levels, printer.dot)

look = {"auto_levels": True, "brightness": 0.2}
photograph = halftone.convert(PHOTOGRAPH, width=WIDTH, levels=256, method="none", **look).luminance
steps = Levels.of(f"lstar:{STEPS}").luminance.repeat(WIDTH // STEPS)
asked = np.vstack([photograph, np.ones((GAP, WIDTH), np.float32), np.tile(steps, (WEDGE, 1))])


def magnified(light: np.ndarray) -> np.ndarray:
    """Every pixel of the crop as large as a drawn dot."""
    (top, left), (rows, columns) = CORNER, CROP
    return light[top : top + rows, left : left + columns].repeat(SCALE, 0).repeat(SCALE, 1)


def drawn(frame: halftone.Frame) -> np.ndarray:
    """The printed dots of the crop."""
    (top, left), (rows, columns) = np.multiply(CORNER, SCALE), np.multiply(CROP, SCALE)
    return np.concatenate(list(paper.drawn(frame, SCALE)))[top : top + rows, left : left + columns]


panels = [("asked for", at_distance(asked, printer.dpi, INCHES), magnified(asked))]
for dot_gain, name in (("keep", "printed, not corrected"), ("correct", "printed, tone corrected")):
    frame = halftone.convert(asked, profile=printer, width=WIDTH, dot_gain=dot_gain)
    panels.append((name, at_distance(paper.seen(frame), printer.dpi, INCHES), drawn(frame)))

height = CAPTION + asked.shape[0] + GAP + CROP[0] * SCALE + GAP
sheet = Image.new("L", (len(panels) * (WIDTH + GAP) + GAP, height), 255)
draw = ImageDraw.Draw(sheet)
for column, (name, above, below) in enumerate(panels):
    x = GAP + column * (WIDTH + GAP)
    draw.text((x, 0), f"{name}: mean light {above[: len(photograph)].mean():.3f}", fill=0)
    for light, y in ((above, CAPTION), (below, CAPTION + asked.shape[0] + GAP)):
        codes = np.rint(encoding("srgb").encode(np.clip(light, 0, 1)) * 255).astype(np.uint8)
        sheet.paste(Image.fromarray(codes), (x, y))
sheet.save(Path(__file__).with_suffix(".png"), optimize=True)
