"""The levels of a device: the luminance of every level index, and what follows from them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone.errors import UsageError
from halftone.tone.ladder import log_ladder, lstar_ladder, uniform_ladder, visible_steps
from halftone.tone.transfer import Encoding, encoding

__all__ = ["LADDERS", "Levels"]

LADDERS = ("N", "uniform-linear:N", "lstar:N", "log:I0:N", "Y0,Y1,…")
"""Text forms of levels; N is the number of levels, I0 the light of black, Y a measured luminance."""

BUCKETS = 1024
"""Entries of :meth:`Levels.buckets`."""

CLOSEST = 1e-30
"""Differing levels are at least this far apart: below, float32 cannot divide a step."""

_ALLOWED = f"allowed: {', '.join(LADDERS)} (N = 2 … 256)"


@dataclass(frozen=True, eq=False)
class Levels:
    """Measured luminances, darkest first.

    luminance : float32 (n,), of every level index, non-decreasing.
    text : the form it was made from.
    encoding : the encoding whose codes k/(n−1) these are, or None.

    ``distinct`` are the luminances that differ, ascending, at least two; ``index`` gives the level
    index of each, the lowest where several are equal.
    """

    luminance: NDArray[np.float32]
    text: str
    encoding: Encoding | None = None

    def __post_init__(self) -> None:
        values = np.array(self.luminance, np.float64)
        if values.ndim != 1 or not 2 <= values.size <= 256:
            raise UsageError(f"levels of shape {values.shape}; {_ALLOWED}")
        if not np.isfinite(values).all() or (values < 0).any():
            raise UsageError("levels hold a negative luminance, NaN or infinity; " + _ALLOWED)
        if (values > 1e6).any():
            raise UsageError(f"a level of luminance {values.max():g}; allowed: up to 1e6 (white = 1)")
        luminance = values.astype(np.float32)
        fall = np.flatnonzero(np.diff(luminance) < 0)
        if fall.size:
            k = int(fall[0])
            raise UsageError(
                f"levels fall from {values[k]:g} (level {k}) to {values[k + 1]:g} (level {k + 1}); "
                "allowed: luminances that never fall. Sort them, darkest first"
            )
        distinct, first = np.unique(luminance, return_index=True)
        if distinct.size < 2:
            raise UsageError(f"all levels have the luminance {values[0]:g}: no picture can be shown")
        if np.diff(distinct).min() < CLOSEST:
            raise UsageError(
                f"two levels differ by {np.diff(distinct).min():g}; allowed: {CLOSEST:g} and more, "
                "or equal ones. Leave one of them out"
            )
        for name, array in (
            ("luminance", luminance),
            ("distinct", distinct),
            ("index", first.astype(np.uint8)),
        ):
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    distinct: NDArray[np.float32] = None  # type: ignore[assignment]
    index: NDArray[np.uint8] = None  # type: ignore[assignment]

    @classmethod
    def of(cls, spec: Any, response: str | Encoding | None = None) -> Levels:
        """Levels from a count, a text form, a sequence of luminances, or Levels.

        response : the encoding under which a bare count is meant (sRGB if None): level k of n has
        the luminance of the code k/(n−1). It does not apply to anything but a count.
        """
        if isinstance(spec, Levels):
            return _no_response(spec, response)
        if isinstance(spec, str):
            return _parse(spec.strip(), response)
        if isinstance(spec, int | np.integer) and not isinstance(spec, bool):
            return _count(int(spec), response)
        try:
            values = np.asarray(spec, np.float64)
        except (TypeError, ValueError):
            raise UsageError(f"levels={spec!r}; {_ALLOWED}") from None
        if values.ndim == 0:
            raise UsageError(f"levels={spec!r}; {_ALLOWED}")
        text = ",".join(f"{v:.9g}" for v in np.ravel(values)[:256])
        return _no_response(cls(values, text), response)  # type: ignore[arg-type]

    def __len__(self) -> int:
        return self.luminance.size

    @property
    def darkest(self) -> float:
        return float(self.distinct[0])

    @property
    def lightest(self) -> float:
        return float(self.distinct[-1])

    @property
    def bits(self) -> int:
        """Bits that hold a level index: 1, 2, 4 or 8."""
        return next(bits for bits in (1, 2, 4, 8) if len(self) <= 1 << bits)

    @cached_property
    def contours(self) -> int:
        """How many steps between neighbouring levels show in a smooth area."""
        return visible_steps(self.distinct)

    def middles(self) -> NDArray[np.float32]:
        """Light from which on the next distinct level is the nearer one; above the lower level."""
        low, high = self.distinct[:-1], self.distinct[1:]
        middle = ((low.astype(np.float64) + high) / 2).astype(np.float32)
        return np.where(middle > low, middle, high)

    def buckets(self) -> tuple[NDArray[np.uint8], float]:
        """A table from darkest to lightest of the nearest level at the start of each bucket.

        A kernel takes ⌊(v − darkest)·scale⌋ in float32 and walks up from there by
        :meth:`middles`; a bucket starts one bucket early, which is more than any rounding of that
        product. Returns the table and the scale.
        """
        darkest, lightest = self.darkest, self.lightest
        scale = float(np.float32((BUCKETS - 1) / (lightest - darkest)))
        edge = darkest + (np.arange(BUCKETS) - 1) / scale
        return np.searchsorted(self.middles(), edge, side="right").astype(np.uint8), scale

    def srgb(self) -> NDArray[np.uint8]:
        """8-bit sRGB code of every level index, as a saved picture shows it."""
        code = encoding("srgb").encode(np.minimum(self.luminance, 1))
        return np.rint(code * 255).astype(np.uint8)


@lru_cache(maxsize=64)
def _count(n: int, response: str | Encoding | None) -> Levels:
    if not 2 <= n <= 256:
        raise UsageError(f"levels={n}; {_ALLOWED}")
    code = encoding(response or "srgb")
    return Levels(code.decode(np.arange(n) / (n - 1)), str(n), code)  # type: ignore[arg-type]


def _parse(text: str, response: str | Encoding | None) -> Levels:
    name, _, rest = text.lower().replace("_", "-").replace("l*", "lstar").partition(":")
    try:
        if not rest and "," in name:
            return Levels.of([float(part) for part in name.split(",")], response)
        if not rest:
            return _count(int(name), response)
        if name in ("uniform-linear", "uniform", "linear"):
            made = Levels(uniform_ladder(_steps(rest)), text)  # type: ignore[arg-type]
        elif name == "lstar":
            made = Levels(lstar_ladder(_steps(rest)), text)  # type: ignore[arg-type]
        elif name == "log":
            black, _, count = rest.partition(":")
            made = Levels(log_ladder(float(black), _steps(count)), text)  # type: ignore[arg-type]
        else:
            raise ValueError(name)
    except UsageError:
        raise
    except ValueError:
        raise UsageError(f"levels='{text}' is not understood; {_ALLOWED}") from None
    return _no_response(made, response)


def _steps(count: str) -> int:
    n = int(count)
    if not 2 <= n <= 256:
        raise UsageError(f"{n} levels; {_ALLOWED}")
    return n - 1


def _no_response(levels: Levels, response: str | Encoding | None) -> Levels:
    if response is not None:
        raise UsageError(
            f"gamma does not apply to levels '{levels.text}', whose luminances are given; "
            "leave it out, or give a count of levels"
        )
    return levels
