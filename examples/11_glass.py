"""Two panels, of 4 and of 16 grays: their ladders as step wedges, and a photograph as each would show
it, read back from the very bytes that it would get. Writes examples/11_glass.png."""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

import halftone
from devices.framebuffer import FrameBuffer
from devices.profile import load
from halftone.cli.demo import PHOTOGRAPH
from halftone.tone import encoding

WIDTH, HEIGHT, WEDGE, CAPTION, GAP = 400, 266, 40, 18, 8
PANELS = ("epaper-4gray", "epaper-16gray")


def shown(name: str, frame: halftone.Frame) -> Image.Image:
    """*frame* sent to the panel and seen, its paper white as white."""
    panel = FrameBuffer(load(name), shape=frame.shape)
    panel.write_bytes(frame.packed())
    panel.refresh()
    codes = np.rint(encoding("srgb").encode(panel.snapshot()) * 255).astype(np.uint8)
    return Image.fromarray(codes)


sheet = Image.new("L", (len(PANELS) * (WIDTH + GAP) + GAP, HEIGHT + WEDGE + 2 * (CAPTION + GAP)), 200)
draw = ImageDraw.Draw(sheet)
for column, name in enumerate(PANELS):
    profile = load(name)
    steps = profile.levels.luminance[np.arange(WIDTH) * len(profile.levels) // WIDTH]
    wedge = halftone.dither(np.tile(steps, (WEDGE, 1)), "none", levels=profile.levels)
    photograph = halftone.convert(
        PHOTOGRAPH, profile=profile, width=WIDTH, height=HEIGHT, auto_levels=True, brightness=0.2
    )
    x = GAP + column * (WIDTH + GAP)
    ladder = profile.levels.luminance.tolist()
    texts = [f"{v:.3f}" for v in ladder]
    listed = " ".join(texts if len(texts) < 8 else [*texts[:3], "...", *texts[-2:]])
    wedge = halftone.Frame(wedge.indices, wedge.levels, packing=profile.packing)
    sheet.paste(shown(name, wedge), (x, GAP))
    draw.text((x, GAP + WEDGE + 3), f"{name}: {listed}", fill=0)
    sheet.paste(shown(name, photograph), (x, GAP + WEDGE + CAPTION))
    draw.text((x, GAP + WEDGE + CAPTION + HEIGHT + 3), f"photograph, {photograph.method}", fill=0)
sheet.save(Path(__file__).with_suffix(".png"), optimize=True)
