"""``halftone print``: pictures to a printer, or to what the printer would get."""

from __future__ import annotations

import argparse
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

from halftone.cli.picture import recipe, recipe_arguments

__all__ = ["arguments", "run"]


def arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("paths", nargs="+", metavar="IN...", help="picture files, or - for stdin; a page each")
    group = parser.add_argument_group("where it goes")
    add = group.add_argument
    add(
        "--to",
        metavar="URI",
        help="usb://VENDOR:PRODUCT, usb://MAKE/MODEL, socket://HOST, file:PATH, serial:PATH; with a "
        "language in front if it is not the profile's: escpos+usb://04b8:0202",
    )
    add(
        "--dry-run",
        metavar="OUT",
        help="print nothing; write what the bytes say, read back strictly, as a picture",
    )
    add("--dump", metavar="FILE", help="write the bytes that the device accepts, or would")
    group = parser.add_argument_group("how it is printed")
    add = group.add_argument
    add("--copies", type=int, default=1, metavar="N")
    add("--density", type=int, metavar="N", help="how dark, in the device's own numbers")
    add("--cut", action=argparse.BooleanOptionalAction, help="cut the paper after each page")
    add(
        "-o",
        "--option",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="an option of the language (halftone devices languages)",
    )
    add(
        "--timeout", type=float, default=60.0, metavar="S", help="give up after S seconds without a byte"
    )
    add(
        "--wait",
        type=float,
        default=600.0,
        metavar="S",
        help="how long to wait for paper, or a cover to be closed (default 600)",
    )
    recipe_arguments(parser)
    group = parser.add_argument_group("output")
    add = group.add_argument
    add("--json", action="store_true", help="say what was printed, with all stages, as JSON")
    add("-j", "--jobs", type=int, default=1, metavar="N", help="threads; 0 is one per processor")
    add("-q", "--quiet", action="store_true", help="no notes and no progress bar")


def run(options: argparse.Namespace) -> int:
    """Print all pictures as one job."""
    from halftone.cli.console import our_devices, quiet_libraries
    from halftone.cli.progress import Bar
    from halftone.errors import UsageError

    our_devices()
    if options.device is None:
        raise UsageError("which device? Give --device NAME (halftone list devices)")
    if options.to is None and options.dry_run is None and options.dump is None:
        raise UsageError(
            "where to? Give --to URI (halftone devices list shows what is there), "
            "or --dry-run OUT.png to see what it would print"
        )
    if options.to is not None and options.dry_run is not None:
        raise UsageError("both --to and --dry-run were given; a dry run goes nowhere")
    if options.paths.count("-") > 1:
        raise UsageError("stdin can be read once, and - was given twice")
    if options.copies > 1 and "-" in options.paths:
        raise UsageError("stdin can be read once: print copies of a file")
    made = recipe(options, sources=1)
    with quiet_libraries(), Bar(1, shown=not options.quiet) as bar:
        return _print(options, made, bar)


def _print(options: argparse.Namespace, made: Any, bar: Any) -> int:
    from devices.registry import open_device
    from devices.sending import Patience
    from halftone.errors import HalftoneError

    names = options.paths
    uri = options.to or (f"{made.profile.language}+mem:" if made.profile.language else "mem:")
    patience = Patience(options.timeout, None if options.wait < 0 else options.wait)
    taken = bytearray()
    with _dump(options.dump) as dump:
        device = open_device(uri, made.profile, options=_options(options.option), patience=patience)
        device.record = taken.extend if options.dry_run is not None else dump
        progress = bar.file(names[0] if len(names) == 1 else f"{len(names)} pictures")
        cancelled = threading.Event()
        with device:
            report = _patiently(lambda: _job(device, made, options, progress, cancelled), cancelled)
        if options.dry_run is not None and not report.cancelled:
            from halftone.cli.decode import save_pages

            if dump is not None:
                dump(bytes(taken))
            save_pages(device.language.decode(bytes(taken)), options.dry_run)
    bar.done(names[0])
    _tell(report, options)
    if report.cancelled and not report.completed:
        raise HalftoneError("the device did not take the end of the command; switch it off and on")
    if report.cancelled:
        raise KeyboardInterrupt
    return 0


def _job(device: Any, made: Any, options: argparse.Namespace, progress: Any, cancelled: Any) -> Any:
    """Print everything; a picture is opened when its turn comes, and again for each copy."""
    stages: list[dict[str, Any]] = []

    def bands(path: str) -> Any:
        given = made.bands(path)
        stages.append(given.report)
        return given

    report = device.print(
        *(partial(bands, path) for path in options.paths),
        copies=options.copies,
        density=options.density,
        cut=options.cut,
        progress=progress,
        cancel=cancelled.is_set,
        notify=lambda status: None if options.quiet else _say(f"the device: {status}"),
    )
    report.pictures += stages
    return report


def _tell(report: Any, options: argparse.Namespace) -> None:
    notes = dict.fromkeys(note for picture in report.pictures for note in picture.get("notes", []))
    if not options.quiet:
        for note in notes:
            _say(note)
    if options.json:
        import dataclasses
        import json

        fields = dataclasses.asdict(report) | {"reasons": sorted(report.reasons)}
        print(json.dumps(fields, indent=1))
    elif not options.quiet:
        _say(f"{report}" + (f" to {options.to}" if options.to else ""))


def _patiently(job: Callable[[], Any], cancelled: threading.Event) -> Any:
    """job(), which Ctrl-C asks to complete its open command and to end; a second one ends it at once."""
    from halftone.cli.console import interrupted

    done: list[Any] = []
    failed: list[BaseException] = []
    ended = threading.Event()  # an interrupted join takes the thread for ended (CPython's issue 90882)

    def work() -> None:
        try:
            done.append(job())
        except BaseException as error:
            failed.append(error)
        finally:
            ended.set()

    try:
        threading.Thread(target=work, daemon=True).start()
        while not ended.wait(0.05):  # the signal may reach another thread, and not wake this
            if interrupted():
                raise KeyboardInterrupt
    except KeyboardInterrupt:
        cancelled.set()
        _say("stopping: the device is given the end of its command (Ctrl-C again leaves at once)")
        while not ended.wait(0.05):
            pass
    if failed:
        raise failed[0]
    return done[0]


@contextmanager
def _dump(path: str | None) -> Iterator[Callable[[bytes], Any] | None]:
    if path is None:
        yield None
        return
    from halftone.images.output import output

    with output(path) as file:
        yield file.write


def _options(texts: list[str]) -> dict[str, str]:
    from halftone.errors import UsageError

    found: dict[str, str] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not equals or not key:
            raise UsageError(f"-o {text}: allowed: KEY=VALUE")
        key = key.replace("-", "_")
        if key in found:
            raise UsageError(f"-o {key} was given twice")
        found[key] = value
    return found


def _read_back(device: Any, path: str | None) -> int:
    """Decode what a dry run sent, and write it; the number of pages."""
    if path is None:
        return 0
    from halftone.cli.decode import save_pages

    return save_pages(device.language.decode(device.transport.data), path)


def _say(text: str) -> None:
    print(f"halftone: {text}", file=sys.stderr)
