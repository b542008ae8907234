"""``halftone list``: what there is, with claims and sources."""

from __future__ import annotations

import argparse
from typing import Any

from halftone.errors import UsageError

__all__ = ["arguments", "run", "show_table"]

_WHAT = ("methods", "devices", "screens", "encodings", "levels")


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("what", choices=_WHAT, metavar="|".join(_WHAT))
    parser.add_argument("--dpi", type=float, metavar="D", help="of the device, for screens (203)")
    parser.add_argument("--json", action="store_true", help="as JSON")


def run(options: argparse.Namespace) -> int:
    if options.dpi is not None and options.what != "screens":
        raise UsageError(f"--dpi does not apply to list {options.what}; it goes with list screens")
    rows = _screens(options.dpi) if options.what == "screens" else _TABLES[options.what]()
    if options.json:
        import json

        print(json.dumps(rows, indent=1, ensure_ascii=False))
        return 0
    show_table(rows)
    return 0


def show_table(rows: list[dict[str, Any]]) -> None:
    """Rows with the same keys, under their keys."""
    table = [list(rows[0]), *([str(v) for v in row.values()] for row in rows)]
    widths = [max(len(line[c]) for line in table) for c in range(len(table[0]))]
    for line in table:
        print("  ".join(v.ljust(w) for v, w in zip(line, widths, strict=True)).rstrip())


def _screens(dpi: float | None) -> list[dict[str, Any]]:
    """Which rulings a device can show with how many tones, at 45°."""
    from halftone.screens.clustered import rulings

    given = 203.2 if dpi is None else dpi
    rows = [
        {
            "lpi": f"{row.lpi:g}",
            "pixels a cell": f"{row.pixels:.1f}",
            "tones": row.tones,
            "with supercells": row.supercell_tones,
            "method": f"screen:round@45:{row.lpi:g}lpi",
        }
        for row in rulings(given)
    ]
    if not rows:
        raise UsageError(f"{given:g} dpi can show no customary ruling; allowed: about 40 … 12,000")
    return rows


def _methods() -> list[dict[str, Any]]:
    from halftone.dithering.registry import ALIASES, methods

    return [
        {
            "method": name,
            "tone": str(method.claim),
            "runs on": method.needs,
            "also": " ".join(a for a, n in ALIASES.items() if n == name and ":" not in a),
            "source": method.source,
        }
        for name, method in methods().items()
    ]


def _devices() -> list[dict[str, Any]]:
    from halftone.cli.console import our_devices

    profile = our_devices()
    rows = []
    for name in profile.names():
        made = profile.load(name)
        size = f"{made.width or 'any'} × {made.height or 'any'}"
        dpi = "—" if made.dpi is None else f"{made.dpi[0]:g}"
        rows.append(
            {
                "device": name,
                "dots": size,
                "dpi": dpi,
                "levels": len(made.levels),
                "bits": made.bits,
                "language": made.language or "—",
                "title": made.title,
            }
        )
    return rows


def _encodings() -> list[dict[str, Any]]:
    return [
        {"encoding": "srgb", "meaning": "IEC 61966-2-1, the default for integer codes"},
        {"encoding": "bt709", "meaning": "ITU-R BT.709, as PNM files are by their specification"},
        {"encoding": "gamma:G", "meaning": "light = code^G, as gamma:2.2"},
        {"encoding": "linear", "meaning": "the codes are light, the default for floats"},
    ]


def _levels() -> list[dict[str, Any]]:
    return [
        {"levels": "N", "meaning": "N evenly spaced codes of sRGB, or of --gamma"},
        {"levels": "uniform-linear:N", "meaning": "equal differences of light"},
        {"levels": "lstar:N", "meaning": "equal steps of CIE L*"},
        {
            "levels": "log:I0:N",
            "meaning": "equal ratios from black I0 to 1, I0 usually 0.005 … 0.025",
        },
        {"levels": "Y0,Y1,…", "meaning": "measured luminances, darkest first, 1 = white"},
    ]


_TABLES = {
    "methods": _methods,
    "devices": _devices,
    "encodings": _encodings,
    "levels": _levels,
}
