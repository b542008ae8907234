"""What a device makes of a picture, side by side: the picture asked for, the dots sent, what is seen.

``Preview.of("photo.jpg", profile=load("receipt-80mm"))`` shows itself in a notebook.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import BAND_ROWS, LUMINANCE, Light, whole
from halftone._parallel import bands
from halftone.errors import InputError, InputFileError, UsageError, near
from halftone.frame import Bands, Frame
from halftone.images.places import Place
from halftone.recipe import Recipe
from halftone.tone.levels import Levels
from halftone.tone.transfer import encoding

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["DISTANCE", "PANELS", "Preview", "preview_of"]

PANELS = {
    "asked": "the picture asked for: light at the device's size and within its range",
    "sent": "the dots sent, as ideal levels would show them",
    "seen": "what is seen at a distance: printed dots on paper, or the levels of the glass",
}

DISTANCE = 30.0
"""Centimetres from which a print or a panel in the hand is looked at."""
FURTHEST_CM = 500.0
CM_PER_INCH = 2.54

WIDE, PIXELS = 2000, 1 << 25
"""Neither is exceeded by the default scale, but a dot is a pixel at least."""

DRAWN = 4
"""The scale from which on printed dots are drawn with their shapes."""

SEPARATOR, GRAY = 4, 128
"""Pixels between two panels, and their code: neither paper nor ink."""

BYTES_A_DOT, BYTES_A_SAMPLE = 40, 20
"""Held for a dot: light asked for, index, light shown and seen, and what the eye's filter needs; and for
each sample of a drawn dot."""

Codes = NDArray[np.uint8]
Progress = Callable[[float], None]


@dataclass(frozen=True, eq=False)
class Preview:
    """asked, shown : float32 (M, N), light asked for, and light that the device shows from near.

    sent : the dots. distance : centimetres to the viewer; 0 is a magnifying glass. paper : draws the
    dots of a printer, or None. max_memory : bytes that a picture may take.
    """

    asked: Light
    sent: Frame
    shown: Light
    distance: float
    paper: Any = None
    max_memory: int = 4 << 30

    @classmethod
    def of(
        cls,
        picture: Any,
        *,
        distance: float = DISTANCE,
        progress: Progress | None = None,
        **options: Any,
    ) -> Preview:
        """Of a *picture* with *options* as :func:`halftone.convert` takes them."""
        return preview_of(Recipe(**options), picture, distance, progress)

    @property
    def shape(self) -> tuple[int, int]:
        return self.sent.shape

    def light(self, panel: str) -> Light:
        """Light of one of :data:`PANELS`, float32 (M, N), a value a dot."""
        if panel == "asked":
            return self.asked
        return self.sent.luminance if panel == "sent" else self._at_distance(self.shown, 1)

    def best_scale(self, panel: str = "all") -> int:
        """The largest scale of a picture up to 2,000 pixels wide and of 32 Mi pixels; 1 at least."""
        count, (rows, columns) = len(chosen(panel)), self.shape
        room = (WIDE - (count - 1) * SEPARATOR) // (count * columns)
        most = int((PIXELS / (count * rows * columns)) ** 0.5)
        return max(1, min(room, most, 256))

    def bands(self, scale: int | None = None, panel: str = "all") -> Bands:
        """The picture, of 8-bit sRGB codes, which is made band by band when it is written.

        scale : pixels a dot; None is :meth:`best_scale`. panel : one of :data:`PANELS`, or ``all``.
        """
        names = chosen(panel)
        scale = self.best_scale(panel) if scale is None else whole("scale", scale, 1, 256)
        rows, columns = self.shape
        shape = (rows * scale, len(names) * (columns * scale + SEPARATOR) - SEPARATOR)
        self._check(scale, names, shape)
        dpi = None if self.sent.dpi is None else (self.sent.dpi[0] * scale, self.sent.dpi[1] * scale)
        parts = self._parts(scale, names)
        return Bands(shape, parts, Levels.of(256), "preview", dpi, report=self.sent.report)

    def save(self, path: str | Path, *, scale: int | None = None, panel: str = "all") -> None:
        """Write the picture as a PNG."""
        self.bands(scale, panel).save(path, "png")

    def _repr_png_(self) -> bytes:
        from halftone.images.png import encode

        made = self.bands()
        return encode(Frame(np.concatenate(list(made.indices)), made.levels, dpi=made.dpi))

    def _check(self, scale: int, names: list[str], shape: tuple[int, int]) -> None:
        need = BYTES_A_DOT * self.asked.size + 3 * scale * shape[1]
        if "seen" in names and self._draws(scale):
            need += BYTES_A_SAMPLE * self.asked.size * scale**2
        _check_memory(need, self.max_memory, f"a preview of {shape[1]} × {shape[0]} pixels")

    def _draws(self, scale: int) -> bool:
        """Whether dots have shapes: not too small on the screen, nor too far away."""
        from devices.paper import FINEST, FURTHEST

        samples = max(self.sent.dpi or (1, 1)) * scale * self.distance / CM_PER_INCH
        return self.paper is not None and DRAWN <= scale <= FINEST and samples <= FURTHEST

    def _parts(self, scale: int, names: list[str]) -> Iterator[Codes]:
        """Bands of the panels beside each other."""
        panels = [self._panel(name, scale) for name in names]
        gap = np.full((1, SEPARATOR), GRAY, np.uint8)
        for start, stop in bands(self.shape[0], max(1, BAND_ROWS // scale)):
            parts: list[Codes] = []
            for panel in panels:
                parts += [gap.repeat((stop - start) * scale, axis=0)] if parts else []
                parts.append(panel(start, stop))
            yield np.hstack(parts)

    def _panel(self, name: str, scale: int) -> Callable[[int, int], Codes]:
        """Codes of the rows of dots start … stop−1."""
        if name == "seen" and self._draws(scale):
            large = self._at_distance(np.concatenate(list(self.paper.drawn(self.sent, scale))), scale)
            return lambda start, stop: srgb(large[start * scale : stop * scale])
        if name == "sent":
            table = self.sent.levels.srgb()
            return lambda start, stop: _repeated(table[self.sent.indices[start:stop]], scale)
        light = self.light(name)
        return lambda start, stop: _repeated(srgb(light[start:stop]), scale)

    def _at_distance(self, light: Light, scale: int) -> Light:
        """*light*, of scale × scale samples a dot, as the eye has it; unchanged at a distance of 0, and
        where nobody knows how large a dot is."""
        from devices.paper import at_distance

        if self.sent.dpi is None or self.distance == 0:
            return light
        across, down = self.sent.dpi
        return at_distance(light, (across * scale, down * scale), self.distance / CM_PER_INCH)


def preview_of(
    recipe: Recipe, picture: Any, distance: float = DISTANCE, progress: Progress | None = None
) -> Preview:
    """*picture*, as *recipe* halftones it, seen from *distance* centimetres."""
    if not 0 <= distance <= FURTHEST_CM:
        raise UsageError(f"distance {distance:g} cm; allowed: 0 … {FURTHEST_CM:g}")
    with _twice(picture, recipe.max_memory) as place:
        asked = recipe.light(place)
        rows, columns = asked.shape
        need = BYTES_A_DOT * rows * columns
        _check_memory(need, recipe.max_memory, f"a preview of {columns} × {rows} dots")
        sent = recipe.convert(place, progress)
    paper = _paper(recipe)
    shown = _on_glass(recipe.profile, sent) if paper is None else paper.seen(sent)
    return Preview(asked, sent, shown, distance, paper, recipe.max_memory)


def chosen(panel: str) -> list[str]:
    """The panels that *panel* names."""
    if panel != "all" and panel not in PANELS:
        raise UsageError(near(str(panel), [*PANELS, "all"], "panel"))
    return [*PANELS] if panel == "all" else [panel]


def srgb(light: NDArray[np.floating[Any]]) -> Codes:
    """8-bit sRGB codes of *light*; what is beyond white is white."""
    return np.rint(encoding("srgb").encode(np.clip(light, 0, 1)) * 255).astype(np.uint8)


@contextmanager
def _twice(picture: Any, limit: int) -> Iterator[Any]:
    """*picture* so that it can be read twice, be it stdin or a pipe."""
    if not isinstance(picture, str | os.PathLike):
        yield picture
        return
    place = Place(os.fspath(picture), limit)
    try:
        yield place.path
    except InputFileError as error:
        raise InputFileError(str(error).replace(f"'{place.path}'", place.name)) from None
    finally:
        place.close()


def _paper(recipe: Recipe) -> Any:
    """The paper that the device prints on, where its dots are known."""
    from devices.paper import Paper

    dot = getattr(recipe.profile, "dot", None)
    if dot is None or len(recipe.ladder) != 2:
        return None
    return Paper(recipe.ladder, dot, getattr(recipe.profile, "measured", None))


def _check_memory(need: int, limit: int, what: str) -> None:
    if need > limit:
        raise InputError(
            f"{what} would take about {need >> 20} MiB; allowed: {limit >> 20} MiB. Raise --max-memory "
            "(max_memory=), or ask for a smaller --width or --scale (width=, scale=)"
        )


def _on_glass(profile: Any, sent: Frame) -> Light:
    """Light of a panel's pixels; of one that only says its levels, those."""
    from devices.framebuffer import FrameBuffer

    if not getattr(profile, "glass", None):
        return sent.luminance
    luminances = tuple(sent.levels.luminance.tolist())  # not the profile's own where others were given
    panel = FrameBuffer(replace(profile, level_luminance=luminances), shape=sent.shape)
    panel.write(sent)
    panel.refresh()
    light = panel.snapshot()
    return light if light.ndim == 2 else (light @ np.array(LUMINANCE)).astype(np.float32)


def _repeated(codes: Codes, scale: int) -> Codes:
    return codes.repeat(scale, axis=1).repeat(scale, axis=0)
