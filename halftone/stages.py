"""The stages from a picture to a frame: each says how long it took, and what was left out says why."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import BAND_ROWS, Light, Pixels, Source
from halftone._parallel import bands, count_workers, in_order
from halftone.dithering.base import Job, Method
from halftone.errors import InputError, UsageError
from halftone.frame import Frame
from halftone.images.read import Picture
from halftone.images.rows import piece_rows
from halftone.tone.levels import Levels
from halftone.tone.range import bring_into_range
from halftone.tone.transfer import encoding as find_encoding

__all__ = ["Halftoning", "Report", "background_light", "check_memory", "decoded", "light_of"]

BACKGROUNDS = {"white": 1.0, "black": 0.0}

Progress = Callable[[float], None]
Indices = NDArray[np.uint8]


@dataclass
class Report:
    """What was done, with seconds, and what was left out, with the reason."""

    stages: list[dict[str, Any]] = field(default_factory=list)
    left_out: list[dict[str, str]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    reading: Callable[[], float] = field(default=lambda: 0.0, repr=False)
    """Seconds spent on rows of the file so far, in whichever stage asked for them."""

    def entry(self, name: str, **facts: Any) -> dict[str, Any]:
        """A new stage, of no time yet."""
        entry: dict[str, Any] = {"stage": name, **facts, "seconds": 0.0}
        self.stages.append(entry)
        return entry

    @contextmanager
    def timing(self, entry: dict[str, Any]) -> Iterator[None]:
        """Add the time within to *entry*, but what was spent on reading to the first stage."""
        start, read = time.perf_counter(), self.reading()
        try:
            yield
        finally:
            spent, read = time.perf_counter() - start, self.reading() - read
            for stage, seconds in ((self.stages[0], read), (entry, max(0.0, spent - read))):
                stage["seconds"] = round(stage["seconds"] + seconds, 6)

    @contextmanager
    def stage(self, name: str, **facts: Any) -> Iterator[dict[str, Any]]:
        entry = self.entry(name, **facts)
        with self.timing(entry):
            yield entry

    @property
    def seconds(self) -> float:
        """Of all stages so far."""
        return float(sum(stage["seconds"] for stage in self.stages))

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
    # Gray codes without alpha may go to a method as they are; of colours, light is made anyway.
    if source.pixels.ndim == 2 and _opaque(read.alpha):
        report.leave_out("alpha", "every pixel is opaque")
        return source
    if report.stages:
        report.stages[-1]["alpha"] = f"over light {paper:g}"
    return replace(source, cover=read.alpha, paper=paper, premultiplied=read.premultiplied)


def _opaque(alpha: Pixels) -> bool:
    """Whether alpha is full everywhere, by a pass over its rows up to the first that is not."""
    full = 1 if alpha.dtype.kind == "f" else np.iinfo(alpha.dtype).max
    return all((alpha[a:b] == full).all() for a, b in bands(alpha.shape[0], BAND_ROWS))


def decoded(pixels: Pixels, name: str | None) -> Source:
    """Pixels with the meaning *name*: a table for 8 and 16 bits, else row by row.

    None: integers are sRGB codes, floats are light.
    """
    floats = pixels.dtype.kind == "f"
    code = find_encoding(name or ("linear" if floats else "srgb"))
    if pixels.dtype in (np.uint8, np.uint16):
        return Source(pixels, code.table(1 << (8 * pixels.dtype.itemsize)))
    if floats and code.name == "linear":
        return Source(pixels)
    full = 1.0 if floats else float(np.iinfo(pixels.dtype).max)

    def decode(rows: NDArray[Any], start: int) -> Light:
        with np.errstate(over="ignore"):
            return code.decode(rows / full).astype(np.float32)

    return Source(pixels, decode=decode)


@dataclass(frozen=True)
class Halftoning:
    """Finite light on its way to level indices.

    workers : bands that are worked on at once, where the method allows it; 0 is one per processor.
    """

    source: Source
    method: Method
    levels: Levels
    rule: str
    workers: int
    report: Report
    dpi: tuple[float, float] | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the level indices."""
        height, width = self.source.shape
        return height * self.method.scale, width * self.method.scale

    def bands(
        self,
        out: Callable[[int, int], Indices],
        progress: Progress | None = None,
        ahead: bool = True,
    ) -> Generator[Indices]:
        """Level indices, band after band, each written into out(its first row, the row after it).

        ahead : whether a band is worked on while the one before it is dealt with.
        """
        method, levels, report = self.method, self.levels, self.report
        scale, workers = method.scale, count_workers(self.workers)
        entry = report.entry("dither", method=method.text(), levels=levels.text, range=self.rule)
        with report.timing(entry):
            source = bring_into_range(self.source, levels.darkest, levels.lightest, self.rule)
            halftoner = method.halftoner(Job(source, levels, self.dpi, workers))
            used = workers if halftoner.parallel else 1
            threads = getattr(halftoner, "threads", used)
            entry.update(claim=str(method.claim), workers=threads, visible_steps=levels.contours)
        if method.needs == "numpy":
            report.leave_out("numba", f"'{method.text()}' needs no compiled code")
        if source.codes() is not None:
            report.leave_out("float copy", "integer codes go to the method with a table of their light")

        def work(start: int, stop: int) -> Indices:
            indices = out(start * scale, stop * scale)
            halftoner.band(start, stop, indices)
            return indices

        height, width = source.shape
        rows = getattr(halftoner, "band_rows", 0) or piece_rows(width * scale**2, BAND_ROWS)
        give_up = getattr(halftoner, "stop", lambda: None)
        pooled = used if used > 1 or (ahead and workers > 1) else 0
        parts = in_order(work, height, rows, pooled, give_up)
        done = 0
        with closing(parts):
            while True:
                with report.timing(entry):
                    part = next(parts, None)
                if part is None:
                    return
                done += len(part)
                if progress:
                    progress(done / (height * scale))
                yield part

    def frame(self, progress: Progress | None = None) -> Frame:
        """All of it."""
        indices = np.empty(self.shape, np.uint8)
        for _ in self.bands(lambda start, stop: indices[start:stop], progress, ahead=False):
            pass
        report = self.report.as_dict()
        return Frame(indices, self.levels, self.method.text(), self.dpi, report=report)
