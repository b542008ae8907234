"""``halftone decode``: the bytes of a print job back to pictures."""

from __future__ import annotations

import argparse
import os
import sys
from typing import Any

__all__ = ["arguments", "run", "save_pages"]


def arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("paths", nargs="+", metavar="BYTES OUT", help="a file of bytes, or -; then a picture, or -")
    add("--language", metavar="L", help="what it is in; default: found by its first bytes")
    add("--json", action="store_true", help="say what the bytes state, as JSON")


def run(options: argparse.Namespace) -> int:
    """Decode a stream; its first mistake is named with its offset."""
    from halftone.cli.console import our_devices
    from halftone.cli.picture import same_file
    from halftone.errors import UsageError
    from halftone.images.write import format_of

    if len(options.paths) != 2:
        raise UsageError(f"paths given: {len(options.paths)}; give BYTES and OUT")
    if same_file(options.paths[0], options.paths[1]):
        raise UsageError(f"'{options.paths[1]}' is the input itself; name another output")
    format_of(options.paths[1])
    our_devices()
    from devices.decoding import decode
    from devices.languages import detect

    data = _read(options.paths[0])
    name = options.language or (detect(data) if data else "")
    frames = decode(data, name or None)
    save_pages(frames, options.paths[1])
    if options.json:
        import json

        pages = [
            {
                "width": f.shape[1],
                "height": f.shape[0],
                "dpi": f.dpi,
                "levels": len(f.levels),
                **f.report,
            }
            for f in frames
        ]
        stream = sys.stderr if options.paths[1] == "-" else sys.stdout
        print(json.dumps({"language": name, "pages": pages}, indent=1, default=str), file=stream)
    return 0


def save_pages(frames: list[Any], path: str) -> int:
    """Write the only page to *path*, several to *path* with their numbers; how many there are."""
    from halftone.errors import InputFileError, UsageError

    if not frames:
        raise InputFileError("the bytes hold no page")
    if len(frames) > 1 and path == "-":
        raise UsageError(f"{len(frames)} pages cannot go to stdout; name a file")
    stem, ending = os.path.splitext(path)  # noqa: PTH122 (pathlib takes 4 ms to import)
    for number, frame in enumerate(frames, 1):
        frame.save(path if len(frames) == 1 else f"{stem}-{number:03d}{ending}")
    return len(frames)


def _read(path: str) -> bytes:
    from pathlib import Path

    from halftone.errors import InputFileError

    try:
        if path == "-":
            if sys.stdin is None:
                raise InputFileError("stdin is closed: nothing can be read there")
            return sys.stdin.buffer.read()
        return Path(path).read_bytes()
    except OSError as error:
        raise InputFileError(f"'{path}' cannot be read: {error.strerror or error}") from None
