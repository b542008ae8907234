"""``halftone preview``: the picture asked for, the dots sent and what would be seen, side by side."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING, Any

from halftone.cli.picture import recipe, recipe_arguments, same_file

if TYPE_CHECKING:
    from devices.preview import Preview

__all__ = ["arguments", "check_png", "run"]


def arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add(
        "paths",
        nargs="+",
        metavar="IN [OUT]",
        help="a picture file, or - for stdin; then OUT.png, or - for stdout; without OUT the terminal",
    )
    group = parser.add_argument_group("what is shown")
    add = group.add_argument
    add("--panel", default="all", metavar="P", help="asked, sent, seen or all (default)")
    add(
        "--scale",
        type=int,
        metavar="N",
        help="pixels a dot; default: as fit into 2000 pixels, 1 or more",
    )
    add(
        "--distance",
        type=float,
        metavar="CM",
        help="from which it is seen (default 30); 0 is a magnifying glass",
    )
    recipe_arguments(parser)
    group = parser.add_argument_group("output")
    add = group.add_argument
    add("--no-overwrite", action="store_true", help="refuse to replace a file")
    add("-j", "--jobs", type=int, default=1, metavar="N", help="threads; 0 is one per processor")
    add("-q", "--quiet", action="store_true", help="no notes and no progress bar")


def run(options: argparse.Namespace) -> int:
    """Show one picture."""
    from halftone.cli.console import interruptible, our_devices, quiet_libraries
    from halftone.cli.progress import Bar

    _check(options)
    our_devices()
    from devices.preview import DISTANCE, chosen, preview_of

    chosen(options.panel)
    made = recipe(options, sources=1)
    distance = DISTANCE if options.distance is None else options.distance
    source = options.paths[0]

    def work() -> Preview:
        preview = preview_of(made, source, distance, bar.file(source))
        if len(options.paths) > 1:
            _write(preview, options)
        return preview

    with quiet_libraries(), Bar(1, shown=not options.quiet) as bar:
        preview = interruptible(work, bar.stop)
        bar.done(source)
    if len(options.paths) == 1:
        _show(preview, options)
    if not options.quiet:
        _tell(preview, options)
    return 0


def check_png(path: str, format: str | None = None) -> None:
    """Refuse to write a preview as anything but a PNG."""
    from halftone.errors import UsageError
    from halftone.images.write import format_of

    kind = format_of(path, format)
    if kind != "png":
        raise UsageError(f"a preview is a PNG, not {kind}; name OUT.png or leave --format out")


def _check(options: argparse.Namespace) -> None:
    """All that is wrong with the paths is said before any work."""
    from halftone._arrays import whole
    from halftone.errors import UsageError

    if len(options.paths) > 2:
        raise UsageError(f"paths given: {len(options.paths)}; give IN, and OUT.png or nothing")
    if options.scale is not None:
        whole("scale", options.scale, 1, 256)
    if len(options.paths) == 1:
        if sys.stdout is None or not sys.stdout.isatty():
            raise UsageError("stdout is no terminal; name OUT.png, or - to write a PNG to stdout")
        if options.scale is not None:
            raise UsageError("--scale is for a PNG; a terminal shows as many pixels as it has cells")
        return
    source, target = options.paths
    check_png(target)
    if target != "-" and source != "-" and same_file(source, target):
        raise UsageError(f"'{target}' is the input itself; name another output")


def _write(preview: Preview, options: argparse.Namespace) -> None:
    from halftone.images.write import write

    picture = preview.bands(options.scale, options.panel)
    write(picture, options.paths[1], "png", overwrite=not options.no_overwrite)


def _show(preview: Preview, options: argparse.Namespace) -> None:
    from devices.preview import chosen
    from halftone.cli.terminal import columns_of_terminal, lines, shows_blocks

    dpi = preview.sent.dpi or (1.0, 1.0)
    pictures = [preview.light(name) for name in chosen(options.panel)]
    for line in lines(pictures, columns_of_terminal(), shows_blocks(), dpi[0] / dpi[1]):
        print(line)


def _tell(preview: Preview, options: argparse.Namespace) -> None:
    notes: list[Any] = list(preview.sent.report.get("notes", []))
    if options.distance and preview.sent.dpi is None:
        notes.append("nobody says how many dots an inch has: seen as sent, whatever the distance")
    for note in notes:
        print(f"halftone: {note}", file=sys.stderr)
