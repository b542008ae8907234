"""``halftone plan``: which stages a scene takes on a device, which are left out, and why."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from halftone.cli.render import Ready

__all__ = ["arguments", "run"]


def arguments(parser: argparse.ArgumentParser) -> None:
    from halftone.cli.render import of_scene

    parser.add_argument("scene", metavar="SCENE", help="a scene.toml, or a bare mesh: .obj, .ply")
    of_scene(parser)
    parser.add_argument("-m", "--method", help="a method (halftone list methods)")
    parser.add_argument("--json", action="store_true", help="as JSON")


def run(options: argparse.Namespace) -> int:
    from halftone.cli.render import prepared
    from halftone.scene.load import named
    from halftone.scene.render import Renderer

    ready = prepared(options)
    with named(options.scene):
        renderer = Renderer(ready.scene)
    found = renderer.plan(ready.target, shading=options.shading, samples=options.samples)
    rows: list[dict[str, Any]] = [{"stage": "size", "used": True, "why": why} for why in ready.reasons]
    for name, used, why in found.stages:
        if name == "projection":  # its why is that of the size, which stands above
            why = why.removesuffix(f": {ready.target.why}")
        rows.append({"stage": name, "used": used, "why": why})
    rows += _display(ready)
    if options.json:
        import json

        report = {"scene": options.scene, "width": ready.width, "height": ready.height, "stages": rows}
        print(json.dumps(report, indent=1, ensure_ascii=False))
        return 0
    wide = max(len(row["stage"]) for row in rows)
    for row in rows:
        print(f"{'used' if row['used'] else 'left out':9} {row['stage']:{wide}}  {row['why']}")
    return 0


def _display(ready: Ready) -> list[dict[str, Any]]:
    """What comes after the renderer."""
    recipe = ready.recipe
    fits = ready.height == recipe.height
    why = "rendered at the size of the device" if fits else "the device's dots are not square"
    return [
        {"stage": "8-bit codes", "used": False, "why": "float32 radiance goes straight to the levels"},
        {"stage": "resize", "used": not fits, "why": why},
        {
            "stage": "dither",
            "used": True,
            "why": f"{recipe._method.text()} on {len(recipe.ladder)} levels",
        },
    ]
