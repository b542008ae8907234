"""From a picture or linear light to a frame: the one way through the house.

read → light → place (resize) → adjust → range → dither. Every stage says how long it took, and what
was left out says why.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from halftone._arrays import BAND_ROWS, Light, Source, as_pixels, check_finite
from halftone._parallel import bands, count_workers, for_each_band
from halftone.dithering.base import Job, Method
from halftone.dithering.registry import method as find_method
from halftone.errors import InputError, UsageError
from halftone.frame import Frame
from halftone.images.read import DEFAULT_LIMIT, Picture, read_picture
from halftone.packing import Packing
from halftone.tone import adjust
from halftone.tone.levels import Levels
from halftone.tone.range import bring_into_range
from halftone.tone.transfer import encoding as find_encoding

__all__ = ["DEFAULT_METHOD", "Profile", "convert", "dither", "read"]

DEFAULT_METHOD = "floyd-steinberg"

BACKGROUNDS = {"white": 1.0, "black": 0.0}

Progress = Callable[[float], None]


class Profile(Protocol):
    """What the pipeline asks of a device."""

    @property
    def name(self) -> str: ...
    @property
    def width(self) -> int | None: ...
    @property
    def height(self) -> int | None: ...
    @property
    def dpi(self) -> tuple[float, float] | None: ...
    @property
    def levels(self) -> Levels: ...
    @property
    def packing(self) -> Packing: ...
    @property
    def method(self) -> str | None: ...


@dataclass
class _Report:
    """What was done, with seconds, and what was left out, with the reason."""

    stages: list[dict[str, Any]] = field(default_factory=list)
    left_out: list[dict[str, str]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    @contextmanager
    def stage(self, name: str, **facts: Any) -> Iterator[dict[str, Any]]:
        entry: dict[str, Any] = {"stage": name, **facts}
        start = time.perf_counter()
        yield entry
        entry["seconds"] = round(time.perf_counter() - start, 6)
        self.stages.append(entry)

    def leave_out(self, name: str, why: str) -> None:
        self.left_out.append({"stage": name, "why": why})

    def as_dict(self) -> dict[str, Any]:
        return {"stages": self.stages, "left_out": self.left_out, "notes": self.notes}


def read(
    path: str | Path,
    *,
    encoding: str | None = None,
    background: str | float = "white",
    max_memory: int = DEFAULT_LIMIT,
) -> Light:
    """Read a picture file as linear light: float32, (M, N) or (M, N, 3), 1 = white.

    path : a file that OpenImageIO reads, or ``-`` for stdin. EXIF orientation is applied.
    encoding : what the file's codes mean (:data:`halftone.tone.transfer.ENCODINGS`); None takes
    what the file says: sRGB for integers, light for floats.
    background : the light under transparent pixels, ``white``, ``black`` or 0 … 1.
    max_memory : bytes; a larger picture is refused before it is read.

    Raises :class:`halftone.errors.InputFileError`.
    """
    source = _light_of(read_picture(path, max_memory), encoding, _background(background), _Report())
    light = np.empty(source.pixels.shape, np.float32)
    for start, stop in bands(source.shape[0], BAND_ROWS):
        light[start:stop] = source.colours(start, stop)
    return light


def dither(
    image: Any,
    method: str | Method = DEFAULT_METHOD,
    *,
    levels: Any = 2,
    encoding: str | None = None,
    gamma: str | float | None = None,
    range: str = "clip",
    nonfinite: str = "error",
    serpentine: bool | None = None,
    strength: float = 1.0,
    seed: int = 0,
    workers: int = 1,
    progress: Progress | None = None,
) -> Frame:
    """Halftone an array: the level index of every pixel, for any levels.

    image : (M, N) gray or (M, N, 3) RGB, of which the luminance is taken; an array, nested lists of
    floats, or a PIL image. Integers are sRGB codes over the full range of their type, floats are
    linear light with 1 = white. The input is never changed.
    method : a name or a method (``halftone list methods``, :mod:`halftone.dithering`).
    levels : a count n, for the luminances of the n codes k/(n−1); a named ladder
    (``uniform-linear:N``, ``lstar:N``, ``log:I0:N``); or measured luminances, darkest first.
    encoding : what the image's codes mean, ``srgb``, ``bt709``, ``gamma:G`` or ``linear``.
    gamma : the response of the device under which a count of levels is meant; None is sRGB.
    range : how light beyond the levels is brought in: ``clip``, ``scale`` or ``compress``.
    nonfinite : ``error``, or ``clip`` to show NaN as black and ±inf as white and black.
    serpentine, strength, seed : set the method's option of that name; an error where it has none.
    workers : threads; 0 is one per processor. The result does not depend on it.
    progress : called with the share done, 0 … 1.

    Raises :class:`halftone.errors.UsageError` and :class:`halftone.errors.InputError`.
    """
    pixels = as_pixels(image)
    source = _decoded(pixels, encoding or ("linear" if pixels.dtype.kind == "f" else "srgb"))
    chosen = _method(method, serpentine, strength, seed)
    ladder = Levels.of(levels, _response(gamma))
    report = _Report()
    return _dithered(source, chosen, ladder, range, nonfinite, workers, progress, report)


def convert(
    picture: str | Path | Any,
    *,
    profile: Profile | None = None,
    method: str | Method | None = None,
    levels: Any = None,
    width: int | None = None,
    height: int | None = None,
    fit: str = "contain",
    encoding: str | None = None,
    gamma: str | float | None = None,
    brightness: float = 0.0,
    contrast: float = 0.0,
    auto_levels: bool = False,
    invert: bool = False,
    background: str | float = "white",
    range: str = "clip",
    nonfinite: str = "error",
    serpentine: bool | None = None,
    strength: float = 1.0,
    seed: int = 0,
    workers: int = 1,
    max_memory: int = DEFAULT_LIMIT,
    progress: Progress | None = None,
) -> Frame:
    """A picture file or array to the frame that a device shows.

    picture : a path, ``-`` for stdin, or an image as :func:`dither` takes it.
    profile : a device (:func:`devices.profile.load`); gives levels, size, dpi, packing and method
    where they are not given here.
    width, height, fit : the size in dots. With both, ``contain`` (over the background), ``cover``
    or ``stretch``; with one, the other follows; with neither, the device's, or the picture's own.
    brightness, contrast : −1 … 1. auto_levels : darkest and lightest 0.5 % to black and white.
    invert : white less the light. All other parameters are those of :func:`dither`.

    Everything is done in linear light: decode, alpha over the background, luminance, resize,
    auto-levels, brightness, contrast, invert, range, dither.
    """
    report = _Report()
    # What can be refused without the picture is refused before it is read.
    chosen = _method(
        method or (profile and profile.method) or DEFAULT_METHOD, serpentine, strength, seed
    )
    response = _response(gamma)
    if levels is None and profile is not None:
        ladder = Levels.of(profile.levels, response)
    else:
        ladder = Levels.of(2 if levels is None else levels, response)
    if profile is not None and len(ladder) != len(profile.levels):
        raise UsageError(
            f"{len(ladder)} levels were asked for and the device '{profile.name}' has "
            f"{len(profile.levels)}; leave levels out, or give as many"
        )
    paper = _background(background)
    steps = _adjustments(brightness, contrast, invert)
    source = _source(picture, encoding, paper, max_memory, report)
    source = check_finite(source, nonfinite)
    source = _placed(source, profile, width, height, fit, paper, max_memory, report)
    if auto_levels or steps:
        with report.stage("adjust"):
            if auto_levels:
                source = source.then(adjust.auto_levels(source))
            source = source.then(*steps)
    else:
        report.leave_out("adjust", "no brightness, contrast, levels or invert was asked for")
    frame = _dithered(source, chosen, ladder, range, nonfinite, workers, progress, report)
    if profile is None:
        return frame
    return Frame(frame.indices, ladder, frame.method, profile.dpi, profile.packing, frame.report)


def _method(spec: str | Method, serpentine: bool | None, strength: float, seed: int) -> Method:
    strong = None if strength == 1 else strength
    return find_method(spec, serpentine=serpentine, strength=strong, seed=seed or None)


def _response(gamma: str | float | None) -> str | None:
    if gamma is None:
        return None
    return f"gamma:{gamma}" if isinstance(gamma, int | float) else gamma


def _background(background: str | float) -> float:
    light = BACKGROUNDS.get(background) if isinstance(background, str) else background
    if light is None:
        try:
            light = float(background)
        except ValueError:
            light = -1.0
    if not 0 <= light <= 1:
        raise UsageError(f"background={background!r}; allowed: white, black, or light 0 … 1")
    return float(light)


def _adjustments(brightness: float, contrast: float, invert: bool) -> list[Callable[[Light], Light]]:
    steps = []
    if brightness:
        steps.append(adjust.brightness(brightness))
    if contrast:
        steps.append(adjust.contrast(contrast))
    if invert:
        steps.append(adjust.invert())
    return steps


def _source(picture: Any, encoding: str | None, paper: float, limit: int, report: _Report) -> Source:
    if not isinstance(picture, str | Path):
        pixels = as_pixels(picture)
        return _decoded(pixels, encoding or ("linear" if pixels.dtype.kind == "f" else "srgb"))
    with report.stage("read", file=str(picture)) as entry:
        read = read_picture(picture, limit)
        entry.update(size=[read.pixels.shape[1], read.pixels.shape[0]], type=str(read.pixels.dtype))
    return _light_of(read, encoding, paper, report)


def _light_of(read: Picture, encoding: str | None, paper: float, report: _Report) -> Source:
    """Light of a file's pixels over the background."""
    name = encoding or read.encoding
    source = _decoded(read.pixels, name)
    if read.alpha is None:
        report.leave_out("alpha", "the picture has no alpha channel")
        return source
    full = 1 if read.alpha.dtype.kind == "f" else np.iinfo(read.alpha.dtype).max
    if (read.alpha == full).all():
        report.leave_out("alpha", "every pixel is opaque")
        return source
    return replace(source, cover=read.alpha, paper=paper, premultiplied=read.premultiplied)


