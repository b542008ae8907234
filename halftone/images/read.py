"""Picture files in: pixels as stored, row by row, with what their codes mean.

Everything that can go wrong is found before or while reading, in this order: no such file, not a
picture, no pixels, too large for the memory limit (from the header alone), damaged, which may show
only when its last rows are reached.

Most files are read forward, and no more than a window of rows is held. Held as a whole are pictures
that must be turned (EXIF orientations that do not begin with the top row), and those that their
decoder holds as a whole anyway: interlaced PNG, progressive JPEG, and formats other than PNG, JPEG,
TIFF, OpenEXR, BMP, Radiance HDR and raw PNM. Of a TIFF, a strip or a row of tiles is held beside.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import Pixels
from halftone.errors import InputFileError
from halftone.images.channels import Channels, channels_of, encoding_of, orientation_of, upright
from halftone.images.headers import declared_size, exact_pnm, progressive_size
from halftone.images.places import Place
from halftone.images.raw_pnm import RawPnm, raw_pnm
from halftone.images.rows import LOOK_BACK, Rows, Window, piece_rows

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["DEFAULT_LIMIT", "Picture", "read_picture"]

DEFAULT_LIMIT = 4 << 30
"""Bytes of memory that a picture may take unless the caller says otherwise."""

BYTES_PER_PIXEL = 12
"""Beside the stored pixels of a whole picture: light as float32, and copies to resize it."""

FORWARD = ("png", "jpeg", "tiff", "openexr", "bmp", "hdr")
"""Formats of which OpenImageIO reads and holds a few rows at a time."""

TYPES = {"half": "float16", "float": "float32", "double": "float64", "uint": "uint32", "int": "int32"}
"""OpenImageIO's names of types, where NumPy has others."""


@dataclass(frozen=True)
class Picture:
    """Pixels as stored, upright.

    pixels : (M, N) or (M, N, 3), integer codes or floats: an array, or :class:`Rows` of the file,
    which is open until :meth:`close`. alpha : (M, N) of the same type, or None.
    premultiplied : whether the pixels are already weighted by alpha, in light.
    encoding : what the codes mean, as the file says.
    """

    pixels: Pixels
    alpha: Pixels | None
    premultiplied: bool
    encoding: str
    name: str
    window: Window
    place: Place

    def close(self) -> None:
        """Let the file go: nothing can be read any more."""
        self.window.close()
        self.place.close()


def read_picture(path: str | Path, limit: int = DEFAULT_LIMIT, keep: int = LOOK_BACK) -> Picture:
    """Open the first image of a file, or of stdin for ``-``; its rows are read when asked for.

    keep : rows that are held behind the last one read.
    """
    place = Place(path, limit)
    try:
        with open(place.path, "rb") as file:
            head = file.read(4096)
            raw = raw_pnm(head)
            progressive = progressive_size(file)
            declared = declared_size(head) or progressive
        if raw is not None:
            return _raw(raw, place, limit, keep)
        if declared is not None:
            _check_pixels(*declared, 4, 1, place.name, limit)
        interlaced = head[:4] == b"\x89PNG" and head[28:29] == b"\x01"
        return _by_openimageio(place, limit, keep, progressive is None and not interlaced)
    except BaseException:
        place.close()
        raise


def _raw(raw: RawPnm, place: Place, limit: int, keep: int) -> Picture:
    size = (raw.width, raw.height, raw.channels)
    _check_window(size, raw.dtype, keep, piece_rows(raw.width, 64), place.name, limit)
    window = Window(lambda: raw.pieces(place.path, place.name), raw.height, keep)
    channels = Channels(raw.channels, None, raw.dtype, False, False, False)
    pixels = Rows(window, channels.body, _shape(raw.height, raw.width, channels), raw.dtype)
    return Picture(pixels, None, False, "srgb", place.name, window, place)


def _by_openimageio(place: Place, limit: int, keep: int, in_order: bool) -> Picture:
    file = _open(place)
    spec, kind = file.spec(), file.format_name()
    size = (spec.width, spec.height, spec.nchannels)
    if spec.width * spec.height <= 0 or spec.nchannels < 1:
        raise InputFileError(f"{place.name} has no pixels: it is {spec.width} × {spec.height}")
    stored = np.dtype(TYPES.get(str(spec.format), str(spec.format)))
    channels = channels_of(spec, stored, place.name, kind)
    forward = in_order and kind in FORWARD and orientation_of(spec) in (1, 2)
    if forward:
        _check_window(size, stored, keep, _piece(spec), place.name, limit)
    else:
        light = 4 if stored.itemsize > 2 or stored.kind == "f" else 0
        _check_pixels(*size, 2 * stored.itemsize + light, place.name, limit)
    first = [file]  # is open already

    def pieces() -> Iterator[NDArray[Any]]:
        return _pieces(first.pop() if first else _open(place), place, size)

    window = Window(pieces, spec.height, keep if forward else 0)
    shape = _shape(spec.height, spec.width, channels)
    rows = Rows(window, channels.body, shape, channels.dtype)
    cover = None if channels.alpha is None else Rows(window, channels.cover, shape[:2], stored)
    how = (channels.premultiplied, encoding_of(spec, channels.dtype), place.name, window, place)
    if forward:
        return Picture(rows, cover, *how)
    pixels, alpha = _whole(rows, cover, spec)
    if kind == "pnm":
        pixels = exact_pnm(pixels, place.path)
    window.close()
    place.close()
    return Picture(pixels, alpha, *how)


