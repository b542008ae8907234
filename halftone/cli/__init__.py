"""The command ``halftone``. Each subcommand is a module, loaded when it is run."""

from __future__ import annotations

import argparse
import errno
import gc
import io
import os
import re
import sys
import warnings
from collections.abc import Sequence
from typing import NoReturn

__all__ = ["main"]

_COMMANDS = {
    "convert": "pictures to what a device can show, as PNG, PBM, PGM, TIFF or packed bytes",
    "preview": "the picture asked for, the dots sent and what would be seen, side by side",
    "print": "pictures to a printer, or to what it would get",
    "render": "a scene, or a bare mesh, straight to what a device can show",
    "plan": "which stages rendering a scene takes, which it leaves out, and why",
    "demo": "one strip: a photograph and what five limited devices show of it",
    "list": "methods, devices, encodings and level ladders",
    "decode": "the bytes of a print job back to pictures",
    "calibrate": "a printer's tone: print a step chart, read it, keep what it says",
    "devices": "printers that are there: list, info, languages, status, doctor",
    "cache": "the compiled kernels kept for this user: warm, info, clear",
}

_MODULES = {"list": "listing", "print": "printing"}  # a module's name must not hide a built-in one


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: error: {message} (see {self.prog} --help)\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command with *argv* and return its exit code."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # no BLAS here: its threads only cost time
    gc.set_threshold(100_000)  # imports make many objects and no garbage
    code = _outcome(list(sys.argv[1:] if argv is None else argv))
    if argv is None:  # as a program: without taking down the libraries, which takes 10 ms
        sys.stderr.flush()
        os._exit(code)
    return code


def _outcome(arguments: list[str]) -> int:
    from halftone.cli.console import interrupted, listen

    try:
        listen()
        _prepare_streams()
        code = _run(arguments)
        if sys.stdout is not None:
            sys.stdout.flush()
        return code
    except KeyboardInterrupt:
        return _fail("interrupted", 130)
    except BrokenPipeError:
        _drop_stdout()
        return 1
    except MemoryError:
        return _fail("out of memory: lower --max-memory refuses such a picture before it is read", 1)
    except Exception as error:
        if interrupted():
            return _fail("interrupted", 130)
        from halftone.errors import HalftoneError

        if isinstance(error, HalftoneError):
            return _fail(str(error), error.exit_code)
        if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EIO):
            _drop_stdout()
            return _fail(f"stdout cannot be written: {error.strerror}", 1)
        if os.environ.get("HALFTONE_TRACEBACK"):
            raise
        what = f"{type(error).__name__}: {error}".splitlines()[0]
        return _fail(f"internal error, {what} (HALFTONE_TRACEBACK=1 shows where)", 1)


def _run(arguments: list[str]) -> int:
    from importlib import import_module

    command = next((a for a in arguments if not a.startswith("-")), None)
    parser = _Parser(
        prog="halftone",
        description="Halftoning for devices that can show only a few intensities.",
        epilog="Exit codes: 0 ok, 1 other, 2 usage, 3 input file, 4 no device, 5 device fault, "
        "6 measured error too large, 130 interrupted.",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=_version())
    subparsers = parser.add_subparsers(
        dest="command", metavar="COMMAND", parser_class=_Parser, prog="halftone"
    )
    for name, purpose in _COMMANDS.items():
        sub = subparsers.add_parser(name, help=purpose, description=purpose, allow_abbrev=False)
        sub._negative_number_matcher = re.compile(r"^-(\d|\.\d|inf)")  # -1e-1 is a number too
        if name == command:  # only the one that is run says what it takes
            module = import_module(f"halftone.cli.{_MODULES.get(name, name)}")
            module.arguments(sub)
            sub.set_defaults(run=module.run)
    options, unknown = parser.parse_known_args(arguments)
    if hasattr(options, "paths"):  # argparse stops collecting them at the first option
        options.paths += [text for text in unknown if text == "-" or not text.startswith("-")]
        unknown = [text for text in unknown if text != "-" and text.startswith("-")]
    if unknown:
        _refuse(unknown, subparsers.choices[options.command] if options.command else parser)
    if options.command is None:
        parser.print_help()
        return 0
    return int(options.run(options))


def _refuse(unknown: list[str], parser: argparse.ArgumentParser) -> NoReturn:
    from difflib import get_close_matches

    known = [text for action in parser._actions for text in action.option_strings]
    close = get_close_matches(unknown[0].partition("=")[0], known, n=2)
    hint = f". Did you mean {' or '.join(close)}?" if close else ""
    parser.error(f"unrecognized arguments: {' '.join(unknown)}{hint}")


def _prepare_streams() -> None:
    """A stream that is closed, or a terminal that knows ASCII only, is no reason to fail."""
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the free number, so that no file of ours does
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115 (as long as the process)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    warnings.showwarning = _show_warning


def _drop_stdout() -> None:
    """What waits in stdout's buffer cannot be written: the interpreter must not try at exit."""
    if sys.stdout is not None:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _show_warning(message: Warning | str, *_: object, **__: object) -> None:
    print(f"halftone: note: {' '.join(str(message).split())}", file=sys.stderr)


def _version() -> str:
    from halftone import __version__

    return f"halftone {__version__}"


def _fail(message: str, code: int) -> int:
    line = " ".join(message.split())
    print(f"halftone: {line}", file=sys.stderr)
    return code
