"""``halftone convert``: pictures in, what the device can show out."""

# pathlib takes 4 ms to import, which a small picture would notice.
# ruff: noqa: PTH103, PTH112, PTH118, PTH119, PTH121, PTH122
from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

__all__ = ["arguments", "run"]


def arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add(
        "paths",
        nargs="+",
        metavar="IN... OUT",
        help="picture files, or - for stdin; then a file (.png .pbm .pgm .tiff .raw), a folder, or -",
    )
    group = parser.add_argument_group("what the device can show")
    add = group.add_argument
    add(
        "-d",
        "--device",
        metavar="NAME",
        help="a device profile (halftone list devices) or .toml file",
    )
    add("-l", "--levels", help="N, uniform-linear:N, lstar:N, log:I0:N, or luminances Y0,Y1,…")
    add("--gamma", help="response of the device, for a count of levels: 2.2, srgb, … (default srgb)")
    add("--size", metavar="WxH", help="size in dots; Wx or xH keeps the shape")
    add("--width", type=int, metavar="W", help="width in dots; the height follows")
    add("--fit", choices=("contain", "cover", "stretch"), help="with --size WxH")
    group = parser.add_argument_group("how it is halftoned")
    add = group.add_argument
    add("-m", "--method", help="a method (halftone list methods); default floyd-steinberg")
    add("--content", metavar="C", help="text, graphic or photo: the method that suits it")
    add("--strength", type=float, metavar="S", help="0 (nearest level) … 1 (full)")
    add("--serpentine", action="store_true", default=None, help="scan odd rows backwards")
    add("--raster", dest="serpentine", action="store_false", help="scan all rows forwards")
    add("--seed", type=int, metavar="N", help="for methods that draw random numbers")
    add(
        "--range",
        default="clip",
        metavar="RULE",
        help="light beyond the levels: clip, scale, compress",
    )
    group = parser.add_argument_group("the picture")
    add = group.add_argument
    add("--encoding", metavar="E", help="what its codes mean: srgb, bt709, gamma:G, linear")
    add("--brightness", type=float, default=0.0, metavar="B", help="-1 … 1")
    add("--contrast", type=float, default=0.0, metavar="C", help="-1 … 1")
    add("--auto-levels", action="store_true", help="darkest and lightest 0.5 %% to black and white")
    add("--invert", action="store_true", help="white less the light")
    add(
        "--background",
        default="white",
        help="under transparent pixels: white, black, or light 0 … 1",
    )
    add("--nonfinite", default="error", metavar="P", help="NaN and infinity: error, or clip")
    add(
        "--max-memory",
        type=_bytes,
        metavar="SIZE",
        help="refuse what takes more: 500M, 8G (default 4G)",
    )
    group = parser.add_argument_group("output")
    add = group.add_argument
    add("--format", metavar="F", help="png, pbm, pgm, tiff, raw; default: by OUT's ending, else png")
    add("--upscale", type=int, default=1, metavar="N", help="every pixel as N × N")
    add("--preview", action="store_true", help="write what the device will show, as an 8-bit PNG")
    add("--no-overwrite", action="store_true", help="refuse to replace a file")
    add("--json", action="store_true", help="say what was done, stage by stage, with seconds")
    add("-j", "--jobs", type=int, default=1, metavar="N", help="threads; 0 is one per processor")
    add("-q", "--quiet", action="store_true", help="no notes and no progress bar")


@dataclass
class _Task:
    source: str
    target: str


def run(options: argparse.Namespace) -> int:
    """Convert all inputs; a bad one is named and the others are still converted."""
    from halftone._parallel import count_workers
    from halftone.cli.console import interruptible, quiet_libraries
    from halftone.cli.progress import Bar
    from halftone.errors import UsageError

    if len(options.paths) < 2:
        raise UsageError(f"only '{options.paths[0]}' was named; give one or more IN, and OUT")
    *options.inputs, options.output = options.paths
    recipe = _recipe(options)
    tasks = _tasks(options)
    _check_levels(recipe, tasks, options)
    jobs = count_workers(options.jobs)
    with quiet_libraries(), Bar(len(tasks), shown=not options.quiet) as bar:
        results = interruptible(
            lambda: _all(tasks, jobs, lambda task: _one(task, options, recipe, bar), bar.stop), bar.stop
        )
    failed = [r for r in results if "error" in r]
    for result in results:
        for note in result.get("notes", []):
            if not options.quiet:
                print(f"halftone: {note}", file=sys.stderr)
    for result in failed:
        print(f"halftone: {result['error']}", file=sys.stderr)
    if options.json:
        import json

        stream = sys.stderr if options.output == "-" else sys.stdout
        print(json.dumps({"pictures": results, "failed": len(failed)}, indent=1), file=stream)
    return max((r["exit_code"] for r in failed), default=0)


def _check_levels(recipe: Any, tasks: list[_Task], options: argparse.Namespace) -> None:
    """Say before any work that a PBM cannot hold the levels."""
    from halftone.errors import UsageError
    from halftone.images.write import format_of

    if len(recipe.ladder) > 2 and not options.preview:
        for task in tasks:
            if format_of(task.target, options.format) == "pbm":
                raise UsageError(
                    f"PBM holds 2 levels and the device has {len(recipe.ladder)}; use PGM or PNG"
                )


