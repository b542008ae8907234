"""``halftone demo``: one photograph, and what five limited devices show of it, as a strip."""

from __future__ import annotations

import argparse
import io
from pathlib import Path
from typing import Any

__all__ = ["LIMITS", "PHOTOGRAPH", "arguments", "run", "strip"]

PHOTOGRAPH = Path(__file__).parent / "data" / "chelsea.jpg"
"""Chelsea the cat, by Stéfan van der Walt, CC0; from scikit-image, 451 × 300."""

LIMITS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("1 bit, Floyd-Steinberg", {"levels": 2, "method": "floyd-steinberg"}),
    ("1 bit, ordered (Bayer 8)", {"levels": 2, "method": "bayer8"}),
    ("2 bits, log ladder from 0.02", {"levels": "log:0.02:4", "method": "floyd-steinberg"}),
    ("5 measured levels", {"levels": "0.01,0.08,0.3,0.55,1", "method": "stucki"}),
    ("4 bits", {"levels": 16, "method": "floyd-steinberg"}),
)

_CAPTION = 18
_GAP = 6


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("output", nargs="?", default="halftone-demo.png", metavar="OUT.png")
    parser.add_argument("--picture", metavar="IN", help="a picture of your own")
    parser.add_argument("--width", type=int, default=300, metavar="W", help="dots of each (300)")


def run(options: argparse.Namespace) -> int:
    from halftone.cli.console import quiet_libraries
    from halftone.errors import UsageError
    from halftone.images.write import format_of, write_bytes

    if format_of(options.output) != "png":
        raise UsageError(f"the demo is a PNG; '{options.output}' is not")
    if not 16 <= options.width <= 4096:
        raise UsageError(f"width {options.width}; allowed: 16 … 4096")
    with quiet_libraries():
        data = strip(options.picture or PHOTOGRAPH, options.width)
    write_bytes(data, options.output)
    if options.output != "-":
        print(f"{options.output}: the original and {len(LIMITS)} devices")
    return 0


def strip(picture: str | Path, width: int) -> bytes:
    """The original and what each of :data:`LIMITS` shows of it, side by side, as a PNG file."""
    import numpy as np
    from PIL import Image, ImageDraw

    from halftone.pipeline import convert

    adjusted: dict[str, Any] = {"width": width, "auto_levels": True, "brightness": 0.2}
    original = convert(picture, levels=256, method="none", **adjusted)
    tiles = [("256 grays", original)]
    tiles += [(name, convert(picture, **adjusted, **limit)) for name, limit in LIMITS]
    height = original.shape[0]
    across = 3
    down = -(-len(tiles) // across)
    sheet = np.full(
        (down * (height + _CAPTION + _GAP) + _GAP, across * (width + _GAP) + _GAP), 255, np.uint8
    )
    places = []
    for i, (name, frame) in enumerate(tiles):
        x = _GAP + i % across * (width + _GAP)
        y = _GAP + i // across * (height + _CAPTION + _GAP)
        sheet[y : y + height, x : x + width] = frame.preview()
        places.append((x, y + height, name))
    image = Image.fromarray(sheet)
    draw = ImageDraw.Draw(image)
    for x, y, name in places:
        draw.text((x, y + 3), name, fill=0)
    file = io.BytesIO()
    image.save(file, "PNG")
    return file.getvalue()
