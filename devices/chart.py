"""The step chart by which a printer's tone is measured, and reading it from a photo or a scan.

In a black frame lie patches of known light as the method prints them without any correction, row by
row from the darkest; then one of vertical and one of horizontal lines, and places left white. A black
square in the upper left corner says which way up it is, a second one that there are 17 steps. All
places are in units, of which each is the same number of dots.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from devices.calibration import pattern
from devices.profile import DeviceProfile
from halftone._arrays import LUMINANCE
from halftone.errors import InputFileError, UsageError
from halftone.frame import Frame
from halftone.recipe import Recipe

__all__ = ["STEPS", "Chart", "Reading", "make_chart", "read_chart"]

Float = NDArray[np.float64]
Point = tuple[float, float]

STEPS = {
    9: (0.0, 0.03, 0.07, 0.5, 0.66, 0.72, 0.77, 0.84, 0.89),
    17: (0, 0.02, 0.04, 0.07, 0.1, 0.3, 0.45, 0.5, 0.58, 0.66, 0.71, 0.74, 0.77, 0.81, 0.85, 0.89, 0.94),
}
"""Share of white in each step, where 0 is solid ink: dense where printed light depends most on the size
of the dots, and at the dark end, which says how black the ink is. White is the paper between them."""

WIDE, ROW, TOP = 60, 12, 12  # units: of the chart, from patch to patch, and above the first of them
PATCH, EDGE, FRAME = 8, 2, 2
INSIDE = 0.15
"""Share of a patch at each side that is not read: blur, and light that strays from the paper."""
SMALLEST, USUAL, MILLIMETRES = 4, 9, 1.1
"""Dots in a unit; and its size on paper where the dots are fine."""

FEWEST_PIXELS = 3.0
"""Pixels in a unit of a photo that can be read: a patch then has 17 × 17 that count."""
DARKEST, CLIPPED = 0.06, 0.995
"""Light of paper below which a photo is too dark; and from which it may be lighter than it says."""


@dataclass(frozen=True)
class _Layout:
    """Where everything is, in units from the upper left corner of the chart."""

    steps: int

    @property
    def height(self) -> int:
        return TOP + ROW * (-(-(self.steps + 3) // 4)) + FRAME + EDGE

    def patches(self) -> list[tuple[int, int]]:
        """Upper left corner of every place for a patch, by rows; the last are left white."""
        rows = (self.height - TOP) // ROW
        return [(EDGE + FRAME + 4 + ROW * k, TOP + ROW * row) for row in range(rows) for k in range(4)]

    def frame(self) -> list[Point]:
        """Outer corners of the frame, clockwise."""
        right, bottom = WIDE - EDGE, self.height - EDGE
        return [(EDGE, EDGE), (right, EDGE), (right, bottom), (EDGE, bottom)]


@dataclass(frozen=True, eq=False)
class Chart:
    """A chart for one device and method.

    frame : as it is sent to the device. steps : how many. method : its text form.
    patterns : float64 (steps + 2, 512), how often each 3 × 3 neighbourhood of dots (the index of
    :attr:`DotModel.table`) is in what is read of each step, and of vertical and horizontal lines.
    """

    frame: Frame
    steps: int
    method: str
    patterns: Float


def make_chart(profile: DeviceProfile, steps: int = 9, method: str | None = None) -> Chart:
    """The chart of *steps* steps, 9 or 17, for a device of two levels."""
    if steps not in STEPS:
        raise UsageError(f"steps = {steps}; allowed: {' or '.join(map(str, STEPS))}")
    if len(profile.levels) != 2:
        raise UsageError(
            f"'{profile.name}' has {len(profile.levels)} levels: a chart is for printers of two. "
            "Measure the levels themselves and give them as level_luminance in a profile of your own"
        )
    layout = _Layout(steps)
    down, across = _unit(profile, layout)
    indices = np.ones((layout.height * down, WIDE * across), np.uint8)

    def block(x: float, y: float, wide: float, high: float) -> NDArray[np.uint8]:
        """The dots of a rectangle, given in units."""
        rows = slice(round(y * down), round((y + high) * down))
        return indices[rows, round(x * across) : round((x + wide) * across)]

    wide, high = WIDE - 2 * EDGE, layout.height - 2 * EDGE
    block(EDGE, EDGE, wide, high)[:] = 0
    block(EDGE + FRAME, EDGE + FRAME, wide - 2 * FRAME, high - 2 * FRAME)[:] = 1
    for x, y in _markers(steps):
        block(x, y, 4, 4)[:] = 0
    # Without its dots a device has nothing that could be corrected.
    bare = replace(profile, dot_x=None, dot_y=None, measured=None, width=None, height=None)
    text, patterns = "", []
    for place, (x, y) in enumerate(layout.patches()[: steps + 2]):
        patch = block(x, y, PATCH, PATCH)
        if place < steps:
            text, patch[:] = _flat(bare, method, STEPS[steps][place], patch.shape)
        else:
            line = (slice(None), slice(None, None, 3))
            patch[line if place == steps else line[::-1]] = 0
        inner = PATCH * (1 - 2 * INSIDE)
        patterns.append(pattern(block(x + PATCH * INSIDE, y + PATCH * INSIDE, inner, inner)))
    frame = Frame(indices, profile.levels, text, profile.dpi, profile.packing)
    return Chart(frame, steps, text, np.array(patterns))


def _markers(steps: int) -> list[tuple[int, int]]:
    return [(6, 6), (12, 6)] if steps == 17 else [(6, 6)]


def _unit(profile: DeviceProfile, layout: _Layout) -> tuple[int, int]:
    """Dots of a unit down and across."""
    shape = 1.0 if profile.dpi is None else profile.dpi[1] / profile.dpi[0]
    across = USUAL if profile.dpi is None else max(USUAL, round(profile.dpi[0] * MILLIMETRES / 25.4))
    if profile.width is not None:
        across = min(across, profile.width // WIDE)
    if profile.height is not None:
        across = min(across, int(profile.height / layout.height / shape))
    down = max(1, int(across * shape + 0.5))
    if min(across, down) < SMALLEST:
        raise UsageError(
            f"'{profile.name}' has {profile.width} × {profile.height} dots; {layout.steps} steps need "
            f"{WIDE * SMALLEST} × {layout.height * SMALLEST}. Take 9 steps, or a larger label"
        )
    return down, across


def _flat(
    profile: DeviceProfile, method: str | None, share: float, shape: tuple[int, ...]
) -> tuple[str, NDArray[np.uint8]]:
    """An even patch, from the inside of a larger one: without what a method does at its start."""
    skip = 48
    rows, columns = shape[0] + skip, shape[1] + skip
    light = profile.levels.darkest + share * (profile.levels.lightest - profile.levels.darkest)
    recipe = Recipe(profile=profile, method=method, width=columns, height=rows)
    frame = recipe.convert(np.full((rows, columns), light, np.float32))
    return frame.method, frame.indices[skip:, skip:]


@dataclass(frozen=True, eq=False)
class Reading:
    """What a photo says. light : float64 (steps + 2,), of each patch relative to the paper round it.
    spread : float64 (steps + 2,), standard error of each, from its parts. steps : how many."""

    light: Float
    spread: Float
    steps: int


def read_chart(picture: str | Path | Any, encoding: str | None = None) -> Reading:
    """The patches of a chart in a photo or a scan, turned and tilted as it may be.

    picture : a file, or linear light (M, N) or (M, N, 3). encoding : what the file's codes mean, sRGB
    unless the file says otherwise. Uneven light is divided out by the paper round each patch.

    Raises :class:`InputFileError`: not found, too small, too dark, over-exposed, and what to do.
    """
    name, light = "the picture", picture
    if isinstance(picture, str | Path):
        from halftone.pipeline import read

        name, light = f"'{picture}'", read(picture, encoding=encoding)
    light = np.asarray(light, np.float32)
    clipped = np.asarray(light >= CLIPPED)
    if light.ndim == 3:
        light, clipped = light @ np.array(LUMINANCE, np.float32), np.any(clipped, axis=2)
    if np.percentile(light, 99) < DARKEST:
        raise _too_dark(name, float(np.percentile(light, 99)))
    found = next(filter(None, (_upright(light, corners) for corners in _frames(light))), None)
    if found is None:
        if clipped.mean() > 0.8:
            raise _over_exposed(name, float(clipped.mean()))
        raise InputFileError(
            f"{name}: no chart was found. The whole black frame must be in the picture, sharp, seen "
            "from above, with white paper round it"
        )
    map_, layout, unit = found
    if unit < FEWEST_PIXELS:
        raise InputFileError(
            f"{name}: the chart is too small, {unit * PATCH:.0f} pixels a patch; needed: "
            f"{FEWEST_PIXELS * PATCH:.0f}. Take it from nearer, or scan it finer"
        )
    return _measured(name, light, clipped, map_, layout)


def _too_dark(name: str, light: float) -> InputFileError:
    return InputFileError(
        f"{name} is too dark to read: its white is {100 * light:.1f} % light; needed: "
        f"{100 * DARKEST:.0f} % and more. Give it more light or a longer exposure"
    )


def _over_exposed(name: str, share: float) -> InputFileError:
    return InputFileError(
        f"{name} is over-exposed: {100 * share:.0f} % of the paper is as light as the file can say. "
        "Take it darker, with the paper a light gray, and automatic corrections off"
    )


def _frames(light: NDArray[np.float32]) -> Iterator[Float]:
    """Corners (4, 2) of what may be the chart's frame, the largest first: x and y in pixels."""
    step = max(1, -(-max(light.shape) // 600))
    rows, columns = (n // step for n in light.shape)
    small = light[: rows * step, : columns * step].reshape(rows, step, columns, step).mean(axis=(1, 3))
    parts = [p for p in _dark_parts(small) if len(p) > 50]
    parts.sort(key=lambda p: -float(np.prod(np.ptp(p, axis=0))))
    for part in parts[:4]:
        inside = part.min() > 0 and (part.max(axis=0) < [columns - 1, rows - 1]).all()
        if not inside or (np.ptp(part, axis=0) < 40).any():
            continue
        corners = (_widest(part.astype(np.float64)) + 0.5) * step - 0.5
        yield _refined(light, corners)


def _dark_parts(small: NDArray[np.float32]) -> list[NDArray[np.int64]]:
    """Connected areas darker than their surroundings: (n, 2), the x and y of their pixels."""
    dark = small < 0.6 * _surroundings(small, max(small.shape) // 6)
    runs: list[tuple[int, int, int]] = []  # row, first column, the column after the last
    parent: list[int] = []

    def root(run: int) -> int:
        while parent[run] != run:
            parent[run] = parent[parent[run]]
            run = parent[run]
        return run

    above: list[int] = []
    for y, row in enumerate(dark):
        edges = np.flatnonzero(np.diff(row, prepend=False, append=False)).tolist()
        here, other = [], 0
        for first, last in zip(edges[::2], edges[1::2], strict=True):
            here.append(len(runs))
            runs.append((y, first, last))
            parent.append(here[-1])
            while other < len(above) and runs[above[other]][2] <= first:
                other += 1
            for touching in above[other:]:
                if runs[touching][1] >= last:
                    break
                parent[root(touching)] = root(here[-1])
        above = here
    parts: dict[int, list[NDArray[np.int64]]] = {}
    for run, (y, first, last) in enumerate(runs):
        x = np.arange(first, last)
        parts.setdefault(root(run), []).append(np.stack([x, np.full_like(x, y)], axis=1))
    return [np.concatenate(pieces) for pieces in parts.values()]


def _surroundings(small: NDArray[np.float32], reach: int) -> Float:
    """Mean light of the square about every pixel, as much of it as there is."""
    total = np.pad(small.astype(np.float64).cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    rows, columns = small.shape
    top, bottom = (np.clip(np.arange(rows) + d, 0, rows)[:, None] for d in (-reach, reach + 1))
    left, right = (np.clip(np.arange(columns) + d, 0, columns) for d in (-reach, reach + 1))
    found = total[bottom, right] - total[top, right] - total[bottom, left] + total[top, left]
    return np.asarray(found / ((bottom - top) * (right - left)))


def _widest(points: Float) -> Float:
    """The four of *points* (n, 2) that span the largest area, in order round it."""
    angles = np.arange(0, np.pi, np.pi / 90)  # only what is outermost in some direction can be one
    ways = points @ np.array([np.cos(angles), np.sin(angles)])
    outer = np.unique(points[np.concatenate([ways.argmax(0), ways.argmin(0)])], axis=0)
    outer = outer[np.argsort(np.arctan2(*(outer - outer.mean(0)).T[::-1]))]
    quad = outer[np.arange(4) * len(outer) // 4]
    for _ in range(8):  # each in turn to where it adds most
        for k in range(4):
            before, after = quad[k - 1], quad[(k + 1) % 4]
            way = np.array([(after - before)[1], -(after - before)[0]])
            quad[k] = outer[((outer - before) @ way).argmax()]
    return quad


def _refined(light: NDArray[np.float32], corners: Float) -> Float:
    """Corners where lines through the outer edge of the frame meet, each found at half its light."""
    lines = []
    for k in range(4):
        a, b = corners[k], corners[(k + 1) % 4]
        way = (b - a) / np.hypot(*(b - a))
        out = np.array([way[1], -way[0]])
        if out @ (a - corners.mean(0)) < 0:
            out = -out
        reach = 0.025 * np.hypot(*(b - a))
        depth = np.linspace(-reach, reach, 81)
        along = a + np.linspace(0.08, 0.92, 60)[:, None] * (b - a)
        seen = _sampled(light, along[:, None] + depth[:, None] * out)
        half = (seen.min(1) + seen[:, -8:].mean(1)) / 2
        last = seen.shape[1] - 1 - (seen < half[:, None])[:, ::-1].argmax(1)  # the outermost dark one
        points = along + depth[last][:, None] * out
        keep = np.ones(len(points), bool)
        for _ in range(3):
            slope, start = np.polyfit((points[keep] - a) @ way, (points[keep] - a) @ out, 1)
            off = np.abs((points - a) @ out - slope * ((points - a) @ way) - start)
            keep = off <= max(0.5, 2 * float(np.median(off)))
        across = out - slope * way  # points p of the line have p · across as its start has
        lines.append((across, (a + start * out) @ across))
    pairs = [(lines[k - 1], lines[k]) for k in range(4)]
    return np.array([np.linalg.lstsq([u, v], [s, t], rcond=None)[0] for (u, s), (v, t) in pairs])


def _sampled(light: NDArray[np.float32] | NDArray[np.bool_], points: Float) -> Float:
    """Light at *points* (…, 2), x and y in pixels, between the four pixels round each."""
    rows, columns = light.shape
    x, y = np.clip(points[..., 0], 0, columns - 1.001), np.clip(points[..., 1], 0, rows - 1.001)
    i, j = y.astype(np.int64), x.astype(np.int64)
    p, q = y - i, x - j
    upper = light[i, j] * (1 - q) + light[i, j + 1] * q
    return np.asarray(upper * (1 - p) + (light[i + 1, j] * (1 - q) + light[i + 1, j + 1] * q) * p)


@dataclass(frozen=True, eq=False)
class _Map:
    """From units of the chart to pixels of the photo, by a projection (3, 3)."""

    matrix: Float

    @classmethod
    def of(cls, units: list[Point], pixels: Float) -> _Map:
        rows = []
        for (x, y), (p, q) in zip(units, pixels, strict=True):
            rows += [[x, y, 1, 0, 0, 0, -p * x, -p * y], [0, 0, 0, x, y, 1, -q * x, -q * y]]
        found = np.linalg.lstsq(np.array(rows, np.float64), pixels.ravel(), rcond=None)[0]
        return cls(np.append(found, 1.0).reshape(3, 3))

    def block(self, x: float, y: float, wide: float, high: float, fine: float = 8) -> Float:
        """Points (n, m, 2) of a rectangle in units, *fine* to the unit."""
        u = x + (np.arange(int(wide * fine)) + 0.5) / fine
        v = y + (np.arange(int(high * fine)) + 0.5) / fine
        grid = np.stack([*np.meshgrid(u, v), np.ones((v.size, u.size))], axis=-1) @ self.matrix.T
        return np.asarray(grid[..., :2] / grid[..., 2:])


def _upright(light: NDArray[np.float32], corners: Float) -> tuple[_Map, _Layout, float] | None:
    """Which way up the chart is and how many steps it has; with the pixels in a unit. None: no chart."""
    (a, b), (c, d) = corners[1] - corners[0], corners[2] - corners[1]
    if a * d < b * c:
        corners = corners[::-1]
    best, found = 0.35, None
    for steps in STEPS:
        layout = _Layout(steps)
        for turn in range(4):
            turned = np.roll(corners, turn, axis=0)
            map_ = _Map.of(layout.frame(), turned)

            def mean(x: float, y: float, wide: float, high: float, map_: _Map = map_) -> float:
                return float(_sampled(light, map_.block(x, y, wide, high, 2)).mean())

            dark = [(x + 1, y + 1, 2, 2) for x, y in _markers(steps)]
            marks = [mean(*place) for place in [*dark, (13, EDGE + 0.5, 30, 1)]]
            blank = [mean(x + 1, 7, 2, 2) for x in range(_markers(steps)[-1][0] + 6, 52, 6)]
            blank += [mean(x - 3, y, 2, PATCH) for x, y in layout.patches()]
            score = (min(blank) - max(marks)) / max(max(blank), 1e-9)
            if score > best:
                sides = np.hypot(*(turned - np.roll(turned, 1, axis=0)).T)
                best = score
                found = map_, layout, float(sides.min() / max(WIDE, layout.height))
    return found


def _measured(
    name: str, light: NDArray[np.float32], clipped: NDArray[np.bool_], map_: _Map, layout: _Layout
) -> Reading:
    """The patches relative to the paper round them, each as the mean of 4 × 4 parts."""
    values, spreads, papers, full = [], [], [], []
    rim, inner = PATCH * INSIDE, PATCH * (1 - 2 * INSIDE)
    for x, y in layout.patches()[: layout.steps + 2]:
        ring = [(-3, -3, 14, 2), (-3, 9, 14, 2), (-3, -1, 2, 10), (9, -1, 2, 10)]
        points = [map_.block(x + dx, y + dy, wide, high) for dx, dy, wide, high in ring]
        paper = float(np.mean([np.median(_sampled(light, side)) for side in points]))
        full.append(np.mean([_sampled(clipped, side).mean() for side in points]))
        seen = _sampled(light, map_.block(x + rim, y + rim, inner, inner, 80 / inner))
        side = seen.shape[0] // 4
        parts = seen[: 4 * side, : 4 * side].reshape(4, side, 4, side).mean(axis=(1, 3))
        values.append(float(seen.mean()) / max(paper, 1e-9))
        spreads.append(float(parts.std(ddof=1)) / 4 / max(paper, 1e-9))
        papers.append(paper)
    if np.median(papers) < DARKEST:
        raise _too_dark(name, float(np.median(papers)))
    if np.mean(full) > 0.2:
        raise _over_exposed(name, float(np.mean(full)))
    return Reading(np.array(values), np.array(spreads), layout.steps)
