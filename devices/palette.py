"""Palettes: the colours that a panel of e-paper has, as somebody measured them.

A palette is a TOML file: ``title``, ``provenance`` and a list ``colour``, each with its ``name``, its
``code`` on the wire and either ``srgb`` (three 8-bit codes) or ``xyz`` (CIE 1931, Y = 1 for a perfect
white, D65). Ours lie in ``devices/palettes``; a path to a ``.toml`` file is taken too.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import LUMINANCE
from halftone.errors import DeviceNotFoundError, UsageError, near
from halftone.tone.transfer import encoding

__all__ = ["Palette"]

_OURS = Path(__file__).parent / "palettes"
_KEYS = ("title", "provenance", "colour")
_COLOUR_KEYS = ("name", "code", "srgb", "xyz")

XYZ_TO_RGB = (
    (3.2404542, -1.5371385, -0.4985314),
    (-0.9692660, 1.8760108, 0.0415560),
    (0.0556434, -0.2040259, 1.0572252),
)
"""To linear R, G, B of BT.709 with D65 white: the inverse of IEC 61966-2-1's matrix (B. Lindbloom)."""


@dataclass(frozen=True, eq=False)
class Palette:
    """Colours of a panel.

    name, title. provenance : who measured what, and how.
    names : of the colours. codes : what each is called on the wire, 0 … 255, all different.
    light : float32 (n, 3), linear R, G, B of BT.709 relative to a perfect white; a little below 0 where
    a measured colour lies outside of what R, G, B can make.
    """

    name: str
    title: str
    provenance: str
    names: tuple[str, ...]
    codes: tuple[int, ...]
    light: NDArray[np.float32]

    def __post_init__(self) -> None:
        light = np.array(self.light, np.float32)
        if light.shape != (len(self.names), 3) or len(self.codes) != len(self.names):
            raise self._wrong(
                f"{len(self.names)} names, {len(self.codes)} codes and colours of shape {light.shape}; "
                "allowed: as many of each, and (n, 3)"
            )
        if not 2 <= len(self.names) <= 256:
            raise self._wrong(f"{len(self.names)} colours; allowed: 2 … 256")
        for what, values in (("name", self.names), ("code", self.codes)):
            twice = sorted({v for v in values if values.count(v) > 1}, key=str)
            if twice:
                raise self._wrong(f"the {what} {twice[0]} is there twice")
        bad = [c for c in self.codes if not 0 <= c <= 255]
        if bad:
            raise self._wrong(f"code {bad[0]}; allowed: 0 … 255")
        if not np.isfinite(light).all() or np.abs(light).max() > 10:
            raise self._wrong("a colour is NaN, infinite or beyond 10 times white")
        light.flags.writeable = False
        object.__setattr__(self, "light", light)
        if self.white <= 0:
            raise self._wrong("white has no light")

    def _wrong(self, why: str) -> UsageError:
        return UsageError(f"palette '{self.name}': {why}")

    def __len__(self) -> int:
        return len(self.names)

    @property
    def luminance(self) -> NDArray[np.float32]:
        """Of every colour, relative to a perfect white, float32 (n,)."""
        return np.asarray(self.light @ np.array(LUMINANCE), np.float32)

    @property
    def paper(self) -> int:
        """Index of the colour called white, else of the lightest."""
        return self.names.index("white") if "white" in self.names else int(self.luminance.argmax())

    @property
    def white(self) -> float:
        """Luminance of its white."""
        return float(self.luminance[self.paper])

    @property
    def relative(self) -> NDArray[np.float32]:
        """The colours with white at luminance 1, its tint kept: float32 (n, 3). Others may be lighter
        (a measured yellow is)."""
        return np.asarray(self.light / self.white, np.float32)

    @classmethod
    def known(cls) -> list[str]:
        """Names of ours."""
        return sorted(path.stem for path in _OURS.glob("*.toml"))

    @classmethod
    def load(cls, name: str | Path) -> Palette:
        """The palette called *name*, or in the ``.toml`` file *name*."""
        path = Path(name)
        if path.suffix != ".toml":
            if str(name) not in cls.known():
                raise UsageError(near(str(name), cls.known(), "palette"))
            path = _OURS / f"{name}.toml"
        try:
            with open(path, "rb") as file:
                data = tomllib.load(file)
        except tomllib.TOMLDecodeError as error:
            raise UsageError(f"palette '{path}' is not TOML: {error}") from None
        except (OSError, UnicodeDecodeError) as error:
            raise DeviceNotFoundError(f"palette '{path}' cannot be read: {error}") from None
        return cls.of(data, path.stem)

    @classmethod
    def of(cls, data: Mapping[str, Any], name: str) -> Palette:
        """A palette from the tables of its TOML file."""
        for key in data:
            if key not in _KEYS:
                raise UsageError(f"palette '{name}': {near(key, _KEYS, 'key')}")
        colours = data.get("colour")
        if not isinstance(colours, list) or not all(isinstance(c, dict) for c in colours):
            raise UsageError(f"palette '{name}': colours are missing; give each as [[colour]]")
        for key in ("title", "provenance"):
            if not isinstance(data.get(key), str):
                raise UsageError(f"palette '{name}': {key} is missing, or no text")
        parts = [_colour(colour, f"palette '{name}', colour {k}") for k, colour in enumerate(colours)]
        names, codes, light = zip(*parts, strict=True) if parts else ((), (), ())
        made = np.array(light, np.float64).reshape(-1, 3)
        return cls(name, data["title"], data["provenance"], names, codes, made.astype(np.float32))


def _colour(given: Mapping[str, Any], place: str) -> tuple[str, int, NDArray[np.float64]]:
    """Name, code and light of one table of a file."""
    for key in given:
        if key not in _COLOUR_KEYS:
            raise UsageError(f"{place}: {near(key, _COLOUR_KEYS, 'key')}")
    name, code = given.get("name"), given.get("code")
    if not isinstance(name, str) or not name:
        raise UsageError(f"{place}: name = {name!r}; allowed: a text")
    if not isinstance(code, int) or isinstance(code, bool):
        raise UsageError(f"{place} ({name}): code = {code!r}; allowed: 0 … 255")
    if ("srgb" in given) == ("xyz" in given):
        raise UsageError(f"{place} ({name}): give either srgb or xyz")
    key, top = ("srgb", 255) if "srgb" in given else ("xyz", 10)
    values = given[key]
    numbers = isinstance(values, list) and len(values) == 3
    if not numbers or not all(
        isinstance(v, int | float) and not isinstance(v, bool) and 0 <= v <= top for v in values
    ):
        raise UsageError(f"{place} ({name}): {key} = {values!r}; allowed: three numbers 0 … {top}")
    measured = np.array(values, np.float64)
    if key == "srgb":
        return name, code, encoding("srgb").decode(measured / 255)
    return name, code, np.array(XYZ_TO_RGB) @ measured
