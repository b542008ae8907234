"""``halftone convert``: pictures in, what the device can show out."""

# pathlib takes 4 ms to import, which a small picture would notice.
# ruff: noqa: PTH103, PTH112, PTH118, PTH119, PTH122
from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from halftone.cli.picture import recipe, recipe_arguments, same_file

__all__ = ["arguments", "run"]


def arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add(
        "paths",
        nargs="+",
        metavar="IN... OUT",
        help="picture files, or - for stdin; then a file (.png .pbm .pgm .tiff .raw), a folder, or -",
    )
    recipe_arguments(parser)
    group = parser.add_argument_group("output")
    add = group.add_argument
    add("--format", metavar="F", help="png, pbm, pgm, tiff, raw; default: by OUT's ending, else png")
    add("--upscale", type=int, metavar="N", help="every pixel as N × N")
    add(
        "--preview",
        action="store_true",
        help="write a PNG of the picture asked for, the dots sent and what is seen, side by side, "
        "--upscale pixels a dot (halftone preview has more options)",
    )
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
    from halftone._arrays import whole
    from halftone._parallel import count_workers
    from halftone.cli.console import interruptible, our_devices, quiet_libraries
    from halftone.cli.progress import Bar
    from halftone.errors import UsageError

    if len(options.paths) < 2:
        raise UsageError(f"only '{options.paths[0]}' was named; give one or more IN, and OUT")
    *options.inputs, options.output = options.paths
    if options.upscale is not None:
        whole("upscale", options.upscale, 1, 256)
    if options.preview:
        our_devices()
    made = recipe(options, sources=len(options.inputs))
    tasks = _tasks(options)
    _check_levels(made, tasks, options)
    jobs = count_workers(options.jobs)
    with quiet_libraries(), Bar(len(tasks), shown=not options.quiet) as bar:
        results = interruptible(
            lambda: _all(tasks, jobs, lambda task: _one(task, options, made, bar), bar.stop), bar.stop
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
        work = _preview if options.preview else _convert
        bands = work(recipe, task, options, bar.file(task.source))
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


def _convert(recipe: Any, task: _Task, options: argparse.Namespace, progress: Any) -> Any:
    """What the device gets, written band by band; the bands, whose report is then complete."""
    from halftone.frame import UPSCALED
    from halftone.stages import check_memory

    bands = recipe.bands(task.source, progress)
    factor = options.upscale or 1
    large = bands.upscaled(factor)
    if factor > 1:
        height, width = large.shape
        held = min(height, max(factor, UPSCALED // width)) * width
        check_memory(3 * held, recipe.max_memory, f"every pixel as {factor} × {factor}")
    _write(large, task, options)
    return bands


def _preview(recipe: Any, task: _Task, options: argparse.Namespace, progress: Any) -> Any:
    """The picture asked for, the dots sent and what is seen; the dots."""
    from devices.preview import DISTANCE, preview_of

    preview = preview_of(recipe, task.source, DISTANCE, progress)
    _write(preview.bands(options.upscale), task, options)
    return preview.sent


def _write(bands: Any, task: _Task, options: argparse.Namespace) -> None:
    from halftone.images.write import write

    stages = bands.report["stages"]
    start, others = time.perf_counter(), sum(s["seconds"] for s in stages)
    size = write(bands, task.target, options.format, overwrite=not options.no_overwrite)
    others -= sum(s["seconds"] for s in stages)
    spent = max(0.0, time.perf_counter() - start + others)
    stages.append({"stage": "write", "bytes": size, "seconds": round(spent, 6)})


def _tasks(options: argparse.Namespace) -> list[_Task]:
    """Input and output paths; everything that is wrong with them is said before any work."""
    from halftone.cli.preview import check_png
    from halftone.errors import OutputError, UsageError
    from halftone.images.write import format_of

    inputs, output = options.inputs, options.output
    to_folder = len(inputs) > 1 or output.endswith("/") or os.path.isdir(output)
    if options.preview:
        check_png("-" if to_folder else output, options.format)
    if not to_folder:
        format_of(output, options.format)
        if output != "-" and inputs[0] != "-" and same_file(inputs[0], output):
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
        if task.source != "-" and same_file(task.source, task.target):
            raise UsageError(f"'{task.target}' is an input itself; name another folder")
        seen[task.target] = task.source
    try:
        os.makedirs(output, exist_ok=True)
    except OSError as error:
        raise OutputError(f"the folder '{output}' cannot be made: {error.strerror}") from None
    return tasks


def _stem(name: str) -> str:
    return "stdin" if name == "-" else os.path.splitext(os.path.basename(name))[0]
