"""The stages from a picture to a frame: each says how long it took, and what was left out says why."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from halftone._arrays import BAND_ROWS, Source
from halftone._parallel import bands, count_workers, for_each_band
from halftone.dithering.base import Job, Method
from halftone.errors import InputError, UsageError
from halftone.frame import Frame
from halftone.images.read import Picture
from halftone.tone.ladder import visible_steps
from halftone.tone.levels import Levels
from halftone.tone.range import bring_into_range
from halftone.tone.transfer import encoding as find_encoding

__all__ = ["Report", "background_light", "check_memory", "decoded", "dithered", "light_of"]

BACKGROUNDS = {"white": 1.0, "black": 0.0}

Progress = Callable[[float], None]


@dataclass
class Report:
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


def check_memory(need: int, limit: int, what: str) -> None:
    """Refuse what would take more bytes than *limit*, before it is made."""
    if need > limit:
        raise InputError(
            f"{what} would take about {need >> 20} MiB; allowed: {limit >> 20} MiB. "
            "Raise --max-memory (max_memory=), or ask for less"
        )


def background_light(background: str | float) -> float:
    """Light of ``white``, ``black``, or a number 0 … 1."""
    light = BACKGROUNDS.get(background) if isinstance(background, str) else background
    try:
        value = float(background if light is None else light)
    except (TypeError, ValueError):
        value = -1.0
    if not 0 <= value <= 1:
        raise UsageError(f"background={background!r}; allowed: white, black, or light 0 … 1")
    return value


def light_of(read: Picture, encoding: str | None, paper: float, report: Report) -> Source:
    """Light of a file's pixels over the background."""
    source = decoded(read.pixels, encoding or read.encoding)
    if read.alpha is None:
        report.leave_out("alpha", "the picture has no alpha channel")
        return source
    full = 1 if read.alpha.dtype.kind == "f" else np.iinfo(read.alpha.dtype).max
    if (read.alpha == full).all():
        report.leave_out("alpha", "every pixel is opaque")
        return source
    if report.stages:
        report.stages[-1]["alpha"] = f"over light {paper:g}"
    return replace(source, cover=read.alpha, paper=paper, premultiplied=read.premultiplied)


def decoded(pixels: np.ndarray, name: str | None) -> Source:
    """Pixels with the meaning *name*; a table for 8 and 16 bits, else light at once.

    None: integers are sRGB codes, floats are light.
    """
    floats = pixels.dtype.kind == "f"
    code = find_encoding(name or ("linear" if floats else "srgb"))
    if pixels.dtype in (np.uint8, np.uint16):
        return Source(pixels, code.table(1 << (8 * pixels.dtype.itemsize)))
    if floats and code.name == "linear":
        return Source(pixels)
    light = np.empty(pixels.shape, np.float32)
    full = 1.0 if floats else float(np.iinfo(pixels.dtype).max)
    for start, stop in bands(pixels.shape[0], BAND_ROWS):
        with np.errstate(over="ignore"):
            light[start:stop] = code.decode(pixels[start:stop] / full)
    return Source(light)


def dithered(
    source: Source,
    method: Method,
    levels: Levels,
    rule: str,
    workers: int,
    progress: Progress | None,
    report: Report,
    dpi: tuple[float, float] | None = None,
) -> Frame:
    """Finite light to level indices."""
    workers = count_workers(workers)
    source = bring_into_range(source, levels.darkest, levels.lightest, rule)
    height, width = source.shape
    scale = method.scale
    indices = np.empty((height * scale, width * scale), np.uint8)
    with report.stage("dither", method=method.text(), levels=levels.text, range=rule) as entry:
        halftoner = method.halftoner(Job(source, levels, dpi))
        used = workers if halftoner.parallel else 1
        for_each_band(
            lambda start, stop: halftoner.band(start, stop, indices[start * scale : stop * scale]),
            height,
            BAND_ROWS,
            used,
            progress,
        )
        contours = visible_steps(levels.distinct)
        entry.update(claim=str(method.claim), workers=used, visible_steps=contours)
    if method.needs == "numpy":
        report.leave_out("numba", f"'{method.text()}' needs no compiled code")
    if source.codes() is not None:
        report.leave_out("float copy", "integer codes go to the method with a table of their light")
    return Frame(indices, levels, method.text(), dpi, report=report.as_dict())
