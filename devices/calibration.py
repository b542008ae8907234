"""Calibration: from a few readings of a chart to what a printer's dots and black really are.

The model is as simple as the readings allow. First a round dot and a black; then, each only where what
it explains is more than noise (:data:`DEMANDED`): a dot of two diameters, which lines across and down
tell apart; light that spreads within the paper; and last a curve of free pieces on top.

Sources: the dot model is :mod:`halftone.tone.dotgain`; the spread of light is Yule & Nielsen, The
penetration of light into paper (TAGA 3, 1951): roots of light mix, not light.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from devices.profile import DeviceProfile, folders, names
from halftone.errors import OutputError, UsageError
from halftone.tone.dotgain import DotModel

__all__ = ["Calibration", "fit", "pattern", "relative_light", "save"]

Float = NDArray[np.float64]

Pairs = tuple[tuple[float, float], ...]

SCALES = ("light", "density", "lstar")
"""What typed readings may be, all relative to the bare paper: light in %, D = −log10 light, or L*."""

NEEDED = 0.1
"""Of the paper's light: steps that differ less are no readings of a chart."""
DEMANDED = 4.0
"""A freedom is demanded by readings of which it explains so many times the noise's variance: noise alone
does so once in twenty times."""

BLACK, DOUBT = 0.05, 0.04
"""Light of solid ink before anything is read, and how sure that is: densities of 1 to 2."""
BLACKEST = 0.6
LEAST_NOISE = 0.003
WIDEST_SPREAD = 4.0
CONTRADICTS, CONTRADICTS_LIGHT, STRANGE = 6.0, 0.06, 0.1
"""A reading contradicts the others if it is off by so many times the noise, and at least so much light;
readings that are off by so much on the whole are not of this chart."""
PIECES_DEMANDED = 12.0
"""As DEMANDED, for a free point: where it stands is chosen too."""
PAIRS = 17
"""Points of a curve that is saved."""

_DIAMETERS = np.linspace(0.6, 3.0, 49)
_FINE = np.linspace(0.6, 3.0, 241)


@dataclass(frozen=True)
class Calibration:
    """What a printer was found to do.

    dot : its dot. black : light of solid ink, paper is 1. measured : (predicted, measured) light,
    rising, where the dot does not explain all; else None. noise : standard deviation of a reading.
    residuals : reading less model, one for each that was given. model : what it consists of.
    """

    dot: DotModel
    black: float
    measured: Pairs | None
    noise: float
    residuals: tuple[float, ...]
    model: str

    def light(self, patterns: Float) -> Float:
        """Light of patches by their neighbourhoods (n, 512), as of :class:`devices.chart.Chart`."""
        light = 1 - (1 - self.black) * (patterns @ self.dot.table)
        if self.measured is None:
            return np.asarray(light)
        predicted, seen = np.array(self.measured).T
        return np.asarray(np.interp(light, predicted, seen))


def relative_light(readings: Sequence[float], scale: str = "light") -> Float:
    """Readings as light relative to paper, 0 … 1. scale : one of :data:`SCALES`."""
    given = np.array(readings, np.float64)
    if scale not in SCALES:
        raise UsageError(f"readings as '{scale}'; allowed: {', '.join(SCALES)}")
    if scale == "density":
        light = 10.0**-given
    elif scale == "lstar":
        light = np.where(given > 8, ((given + 16) / 116) ** 3, given / 903.2963)
    else:
        light = given / 100
    wrong = np.flatnonzero(~((light >= 0) & (light <= 1.1)))
    if wrong.size:
        k = int(wrong[0])
        meant = {"light": "0 … 100 % of the paper's light", "density": "0 and more", "lstar": "0 … 100"}
        raise UsageError(
            f"reading {k + 1} is {given[k]:g}; allowed: {meant[scale]}, with the bare paper as white"
        )
    return np.asarray(light)


