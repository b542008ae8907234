"""Picture files in: OpenImageIO's pixels as stored, with what their codes mean.

Everything that can go wrong is found before or while reading, in this order: no such file, not a
picture, no pixels, too large for the memory limit (from the header alone), damaged.
"""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from halftone.errors import InputFileError
from halftone.images.headers import declared_size, exact_pnm

__all__ = ["DEFAULT_LIMIT", "Picture", "read_picture"]

DEFAULT_LIMIT = 4 << 30
"""Bytes of memory that a picture may take unless the caller says otherwise."""

BYTES_PER_PIXEL = 12
"""Beside the stored pixels: light as float32, copies to resize it, and level indices."""

CHUNK = 1 << 20


@dataclass(frozen=True)
class Picture:
    """Pixels as stored, upright.

    pixels : (M, N) or (M, N, 3), integer codes or floats. alpha : (M, N) of the same type, or
    None. premultiplied : whether the pixels are already weighted by alpha, in light.
    encoding : what the codes mean, as the file says.
    """

    pixels: NDArray[Any]
    alpha: NDArray[Any] | None
    premultiplied: bool
    encoding: str
    name: str


def read_picture(path: str | Path, limit: int = DEFAULT_LIMIT) -> Picture:
    """Read the first image of a file, or of stdin for ``-``."""
    name = "stdin" if str(path) == "-" else f"'{path}'"
    with _opened(path, name, limit) as place:
        file = _open(place, name, limit)
        spec = file.spec()
        _check_size(spec, name, limit)
        pixels = file.read_image(0, 0, 0, spec.nchannels, "unknown")
        # Some readers return pixels for a truncated file: the error message tells.
        trouble = file.geterror()
        if pixels is None or trouble:
            raise InputFileError(f"{name} is damaged or cut off: {_reason(trouble, place)}")
        pixels, kind = np.asarray(pixels), file.format_name()
        if kind == "pnm":
            pixels = exact_pnm(pixels, place)
    return _picture(pixels, spec, name, kind)


@contextmanager
def _opened(path: str | Path, name: str, limit: int) -> Iterator[str]:
    """A path under which OpenImageIO can open the picture."""
    if name == "stdin":
        if sys.stdin is None:
            raise InputFileError("stdin is closed: no picture was piped in")
        with _in_memory(sys.stdin.buffer, name, limit) as place:
            yield place
        return
    try:
        with open(path, "rb") as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):  # a pipe, as <(…)
                with _in_memory(file, name, limit) as place:
                    yield place
            elif not file.read(1):
                raise InputFileError(f"{name} is empty (0 bytes)")
            elif str(path).isprintable():
                yield str(path)  # the ending helps to find the format
            else:
                yield f"/proc/self/fd/{file.fileno()}"
    except IsADirectoryError:
        raise InputFileError(f"{name} is a folder; name the pictures in it") from None
    except OSError as error:
        raise InputFileError(f"{name} cannot be read: {error.strerror}") from None


@contextmanager
def _in_memory(stream: BinaryIO, name: str, limit: int) -> Iterator[str]:
    """All of a stream as a file without a place on a disk: OpenImageIO reads files only."""
    handle = os.memfd_create("halftone")
    try:
        size = 0
        with os.fdopen(os.dup(handle), "wb") as memory:
            while chunk := stream.read(CHUNK):
                size += memory.write(chunk)
                if size > limit:
                    raise InputFileError(f"{name} holds more than {limit >> 20} MiB; raise --max-memory")
        if not size:
            raise InputFileError(f"{name} is empty: no picture was piped in")
        yield f"/proc/self/fd/{handle}"
    finally:
        os.close(handle)


def _open(place: str, name: str, limit: int) -> Any:
    import OpenImageIO as oiio

    with open(place, "rb") as head:  # of formats that are decoded when they are opened
        size = declared_size(head.read(4096))
    if size is not None:
        _check_pixels(*size, 4, 1, name, limit)
    wish = oiio.ImageSpec()
    wish.attribute("oiio:UnassociatedAlpha", 1)  # codes as stored, not multiplied as if linear
    file = oiio.ImageInput.open(place, wish)
    if file is None:
        reason = _reason(oiio.geterror(), place)
        raise InputFileError(f"{name} is not a picture that can be read: {reason}")
    return file


