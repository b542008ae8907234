"""``halftone render``: a scene straight to what the device can show, without an 8-bit stop."""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from halftone.recipe import Recipe
    from halftone.scene.model import Scene
    from halftone.scene.plan import Target

__all__ = ["Ready", "arguments", "of_scene", "prepared", "run"]

SHAPE = 3 / 4
"""Height over width of a picture of which nothing says its height."""

WIDTH = 512
"""Of a picture of which nothing says its size."""

ADJUSTING = (
    *("method", "strength", "serpentine", "seed"),
    *("range", "brightness", "contrast", "auto_levels", "invert"),
)
"""Options of :class:`halftone.recipe.Recipe` that have the same name here."""


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", metavar="SCENE", help="a scene.toml, or a bare mesh: .obj, .ply")
    parser.add_argument("output", metavar="OUT", help="a file (.png .pbm .pgm .tiff .raw), or -")
    of_scene(parser)
    group = parser.add_argument_group("how it is halftoned")
    add = group.add_argument
    add("-m", "--method", help="a method (halftone list methods); default floyd-steinberg")
    add("--strength", type=float, metavar="S", help="0 (nearest level) … 1 (full)")
    add("--serpentine", action="store_true", default=None, help="scan odd rows backwards")
    add("--raster", dest="serpentine", action="store_false", help="scan all rows forwards")
    add("--seed", type=int, metavar="N", help="for methods that draw random numbers")
    add("--range", default="clip", metavar="RULE", help="light beyond the levels: clip, scale, compress")
    add("--brightness", type=float, default=0.0, metavar="B", help="-1 … 1")
    add("--contrast", type=float, default=0.0, metavar="C", help="-1 … 1")
    add("--auto-levels", action="store_true", help="darkest and lightest 0.5 %% to black and white")
    add("--invert", action="store_true", help="white less the light")
    group = parser.add_argument_group("output")
    add = group.add_argument
    add("--format", metavar="F", help="png, pbm, pgm, tiff, raw; default: by OUT's ending, else png")
    add("--upscale", type=int, default=1, metavar="N", help="every pixel as N × N")
    add("--preview", action="store_true", help="write what the device will show, as an 8-bit PNG")
    add("--no-overwrite", action="store_true", help="refuse to replace a file")
    add("--json", action="store_true", help="say what was done, stage by stage, with seconds")
    add("-j", "--jobs", type=int, default=1, metavar="N", help="threads; 0 is one per processor")
    add("-q", "--quiet", action="store_true", help="no notes")


def of_scene(parser: argparse.ArgumentParser) -> None:
    """What ``render`` and ``plan`` both take."""
    group = parser.add_argument_group("the device and the picture")
    add = group.add_argument
    add("-d", "--device", metavar="NAME", help="a profile (halftone list devices) or .toml file")
    add("-l", "--levels", help="N, uniform-linear:N, lstar:N, log:I0:N, or luminances Y0,Y1,…")
    add("--gamma", help="response of the device, for a count of levels: 2.2, srgb, … (default srgb)")
    add("--size", metavar="WxH", help="in dots; the device's, and 4:3, where it is not said")
    add(
        "-s",
        "--shading",
        default="phong",
        metavar="S",
        help="flat, gouraud, phong or fast-phong; default phong",
    )
    add("--samples", type=int, default=1, metavar="N", help="N × N samples where edges are; default 1")


def run(options: argparse.Namespace) -> int:
    """Render, halftone and write one scene."""
    from halftone.cli.console import interruptible, quiet_libraries

    with quiet_libraries():
        result = interruptible(lambda: _rendered(options), lambda: None)
    if not options.quiet:
        for note in result["notes"]:
            print(f"halftone: {note}", file=sys.stderr)
    if options.json:
        import json

        stream = sys.stderr if options.output == "-" else sys.stdout
        print(json.dumps(result, indent=1, default=str), file=stream)
    return 0


@dataclass(frozen=True)
class Ready:
    """A scene and what becomes of it: checked, before any work.

    width, height : of the picture that is rendered, in square pixels. reasons : why this size.
    notes : what the scene's files have that was left out.
    """

    scene: Scene
    recipe: Recipe
    width: int
    height: int
    reasons: list[str]
    notes: list[str]

    @property
    def target(self) -> Target:
        """What the device makes of it, as far as rendering need know."""
        from halftone.scene.plan import Target

        if len(self.scene.ambient) != 3:
            return Target(self.width, self.height)
        levels = len(self.recipe.ladder)
        device = "bilevel device" if levels == 2 else f"device of {levels} grays"
        return Target(self.width, self.height, 1, f"{device}: luminance only")