def _shape(height: int, width: int, channels: Channels) -> tuple[int, ...]:
    return (height, width) if channels.colours == 1 else (height, width, 3)


def _whole(pixels: Rows, alpha: Rows | None, spec: Any) -> tuple[NDArray[Any], NDArray[Any] | None]:
    """All rows at once, upright."""
    body = np.empty(pixels.shape, pixels.dtype)
    cover = None if alpha is None else np.empty(alpha.shape, alpha.dtype)
    step = _piece(spec)
    for top in range(0, spec.height, step):
        body[top : top + step] = pixels[top : top + step]
        if cover is not None and alpha is not None:
            cover[top : top + step] = alpha[top : top + step]
    return upright(body, spec), None if cover is None else upright(cover, spec)


def _piece(spec: Any) -> int:
    """Rows read in one call: at least a row of tiles."""
    rows = piece_rows(spec.width, 64)
    return max(rows // spec.tile_height, 1) * spec.tile_height if spec.tile_height else rows


def _pieces(file: Any, place: Place, size: tuple[int, int, int]) -> Iterator[NDArray[Any]]:
    """Consecutive rows (n, N, C) as stored; InputFileError where they cannot be read."""
    spec = file.spec()
    if (spec.width, spec.height, spec.nchannels) != size:
        raise InputFileError(f"{place.name} was changed while it was read")
    step, (left, top), channels = _piece(spec), (spec.x, spec.y), spec.nchannels
    for y in range(top, top + spec.height, step):
        stop = min(y + step, top + spec.height)
        if spec.tile_height:
            box = (left, left + spec.width, y, stop, spec.z, spec.z + 1)
            rows = file.read_tiles(0, 0, *box, 0, channels, "unknown")
        else:
            rows = file.read_scanlines(0, 0, y, stop, spec.z, 0, channels, "unknown")
        # Some readers return pixels for a truncated file: the error message tells.
        trouble = file.geterror()
        if rows is None or trouble:
            reason = _reason(trouble, place.path)
            raise InputFileError(f"{place.name} is damaged or cut off: {reason}")
        yield np.asarray(rows).reshape(stop - y, spec.width, channels)


def _open(place: Place) -> Any:
    import OpenImageIO as oiio

    wish = oiio.ImageSpec()
    wish.attribute("oiio:UnassociatedAlpha", 1)  # codes as stored, not multiplied as if linear
    file = oiio.ImageInput.open(place.path, wish)
    if file is None:
        reason = _reason(oiio.geterror(), place.path)
        raise InputFileError(f"{place.name} is not a picture that can be read: {reason}")
    return file


def _check_window(
    size: tuple[int, int, int], stored: np.dtype[Any], keep: int, piece: int, name: str, limit: int
) -> None:
    width, height, channels = size
    need = width * channels * stored.itemsize * min(height, keep + 2 * piece)
    _check(need, size, name, limit)


def _check_pixels(width: int, height: int, channels: int, stored: int, name: str, limit: int) -> None:
    need = width * height * (channels * stored + BYTES_PER_PIXEL)
    _check(need, (width, height, channels), name, limit)


def _check(need: int, size: tuple[int, int, int], name: str, limit: int) -> None:
    if need > limit:
        width, height, channels = size
        raise InputFileError(
            f"{name} is {width} × {height} × {channels} and would take about {need >> 20} MiB; "
            f"allowed: {limit >> 20} MiB. Raise --max-memory (max_memory=) or make the picture "
            "smaller first"
        )


def _reason(message: str, place: str) -> str:
    """The first line of a library's message, without the path, which we name ourselves."""
    for quoted in (f' ("{place}")', f' for "{place}"', f'"{place}"', place):
        message = message.replace(quoted, "" if quoted.startswith(" ") else "it")
    lines = [line.strip() for line in message.splitlines() if line.strip()]
    return lines[0] if lines else "no reason given"
