"""Device profiles: what a device can show, as data.

A profile is a TOML file whose keys are the fields of :class:`DeviceProfile`. Ours lie in
``devices/profiles``; a user's own in ``$XDG_CONFIG_HOME/halftone/profiles`` (usually
``~/.config/halftone/profiles``) come first. A path to a ``.toml`` file is taken too.
"""

from __future__ import annotations

import os
import tomllib
from dataclasses import dataclass, field, fields
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

from halftone.errors import DeviceNotFoundError, UsageError, near
from halftone.packing import Packing
from halftone.tone.dotgain import DotModel
from halftone.tone.levels import Levels

__all__ = ["DeviceProfile", "folders", "load", "names"]

_OURS = Path(__file__).parent / "profiles"


@dataclass(frozen=True, eq=False)
class DeviceProfile:
    """A device.

    name : as ``--device`` takes it. title : one line for people.
    provenance : where the figures come from, and what was not measured.
    width, height : dots; None is any (height: a roll).
    dpi_x, dpi_y : dots per inch across and down, or None.
    level_luminance : a text form or a list of luminances, as ``levels`` of ``halftone.dither``;
    1 is the device's white.
    bits, bit_order, codes : as in :class:`halftone.packing.Packing`.
    default_method : a method's text form, or None for the product's default.
    language : what it understands (``halftone devices languages``), or None if it is no printer of
    ours. options : the language's options that suit it.
    density : the least and the greatest number it takes for how dark it prints, or None.
    cut : whether it cuts the paper after a page unless told otherwise.
    dot_x, dot_y : measured diameter of a printed dot across and down, in dots (1 touches its
    neighbours); None where nobody has measured.
    measured : pairs of the luminance that dots and levels predict and the one that was measured, both
    rising (``halftone calibrate``), or None.
    glass : for panels, the keys of :class:`devices.glass.Glass`.
    """

    name: str
    title: str
    provenance: str
    level_luminance: str | int | tuple[float, ...] = 2
    width: int | None = None
    height: int | None = None
    dpi_x: float | None = None
    dpi_y: float | None = None
    bits: int = 1
    bit_order: str = "msb"
    codes: tuple[int, ...] | None = None
    default_method: str | None = None
    language: str | None = None
    options: dict[str, Any] = field(default_factory=dict)
    density: tuple[int, ...] | None = None
    cut: bool = False
    dot_x: float | None = None
    dot_y: float | None = None
    measured: tuple[tuple[float, float], ...] | None = None
    glass: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        try:
            self._check()
        except UsageError as error:
            raise UsageError(f"profile '{self.name}': {error}") from None

    def _check(self) -> None:
        for name in ("width", "height", "dpi_x", "dpi_y"):
            value = getattr(self, name)
            if value is not None and not 0 < value <= 1_000_000:
                raise UsageError(f"{name} = {value}; allowed: 1 … 1,000,000")
        if (self.dpi_x is None) != (self.dpi_y is None):
            raise UsageError("give both dpi_x and dpi_y, or neither")
        if len(self.levels) > 1 << self.packing.bits:
            raise UsageError(f"{len(self.levels)} levels do not fit into {self.bits} bits")
        if self.default_method is not None:
            from halftone.pipeline import check_method

            check_method(self.default_method)
        if self.codes is not None and len(self.codes) != len(self.levels):
            raise UsageError(f"{len(self.codes)} codes for {len(self.levels)} levels")
        if self.density is not None and (len(self.density) != 2 or self.density[0] > self.density[1]):
            raise UsageError(f"density = {list(self.density)}; allowed: [least, greatest]")
        if (self.dot_x is None) != (self.dot_y is None):
            raise UsageError("give both dot_x and dot_y, or neither")
        for name in ("dot_x", "dot_y"):
            value = getattr(self, name)
            if value is not None and not 0.1 <= value <= 3:
                raise UsageError(f"{name} = {value}; allowed: 0.1 … 3 dots")
        if self.measured is not None:
            self._check_measured(self.measured)
        if self.glass:
            from devices.glass import Glass

            Glass.of(self.glass)
        if self.options and self.language is None:
            raise UsageError("options are given and no language")

    def _check_measured(self, pairs: tuple[tuple[float, float], ...]) -> None:
        if self.dot is None:
            raise UsageError("measured is given and no dot_x and dot_y, from which it says what differs")
        rising = all(a[0] < b[0] and a[1] < b[1] for a, b in pairwise(pairs))
        if len(pairs) < 2 or not rising or not all(0 <= v <= 2 for pair in pairs for v in pair):
            raise UsageError(
                "measured: allowed are two or more pairs [predicted, measured luminance], both rising"
            )
        import numpy as np

        ink, paper = np.interp(self.levels.luminance[[0, -1]], *np.array(pairs).T)
        if paper - ink < 1e-4 * float(self.levels.lightest - self.levels.darkest):
            raise UsageError(f"measured: from ink to paper {ink:g} to {paper:g}; calibrate again")

    @cached_property
    def levels(self) -> Levels:
        """The luminance of every level."""
        return Levels.of(self.level_luminance)

    @cached_property
    def packing(self) -> Packing:
        """How the device wants its pixels."""
        return Packing(self.bits, self.bit_order, self.codes)

    @property
    def dpi(self) -> tuple[float, float] | None:
        if self.dpi_x is None or self.dpi_y is None:
            return None
        return self.dpi_x, self.dpi_y

    @property
    def note(self) -> str | None:
        """What is said aloud of every picture for it."""
        if "palette" not in self.glass:
            return None
        return (
            f"of the colours of '{self.name}' only black and white are used: no method is for palettes"
        )

    @property
    def dot(self) -> DotModel | None:
        """The printed dot, or None where nobody has measured or assumed one."""
        if self.dot_x is None or self.dot_y is None:
            return None
        return DotModel(self.dot_x, self.dot_y)

    @property
    def method(self) -> str | None:
        return self.default_method


