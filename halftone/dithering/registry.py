"""Names of methods, and the text form of every method.

Case, ``-``, ``_`` and blanks do not matter. After the name come parts, divided by ``:``:
``stucki:raster``, ``random:triangular``, ``threshold:otsu``, ``fs:strength=0.8``, and
``ed:7,3,5,1/16`` for four weights of one's own. Some names are a prefix, and their family reads what
follows, a file's name too: ``dots:mese16``, ``dots:own.csv``. Only the family that is named is loaded.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, lru_cache
from importlib import import_module
from typing import Any, NamedTuple

from halftone.dithering.base import Method
from halftone.errors import UsageError, near

__all__ = ["ALIASES", "NAMES", "method", "methods"]


class _Family(NamedTuple):
    """A module, its words (``raster``) as options, its numbers (``seed=3``), its bare value."""

    module: str
    words: dict[str, dict[str, Any]]
    numbers: dict[str, Callable[[str], Any]]
    bare: str | None = None


_FAMILIES = {
    "none": _Family("threshold", {n: {"by": n} for n in ("arithmetic", "ratio")}, {}),
    "threshold": _Family("threshold", {"otsu": {"at": "otsu"}}, {}, "at"),
    "random": _Family(
        "noise",
        {n: {"noise": n} for n in ("uniform", "triangular")},
        {"strength": float, "seed": int},
    ),
    "bayer": _Family("ordered", {}, {"strength": float}),
    "diffusion": _Family(
        "diffusion",
        {
            "raster": {"serpentine": False},
            "serpentine": {"serpentine": True},
            "right": {"from_right": True},
            "cold": {"start": "cold"},
            "warm": {"start": "warm"},
        },
        {"strength": float, "noise": float, "edges": float, "seed": int},
    ),
}
_FAMILIES["curve"] = _Family("curve", {}, {"strength": float, "memory": int, "decay": float})
_FAMILIES["toned"] = _FAMILIES["diffusion"]._replace(module="toned")

_DIFFUSION = (
    "floyd-steinberg",
    "false-floyd-steinberg",
    "jarvis-judice-ninke",
    "stucki",
    "burkes",
    "sierra",
    "sierra-two-row",
    "sierra-lite",
    "atkinson",
    "stevenson-arce",
    "shiau-fan",
    "shiau-fan-2",
)
_BAYER = (2, 4, 8, 16)

_MAPS = (
    "checks", "o2x2", "o3x3", "o4x4", "o8x8", "h4x4a", "h6x6a", "h8x8a", "h4x4o", "h6x6o", "h8x8o",
    "h16x16o", "c5x5b", "c5x5w", "c6x6b", "c6x6w", "c7x7b", "c7x7w", "cluster3", "cluster4", "cluster8",
)  # fmt: skip

NAMES: dict[str, str] = {
    "none": "none",
    "threshold": "threshold",
    "random": "random",
    **{f"bayer{n}": "bayer" for n in _BAYER},
    **dict.fromkeys(("blue-noise", "screen:round@45:8px", *_MAPS), "screened"),
    **dict.fromkeys(("patterns:classic2", "patterns:classic3", "patterns:4", "patterns:8"), "patterns"),
    "growth:8": "patterns",
    **dict.fromkeys(_DIFFUSION, "diffusion"),
    **dict.fromkeys(("ostromoukhov", "zhou-fang"), "toned"),
    "riemersma": "curve",
    **dict.fromkeys(("dots:knuth", "dots:mese8", "dots:mese16", "dots:64"), "dots"),
}
"""Canonical names, each with its family, in the order in which they are listed."""

ALIASES = {
    "nearest": "none",
    "fs": "floyd-steinberg",
    "ffs": "false-floyd-steinberg",
    "jjn": "jarvis-judice-ninke",
    "jarvis": "jarvis-judice-ninke",
    "jajuni": "jarvis-judice-ninke",
    "sierra3": "sierra",
    "sierra2": "sierra-two-row",
    "two-row-sierra": "sierra-two-row",
    "sierra2-4a": "sierra-lite",
    "filter-lite": "sierra-lite",
    "shiau-fan-1": "shiau-fan",
    "noise": "random",
    "otsu": "threshold:otsu",
    "hilbert": "riemersma",
    "dots": "dots:64",
    "knuth": "dots:knuth",
    "mese8": "dots:mese8",
    "mese16": "dots:mese16",
    **{f"bayer{n}x{n}": f"bayer{n}" for n in _BAYER},
    "bluenoise": "blue-noise",
    "void-and-cluster": "blue-noise",
    "classic2": "patterns:classic2",
    "classic3": "patterns:classic3",
    **{f"ordered:bayer{n}": f"bayer{n}" for n in _BAYER},
}


_PREFIXES = {
    "dots": ("dots", "DotDiffusion"),
    "patterns": ("patterns", "Patterns"),
    "growth": ("patterns", "grown"),
}
"""Names with a text of their own after the colon: module and maker, which takes that text."""


def methods() -> dict[str, Method]:
    """All canonical names with the method each stands for."""
    return {name: method(name) for name in NAMES}


def method(spec: str | Method, **options: Any) -> Method:
    """The method *spec* names, with *options* set.

    An option that is None is left as the method has it; one that does not apply is an error.
    """
    given = {name: value for name, value in options.items() if value is not None}
    if not isinstance(spec, str):
        if isinstance(spec, type) or not hasattr(spec, "halftoner"):
            raise UsageError(f"method={spec!r}; allowed: a name, or a method as FloydSteinberg()")
        return spec.with_options(**given) if given else spec
    from_file = any(word in spec.lower() for word in _FROM_FILES)
    made = _named.__wrapped__(spec) if from_file else _named(spec)
    return made.with_options(**given) if given else made


_FROM_FILES = ("mask", "dots", "patterns")
"""Methods of these names may read a file, each time; any other text always means the same."""


@lru_cache(maxsize=64)
def _named(spec: str) -> Method:
    made = _prefixed(spec)
    if made is None:
        name, *parts = _canonical(spec).split(":")
        made = _make(spec, name, parts)
    return made


def _prefixed(spec: str) -> Method | None:
    """The method of a name whose family reads what follows it, which keeps its case."""
    text = spec.strip()
    head, colon, rest = text.partition(":")
    if not (rest and _key(head.lower()) in {*_PREFIXES, *_SCREEN_KEYS}):
        # an alias, of the whole (ordered:bayer8) or of the name before its options (knuth:…)
        whole = _forms().get(_key(text.lower()))
        text = whole or f"{_forms().get(_key(head.lower()), head)}{colon}{rest}"
        head, _, rest = text.partition(":")
    key = _key(head.lower())
    found: Method
    name, *parts = _canonical(spec).split(":")
    blown_up = NAMES.get(name) == "bayer" and any(part.startswith("dot=") for part in parts)
    if blown_up:
        text = ":".join((name, *parts))
    if blown_up or key in _SCREEN_KEYS:
        found = import_module("halftone.dithering.screened").screened(text)
        return found
    if key not in _PREFIXES:
        return None
    module, maker = _PREFIXES[key]
    rest, _, strength = rest.partition(":strength=")
    found = getattr(import_module(f"halftone.dithering.{module}"), maker)(rest.strip())
    return found.with_options(strength=_number(float, strength, spec)) if strength else found


def _canonical(spec: str) -> str:
    """*spec* with its name in canonical form; the longest name first, as in ordered:bayer8."""
    parts = [part.strip() for part in spec.lower().split(":")]
    forms = _forms()
    for count in range(len(parts), 0, -1):
        name = forms.get(_key(":".join(parts[:count])))
        if name is not None:
            return ":".join([name, *parts[count:]])
    return ":".join(parts)


@cache
def _forms() -> dict[str, str]:
    return {_key(name): name for name in NAMES} | {_key(a): name for a, name in ALIASES.items()}


def _key(name: str) -> str:
    return "".join(c for c in name if c not in "-_ ")


_SCREEN_KEYS = {_key(name) for name in ("blue-noise", "mask", "screen", *_MAPS)}


def _make(spec: str, name: str, parts: list[str]) -> Method:
    weights = None
    if name == "ed" and parts:
        weights, family = parts.pop(0), _FAMILIES["diffusion"]
    elif name in NAMES:
        family = _FAMILIES[NAMES[name]]
    else:
        raise UsageError(near(name, [*NAMES, *ALIASES], "method"))
    options: dict[str, Any] = {}
    for part in parts:
        key, _, value = part.partition("=")
        given = set(family.words.get(part, {key if key in family.numbers else family.bare: None}))
        if given & set(options):
            raise UsageError(f"'{part}' in the method '{spec}' says again what was said before it")
        if part in family.words:
            options |= family.words[part]
        elif key in family.numbers and value:
            options[key] = _number(family.numbers[key], value, spec)
        elif family.bare:
            options[family.bare] = _number(float, part, spec)
        else:
            known = [*family.words, *(f"{n}=…" for n in family.numbers)]
            raise UsageError(
                f"'{part}' in the method '{spec}' is unknown; allowed after {name}: {', '.join(known)}"
            )
    module = import_module(f"halftone.dithering.{family.module}")
    return _build(module, name, weights, options, spec)


def _build(module: Any, name: str, weights: str | None, options: dict[str, Any], spec: str) -> Method:
    made: Method
    if name == "none":
        made = module.Nearest(**options)
    elif name == "threshold":
        made = module.Threshold(**options)
    elif name == "random":
        made = module.RandomDither(**options)
    elif name.startswith("bayer"):
        from halftone.screens.bayer import bayer

        made = module.Ordered(bayer(int(name.removeprefix("bayer"))), **options)
    elif name == "riemersma":
        made = module.Riemersma(**options)
    elif NAMES.get(name) == "toned":
        made = module.ToneDiffusion(name, **options)
    elif weights is None:
        made = module.ErrorDiffusion(name, **options)
    else:
        from halftone.dithering.filters import four_weights

        values, _, divisor = weights.partition("/")
        shares = tuple(_number(float, w, spec) for w in values.split(","))
        divided = four_weights(shares, _number(float, divisor or "1", spec))
        made = module.ErrorDiffusion(divided, **options)
    return made


def _number(kind: Callable[[str], Any], text: str, spec: str) -> Any:
    try:
        if "_" in text:  # Python's digit groups
            raise ValueError
        return kind(text)
    except ValueError:
        raise UsageError(f"'{text}' in the method '{spec}' is not a number") from None
