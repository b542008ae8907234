"""Frames to files of every format, band by band."""

# pathlib takes 4 ms to import, which a small picture would notice.
# ruff: noqa: PTH122
from __future__ import annotations

import io
import os
from collections.abc import Callable
from typing import TYPE_CHECKING

from halftone.errors import UsageError
from halftone.images.output import Output, output

if TYPE_CHECKING:
    from pathlib import Path

    from halftone.frame import Bands, Frame

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
    suffix = os.path.splitext(path)[1]
    ending = suffix.lower().lstrip(".")
    if ending not in ENDINGS:
        raise UsageError(
            f"'{path}' ends in '{suffix}', which cannot be written; allowed: "
            f".{', .'.join(ENDINGS)}, or --format {'|'.join(FORMATS)}"
            + (" (JPEG and other lossy formats would smear the dots)" if ending else "")
        )
    return ENDINGS[ending]


def encode(frame: Frame, format: str) -> bytes:
    """The bytes of a file in one of :data:`FORMATS`."""
    file = io.BytesIO()
    _writer(format)(frame.bands(), file)
    return file.getvalue()


def write(
    bands: Bands,
    path: str | Path,
    format: str | None = None,
    *,
    overwrite: bool = True,
    preview: bool = False,
) -> int:
    """Write level indices to *path* (``-`` is stdout), band by band; returns the number of bytes.

    preview : as an 8-bit gray PNG of what the device shows.
    """
    kind = format_of(path, format)
    writer = _writer("preview" if preview else kind)
    with output(path, overwrite=overwrite, seeks=kind == "tiff") as file:
        writer(bands, file)
    return file.size


def write_bytes(data: bytes, path: str | Path, *, overwrite: bool = True) -> None:
    """Write *data* to *path*, or to stdout for ``-``."""
    with output(path, overwrite=overwrite) as file:
        file.write(data)


def _writer(format: str) -> Callable[[Bands, Output], None]:
    if format in ("png", "preview"):
        from halftone.images import png

        return png.write if format == "png" else png.write_preview
    if format == "tiff":
        from halftone.images import tiff

        return tiff.write
    if format == "raw":
        return _write_raw
    from halftone.images import pnm

    return pnm.write_pbm if format == "pbm" else pnm.write_pgm


def _write_raw(bands: Bands, file: Output) -> None:
    for part in bands:
        file.write(part.packed().data)
