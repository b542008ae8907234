"""Flat-field print curves: the luminance that even patches of a method have in print, and the inverse.

A patch of every tone is halftoned and its dots are laid on paper by the dot model; the mean is what
the tone looks like. The inverse says which light to ask a method for, so that the print has the
luminance that was meant. Curves are computed once and kept, in the process and in the cache folder.

Error diffusion prints some tones lighter or darker than their neighbours, where its texture locks
(a checkerboard at ½ takes more ink than the wavy textures about it), so its curve is not monotone.
The running maximum is therefore taken over a chain of tones that rises by the smallest steps; tones
off the chain are never asked for.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone import _objects
from halftone._arrays import Light, Source
from halftone.dithering.base import Method
from halftone.dithering.registry import method as find_method
from halftone.errors import UsageError
from halftone.screens.order import Screen
from halftone.stages import Halftoning, Report
from halftone.tone.dotgain import DotModel
from halftone.tone.levels import Levels

__all__ = ["PrintCurve", "print_curve"]

Float = NDArray[np.float64]
Dpi = tuple[float, float]
Measured = Sequence[tuple[float, float]]

ENTRIES = 1 << 16
"""Of the table of the inverse: luminances evenly from the darkest to the lightest that print."""
SIDE = 256
"""Rows and columns of the patch of a method that has no period, with the rim …"""
RIM = 8
"""… of so many at each side that is not measured: error diffusion has not settled yet."""
LARGEST = 512
"""Rows and columns of a period that are printed at most."""
MOST_STEPS = 512
"""A screen of so many tones is taken tone by tone; a finer one is as good as continuous."""
EVEN = 256
"""Tones that are tried at first of a method that has no steps …"""
MOST = 512
"""… and the most that are tried, where the curve is steep or bends."""
STEP = 1 / 255
"""Of the span from ink to paper: printed tones are sought at most so far apart."""
CLOSEST = 1 / 16384
"""Of the span: tones are not tried closer than this."""
STEEPEST = 16.0
"""Of the mean slope: where a curve is steeper, it jumps."""
NOTED = 0.04
"""Luminance by which a curve falls that the user is told of; every fall stands in the report."""
OFF = 0.381966
"""Where in its interval a tone is tried: far from simple fractions, at which textures lock."""


@dataclass(frozen=True, eq=False)
class PrintCurve:
    """What is printed for what is asked of a method.

    asked, printed : float64 (T,), light of even patches, ascending, and their mean luminance in print.
    rising : whether *printed* never falls by more than a quarter of 1/255 of its span.
    note : what the user should know, or "".
    steps : whether these are all tones that the method has; the nearest is then asked for.
    origin : ``computed``, ``file`` or ``memory``.
    """

    asked: Float
    printed: Float
    rising: bool
    note: str = ""
    steps: bool = False
    origin: str = "computed"

    @property
    def falls(self) -> float:
        """The most that *printed* falls below what a darker tone printed."""
        return float((np.maximum.accumulate(self.printed) - self.printed).max())

    @property
    def darkest(self) -> float:
        """The least luminance that can be printed."""
        return float(self.printed.min())

    @property
    def lightest(self) -> float:
        """The greatest luminance that can be printed."""
        return float(self.printed.max())

    @property
    def has_tones(self) -> bool:
        """Whether anything between solid ink and paper is ever printed."""
        return bool(((self.printed > self.darkest) & (self.printed < self.lightest)).any())

    @cached_property
    def table(self) -> Light:
        """Light to ask for, float32 (ENTRIES,)."""
        chain = _chain(self.printed)
        printed, asked = self.printed[chain], self.asked[chain]
        slope = np.diff(printed) / np.diff(asked) * (asked[-1] - asked[0]) / (printed[-1] - printed[0])
        jump = (np.diff(chain) > 1) | (slope > STEEPEST) | self.steps
        at = np.flatnonzero(jump)  # the nearer of the two is asked for, nothing between them
        middle = (printed[at] + printed[at + 1]) / 2
        printed = np.insert(printed, np.repeat(at + 1, 2), np.repeat(middle, 2))
        asked = np.insert(
            asked, np.repeat(at + 1, 2), np.column_stack((asked[at], asked[at + 1])).ravel()
        )
        wanted = np.linspace(self.darkest, self.lightest, ENTRIES)
        return np.interp(wanted, printed, asked).astype(np.float32)

    def inverse(self, light: Light) -> Light:
        """Light to ask for, so that the luminance *light* is printed, or the nearest that can be."""
        scale = np.float32((ENTRIES - 1) / (self.lightest - self.darkest))
        place = (light - np.float32(self.darkest)) * scale + np.float32(0.5)
        asked: Light = np.take(self.table, np.clip(place, 0, ENTRIES - 1).astype(np.uint16))
        return asked


def print_curve(
    method: str | Method,
    levels: Levels,
    dot: DotModel,
    dpi: Dpi | None = None,
    measured: Measured | None = None,
) -> PrintCurve:
    """The print curve of *method* on two levels, of which the darker is printed as dots.

    measured : pairs of predicted and measured luminance, both rising, from a calibration.

    Raises :class:`UsageError` where there are more levels than two.
    """
    chosen = find_method(method)
    chosen.check(levels)
    if len(levels) != 2:
        raise UsageError(f"{len(levels)} levels; allowed: 2, as dots are of ink on paper")
    screen = _screen(chosen, dpi)
    pattern = chosen.scale > 1
    steps = pattern or (screen is not None and screen.tones <= MOST_STEPS)
    key = _key(chosen, levels, dot, dpi)
    asked, printed, origin = _kept(key)
    if asked is None or printed is None:
        field = _Field(chosen, levels, dot, dpi, screen)
        asked, printed = field.of_steps() if steps else field.of_any()
        _keep(key, asked, printed)
    if measured is not None:
        predicted, seen = np.array(measured, np.float64).T
        printed = np.interp(printed, predicted, seen)
    span = float(levels.lightest - levels.darkest)
    if not printed[-1] - printed[0] > 1e-4 * span:
        raise UsageError("the measured luminances do not rise from ink to paper; calibrate again")
    notes = []
    fall = float((np.maximum.accumulate(printed) - printed).max())
    rising = bool(fall <= STEP / 4 * (printed[-1] - printed[0]))
    if fall > NOTED:
        notes.append(
            f"the print curve of '{chosen.text()}' falls by up to {fall:.3f} where its texture "
            "locks: only tones that rise are asked for"
        )
    if 1 - dot.solid > STEP / 2 and measured is None:
        notes.append(
            f"dots of {dot.across:g} × {dot.down:g} leave paper between them: the darkest luminance "
            f"that can be printed is {printed.min():.3f}"
        )
    return PrintCurve(asked, printed, rising, "; ".join(notes), steps, origin)


@dataclass(frozen=True)
class _Field:
    """Even patches of a method in print."""

    method: Method
    levels: Levels
    dot: DotModel
    dpi: Dpi | None
    screen: Screen | None

    def printed(self, tones: Float) -> Float:
        """Mean luminance in print of a patch of each tone: of whole periods where there are any."""
        rows = columns = SIDE - 2 * RIM
        if self.method.scale > 1:
            rows = columns = 2
        elif self.screen is not None:
            rows, columns = (min(side, LARGEST) for side in self.screen.thresholds.shape)
        return np.array([self.patch(float(tone), rows, columns) for tone in tones])

    def patch(self, tone: float, rows: int, columns: int) -> float:
        """Mean luminance in print of an even patch, within a rim about it."""
        scale = self.method.scale
        rim = 1 if self.screen is not None or scale > 1 else RIM
        light = np.full((rows + 2 * rim, columns + 2 * rim), tone, np.float32)
        work = Halftoning(Source(light), self.method, self.levels, "clip", 1, Report(), self.dpi)
        covered = self.dot.covered((work.frame().indices == 0).astype(np.uint8))
        rim *= scale
        share = float(covered[rim:-rim, rim:-rim].mean(dtype=np.float64))
        return self.levels.lightest - (self.levels.lightest - self.levels.darkest) * share

    def of_steps(self) -> tuple[Float, Float]:
        """Every tone of a method of few tones, asked for by the middle between its borders."""
        if self.screen is None:  # patterns: the nearest tone is shown
            asked = np.linspace(0, 1, self.method.claim.tones)
        else:
            strength = getattr(self.method, "strength", 1.0)
            border = 0.5 + strength * (self.screen.ranked[0].astype(np.float64) - 0.5)
            asked = np.concatenate(([0.0], (border[1:] + border[:-1]) / 2, [1.0]))
        asked = self.levels.darkest + asked * (self.levels.lightest - self.levels.darkest)
        return asked, self.printed(asked)

    def of_any(self) -> tuple[Float, Float]:
        """Tones evenly, and more of them between those of the chain that print far apart."""
        span = self.levels.lightest - self.levels.darkest
        part = (np.arange(EVEN) + OFF) / EVEN
        asked = self.levels.darkest + span * np.concatenate(([0.0], part, [1.0]))
        printed = self.printed(asked)
        while len(asked) < MOST and ((printed > printed[0]) & (printed < printed[-1])).any():
            more = _missed(asked, printed, span)[: MOST - len(asked)]
            if not more.size:
                break
            asked = np.concatenate((asked, more))
            printed = np.concatenate((printed, self.printed(more)))
            order = np.argsort(asked, kind="stable")
            asked, printed = asked[order], printed[order]
        return asked, printed


def _missed(asked: Float, printed: Float, span: float) -> Float:
    """Tones to try next, the most wanted first: within intervals between neighbours that the curve
    crosses where the chain makes a wide step, unless the curve is straight there."""
    low, high = np.minimum(printed[1:], printed[:-1]), np.maximum(printed[1:], printed[:-1])
    width = np.diff(asked)
    slope = np.pad(np.diff(printed) / width, 1, mode="edge")
    bend = np.maximum(np.abs(slope[1:-1] - slope[:-2]), np.abs(slope[1:-1] - slope[2:])) * width
    wanted = np.zeros(width.size)
    chain = _chain(printed)
    for first, last in pairwise(chain):
        step = printed[last] - printed[first]
        straight = last == first + 1 and bend[first] < STEP / 8 * span
        if step > STEP * span and not straight:
            part = slice(first, last)
            crossed = (high[part] > printed[first]) & (low[part] < printed[last])
            wanted[part] = np.where(crossed, step, 0.0)
    wanted[width < CLOSEST * span] = 0.0
    order = np.argsort(-wanted, kind="stable")
    order = order[wanted[order] > 0]
    return asked[order] + OFF * width[order]


def _chain(printed: Float) -> NDArray[np.intp]:
    """Of the tones, ascending, those that rise from the first to the last by the smallest steps: with
    the least sum of squares. Of a curve that never falls, all that differ."""
    count = len(printed)
    cost, before = np.full(count, np.inf), np.zeros(count, np.intp)
    cost[0] = 0.0
    for last in range(1, count):
        step = printed[last] - printed[:last]
        total = np.where(step > 0, cost[:last] + step * step, np.inf)
        before[last] = np.argmin(total)
        cost[last] = total[before[last]]
    chain = [count - 1]
    while chain[-1]:
        chain.append(int(before[chain[-1]]))
    return np.array(chain[::-1])


def _screen(method: Method, dpi: Dpi | None) -> Screen | None:
    """The threshold array of a method that has one."""
    screen: Any = getattr(method, "screen", None)
    made = screen(dpi) if callable(screen) else screen
    return made if isinstance(made, Screen) else None


# --- kept curves

_MAGIC = b"halftone-curve-1\n"
_memory: dict[str, tuple[Float, Float]] = {}


def _key(method: Method, levels: Levels, dot: DotModel, dpi: Dpi | None) -> str:
    """Of everything a curve depends on; "" for a method that does not say what it is made of."""
    made: Any = method
    if not is_dataclass(made):
        return ""
    parts = _content((made, levels.luminance, dot, dpi, _sources()))
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:32]


def _content(value: Any) -> list[str]:
    if isinstance(value, np.ndarray):
        return [str(value.dtype), str(value.shape), hashlib.sha256(value.tobytes()).hexdigest()]
    if is_dataclass(value):
        found = [type(value).__qualname__]
        for item in fields(value):
            found += [item.name, *_content(getattr(value, item.name))]
        return found
    if isinstance(value, tuple | list):
        return ["(", *(part for item in value for part in _content(item)), ")"]
    return [repr(value)]


@lru_cache(maxsize=1)
def _sources() -> tuple[str, ...]:
    """Names, sizes and times of the files that a curve is computed by."""
    here = Path(__file__).parent
    files = [
        Path(__file__),
        *(f for room in ("dithering", "screens", "tone") for f in (here / room).rglob("*")),
    ]
    return tuple(
        f"{path.name} {path.stat().st_size} {path.stat().st_mtime_ns}"
        for path in sorted(files)
        if path.suffix in (".py", ".npz")
    )


def _path(key: str) -> Path:
    return _objects.directory() / f"{key}.curve"


def _kept(key: str) -> tuple[Float | None, Float | None, str]:
    known = _memory.get(key)
    if known is not None:
        return *known, "memory"
    try:
        blob = _path(key).read_bytes() if key else b""
    except (OSError, RuntimeError):  # RuntimeError: a user without a home folder
        blob = b""
    head, payload = blob[: len(_MAGIC) + 32], blob[len(_MAGIC) + 32 :]
    if head != _MAGIC + hashlib.sha256(payload).digest() or len(payload) % 16 or not payload:
        return None, None, "computed"
    _memory[key] = tuple(np.frombuffer(payload, "<f8").reshape(2, -1))  # type: ignore[assignment]
    return *_memory[key], "file"


def _keep(key: str, asked: Float, printed: Float) -> None:
    """In the process, and in the cache folder where that can be written."""
    if not key:
        return
    if len(_memory) >= 64:
        _memory.clear()
    _memory[key] = asked, printed
    payload = np.array((asked, printed), "<f8").tobytes()
    temporary = None
    try:
        path = _path(key)
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".curve")
        with os.fdopen(handle, "wb") as file:
            file.write(_MAGIC + hashlib.sha256(payload).digest() + payload)
        os.replace(temporary, path)
    except (OSError, RuntimeError):
        if temporary:
            Path(temporary).unlink(missing_ok=True)
