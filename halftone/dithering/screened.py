"""Methods by screens: clustered dots at a ruling and an angle, and the text form of every screen.

::

    blue-noise                     the 256 × 256 mask that ships
    blue-noise:64x32:seed=3        one of one's own, width × height; also sigma=1.9
    h8x8a, c7x7w, cluster4, …      maps of ImageMagick and netpbm
    mask:FILE                      ranks or thresholds from a file
    screen:SHAPE@ANGLE:60lpi       clustered dots, lines per inch of the device; also dpi=203, tones=129
    screen:SHAPE@ANGLE:8px         the same by the period in pixels
    bayer8:dot=2                   any of them with dot=W or dot=WxH, dots of at least W × H pixels
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from halftone._arrays import shortest
from halftone.dithering.base import NO_CLAIM, Claim, Halftoner, Job, Method, check_strength
from halftone.dithering.ordered import Ordered
from halftone.errors import UsageError, near
from halftone.screens.bayer import SIZES, bayer
from halftone.screens.bluenoise import blue_noise
from halftone.screens.clustered import (
    COARSEST,
    FEWEST_TONES,
    FINEST,
    SHAPES,
    Supercell,
    clustered,
    find_supercell,
)
from halftone.screens.mask import LARGEST_DOT, is_even, mask, minimum_dot
from halftone.screens.named import NAMES as MAPS
from halftone.screens.named import named
from halftone.screens.order import Screen

__all__ = ["NAMES", "ClusteredDot", "screen", "screened"]

NAMES = ("blue-noise", "mask", "screen", *MAPS)
"""First words of the text forms, besides bayer2 … bayer16."""


@dataclass(frozen=True)
class ClusteredDot(Method):
    """A clustered-dot screen of dark dots, by supercells of the device's pixels.

    shape : a name of :data:`halftone.screens.clustered.SHAPES`.
    angle : degrees counter-clockwise.
    lpi : lines per inch, dpi/20 … dpi/2; or period : pixels, 2 … 20. One of them.
    dpi : dots per inch across and down; left out, it is the device's.
    tones : the fewest tones the supercell must hold.
    dot : width and height of the smallest dot in pixels; the screen is made on dots of that size,
    at the same ruling and angle.
    strength : as in :class:`Ordered`.

    A cell is at most 2 % and 1° off; :meth:`supercell` tells what is achieved.
    """

    shape: str = "round"
    angle: float = 45.0
    lpi: float | None = None
    period: float | None = None
    dpi: tuple[float, float] | None = None
    tones: int = FEWEST_TONES
    dot: tuple[int, int] = (1, 1)
    strength: float = 1.0

    options = ("strength",)

    def __post_init__(self) -> None:
        if self.shape not in SHAPES:
            raise UsageError(near(self.shape, SHAPES, "dot shape"))
        if (self.lpi is None) == (self.period is None):
            raise UsageError(
                f"a clustered-dot screen of lpi={self.lpi}, period={self.period}; allowed: one of them, "
                "as screen:round@45:60lpi or screen:round@45:8px"
            )
        if not 2 <= self.tones <= 4096:
            raise UsageError(f"tones={self.tones}; allowed: 2 … 4096")
        if not -360 <= self.angle <= 360:
            raise UsageError(f"a screen angle of {self.angle!r}°; allowed: −360 … 360")
        _check_dot(self.dot)
        check_strength(self.strength)
        if self.period is not None:
            low, high = FINEST * max(self.dot), COARSEST * min(self.dot)
            if not low <= self.period <= high:
                raise UsageError(f"a period of {self.period:g} pixels; allowed: {low} … {high}")
        elif self.lpi is not None and not 0 < self.lpi < math.inf:
            raise UsageError(f"{self.lpi!r} lines per inch; allowed: above 0")
        if self.dpi is not None or self.period is not None:
            self.supercell()

    def supercell(self, dpi: tuple[float, float] | None = None) -> Supercell:
        """The supercell on a device of *dpi*, in dots; its lpi, angle and tones are those achieved.

        Given a period in pixels, its lpi is lines per pixel.
        """
        if self.period is not None:
            return self._found(1 / self.period, (1.0, 1.0))
        chosen = self.dpi or dpi
        if chosen is None or self.lpi is None:
            raise UsageError(
                f"'{self.text()}' needs the device's dots per inch; choose a device, or give "
                "them as :dpi=203, or the period in pixels as :8px"
            )
        return self._found(self.lpi, chosen)

    def _found(self, lpi: float, dpi: tuple[float, float]) -> Supercell:
        dots = float(dpi[0] / self.dot[0]), float(dpi[1] / self.dot[1])
        return find_supercell(float(self.angle), float(lpi), dots, self.tones)

    def screen(self, dpi: tuple[float, float] | None = None) -> Screen:
        """The screen on a device of *dpi*."""
        made = clustered(self.shape, self.supercell(dpi), self.text())
        return Screen(minimum_dot(made, *self.dot).thresholds, self.text(), made.source)

    @property
    def claim(self) -> Claim:
        if self.strength != 1:
            return NO_CLAIM
        known = self.dpi is not None or self.period is not None
        return Claim("tones", self.supercell().tones if known else self.tones)

    @property
    def source(self) -> str:
        return "clustered dot, supercell"

    def text(self) -> str:
        ruling = (
            f"{shortest(self.lpi)}lpi" if self.lpi is not None else f"{shortest(self.period or 0)}px"
        )
        parts = ["screen", f"{self.shape}@{shortest(self.angle)}", ruling]
        if self.dpi is not None:
            across, down = (shortest(d) for d in self.dpi)
            parts.append(f"dpi={across}" if across == down else f"dpi={across}x{down}")
        if self.tones != FEWEST_TONES:
            parts.append(f"tones={self.tones}")
        if self.dot != (1, 1):
            parts.append(f"dot={self.dot[0]}x{self.dot[1]}")
        if self.strength != 1:
            parts.append(f"strength={shortest(self.strength)}")
        return ":".join(parts)

    def halftoner(self, job: Job) -> Halftoner:
        return Ordered(self.screen(job.dpi), self.strength).halftoner(job)


@dataclass(frozen=True)
class _Uneven(Ordered):
    """A screen whose thresholds are not even: it changes tone and claims none."""

    @property
    def claim(self) -> Claim:
        return NO_CLAIM


def screened(text: str, strength: float = 1.0) -> Method:
    """The method that a text form names; ``:strength=0.5`` may end it."""
    head, _, tail = text.rpartition(":")
    if tail.startswith("strength=") and head:
        text, strength = head, _number(tail.partition("=")[2], text)
    made = screen(text)
    if isinstance(made, ClusteredDot):
        return made if strength == 1 else made.with_options(strength=strength)
    return Ordered(made, strength) if is_even(made) else _Uneven(made, strength)


def screen(text: str) -> Screen | ClusteredDot:
    """What a text form names: a screen, or for ``screen:…`` the method that makes one for a device.

    Case, ``-``, ``_`` and blanks in names do not matter; a file's name is taken as it is.
    """
    name, *parts = text.strip().split(":")
    name = "".join(c for c in name.lower() if c not in "-_ ")
    dot = (1, 1)
    for part in list(parts):
        if part.lower().startswith("dot="):
            dot = _two(part[4:], int, text)
            _check_dot(dot)
            parts.remove(part)
    if name == "mask":
        if not any(parts):
            raise UsageError(f"'{text}' names no file; allowed: mask:FILE")
        return minimum_dot(mask(":".join(parts)), *dot)
    parts = [part.strip().lower() for part in parts]
    if name == "screen":
        return _clustered(parts, dot, text)
    if name == "bluenoise":
        return minimum_dot(_blue_noise(parts, text), *dot)
    known = {f"bayer{n}": n for n in SIZES}
    if name not in known and name not in MAPS:
        raise UsageError(near(name, [*NAMES, *known], "screen"))
    _no_more(parts, text, "dot=2, dot=2x1")
    return minimum_dot(bayer(known[name]) if name in known else named(name), *dot)


def _blue_noise(parts: list[str], text: str) -> Screen:
    size, options = (256, 256), dict[str, Any]()
    for part in list(parts):
        key, _, value = part.partition("=")
        if key == "seed" and value:
            options["seed"] = _number(value, text, int)
        elif key == "sigma" and value:
            options["sigma"] = _number(value, text)
        elif part[:1].isdigit():
            size = _two(part, int, text)
        else:
            continue
        parts.remove(part)
    _no_more(parts, text, "64x64 (width × height), seed=3, sigma=1.9, dot=2")
    return blue_noise(size[1], size[0], **options)


def _clustered(parts: list[str], dot: tuple[int, int], text: str) -> ClusteredDot:
    options: dict[str, Any] = {"dot": dot}
    for whole in list(parts):
        part, at, angle = whole.partition("@")
        key, _, value = part.partition("=")
        if at:
            options["angle"] = _number(angle, text)
        if part in SHAPES:
            options["shape"] = part
        elif part.endswith("lpi"):
            options["lpi"] = _number(part[:-3], text)
        elif part.endswith("px"):
            options["period"] = _number(part[:-2], text)
        elif key == "dpi" and value:
            options["dpi"] = _two(value, float, text)
        elif key == "tones" and value:
            options["tones"] = _number(value, text, int)
        else:
            continue
        parts.remove(whole)
    shapes = ", ".join(SHAPES)
    _no_more(parts, text, f"a shape ({shapes}) with @ANGLE, 60lpi or 8px, dpi=203, tones=129, dot=2")
    return ClusteredDot(**options)


def _no_more(parts: list[str], text: str, allowed: str) -> None:
    if parts:
        raise UsageError(f"'{parts[0]}' in the method '{text}' is unknown; allowed: {allowed}")


def _two(value: str, kind: Callable[[str], Any], text: str) -> tuple[Any, Any]:
    """``8`` or ``8x6`` as two numbers."""
    first, x, second = value.partition("x")
    return _number(first, text, kind), _number(second if x else first, text, kind)


def _number(value: str, text: str, kind: Callable[[str], Any] = float) -> Any:
    try:
        if "_" in value:  # Python's digit groups
            raise ValueError
        return kind(value)
    except ValueError:
        raise UsageError(f"'{value}' in the method '{text}' is not a number") from None


def _check_dot(dot: tuple[int, int]) -> None:
    if not all(1 <= side <= LARGEST_DOT for side in dot):
        raise UsageError(f"dot={dot[0]}x{dot[1]}; allowed: 1 … {LARGEST_DOT} pixels each")
