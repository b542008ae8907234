"""The languages, by name: one file and one line of the table each."""

from __future__ import annotations

from dataclasses import MISSING, fields
from functools import cache
from importlib import import_module
from typing import Any

from devices.languages.base import Language
from halftone.errors import InputFileError, UsageError, near

__all__ = ["detect", "language", "language_type", "languages"]

TABLE = {
    "escpos": "devices.languages.escpos:EscPos",
    "zpl": "devices.languages.zpl:Zpl",
    "tspl": "devices.languages.tspl:Tspl",
    "epl2": "devices.languages.epl2:Epl2",
    "brother-ql": "devices.languages.brother_ql:BrotherQl",
    "dymo": "devices.languages.dymo:Dymo",
    "pcl": "devices.languages.pcl:Pcl",
    "pwg": "devices.languages.pwg:Pwg",
    "cups-raster": "devices.languages.cups_raster:CupsRaster",
    "urf": "devices.languages.urf:Urf",
    "png": "devices.languages.png:Png",
    "pbm": "devices.languages.pbm:Pbm",
}
"""Name → module and class, in the order in which a stream is tried for them."""

GROUP = "halftone.languages"


def languages() -> list[str]:
    """All names: ours, then those that other packages add under the entry point *halftone.languages*."""
    return [*TABLE, *sorted(set(_others()) - set(TABLE))]


def language_type(name: str) -> type[Language]:
    """The class called *name*. Raises UsageError with the near matches for an unknown one."""
    if name not in TABLE:
        others = _others()
        if name not in others:
            raise UsageError(near(name, languages(), "language"))
        found = others[name].load()
    else:
        module, _, kind = TABLE[name].partition(":")
        found = getattr(import_module(module), kind)
    if not (isinstance(found, type) and issubclass(found, Language)):
        raise UsageError(f"the language '{name}' is no devices.languages.base.Language")
    return found


def language(name: str, **options: Any) -> Language:
    """The language *name* with *options*; text values are turned into the type of their option.

    Raises UsageError for an unknown name, an unknown option, and a value that is not allowed.
    """
    kind = language_type(name)
    allowed = {f.name: f for f in fields(kind) if f.init}  # type: ignore[arg-type]
    values = {}
    for key, value in options.items():
        if key not in allowed:
            if not allowed:
                raise UsageError(f"'{name}' has no options; '{key}' was given")
            raise UsageError(near(key, allowed, f"option of '{name}'"))
        default = allowed[key].default
        values[key] = _typed(f"{name}: {key}", value, None if default is MISSING else default)
    return kind(**values)


def detect(data: bytes) -> str:
    """The name of the language of a stream. Raises InputFileError if it is none of them."""
    head = data[:1024]
    for name in TABLE:
        if language_type(name).sniff(head):
            return name
    for name in languages()[len(TABLE) :]:
        if language_type(name).sniff(head):
            return name
    start = head[:16].hex(" ") or "nothing"
    raise InputFileError(
        f"the stream is in none of the languages {', '.join(languages())}: it begins with {start}"
    )


@cache
def _others() -> dict[str, Any]:
    from importlib.metadata import entry_points

    return {point.name: point for point in entry_points(group=GROUP)}


def _typed(what: str, value: Any, default: Any) -> Any:
    """*value*, if it has the type of *default*; a text is read as that type."""
    if isinstance(default, bool):
        words = {"yes": True, "true": True, "on": True, "no": False, "false": False, "off": False}
        if isinstance(value, str) and value.lower() in words:
            return words[value.lower()]
        if isinstance(value, bool):
            return value
        raise UsageError(f"{what} = {value!r}; allowed: yes, no")
    if isinstance(default, int):
        try:
            if isinstance(value, str):
                return int(value)
            if isinstance(value, int) and not isinstance(value, bool):
                return value
        except ValueError:
            pass
        raise UsageError(f"{what} = {value!r}; allowed: an integer")
    if isinstance(default, str) and not isinstance(value, str):
        raise UsageError(f"{what} = {value!r}; allowed: a text")
    return value
