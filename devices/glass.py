"""What a panel of glass (or e-paper) adds to the levels: the keys of a profile's table ``[glass]``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from devices.palette import Palette
from devices.pixels import PixelFormat, pixel_format
from halftone._arrays import whole
from halftone.errors import UsageError, near
from halftone.tone.ladder import luminance
from halftone.tone.levels import Levels
from halftone.tone.transfer import encoding

__all__ = ["Glass"]

PIXELS = ("box", "dot", "led")
ROUND = np.pi / 4
"""Share of its cell that the largest round emitter fills."""
FINE = 16
"""Points across a sample at which the shape of a LED is looked up."""


@dataclass(frozen=True)
class Glass:
    """How a panel turns what lies in its memory into light. All light is in units of its white.

    format : of its memory (:func:`devices.pixels.pixel_format`); None is the profile's packing.
    palette : name or file of a :class:`devices.palette.Palette`, for panels of a few colours.
    response : light by voltage 0 … 1, as an encoding (``gamma:2.2``, ``srgb``, ``linear``) or
    ``cie1931`` (voltage as lightness); None for a panel that has no look-up table, and srgb for one
    of R, G, B. ``linear`` also is a display whose amplifiers correct for gamma themselves.
    a : light at voltage 1, as in I = a·V^γ.
    dac_bits : of the converter behind the look-up table.
    time_bits : of the on-time of a LED, whose light is then a multiple of 1/(2^bits − 1).
    black : light of a black pixel that the levels do not hold yet; it takes that much off the range.
    ambient : light reflected by the glass, added to all.
    white : luminance of white relative to a perfect white, for absolute figures.
    pixel : ``box``; ``dot``, printed round dots (the profile's dot_x, dot_y); ``led``, round emitters.
    fill : share of its cell that a LED fills.
    needs_refresh : whether what is written shows only after a refresh, as on e-paper.
    ghosting : g in y = (1 − g)·target + g·previous of every partial refresh.
    """

    format: str | None = None
    palette: str | None = None
    response: str | None = None
    a: float = 1.0
    dac_bits: int = 16
    time_bits: int | None = None
    black: float = 0.0
    ambient: float = 0.0
    white: float = 1.0
    pixel: str = "box"
    fill: float = 0.5
    needs_refresh: bool = False
    ghosting: float = 0.0

    def __post_init__(self) -> None:
        for name in ("format", "palette", "response"):
            value = getattr(self, name)
            if value is not None and not isinstance(value, str):
                raise UsageError(f"glass: {name} = {value!r}; allowed: a text")
        if not isinstance(self.needs_refresh, bool):
            raise UsageError(f"glass: needs_refresh = {self.needs_refresh!r}; allowed: true, false")
        whole("glass: dac_bits", self.dac_bits, 1, 16)
        if self.time_bits is not None:
            whole("glass: time_bits", self.time_bits, 1, 16)
        for name, low, high in (
            ("a", 1e-6, 1e6),
            ("black", 0, 0.999),
            ("ambient", 0, 1e6),
            ("white", 1e-6, 1e6),
            ("fill", 0.01, ROUND),
            ("ghosting", 0, 0.999),
        ):
            value = getattr(self, name)
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not number or not low <= value <= high:
                raise UsageError(f"glass: {name} = {value!r}; allowed: {low:g} … {high:.4g}")
        if self.pixel not in PIXELS:
            raise UsageError(f"glass: {near(str(self.pixel), PIXELS, 'pixel')}")
        if self.ghosting and not self.needs_refresh:
            raise UsageError("glass: ghosting is of panels with needs_refresh = true")
        if self.response is not None and self.response != "cie1931":
            encoding(self.response)
        if self.format is not None:
            channels = pixel_format(self.format).channels
            if self.palette is not None and channels != 1:
                raise UsageError(f"glass: a palette has no use for the format '{self.format}'")

    @classmethod
    def of(cls, table: Mapping[str, Any]) -> Glass:
        """From a profile's table; an unknown key is named with the nearest allowed one."""
        allowed = [field.name for field in fields(cls)]
        for key in table:
            if key not in allowed:
                raise UsageError(f"glass: {near(key, allowed, 'key')}")
        return cls(**table)

    @cached_property
    def pixels(self) -> PixelFormat | None:
        """The format of its memory, where it is not the profile's packing."""
        return None if self.format is None else pixel_format(self.format)

    @cached_property
    def colours(self) -> Palette | None:
        """Its palette."""
        return None if self.palette is None else Palette.load(self.palette)

    def light(self, volts: ArrayLike) -> NDArray[np.float64]:
        """Light for voltages 0 … 1: converter, then response, I = a·V^γ."""
        top = (1 << self.dac_bits) - 1
        driven = np.rint(np.asarray(volts, np.float64) * top) / top
        if self.response == "cie1931":
            return self.a * luminance(100 * driven)
        return self.a * encoding(self.response or "srgb").decode(driven)

    def shown(self, light: ArrayLike) -> NDArray[np.float64]:
        """Light of a level as it leaves the panel: on-time in whole steps, black added."""
        kept = np.asarray(light, np.float64)
        if self.time_bits is not None:
            top = (1 << self.time_bits) - 1
            kept = np.rint(kept * top) / top
        return self.black + (1 - self.black) * kept

    def ladder(self, levels: Any) -> Levels:
        """Levels; a bare count is of evenly spaced voltages, where there is a response."""
        if self.response is None or not str(levels).isdecimal():
            return Levels.of(levels)
        if self.response == "cie1931":
            return Levels.of(f"lstar:{levels}")
        return Levels.of(levels, self.response)

    def emitter(self, scale: int) -> NDArray[np.float32]:
        """Light of a round LED about its cell's middle by sample, of mean 1: float32 (scale, scale)."""
        place = (np.arange(scale * FINE) + 0.5) / (scale * FINE) - 0.5
        lit = np.hypot(place[:, None], place) <= np.sqrt(self.fill / np.pi)
        share = lit.reshape(scale, FINE, scale, FINE).mean(axis=(1, 3))
        tile: NDArray[np.float32] = (share / share.mean()).astype(np.float32)
        return tile