def fit(
    patterns: Float, light: Float, noise: float | None = None, steps: int | None = None
) -> Calibration:
    """The calibration that readings of a chart's patches demand.

    patterns : float64 (n, 512), of the patches. light : float64 (n,), read of each, 1 is the paper.
    noise : standard deviation of a reading; None finds it from the readings. steps : how many of the
    patches are steps; what follows are vertical and horizontal lines. None: all.

    Raises :class:`UsageError` for readings that contradict each other, and names them.
    """
    lines = steps is not None and steps < len(light)
    if len(light) < 5 or patterns.shape != (len(light), 512):
        raise UsageError(f"{len(light)} readings for {len(patterns)} patches; needed: 5, one each")
    if np.ptp(light[:steps]) < NEEDED:
        raise UsageError("the steps differ by less than 10 % of the paper's light: read them again")
    if noise is not None and not 0 < noise < 0.5:
        raise UsageError(f"noise = {noise:g}; allowed: above 0, below 0.5 of the paper's light")
    patches = _Patches(patterns, light)
    richest = patches.best(_Model(lines, True), 0.0)
    found = noise or patches.noise(richest)
    best = patches.best(_Model(False, False), found)
    for model in (_Model(lines, False), _Model(best.model.apart, True), _Model(lines, True)):
        extra = model.freedoms - best.model.freedoms
        richer = patches.best(model, found, best) if extra > 0 else best
        if best.error - richer.error > DEMANDED * extra * found**2:
            best = richer
    _check(patches, best, noise)
    pairs = _pairs(best, patches, noise)
    dot = DotModel(round(best.across, 4), round(best.down, 4))
    made = Calibration(dot, round(best.black, 5), pairs, 0.0, (), str(best.model))
    residuals = light - made.light(patterns)
    free = 0 if pairs is None else len(pairs) - 2
    if pairs is not None and not best.model.spread:
        made = replace(made, model=f"{made.model}, {free} free points on top")
    found = noise or max(LEAST_NOISE, float(np.sqrt((residuals**2).sum() / (len(light) - 2))))
    return replace(made, noise=round(found, 5), residuals=tuple(round(float(r), 5) for r in residuals))


def pattern(indices: NDArray[np.uint8]) -> Float:
    """How often each 3 × 3 neighbourhood occurs, float64 (512,)."""
    ink = 1 - indices.astype(np.int64)
    rows, columns = ink.shape[0] - 2, ink.shape[1] - 2
    code = np.zeros((rows, columns), np.int64)
    for bit in range(9):
        top, left = divmod(bit, 3)
        code |= ink[top : top + rows, left : left + columns] << bit
    return np.bincount(code.ravel(), minlength=512) / code.size


def save(
    calibration: Calibration, base: DeviceProfile, name: str, said: str, *, overwrite: bool = False
) -> Path:
    """The user's own profile *name*: that of *base* with what was found, and what is *said* of it.

    Raises :class:`OutputError` where there is one already, unless *overwrite*; the file is written
    whole or not at all.
    """
    from halftone.images.output import output

    if not name or name.startswith(".") or not all(c.isalnum() or c in "-_." for c in name):
        raise UsageError(f"the profile name '{name}'; allowed: letters, digits, - _ and .")
    own = folders()
    if len(own) < 2:
        raise OutputError("there is no home folder for profiles; set XDG_CONFIG_HOME")
    path = own[0] / f"{name.removesuffix('.toml')}.toml"
    if (path.exists() or path.stem in names()) and not overwrite:
        raise OutputError(f"a profile '{path.stem}' exists; take another name, or --force to replace it")
    made = replace(
        base,
        name=path.stem,
        title=f"{base.title}, calibrated",
        provenance=f"{base.provenance}. {said}",
        level_luminance=(calibration.black, 1.0),
        dot_x=calibration.dot.across,
        dot_y=calibration.dot.down,
        measured=calibration.measured,
    )
    lines = [
        f"{field.name} = {_toml(value)}\n"
        for field in fields(made)
        if field.name != "name" and (value := getattr(made, field.name)) is not None and value != {}
    ]
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"the folder '{path.parent}' cannot be made: {error.strerror}") from None
    with output(path, overwrite=overwrite) as file:
        file.write("".join(lines).encode())
    return path


