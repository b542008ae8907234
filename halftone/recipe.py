"""A recipe: what is done to a picture, checked once, for as many pictures as there are.

read → light → place (resize) → adjust → range → tone (dot gain) → dither.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import (
    BAND_ROWS,
    Light,
    Pixels,
    Source,
    as_pixels,
    check_finite,
    check_policy,
    whole,
)
from halftone._parallel import bands as rows_of
from halftone._parallel import count_workers
from halftone.dithering.base import Method
from halftone.dithering.registry import method as find_method
from halftone.errors import UsageError, near
from halftone.flatfield import print_curve
from halftone.frame import Bands, Frame
from halftone.images.read import DEFAULT_LIMIT, read_picture
from halftone.images.rows import LOOK_BACK, piece_rows
from halftone.packing import Packing
from halftone.stages import Halftoning, Report, background_light, check_memory, decoded, light_of
from halftone.tone import adjust
from halftone.tone.dotgain import DotModel
from halftone.tone.levels import Levels
from halftone.tone.range import bring_into_range, check_rule
from halftone.tone.transfer import encoding as find_encoding

__all__ = ["DEFAULT_METHOD", "Profile", "Recipe"]

DEFAULT_METHOD = "floyd-steinberg"

CONTENTS = {
    "text": "text, line art, barcodes: no dots, one threshold (or the nearest level)",
    "graphic": "flat colours and lines: ordered dots that keep edges and repeat exactly",
    "photo": "photographs: the device's method, or the default",
}

DOT_GAIN = {
    "correct": "what is printed has the luminance asked for, by the device's dot model",
    "keep": "printed dots make the picture as dark as they do",
}

Progress = Callable[[float], None]


class Profile(Protocol):
    """What the pipeline asks of a device.

    It may also have ``dot``, a :class:`halftone.tone.dotgain.DotModel`, and ``measured``, pairs of
    predicted and measured luminance, both rising; a profile without them prints as it prints.
    """

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


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """The options of :func:`halftone.convert`, checked once, before any picture is read."""

    profile: Profile | None = None
    method: str | Method | None = None
    content: str | None = None
    levels: Any = None
    width: int | None = None
    height: int | None = None
    fit: str | None = None
    encoding: str | None = None
    gamma: str | float | None = None
    brightness: float = 0.0
    contrast: float = 0.0
    auto_levels: bool = False
    invert: bool = False
    background: str | float = "white"
    range: str = "clip"
    dot_gain: str = "correct"
    nonfinite: str = "error"
    serpentine: bool | None = None
    strength: float | None = None
    seed: int | None = None
    workers: int = 1
    max_memory: int = DEFAULT_LIMIT

    def __post_init__(self) -> None:
        from halftone.images.resize import check_fit

        profile = self.profile
        given = self.levels
        if given is None:
            given = 2 if profile is None else profile.levels
        ladder = Levels.of(given, response(self.gamma))
        if profile is not None and len(ladder) != len(profile.levels):
            raise UsageError(
                f"{len(ladder)} levels were asked for and the device '{profile.name}' has "
                f"{len(profile.levels)}; leave levels out, or give as many"
            )
        spec = self._spec(ladder)
        for name, value in (("width", self.width), ("height", self.height)):
            if value is not None:
                object.__setattr__(self, name, whole(name, value, 1, 1 << 62))
        if self.encoding is not None:
            find_encoding(self.encoding)
        if self.fit is not None:
            check_fit(self.fit)
            sized = profile if self.width is None and self.height is None else self
            if sized is None or sized.width is None or sized.height is None:
                raise UsageError(f"fit '{self.fit}' needs both a width and a height (--size WxH)")
        check_rule(self.range)
        if self.dot_gain not in DOT_GAIN:
            raise UsageError(near(str(self.dot_gain), DOT_GAIN, "dot gain"))
        check_policy(self.nonfinite)
        count_workers(self.workers)
        chosen = configured(spec, self.serpentine, self.strength, self.seed)
        chosen.check(ladder)
        object.__setattr__(self, "_method", chosen)
        object.__setattr__(self, "_ladder", ladder)
        object.__setattr__(self, "_paper", background_light(self.background))
        object.__setattr__(self, "_steps", self._adjustments())

    _method: Method = field(init=False, repr=False)
    _ladder: Levels = field(init=False, repr=False)
    _paper: float = field(init=False, repr=False)
    _steps: tuple[Callable[[Light], Light], ...] = field(init=False, repr=False)

    def _spec(self, ladder: Levels) -> str | Method:
        """The method asked for, or what suits the content, or the device's, or the default."""
        if self.content is not None:
            if self.content not in CONTENTS:
                raise UsageError(near(str(self.content), CONTENTS, "content"))
            if self.method is not None:
                raise UsageError("both a method and a content were given; give one")
            if self.content == "text":
                return "threshold" if ladder.distinct.size == 2 else "none"
            if self.content == "graphic":
                return "bayer8"
        own = None if self.profile is None else self.profile.method
        return self.method or own or DEFAULT_METHOD

    @property
    def ladder(self) -> Levels:
        """The levels of the device."""
        return self._ladder

    def convert(self, picture: Any, progress: Progress | None = None) -> Frame:
        """*picture*, as :func:`halftone.convert` takes it, as a frame."""
        report = Report()
        with ExitStack() as files:
            work, (height, width) = self._prepared(picture, report, files, whole=True)
            frame = work.frame(progress)
        if frame.shape != (height, width):  # patterns at the right and bottom rim
            frame = replace(frame, indices=np.ascontiguousarray(frame.indices[:height, :width]))
        return replace(frame, packing=self._packing)

    def bands(self, picture: Any, progress: Progress | None = None) -> Bands:
        """*picture* as bands of rows of its frame, which are halftoned when they are asked for.

        The memory it takes does not grow with the height of a file that is read forward
        (:mod:`halftone.images.read`), unless the picture is resized. What is damaged or not finite
        in such a file shows when its rows are reached.
        """
        report = Report()
        with ExitStack() as files:
            work, shape = self._prepared(picture, report, files, whole=False)
            parts = _rows(work, shape, progress, files.pop_all())
        text, dpi = self._method.text(), work.dpi
        return Bands(shape, parts, self._ladder, text, dpi, self._packing, report.as_dict())

    def light(self, picture: Any) -> Light:
        """What is asked of the device: light (M, N) at its size, adjusted and in the range of its
        levels, before dot gain is corrected and before it is halftoned."""
        unset: dict[str, Any] = dict.fromkeys(("serpentine", "strength", "seed"))  # "none" has none
        plain = replace(self, method="none", content=None, dot_gain="keep", **unset)
        with ExitStack() as files:
            work, shape = plain._prepared(picture, Report(), files, whole=True)
            need = 4 * shape[0] * shape[1]
            check_memory(need, self.max_memory, f"the light of {shape[1]} × {shape[0]} dots")
            ladder = self.ladder
            source = bring_into_range(work.source, ladder.darkest, ladder.lightest, self.range)
            light = np.empty(shape, np.float32)
            for start, stop in rows_of(shape[0], BAND_ROWS):
                light[start:stop] = source.band(start, stop)
        return light

    def _prepared(
        self, picture: Any, report: Report, files: ExitStack, whole: bool
    ) -> tuple[Halftoning, tuple[int, int]]:
        """All but the halftoning, and (rows, columns) of the frame, of which *whole* may be held."""
        note = getattr(self.profile, "note", None)
        if note:
            report.notes.append(note)
        source = check_finite(self._source(picture, report, files), self.nonfinite)
        width, height = self._target(source, whole)
        source = self._placed(source, (width, height), report)
        if self.auto_levels or self._steps:
            with report.stage("adjust"):
                if self.auto_levels:
                    source = source.then(adjust.auto_levels(source))
                source = source.then(*self._steps)
        else:
            report.leave_out("adjust", "no brightness, contrast, levels or invert was asked for")
        dpi = None if self.profile is None else self.profile.dpi
        source, rule = self._toned(source, report)
        work = Halftoning(source, self._method, self._ladder, rule, self.workers, report, dpi)
        return work, (height, width)

    def _toned(self, source: Source, report: Report) -> tuple[Source, str]:
        """Light to ask for, so that the print has the light of *source*; and the range rule that is
        left to do: all light is within the range when it has been corrected."""
        profile, why = self.profile, ""
        dot: DotModel | None = getattr(profile, "dot", None)
        if self.dot_gain == "keep":
            why = "dot gain is kept, as was asked for"
        elif profile is None or dot is None:
            why = "no device was chosen whose printed dots are known"
        elif len(self._ladder) > 2:
            why = f"the device has {len(self._ladder)} levels; printed dots are known for two"
        if profile is None or dot is None or why:
            report.leave_out("tone", why)
            return source, self.range
        with report.stage("tone", dot=[dot.across, dot.down], range=self.range) as entry:
            measured = getattr(profile, "measured", None)
            curve = print_curve(self._method, self._ladder, dot, profile.dpi, measured)
            entry.update(curve=curve.origin, printed=[curve.darkest, curve.lightest])
            if curve.has_tones:
                source = bring_into_range(source, curve.darkest, curve.lightest, self.range)
                source = source.then(curve.inverse)
        if not curve.has_tones:
            report.stages.remove(entry)
            report.leave_out("tone", f"'{self._method.text()}' prints no tone between ink and paper")
            return source, self.range
        if not curve.rising:
            entry["falls"] = curve.falls
        if curve.note:
            report.notes.append(curve.note)
        return source, "clip"

    @property
    def _packing(self) -> Packing | None:
        return None if self.profile is None else self.profile.packing

    def _adjustments(self) -> tuple[Callable[[Light], Light], ...]:
        steps = []
        if self.brightness:
            steps.append(adjust.brightness(self.brightness))
        if self.contrast:
            steps.append(adjust.contrast(self.contrast))
        if self.invert:
            steps.append(adjust.invert())
        return tuple(steps)

    def _source(self, picture: Any, report: Report, files: ExitStack) -> Source:
        if not isinstance(picture, str | os.PathLike):
            return decoded(as_pixels(picture), self.encoding)
        with report.stage("read", file=str(picture)) as entry:
            keep = LOOK_BACK + BAND_ROWS * (count_workers(self.workers) - 1)
            read = read_picture(os.fspath(picture), self.max_memory, keep)
            files.callback(read.close)
            size = [read.pixels.shape[1], read.pixels.shape[0]]
            entry.update(size=size, type=str(read.pixels.dtype))
            source = light_of(read, self.encoding, self._paper, report)
        report.reading = lambda: read.window.seconds
        return source

    def _target(self, source: Source, whole: bool) -> tuple[int, int]:
        """(width, height) in dots: what was asked for, or the device's, or the picture's own."""
        from halftone.images.resize import target_size

        rows, columns = source.shape
        width, height = target_size(rows, columns, *self._wanted(), self._aspect())
        self._check_size(width, height)
        need = source.pixels.nbytes + (0 if source.cover is None else source.cover.nbytes)
        if (width, height) != (columns, rows):
            need += 4 * rows * width + 4 * height * width  # between Pillow's two passes, and after
        wide, held = max(width, columns), min(count_workers(self.workers), -(-height // BAND_ROWS))
        need += 80 * piece_rows(wide, BAND_ROWS) * wide * held
        if whole:
            need += height * width
        check_memory(need, self.max_memory, f"the size {width} × {height}")
        return width, height

    def _wanted(self) -> tuple[int | None, int | None]:
        if self.width is None and self.height is None and self.profile is not None:
            return self.profile.width, self.profile.height
        return self.width, self.height

    def _aspect(self) -> float:
        dpi = None if self.profile is None else self.profile.dpi
        return 1.0 if dpi is None else dpi[0] / dpi[1]

    def _placed(self, source: Source, target: tuple[int, int], report: Report) -> Source:
        """The picture at the target size, or its cells, n × n dots each, for n × n patterns."""
        from halftone.images.resize import Cells, LightRows, place

        scale = self._method.scale
        width, height = target
        rows, columns = source.shape
        if (width, height) == (columns, rows) and scale == 1:
            report.leave_out("resize", "the picture has the size asked for")
            return source
        # A size that follows from the picture is its shape but for rounding: no margin for that.
        fit = self.fit or ("stretch" if None in self._wanted() else "contain")
        with report.stage("resize", fit=fit, size=[width, height]):
            placed: Pixels = place(LightRows(source), width, height, fit, self._paper, self._aspect())
        if scale > 1:
            placed = Cells(placed, scale)
        if self.profile is not None and (width, height) != (columns, rows):
            report.notes.append(
                f"the picture of {columns} × {rows} was scaled to {target[0]} × {target[1]} for "
                f"'{self.profile.name}'"
            )
        return Source(placed)

    def _check_size(self, width: int, height: int) -> None:
        for name, dots in (("width", width), ("height", height)):
            most = getattr(self.profile, name, None)
            if most is not None and dots > most:
                raise UsageError(
                    f"the {name} {dots} is more than the {most} dots of the device "
                    f"'{getattr(self.profile, 'name', '')}': nothing is cropped silently. "
                    "Leave --size and --width out to fit"
                )


def _rows(
    work: Halftoning, shape: tuple[int, int], progress: Progress | None, files: ExitStack
) -> Iterator[NDArray[np.uint8]]:
    """Bands cut to (rows, columns): patterns may reach beyond the right and bottom rim."""
    height, width = shape
    columns, done = work.shape[1], 0

    def out(start: int, stop: int) -> NDArray[np.uint8]:
        return np.empty((stop - start, columns), np.uint8)

    with files:
        for band in work.bands(out, progress):
            yield np.ascontiguousarray(band[: height - done, :width])
            done += len(band)


def configured(
    spec: str | Method, serpentine: bool | None, strength: float | None, seed: int | None
) -> Method:
    """The method with the options that are not None set."""
    return find_method(spec, serpentine=serpentine, strength=strength, seed=seed)


def response(gamma: str | float | None) -> str | None:
    """The device's response as the name of an encoding."""
    return f"gamma:{gamma}" if isinstance(gamma, int | float) else gamma
