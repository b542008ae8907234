"""``halftone print``: pictures to a printer, or to what the printer would get."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any, cast

from halftone.cli.console import Flag
from halftone.cli.picture import recipe, recipe_arguments, same_file
from halftone.errors import UsageError

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
        help="how long to wait for paper, or a cover to be closed (default 600; below 0: for ever)",
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

    our_devices()
    if options.device is None:
        raise UsageError("which device? Give --device NAME (halftone list devices)")
    if options.to is None and options.dry_run is None and options.dump is None:
        raise UsageError(
            "where to? Give --to URI (halftone devices list shows what is there), "
            "or --dry-run OUT.png to see what it would print"
        )
    _check_places(options)
    made = recipe(options, sources=1)
    with quiet_libraries(), Bar(1, shown=not options.quiet) as bar:
        return _print(options, made, bar)


def _check_places(options: argparse.Namespace) -> None:
    """All that is wrong with the inputs and outputs is said before any work."""
    from devices.transports.base import Uri
    from halftone.errors import InputFileError
    from halftone.images.write import format_of

    to = None if options.to is None else Uri.parse(options.to)
    if options.dry_run is not None:
        format_of(options.dry_run)
        if to is not None and to.scheme != "mem":
            raise UsageError("both --to and --dry-run were given; a dry run goes nowhere")
    if options.paths.count("-") > 1:
        raise UsageError("stdin can be read once, and - was given twice")
    file = to.path if to is not None and to.scheme == "file" else None
    given = {"--to": file, "--dump": options.dump, "--dry-run": options.dry_run}
    outputs = [(name, path) for name, path in given.items() if path is not None]
    for number, (name, path) in enumerate(outputs):
        for other, second in outputs[:number]:
            if path == second or same_file(path, second):
                raise UsageError(f"{other} and {name} would both write '{path}'")
        if any(same_file(path, source) for source in options.paths if source != "-"):
            raise UsageError(f"'{path}' is an input itself; name another output for {name}")
    for path in options.paths:
        if path != "-" and len(options.paths) > 1 and not os.path.exists(path):  # noqa: PTH110
            raise InputFileError(f"'{path}' cannot be read: there is no such file")


def _print(options: argparse.Namespace, made: Any, bar: Any) -> int:
    from devices.registry import open_device
    from devices.sending import Patience
    from halftone.cli.console import interrupted
    from halftone.errors import HalftoneError

    names = options.paths
    patience = Patience(options.timeout, None if options.wait < 0 else options.wait)
    extra = _options(options.option)
    failed: HalftoneError | None = None
    with _dump(options) as dump:
        device = open_device(_uri(options, made.profile), made.profile, options=extra, patience=patience)
        device.record = dump
        progress = bar.file(names[0] if len(names) == 1 else f"{len(names)} pictures")
        cancelled = Flag()
        try:
            with device:
                _patiently(lambda: _job(device, made, options, progress, cancelled), cancelled)
            if options.dry_run is not None and not device.report.cancelled:
                from halftone.cli.decode import save_pages

                data = cast("Any", device.transport).data
                save_pages(device.language.decode(data, made.max_memory // 2), options.dry_run)
        except HalftoneError as error:
            failed = error
    report = device.report
    bar.done(names[0])
    if failed is None or report.bytes_accepted:
        _tell(report, options)
    if failed is not None and interrupted():
        _say(str(failed))
    if failed is not None:
        raise failed
    if report.cancelled:
        raise KeyboardInterrupt
    return 0


def _uri(options: argparse.Namespace, profile: Any) -> str:
    """Where the bytes go: without --to to the file of --dump, or for a dry run to memory."""
    from urllib.parse import quote

    if options.to is not None:
        return str(options.to)
    own = f"{profile.language}+" if profile.language else ""
    return f"{own}mem:" if options.dry_run is not None else f"{own}file:{quote(options.dump)}"


def _job(device: Any, made: Any, options: argparse.Namespace, progress: Any, cancelled: Any) -> None:
    """Print everything; a picture is opened when its turn comes, and again for each copy."""
    if options.copies > 1 and "-" in options.paths and not device.language.native_copies:
        raise UsageError(
            f"stdin can be read once, and {device.language.name} has no copies: name a file"
        )
    stages: list[dict[str, Any]] = []

    def bands(path: str) -> Any:
        given = made.bands(path)
        stages.append(given.report)
        return given

    try:
        _send(device, options, bands, progress, cancelled)
    finally:
        device.report.pictures += stages


def _send(
    device: Any, options: argparse.Namespace, bands: Callable[[str], Any], progress: Any, cancelled: Any
) -> None:
    device.print(
        *(partial(bands, path) for path in options.paths),
        copies=options.copies,
        density=options.density,
        cut=options.cut,
        progress=progress,
        cancel=cancelled.is_set,
        notify=lambda status: None if options.quiet else _say(f"the device: {status}"),
    )


def _tell(report: Any, options: argparse.Namespace) -> None:
    notes = dict.fromkeys(note for picture in report.pictures for note in picture.get("notes", []))
    if not options.quiet:
        for note in notes:
            _say(note)
    if options.json:
        import dataclasses
        import json

        fields = dataclasses.asdict(report) | {"reasons": sorted(report.reasons)}
        stdout = "-" in (options.dump, options.dry_run) or (options.to or "").endswith("file:-")
        print(json.dumps(fields, indent=1), file=sys.stderr if stdout else sys.stdout)
    elif not options.quiet:
        _say(f"{report}" + (f" to {options.to}" if options.to else ""))


def _patiently(job: Callable[[], None], cancelled: Flag) -> None:
    """job(), which Ctrl-C and SIGTERM ask to complete its open command and to end; a second Ctrl-C ends
    it at once."""
    from halftone.cli.console import interrupted

    failed: list[BaseException] = []
    ended = threading.Event()  # an interrupted join takes the thread for ended (CPython's issue 90882)

    def work() -> None:
        try:
            job()
        except BaseException as error:
            failed.append(error)
        finally:
            ended.set()

    signal.signal(signal.SIGTERM, lambda *_: cancelled.set())
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


@contextmanager
def _dump(options: argparse.Namespace) -> Iterator[Callable[[bytes], Any] | None]:
    """What keeps the bytes that go elsewhere; None where there is nothing to keep."""
    if options.dump is None or (options.to is None and options.dry_run is None):
        yield None
        return
    from halftone.images.output import output

    with output(options.dump) as file:
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


def _say(text: str) -> None:
    print(f"halftone: {text}", file=sys.stderr)