def _toml(value: Any) -> str:
    """A value as TOML."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        import json

        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")  # a TOML string too
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_toml(k)} = {_toml(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml, value))}]"
    return repr(value)


@dataclass(frozen=True)
class _Model:
    """apart : whether the dot has two diameters. spread : whether light spreads within the paper."""

    apart: bool
    spread: bool

    @property
    def freedoms(self) -> int:
        return 2 + self.apart + self.spread

    def __str__(self) -> str:
        dot = "a dot of two diameters" if self.apart else "a round dot"
        return f"{dot}, black" + (", light that spreads in the paper" if self.spread else "")


@dataclass(frozen=True)
class _Fitted:
    """A model at its best. spread : Yule's and Nielsen's n. light : predicted. error : squared."""

    model: _Model
    across: float
    down: float
    black: float
    spread: float
    light: Float
    error: float


def _mixed(covered: Float, black: float, spread: float) -> Float:
    """Light of paper that is covered so far."""
    return np.asarray((1 - covered + covered * max(black, 0.0) ** (1 / spread)) ** spread)


class _Patches:
    """Readings, and what a model predicts of them."""

    def __init__(self, patterns: Float, light: Float) -> None:
        self.patterns, self.light = patterns, light
        self.coverage = patterns @ _round_tables().T  # (n, diameters)
        self.fine = np.array([np.interp(_FINE, _DIAMETERS, row) for row in self.coverage])

    def without(self, k: int) -> _Patches:
        return _Patches(np.delete(self.patterns, k, axis=0), np.delete(self.light, k))

    def covered(self, across: float, down: float) -> Float:
        """Covered share of every patch, between tables that are apart by a little."""
        if across == down:
            k, share = _between(across, _FINE)
            return np.asarray(self.fine[:, k] * (1 - share) + self.fine[:, k + 1] * share)
        (i, p), (j, q) = _between(across, _DIAMETERS), _between(down, _DIAMETERS)
        upper = _table(i, j) * (1 - q) + _table(i, j + 1) * q
        lower = _table(i + 1, j) * (1 - q) + _table(i + 1, j + 1) * q
        return np.asarray(self.patterns @ (upper * (1 - p) + lower * p))

    def noise(self, fitted: _Fitted) -> float:
        """Standard deviation of a reading, from what a model leaves."""
        rest = ((self.light - fitted.light) ** 2).sum()
        freedom = max(1, len(self.light) - fitted.model.freedoms)
        return float(np.clip(np.sqrt(rest / freedom), LEAST_NOISE, 0.1))

    def best(self, model: _Model, noise: float, start: _Fitted | None = None) -> _Fitted:
        """*model* by least squares, from *start* or the best of a coarse grid of diameters."""
        found = []
        for spread in (1.5, 3.0) if model.spread else (1.0,):
            error = ((_mixed(self.fine, BLACK, spread) - self.light[:, None]) ** 2).sum(0)
            d = float(_FINE[error.argmin()])
            first = [d, d, BLACK, spread]
            if start is not None:
                first = [start.across, start.down, start.black, spread]
            found.append(self._descended(model, np.array(first), noise))
        return min(found, key=lambda fitted: fitted.error)

    def _descended(self, model: _Model, first: Float, noise: float) -> _Fitted:
        """Levenberg's and Marquardt's steps from *first*: across, down, black, spread."""
        into = np.array([[1, 1 - model.apart, 0, 0], [0, 0, 1, 0], [0, model.apart, 0, 0], [0, 0, 0, 1]])
        into = into[[True, True, model.apart, model.spread]]  # from what is free to all four
        low, high = np.array([[0.6, 0.6, 0, 1], [3, 3, BLACKEST, WIDEST_SPREAD]])

        def off(values: Float) -> Float:
            light = _mixed(self.covered(*values[:2]), values[2], values[3])
            return np.append(light - self.light, (values[2] - BLACK) / DOUBT * noise)

        values, damping = np.clip(first, low, high), 1e-3
        rest = off(values)
        for _ in range(30):
            slopes = []
            for way in into:
                step = 0.01 * way * np.where(values + 0.01 * way > high, -1, 1)
                slopes.append((off(values + step) - rest) / (step @ way) * (way @ way))
            jacobian = np.array(slopes).T
            normal = jacobian.T @ jacobian
            normal += damping * np.diag(np.diag(normal) + 1e-9)
            change = np.linalg.solve(normal, -jacobian.T @ rest)
            moved = np.clip(values + change @ into, low, high)
            new = off(moved)
            if new @ new < rest @ rest:
                done = rest @ rest - new @ new < 1e-4 * (new @ new) + 1e-12
                values, rest, damping = moved, new, damping / 6
                if done:
                    break
            elif damping > 10:
                break
            else:
                damping *= 6
        across, down, black, spread = (float(v) for v in values)
        light = rest[:-1] + self.light
        return _Fitted(model, across, down, black, spread, light, float(rest @ rest))


def _check(patches: _Patches, best: _Fitted, noise: float | None) -> None:
    """Name readings that the others contradict, each compared with a fit without it."""
    wrong = []
    for k, light in enumerate(patches.light):
        if abs(light - best.light[k]) < CONTRADICTS_LIGHT / 4:  # it pulls the fit by no more than that
            continue
        others = patches.without(k)
        fitted = others.best(best.model, noise or 0.02, best)
        expected = _mixed(patches.covered(fitted.across, fitted.down)[k], fitted.black, fitted.spread)
        limit = max(CONTRADICTS * (noise or others.noise(fitted)), CONTRADICTS_LIGHT)
        if abs(light - expected) > limit:
            wrong.append(f"number {k + 1} is {100 * light:.1f} % and should be {100 * expected:.1f} %")
    if wrong:
        raise UsageError(f"readings contradict the others: {'; '.join(wrong)}. Measure those again")
    off = np.abs(patches.light - best.light)
    if np.sqrt((off**2).mean()) > STRANGE:
        worst = " and ".join(str(k + 1) for k in sorted(np.argsort(off)[-2:]))
        raise UsageError(
            f"readings contradict each other: no dot explains them within {100 * STRANGE:.0f} %, "
            f"numbers {worst} least of all. Are they of this chart, from the darkest on? "
            "Measure those steps again"
        )


def _pairs(
    best: _Fitted, patches: _Patches, noise: float | None
) -> tuple[tuple[float, float], ...] | None:
    """(light that dot and black predict, light measured): the spread in paper, and points added freely
    as long as each explains more than noise. None: there is nothing to add."""
    plain = 1 - (1 - best.black) * patches.covered(best.across, best.down)
    rest = patches.light - best.light
    error, freedom = float(rest @ rest), len(rest) - best.model.freedoms
    points: list[float] = []
    heights = np.zeros(2)
    while len(points) < len(rest) // 3:
        tried = []
        for where in np.unique(np.round(plain, 2)):
            if all(abs(where - p) > 0.03 for p in [*points, best.black, 1.0]):
                at = np.array(sorted([best.black, *points, where, 1.0]))
                hats = np.array([np.interp(plain, at, row) for row in np.eye(len(at))[1:-1]]).T
                found = np.linalg.lstsq(hats, rest, rcond=None)[0]
                tried.append((float(((rest - hats @ found) ** 2).sum()), where, found))
        if not tried:
            break
        left, where, found = min(tried, key=lambda t: t[0])
        freedom -= 1
        variance = noise**2 if noise else max(left / max(1, freedom), LEAST_NOISE**2)
        if error - left <= PIECES_DEMANDED * variance:
            break
        error, points, heights = left, sorted([*points, float(where)]), np.array([0, *found, 0])
    if not points and not best.model.spread:
        return None
    at = np.array([best.black, *points, 1.0])
    curve = np.linspace(best.black, 1, PAIRS) if best.model.spread else at
    light = np.unique(np.concatenate([at, curve]).round(5))
    covered = (1 - light) / (1 - best.black)
    seen = _mixed(np.clip(covered, 0, 1), best.black, best.spread) + np.interp(light, at, heights)
    least = 1e-4 * np.arange(len(seen))  # a curve that rises everywhere, if only by that
    seen = np.maximum.accumulate(np.minimum(seen, 1 + least - least[-1]) - least) + least
    return tuple((float(a), round(float(b), 5)) for a, b in zip(light, seen, strict=True))


def _between(value: float, grid: Float) -> tuple[int, float]:
    """The place before *value* in an even grid, and how far it is on its way to the next."""
    place = (value - grid[0]) / (grid[1] - grid[0])
    k = min(max(int(place), 0), len(grid) - 2)
    return k, place - k


@lru_cache(maxsize=1024)
def _table(across: int, down: int) -> Float:
    """Covered areas of all neighbourhoods, float64 (512,), by the places of two diameters."""
    return DotModel(float(_DIAMETERS[across]), float(_DIAMETERS[down])).table.astype(np.float64)


@lru_cache(maxsize=1)
def _round_tables() -> Float:
    """Those of round dots, float64 (diameters, 512)."""
    return np.array([_table(k, k) for k in range(len(_DIAMETERS))])
