"""Frames to files: whole or not at all."""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from halftone.errors import OutputError, UsageError

if TYPE_CHECKING:
    from halftone.frame import Frame

__all__ = ["FORMATS", "encode", "format_of", "write", "write_bytes"]

ENDINGS = {
    "png": "png",
    "pbm": "pbm",
    "pgm": "pgm",
    "tif": "tiff",
    "tiff": "tiff",
    "raw": "raw",
    "bin": "raw",
}
FORMATS = ("png", "pbm", "pgm", "tiff", "raw")


def format_of(path: str | Path, format: str | None = None) -> str:
    """The format to write: *format*, or what the ending of *path* says; PNG for ``-``."""
    if format is not None:
        name = ENDINGS.get(format.lower())
        if name is None:
            raise UsageError(f"format '{format}' cannot be written; allowed: {', '.join(FORMATS)}")
        return name
    if str(path) == "-":
        return "png"
    ending = Path(path).suffix.lower().lstrip(".")
    if ending not in ENDINGS:
        raise UsageError(
            f"'{path}' ends in '{Path(path).suffix}', which cannot be written; allowed: "
            f".{', .'.join(ENDINGS)}, or --format {'|'.join(FORMATS)}"
            + (" (JPEG and other lossy formats would smear the dots)" if ending else "")
        )
    return ENDINGS[ending]


def encode(frame: Frame, format: str) -> bytes:
    """The bytes of a file in one of :data:`FORMATS`."""
    if format == "raw":
        return frame.packed().tobytes()
    return _encoder(format)(frame)


def _encoder(format: str) -> Callable[[Frame], bytes]:
    if format == "png":
        from halftone.images import png

        return png.encode
    if format == "tiff":
        from halftone.images import tiff

        return tiff.encode
    from halftone.images import pnm

    return pnm.encode_pbm if format == "pbm" else pnm.encode_pgm


def write(frame: Frame, path: str | Path, format: str | None = None, *, overwrite: bool = True) -> int:
    """Write *frame* to *path* (``-`` is stdout); returns the number of bytes."""
    data = encode(frame, format_of(path, format))
    write_bytes(data, path, overwrite=overwrite)
    return len(data)


def write_bytes(data: bytes, path: str | Path, *, overwrite: bool = True) -> None:
    """Write *data* under a temporary name and rename it: *path* is never half a file."""
    if str(path) == "-":
        _to_stdout(data)
        return
    target = Path(path)
    temporary = None
    try:
        if target.exists():
            if not overwrite:
                raise FileExistsError
            if not target.is_file():  # a device or a pipe takes the bytes directly
                target.write_bytes(data)
                return
            target = target.resolve()  # what a link points to is replaced, not the link
        temporary = target.with_name(f".halftone-{os.urandom(6).hex()}.part")
        with open(temporary, "xb") as file:
            file.write(data)
        if target.exists():
            temporary.chmod(stat.S_IMODE(target.stat().st_mode))
        if overwrite:
            os.replace(temporary, target)
            temporary = None
        else:
            _link(temporary, target)
    except FileExistsError:
        what = f"'{target}' exists and --no-overwrite was given; nothing was written"
        raise OutputError(what) from None
    except OSError as error:
        raise OutputError(f"'{target}' cannot be written: {_reason(error)}") from None
    finally:
        if temporary is not None:
            with suppress(OSError):  # it may never have come to be
                temporary.unlink()


def _link(temporary: Path, target: Path) -> None:
    """Give the file its name unless there is one already, in one step where the disk can."""
    try:
        os.link(temporary, target)
    except FileExistsError:
        raise
    except OSError:  # FAT and some network disks know no links
        if target.exists():
            raise FileExistsError from None
        temporary.rename(target)


def _to_stdout(data: bytes) -> None:
    if sys.stdout is None:
        raise OutputError("stdout is closed: nothing can be written there")
    try:
        sys.stdout.buffer.write(data)
        sys.stdout.buffer.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OutputError(f"stdout cannot be written: {_reason(error)}") from None


def _reason(error: OSError) -> str:
    return error.strerror or str(error)
