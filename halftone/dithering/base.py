"""What every method is: a value with a text form and a tone claim that makes a halftoner."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import Source
from halftone.errors import UsageError
from halftone.tone.levels import Levels

__all__ = ["EXACT", "NO_CLAIM", "Claim", "Halftoner", "Job", "Method", "check_flags", "check_strength"]


@dataclass(frozen=True)
class Claim:
    """What a method promises of a constant patch.

    kind : ``exact``: a patch of *side* × *side* pixels or more shows its luminance within 0.5/255
    of the span of the levels, at every tone. ``tones``: within half the largest step between its
    tones, *tones* of them between two levels. ``none``: nothing.
    """

    kind: str
    tones: int = 0
    side: int = 192

    def __str__(self) -> str:
        if self.kind == "exact":
            return "exact" if self.side == 192 else f"exact from {self.side} px"
        return f"{self.tones} tones" if self.kind == "tones" else "none"


EXACT = Claim("exact")
NO_CLAIM = Claim("none")


@dataclass(frozen=True)
class Job:
    """One picture for one device: light already within the range of the levels.

    dpi : dots per inch across and down, or None where the device does not say.
    workers : the most bands that will be worked on at once, or threads within one band.
    """

    source: Source
    levels: Levels
    dpi: tuple[float, float] | None = None
    workers: int = 1


class Halftoner(Protocol):
    """Turns bands of rows into level indices.

    Bands come once each. Where ``parallel`` is true, they may run at once in several threads: they
    are started in order from the top, at most the job's ``workers`` at a time. Otherwise they run one
    after the other, and state is carried from each to the next. The result depends on neither height
    nor number.
    """

    parallel: bool

    def band(self, start: int, stop: int, out: NDArray[np.uint8]) -> None:
        """Level indices of the picture's rows start … stop−1 into *out*.

        *out* is C-contiguous, ((stop − start)·scale, N·scale) with the method's ``scale``.
        """

    # Where it has them:
    # band_rows: int, the height of bands that suits it better than BAND_ROWS.
    # threads: int, in which it works on one band.
    # stop() -> None, called when the run was interrupted or failed: threads that wait give up.


class Method:
    """A halftoning method: the base of frozen dataclasses, which add their fields.

    scale : output pixels for each picture pixel, across and down; 1 but for pattern replacement.
    needs : what it runs on, ``numpy`` or ``kernel`` (compiled).
    options : names of the fields that :meth:`with_options` may set.
    """

    scale: int = 1
    needs: str = "numpy"
    options: ClassVar[tuple[str, ...]] = ()

    @property
    def claim(self) -> Claim:
        """What it promises of tone."""
        return NO_CLAIM

    @property
    def source(self) -> str:
        """Paper and year."""
        return "—"

    def text(self) -> str:
        """The text form, which makes an equal method again."""
        raise NotImplementedError

    def check(self, levels: Levels) -> None:
        """UsageError if the method cannot work on these levels."""

    def with_options(self, **options: Any) -> Self:
        """The same method with some of its options set; UsageError if one does not apply."""
        for name in options:
            if name not in self.options:
                allowed = f"allowed for it: {', '.join(self.options)}"
                rest = allowed if self.options else "it has no options"
                raise UsageError(f"{name} does not apply to the method '{self.text()}'; {rest}")
        return replace(self, **options)  # type: ignore[type-var]

    def halftoner(self, job: Job) -> Halftoner:
        """What halftones one picture."""
        raise NotImplementedError


def check_strength(strength: float) -> None:
    """Refuse a strength outside 0 … 1: above 1 errors grow without bound."""
    if not isinstance(strength, int | float | np.number) or not 0 <= strength <= 1:
        raise UsageError(f"strength={strength!r}; allowed: 0 (nearest level) … 1 (full)")


def check_flags(**flags: Any) -> None:
    """Refuse what is neither true nor false."""
    for name, value in flags.items():
        if not isinstance(value, bool | np.bool_):
            raise UsageError(f"{name}={value!r}; allowed: True or False")