def load(name: str | Path) -> DeviceProfile:
    """The profile called *name*, or in the ``.toml`` file *name*.

    Raises :class:`DeviceNotFoundError` for an unknown name and :class:`UsageError` for a profile
    with a mistake, naming the key and the nearest allowed one.
    """
    if str(name).endswith(".toml"):
        path = Path(name)
        if not path.is_file():
            raise DeviceNotFoundError(f"no device profile '{name}': there is no such file")
        return _read(path)
    if name in names():
        for folder in folders():
            path = folder / f"{name}.toml"
            if path.is_file():
                return _read(path)
    raise DeviceNotFoundError(near(str(name), names(), "device"))


def names() -> list[str]:
    """All profiles, by name."""
    return sorted({path.stem for folder in folders() for path in folder.glob("*.toml")})


def folders() -> list[Path]:
    """Folders that are searched, the user's own first."""
    found = [_OURS]
    base = os.environ.get("XDG_CONFIG_HOME")
    try:
        own = (Path(base) if base else Path.home() / ".config") / "halftone" / "profiles"
    except RuntimeError:  # no home folder
        return found
    return [own, *found]


def _read(path: Path) -> DeviceProfile:
    try:
        with open(path, "rb") as file:
            data = tomllib.load(file)
    except tomllib.TOMLDecodeError as error:
        raise UsageError(f"profile '{path}' is not TOML: {error}") from None
    except (OSError, UnicodeDecodeError) as error:
        raise DeviceNotFoundError(f"profile '{path}' cannot be read: {error}") from None
    allowed = {f.name: f for f in fields(DeviceProfile)}
    values: dict[str, Any] = {"name": path.stem}
    for key, value in data.items():
        if key not in allowed:
            raise UsageError(f"profile '{path}': {near(key, allowed, 'key')}")
        values[key] = _checked(path, key, value, str(allowed[key].type))
    try:
        return DeviceProfile(**values)
    except UsageError as error:
        reason = str(error).removeprefix(f"profile '{values['name']}': ")
        raise UsageError(f"profile '{path}': {reason}") from None
    except TypeError:
        missing = [k for k in ("title", "provenance") if k not in values]
        raise UsageError(f"profile '{path}': {' and '.join(missing)} missing") from None


def _checked(path: Path, key: str, value: Any, annotation: str) -> Any:
    """*value* if it has one of the types of its field; lists become tuples."""
    if isinstance(value, list):
        value = tuple(value)
    if annotation == "bool" and isinstance(value, bool):
        return value
    if annotation.startswith("dict") and isinstance(value, dict):
        return value
    kinds: dict[str, tuple[type, ...]] = {"str": (str,), "int": (int,), "float": (float, int)}
    if annotation.startswith("tuple[tuple") and isinstance(value, tuple):
        return _pairs(path, key, value)
    allowed = tuple(t for part in annotation.split(" | ") for t in kinds.get(part, ()))
    number: Any = int if "tuple[int" in annotation else (int, float)
    numbers = isinstance(value, tuple) and all(
        isinstance(v, number) and not isinstance(v, bool) for v in value
    )
    if isinstance(value, bool) or not (
        isinstance(value, allowed) or ("tuple" in annotation and numbers)
    ):
        kind = annotation.replace("tuple[float, ...]", "list of numbers")
        kind = kind.replace("tuple[int, ...]", "list of integers").replace(" | None", "")
        kind = kind.replace("bool", "true, false").replace("dict[str, Any]", "a table")
        raise UsageError(f"profile '{path}': {key} = {value!r}; allowed: {kind}")
    return value


def _pairs(path: Path, key: str, value: tuple[Any, ...]) -> tuple[tuple[float, float], ...]:
    """A list of lists of two numbers, as tuples."""
    for pair in value:
        numbers = isinstance(pair, list) and all(
            isinstance(v, int | float) and not isinstance(v, bool) for v in pair
        )
        if not numbers or len(pair) != 2:
            raise UsageError(f"profile '{path}': {key} holds {pair!r}; allowed: [number, number]")
    return tuple((float(a), float(b)) for a, b in value)
