"""Frames to files: whole or not at all."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path

from halftone.errors import OutputError, UsageError
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
    if not overwrite and target.exists():
        raise _exists(target)
    if target.exists() and not target.is_file():
        _to_special(data, target)
        return
    temporary = target.with_name(f".{target.name[:200]}.{os.getpid()}.part")
    try:
        with open(temporary, "wb") as file:
            file.write(data)
        if overwrite:
            os.replace(temporary, target)
        else:
            os.link(temporary, target)
    except FileExistsError:
        raise _exists(target) from None
    except OSError as error:
        raise OutputError(f"'{target}' cannot be written: {_reason(error)}") from None
    finally:
        temporary.unlink(missing_ok=True) if temporary.parent.is_dir() else None


def _to_stdout(data: bytes) -> None:
    try:
        sys.stdout.buffer.write(data)
        sys.stdout.buffer.flush()
    except BrokenPipeError:
        # The reader went away: nothing is left to say, not even at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise
    except OSError as error:
        raise OutputError(f"stdout cannot be written: {_reason(error)}") from None


def _to_special(data: bytes, target: Path) -> None:
    """A device or a pipe takes the bytes directly."""
    try:
        with open(target, "wb") as file:
            file.write(data)
    except OSError as error:
        raise OutputError(f"'{target}' cannot be written: {_reason(error)}") from None


def _exists(target: Path) -> OutputError:
    return OutputError(f"'{target}' exists and --no-overwrite was given; nothing was written")


def _reason(error: OSError) -> str:
    return error.strerror or str(error)