def _check_size(spec: Any, name: str, limit: int) -> None:
    if spec.width * spec.height <= 0 or spec.nchannels < 1:
        raise InputFileError(f"{name} has no pixels: it is {spec.width} × {spec.height}")
    stored = 2 * spec.format.size()  # as read, then upright and apart
    if spec.format.size() not in (1, 2) or str(spec.format) == "half":
        stored += 4  # light as float32 at once
    _check_pixels(spec.width, spec.height, spec.nchannels, stored, name, limit)


def _check_pixels(width: int, height: int, channels: int, stored: int, name: str, limit: int) -> None:
    need = width * height * (channels * stored + BYTES_PER_PIXEL)
    if need > limit:
        raise InputFileError(
            f"{name} is {width} × {height} × {channels} and would take about {need >> 20} MiB; "
            f"allowed: {limit >> 20} MiB. Raise --max-memory (max_memory=) or make the picture "
            "smaller first"
        )


def _picture(pixels: NDArray[Any], spec: Any, name: str, format_name: str) -> Picture:
    if pixels.ndim == 2:
        pixels = pixels[:, :, None]
    names = [str(c).upper().rpartition(".")[2] for c in spec.channelnames]
    alpha = None
    place = names.index("A") if "A" in names else 0
    if place in (1, 3):
        alpha = _upright(pixels[:, :, place], spec)
    colours = 3 if pixels.shape[2] >= 3 and place != 1 else 1
    body = _upright(pixels[:, :, :3] if colours == 3 else pixels[:, :, 0], spec)
    if body.dtype.kind == "f":
        body = body.astype(np.float32, copy=False)
    elif body.dtype not in (np.uint8, np.uint16, np.uint32):
        raise InputFileError(f"{name} holds {body.dtype} pixels; allowed: unsigned or float")
    # Only these formats weight pixels by alpha; of the others, readers do not always say so.
    weighted = format_name in ("openexr", "tiff") or body.dtype.kind == "f"
    premultiplied = weighted and not spec.get_int_attribute("oiio:UnassociatedAlpha", 0)
    if premultiplied and alpha is not None and body.dtype.kind != "f":
        # Integer codes are weighted as codes (TIFF 6.0, ExtraSamples 1), not as light.
        body, premultiplied = _divided(body, alpha), False
    return Picture(
        pixels=body,
        alpha=alpha,
        premultiplied=premultiplied,
        encoding=_encoding(spec, body.dtype),
        name=name,
    )


def _encoding(spec: Any, dtype: np.dtype[Any]) -> str:
    """What the file says of its codes; integers are sRGB and floats are light unless it does."""
    if dtype.kind == "f":
        return "linear"
    space = spec.get_string_attribute("oiio:ColorSpace", "").lower()
    if space.startswith("lin"):
        return "linear"
    gamma = spec.get_float_attribute("oiio:Gamma", 0.0)
    if space[:1] == "g" and 0.01 <= gamma <= 100:  # gamma…, or g22_rec709_scene
        return f"gamma:{gamma:.4g}"
    if space[:1] == "g" and space[1:3].isdigit():
        return f"gamma:{int(space[1:3]) / 10}"
    return "srgb"


def _divided(codes: NDArray[Any], alpha: NDArray[Any]) -> NDArray[Any]:
    """Codes divided by their alpha, rounded; where alpha is 0 the code does not matter."""
    full = np.iinfo(codes.dtype).max
    out = np.empty_like(codes)
    for row in range(codes.shape[0]):
        cover = np.maximum(alpha[row].astype(np.float64), 1)
        cover = cover[:, None] if codes.ndim == 3 else cover
        out[row] = np.rint(np.minimum(codes[row] * (full / cover), full))
    return out


def _upright(pixels: NDArray[Any], spec: Any) -> NDArray[Any]:
    """Undo the EXIF orientation 1 … 8 (TIFF 6.0, tag 274)."""
    orientation = spec.get_int_attribute("Orientation", 1)
    if orientation in (5, 6, 7, 8):
        pixels = pixels.swapaxes(0, 1)
    if orientation in (3, 4, 7, 8):
        pixels = pixels[::-1]
    if orientation in (2, 3, 6, 7):
        pixels = pixels[:, ::-1]
    return np.ascontiguousarray(pixels)


def _reason(message: str, place: str) -> str:
    """The first line of a library's message, without the path, which we name ourselves."""
    for quoted in (f' ("{place}")', f' for "{place}"', f'"{place}"', place):
        message = message.replace(quoted, "" if quoted.startswith(" ") else "it")
    lines = [line.strip() for line in message.splitlines() if line.strip()]
    return lines[0] if lines else "no reason given"
