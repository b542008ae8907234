"""What a page says of itself in the headers of PWG raster and CUPS raster."""

from __future__ import annotations

from typing import Any

from devices.languages.base import INK, Page
from devices.languages.raster_start import MOST
from halftone.errors import UsageError
from halftone.packing import Packing, bytes_per_row
from halftone.tone.levels import Levels

__all__ = ["SW", "K", "gray_packing", "header_of", "whole_dpi"]

K, SW = 3, 18
"""Black ink, 1 bit; sRGB's gray, 8 bits."""
AFTER_PAGE = 4
"""When the paper is cut."""


def gray_packing(name: str, levels: Levels) -> Packing:
    """A byte a pixel: the sRGB code of what its level shows. Raises UsageError where two are one."""
    codes = tuple(int(code) for code in levels.srgb())
    if len(set(codes)) < len(codes):
        twice = next(code for k, code in enumerate(codes) if code in codes[:k])
        raise UsageError(
            f"{name} tells levels apart by their 8-bit sRGB code, and two of these have {twice}: "
            f"{levels.text}. Leave one of them out"
        )
    return Packing(8, "msb", codes)


def whole_dpi(name: str, page: Page) -> tuple[int, int]:
    """Dots per inch as headers give them. Raises UsageError for none, and for a page too long."""
    if page.dpi is None:
        raise UsageError(f"{name} states how many dots an inch has; give the picture a dpi")
    x, y = (round(d) for d in page.dpi)
    if not (1 <= x < 1 << 31 and 1 <= y < 1 << 31):
        raise UsageError(f"{name}: {page.dpi[0]:g} × {page.dpi[1]:g} dpi; allowed: 1 and more")
    if page.height > MOST or page.width > MOST:
        raise UsageError(f"{name}: {page.width} × {page.height} dots; allowed: up to {MOST} each way")
    return x, y


def header_of(name: str, page: Page, packing: Packing) -> dict[str, Any]:
    """The fields that PWG raster and CUPS raster have in common."""
    if page.density is not None:
        raise UsageError(f"{name} knows no density")
    dpi = whole_dpi(name, page)
    points = tuple(
        max(1, round(72 * dots / d))
        for dots, d in zip((page.width, page.height), page.dpi or dpi, strict=True)
    )
    return {
        "HWResolution": dpi,
        "PageSize": points,
        "NumCopies": page.copies,
        "CutMedia": AFTER_PAGE if page.cut else 0,
        "cupsWidth": page.width,
        "cupsHeight": page.height,
        "cupsBitsPerColor": packing.bits,
        "cupsBitsPerPixel": packing.bits,
        "cupsBytesPerLine": bytes_per_row(page.width, packing.bits),
        "cupsColorSpace": K if packing == INK else SW,
        "cupsNumColors": 1,
    }
