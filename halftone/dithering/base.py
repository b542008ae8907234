"""What every method is: a value with a text form and a tone claim that makes a halftoner for a job."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import Source
from halftone.tone.levels import Levels

__all__ = ["EXACT", "NO_CLAIM", "Claim", "Halftoner", "Job", "Method"]


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
    """One picture for one device: light already within the range of the levels."""

    source: Source
    levels: Levels
    seed: int = 0


class Halftoner(Protocol):
    """Turns bands of rows into level indices.

    Where ``parallel`` is true, bands may come in any order and from several threads; otherwise
    they come once each, from the top, and state is carried from one to the next. The result does
    not depend on the height of the bands.
    """

    parallel: bool

    def band(self, start: int, stop: int, out: NDArray[np.uint8]) -> None:
        """Level indices of rows start … stop−1 into *out*, (stop−start, N)."""


class Method(Protocol):
    """A halftoning method: a frozen dataclass."""

    @property
    def claim(self) -> Claim: ...

    @property
    def source(self) -> str:
        """Paper and year."""

    @property
    def needs(self) -> str:
        """What it runs on: ``numpy`` or ``kernel`` (compiled)."""

    def text(self) -> str:
        """The text form, which makes an equal method again."""

    def with_options(self, **options: Any) -> Method:
        """The same method with strength, serpentine or seed set; UsageError if one does not apply."""

    def check(self, levels: Levels) -> None:
        """UsageError if the method cannot work on these levels."""

    def halftoner(self, job: Job) -> Halftoner: ...