def _decoded(pixels: np.ndarray, name: str) -> Source:
    """Pixels with the meaning *name*; a table for 8 and 16 bits, else light at once."""
    code = find_encoding(name)
    if pixels.dtype in (np.uint8, np.uint16):
        return Source(pixels, code.table(1 << (8 * pixels.dtype.itemsize)))
    if pixels.dtype.kind == "f" and code.name == "linear":
        return Source(pixels)
    light = np.empty(pixels.shape, np.float32)
    full = 1.0 if pixels.dtype.kind == "f" else float(np.iinfo(pixels.dtype).max)
    for start, stop in bands(pixels.shape[0], BAND_ROWS):
        with np.errstate(over="ignore"):
            light[start:stop] = code.decode(pixels[start:stop] / full)
    return Source(light)


def _placed(
    source: Source,
    profile: Profile | None,
    width: int | None,
    height: int | None,
    fit: str,
    paper: float,
    limit: int,
    report: _Report,
) -> Source:
    """The picture at the size of the device, or at the size asked for."""
    from halftone.images.resize import place

    rows, columns = source.shape
    aspect = 1.0
    if profile is not None:
        if profile.dpi is not None:
            aspect = profile.dpi[0] / profile.dpi[1]
        if width is None and height is None:
            width, height = profile.width, profile.height
        if profile.width is not None and width is not None and width > profile.width:
            raise UsageError(
                f"width {width} is more than the {profile.width} dots of the device "
                f"'{profile.name}': nothing is cropped silently. Leave --width out to fit"
            )
    if (width or columns, height or rows) == (columns, rows) and aspect == 1:
        report.leave_out("resize", "the picture has the size asked for")
        return source
    pixels = (width or columns) * (height or rows)
    if width is None or height is None:
        ratio = width / columns if width else (height or rows) / rows
        pixels = round(rows * columns * ratio * ratio)
    if pixels * 12 > limit:
        raise InputError(
            f"the size asked for has {pixels} pixels and would take about {pixels * 12 >> 20} MiB; "
            f"allowed: {limit >> 20} MiB. Raise --max-memory, or ask for fewer"
        )
    with report.stage("resize", fit=fit) as entry:
        light = np.empty((rows, columns), np.float32)
        for start, stop in bands(rows, BAND_ROWS):
            light[start:stop] = source.band(start, stop)
        placed = place(light, width, height, fit, paper, aspect)
        entry.update(size=[placed.shape[1], placed.shape[0]])
    if profile is not None and columns != placed.shape[1]:
        report.notes.append(
            f"the picture of {columns} × {rows} was scaled to {placed.shape[1]} × "
            f"{placed.shape[0]} for '{profile.name}'"
        )
    return Source(np.ascontiguousarray(placed))


def _dithered(
    source: Source,
    method: Method,
    levels: Levels,
    rule: str,
    nonfinite: str,
    workers: int,
    progress: Progress | None,
    report: _Report,
) -> Frame:
    workers = count_workers(workers)
    source = check_finite(source, nonfinite)
    source = bring_into_range(source, levels.darkest, levels.lightest, rule)
    height, width = source.shape
    indices = np.empty((height, width), np.uint8)
    with report.stage("dither", method=method.text(), levels=levels.text, range=rule) as entry:
        halftoner = method.halftoner(Job(source, levels))
        used = workers if halftoner.parallel else 1
        for_each_band(
            lambda start, stop: halftoner.band(start, stop, indices[start:stop]),
            height,
            BAND_ROWS,
            used,
            progress,
        )
        entry.update(claim=str(method.claim), workers=used)
    if method.needs == "numpy":
        report.leave_out("numba", f"'{method.text()}' needs no compiled code")
    if source.codes() is not None:
        report.leave_out("float copy", "integer codes go to the method with a table of their light")
    return Frame(indices, levels, method.text(), report=report.as_dict())