def _all(
    tasks: list[_Task], jobs: int, work: Callable[[_Task], dict[str, Any]], stop: Callable[[], None]
) -> list[dict[str, Any]]:
    if jobs == 1 or len(tasks) == 1:
        return [work(task) for task in tasks]
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(jobs) as pool:
        try:
            return list(pool.map(work, tasks))
        except BaseException:
            stop()
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def _one(task: _Task, options: argparse.Namespace, recipe: Any, bar: Any) -> dict[str, Any]:
    from halftone.errors import HalftoneError

    result: dict[str, Any] = {"input": task.source, "output": task.target}
    start = time.perf_counter()
    try:
        bands = recipe.bands(task.source, bar.file(task.source))
        _write(bands, task, options, recipe.max_memory)
        result |= {
            "width": bands.shape[1],
            "height": bands.shape[0],
            "method": bands.method,
            "levels": [round(float(v), 7) for v in bands.levels.luminance],
            "seconds": round(time.perf_counter() - start, 6),
            **bands.report,
        }
    except HalftoneError as error:
        text = str(error)
        if task.source not in text and task.target not in text and task.source != "-":
            text = f"'{task.source}': {text}"
        result |= {"error": " ".join(text.split()), "exit_code": error.exit_code}
    bar.done(task.source)
    return result


def _write(bands: Any, task: _Task, options: argparse.Namespace, limit: int) -> None:
    from halftone.frame import UPSCALED
    from halftone.images.write import write
    from halftone.stages import check_memory

    factor = options.upscale
    large = bands.upscaled(factor)
    if factor > 1:
        height, width = large.shape
        held = min(height, max(factor, UPSCALED // width)) * width
        check_memory(3 * held, limit, f"every pixel as {factor} × {factor}")
    stages = bands.report["stages"]
    start, others = time.perf_counter(), sum(s["seconds"] for s in stages)
    size = write(
        large, task.target, options.format, overwrite=not options.no_overwrite, preview=options.preview
    )
    others -= sum(s["seconds"] for s in stages)
    spent = max(0.0, time.perf_counter() - start + others)
    stages.append({"stage": "write", "bytes": size, "seconds": round(spent, 6)})


def _recipe(options: argparse.Namespace) -> Any:
    """Everything but the picture, checked."""
    from halftone._arrays import whole
    from halftone.cli.console import profile
    from halftone.errors import UsageError
    from halftone.recipe import Recipe

    width, height = options.width, None
    if options.size is not None:
        from halftone.images.resize import parse_size

        if width is not None:
            raise UsageError("both --size and --width were given; give one")
        width, height = parse_size(options.size)
    whole("upscale", options.upscale, 1, 256)
    given: dict[str, Any] = {}
    if options.max_memory is not None:
        given["max_memory"] = options.max_memory
    return Recipe(
        profile=profile(options.device),
        method=options.method,
        content=options.content,
        levels=options.levels,
        width=width,
        height=height,
        fit=options.fit,
        encoding=options.encoding,
        gamma=options.gamma,
        brightness=options.brightness,
        contrast=options.contrast,
        auto_levels=options.auto_levels,
        invert=options.invert,
        background=options.background,
        range=options.range,
        nonfinite=options.nonfinite,
        serpentine=options.serpentine,
        strength=options.strength,
        seed=options.seed,
        workers=options.jobs if len(options.inputs) == 1 else 1,
        **given,
    )


def _tasks(options: argparse.Namespace) -> list[_Task]:
    """Input and output paths; everything that is wrong with them is said before any work."""
    from halftone.errors import OutputError, UsageError
    from halftone.images.write import format_of

    inputs, output = options.inputs, options.output
    to_folder = len(inputs) > 1 or output.endswith("/") or os.path.isdir(output)
    if options.preview:
        kind = format_of(output if not to_folder else "x.png", options.format)
        if kind != "png":
            raise UsageError(f"a preview is a PNG, not {kind}; name OUT.png or leave --format out")
    if not to_folder:
        format_of(output, options.format)
        if output != "-" and inputs[0] != "-" and _same(inputs[0], output):
            raise UsageError(f"'{output}' is the input itself; name another output")
        return [_Task(inputs[0], output)]
    if output == "-":
        raise UsageError(f"{len(inputs)} inputs cannot go to stdout; name a folder")
    ending = format_of("-", options.format)
    tasks = [_Task(name, os.path.join(output, f"{_stem(name)}.{ending}")) for name in inputs]
    seen: dict[str, str] = {}
    for task in tasks:
        if task.target in seen:
            raise UsageError(
                f"'{seen[task.target]}' and '{task.source}' would both become '{task.target}'"
            )
        if task.source != "-" and _same(task.source, task.target):
            raise UsageError(f"'{task.target}' is an input itself; name another folder")
        seen[task.target] = task.source
    try:
        os.makedirs(output, exist_ok=True)
    except OSError as error:
        raise OutputError(f"the folder '{output}' cannot be made: {error.strerror}") from None
    return tasks


def _stem(name: str) -> str:
    return "stdin" if name == "-" else os.path.splitext(os.path.basename(name))[0]


def _same(first: str, second: str) -> bool:
    try:
        return os.path.samefile(first, second)
    except OSError:
        return False


def _bytes(text: str) -> int:
    """A size as 500M or 8G; plain numbers are MiB."""
    units = {"K": 10, "M": 20, "G": 30}
    number, unit = (text[:-1], text[-1].upper()) if text[-1:].isalpha() else (text, "M")
    try:
        size = int(float(number) * (1 << units[unit]))
    except (ValueError, KeyError, OverflowError):
        raise argparse.ArgumentTypeError(f"'{text}' is not a size; allowed: 500M, 8G") from None
    if size < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is not above 0")
    return size