def prepared(options: argparse.Namespace) -> Ready:
    """The scene of *options* and its recipe."""
    from halftone.scene.load import read_scene

    recipe, width, height, reasons = _recipe(options)
    dpi = None if recipe.profile is None else recipe.profile.dpi
    rows = height if dpi is None else max(1, round(height * dpi[0] / dpi[1]))
    scene, notes = read_scene(options.scene, width / rows)
    return Ready(scene, recipe, width, rows, reasons, notes)


def _rendered(options: argparse.Namespace) -> dict[str, Any]:
    from halftone.scene.load import named
    from halftone.scene.public import render
    from halftone.stages import check_memory

    start = time.perf_counter()
    _check_output(options)
    ready = prepared(options)
    pixel = 4 * max(options.samples, 1) ** 2 + 4 * len(ready.scene.ambient) + 8
    need = ready.width * ready.height * pixel
    check_memory(need, ready.recipe.max_memory, f"a picture of {ready.width} × {ready.height}")
    loaded = time.perf_counter()
    with named(options.scene):
        picture = render(
            ready.scene,
            ready.width,
            ready.height,
            shading=options.shading,
            samples=options.samples,
            workers=options.jobs,
            channels=ready.target.channels,
            why=ready.target.why,
        )
    bands = ready.recipe.bands(in_one(picture.radiance))
    size = _write(bands, options)
    report = bands.report
    stages = [{"stage": "read", "file": options.scene, "seconds": round(loaded - start, 6)}]
    for name, seconds in picture.report["seconds"].items():
        stages.append({"stage": name, "seconds": round(seconds, 6)})
    stages += [*report["stages"], {"stage": "write", "bytes": size}]
    left_out = [{"stage": name, "why": why} for name, why in picture.report["left_out"].items()]
    left_out += report["left_out"]
    return {
        "scene": options.scene,
        "output": options.output,
        "width": bands.shape[1],
        "height": bands.shape[0],
        "why": ready.reasons,
        "shading": options.shading,
        "method": bands.method,
        "levels": [round(float(v), 7) for v in bands.levels.luminance],
        "seconds": round(time.perf_counter() - start, 6),
        "stages": stages,
        "left_out": left_out,
        "counts": picture.report["counts"],
        "notes": [*ready.notes, *picture.report["notes"], *report["notes"]],
    }


def in_one(radiance: Any) -> Any:
    """Radiance as the display stage takes it: gray, or R, G, B; other channels in equal parts."""
    channels = radiance.shape[2]
    if channels == 1:
        return radiance[:, :, 0]
    return radiance if channels == 3 else radiance.mean(axis=2)


def _check_output(options: argparse.Namespace) -> None:
    from halftone._arrays import whole
    from halftone.errors import UsageError
    from halftone.images.write import format_of

    whole("upscale", options.upscale, 1, 256)
    kind = format_of(options.output, options.format)
    if options.preview and kind != "png":
        raise UsageError(f"a preview is a PNG, not {kind}; name OUT.png or leave --format out")


def _write(bands: Any, options: argparse.Namespace) -> int:
    from halftone.errors import UsageError
    from halftone.images.write import format_of, write

    count = len(bands.levels)
    if count > 2 and not options.preview and format_of(options.output, options.format) == "pbm":
        raise UsageError(f"PBM holds 2 levels and the device has {count}; use PGM or PNG")
    return write(
        bands.upscaled(options.upscale),
        options.output,
        options.format,
        overwrite=not options.no_overwrite,
        preview=options.preview,
    )


def _recipe(options: argparse.Namespace) -> tuple[Recipe, int, int, list[str]]:
    """(recipe, width, height in dots, why)."""
    from halftone.cli.console import profile as find_profile
    from halftone.images.resize import parse_size
    from halftone.recipe import Recipe

    profile = find_profile(options.device)
    width, height = (None, None) if options.size is None else parse_size(options.size)
    why = []
    if width is None and height is None and profile is not None:
        width, height = profile.width, profile.height
        if width is not None:
            why.append(f"{width} dots wide: rendered at {width}")
    aspect = 1.0 if profile is None or profile.dpi is None else profile.dpi[1] / profile.dpi[0]
    if width is None:
        width = WIDTH if height is None else max(1, round(height / SHAPE / aspect))
    if height is None:
        height = max(1, round(width * SHAPE * aspect))
        why.append(f"no height is given: 4:3, {height} dots")
    given = {name: getattr(options, name) for name in ADJUSTING if hasattr(options, name)}
    recipe = Recipe(
        profile=profile,
        levels=options.levels,
        gamma=options.gamma,
        width=width,
        height=height,
        fit="stretch",
        workers=getattr(options, "jobs", 1),
        **given,
    )
    return recipe, width, height, why
