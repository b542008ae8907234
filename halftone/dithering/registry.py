"""Names of methods, and the text form of every method.

Case, ``-``, ``_`` and blanks do not matter. After the name come parts, divided by ``:``:
``stucki:raster``, ``random:triangular``, ``threshold:otsu``, ``fs:strength=0.8``, and
``ed:7,3,5,1/16`` for four weights of one's own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from halftone.dithering.base import Method
from halftone.dithering.diffusion import ErrorDiffusion
from halftone.dithering.filters import FILTERS, four_weights
from halftone.dithering.noise import RandomDither
from halftone.dithering.ordered import Ordered
from halftone.dithering.threshold import Nearest, Threshold
from halftone.errors import UsageError, near
from halftone.screens.bayer import SIZES, bayer

__all__ = ["ALIASES", "method", "methods"]

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
    **{f"bayer{n}x{n}": f"bayer{n}" for n in SIZES},
    **{f"o{n}x{n}": f"bayer{n}" for n in SIZES},
    **{f"ordered:bayer{n}": f"bayer{n}" for n in SIZES},
}


def methods() -> dict[str, Method]:
    """All canonical names with the method each stands for, in the order of the families."""
    found: dict[str, Method] = {"none": Nearest(), "threshold": Threshold()}
    found["random"] = RandomDither()
    found |= {f"bayer{n}": Ordered(bayer(n)) for n in SIZES}
    found |= {name: ErrorDiffusion(made) for name, made in FILTERS.items()}
    return found


def method(spec: str | Method, **options: Any) -> Method:
    """The method *spec* names, with *options* set.

    An option that is None is left as the method has it; one that does not apply is an error.
    """
    given = {name: value for name, value in options.items() if value is not None}
    if not isinstance(spec, str):
        if isinstance(spec, type) or not hasattr(spec, "halftoner"):
            raise UsageError(f"method={spec!r}; allowed: a name, or a method such as FloydSteinberg()")
        return spec.with_options(**given) if given else spec
    name, *parts = _canonical(spec).split(":")
    made = _make(spec, name, parts)
    return made.with_options(**given) if given else made


def _canonical(spec: str) -> str:
    text = spec.strip().lower()
    forms = {_key(name): name for name in methods()}
    forms |= {_key(alias): name for alias, name in ALIASES.items()}
    for cut in range(text.count(":") + 1):  # the longest name first: ordered:bayer8
        parts = text.split(":")
        head, tail = parts[: len(parts) - cut], parts[len(parts) - cut :]
        if _key(":".join(head)) in forms:
            return ":".join([forms[_key(":".join(head))], *tail])
    return text


def _key(name: str) -> str:
    return "".join(c for c in name.lower() if c not in "-_ ")


def _make(spec: str, name: str, parts: list[str]) -> Method:
    if name == "ed" and parts:
        name = f"ed:{parts.pop(0)}"
    elif name not in methods():
        raise UsageError(near(name, [*methods(), *ALIASES], "method"))
    options: dict[str, Any] = {}
    words: dict[str, Callable[[], None]] = {}
    if name in FILTERS or name.startswith("ed:"):
        words = {
            "raster": lambda: options.update(serpentine=False),
            "serpentine": lambda: options.update(serpentine=True),
            "right": lambda: options.update(from_right=True),
        }
    elif name == "random":
        words = {n: lambda n=n: options.update(noise=n) for n in ("uniform", "triangular")}  # type: ignore[misc]
    elif name == "none":
        words = {n: lambda n=n: options.update(by=n) for n in ("arithmetic", "ratio")}  # type: ignore[misc]
    numbers = {"strength": float} if name not in ("none", "threshold") else {}
    if name == "random":
        numbers["seed"] = int  # type: ignore[assignment]
    for part in parts:
        key, _, value = part.partition("=")
        if part in words:
            words[part]()
        elif key in numbers and value:
            options[key] = _number(numbers[key], value, spec)
        elif name == "threshold" and part == "otsu":
            options["at"] = part
        elif name == "threshold":
            options["at"] = _number(float, part, spec)
        else:
            known = [*words, *(f"{n}=…" for n in numbers)]
            hint = ", ".join(known) if known else "nothing"
            raise UsageError(f"'{part}' in the method '{spec}' is unknown; allowed after {name}: {hint}")
    return _build(name, options, spec)


def _build(name: str, options: dict[str, Any], spec: str) -> Method:
    if name == "none":
        return Nearest(**options)
    if name == "threshold":
        return Threshold(**options)
    if name == "random":
        return RandomDither(**options)
    if name.startswith("bayer"):
        return Ordered(bayer(int(name.removeprefix("bayer"))), **options)
    if name.startswith("ed:"):
        weights, _, divisor = name.removeprefix("ed:").partition("/")
        values = tuple(_number(float, w, spec) for w in weights.split(","))
        return ErrorDiffusion(four_weights(values, _number(float, divisor or "1", spec)), **options)
    return ErrorDiffusion(FILTERS[name], **options)


def _number(kind: Callable[[str], Any], text: str, spec: str) -> Any:
    try:
        return kind(text)
    except ValueError:
        raise UsageError(f"'{text}' in the method '{spec}' is not a number") from None
