"""The canonical error filters: which neighbours take which share of a pixel's error.

A tap (dy, dx, w) sends w/divisor of the error dy rows down and dx columns ahead in the direction of
the scan. Weights are the published ones; where two publications differ, the one named.
"""

from __future__ import annotations

from dataclasses import dataclass

from halftone._arrays import shortest
from halftone.errors import UsageError

__all__ = ["FILTERS", "ErrorFilter", "four_weights"]

Tap = tuple[int, int, float]


@dataclass(frozen=True)
class ErrorFilter:
    """Taps of an error filter. Weights are not negative and sum to at most the divisor.

    measured_side : see :attr:`exact_side`.
    """

    name: str
    taps: tuple[Tap, ...]
    divisor: float
    source: str = "—"
    measured_side: int | None = None

    def __post_init__(self) -> None:
        total = 0.0
        seen = set()
        for dy, dx, w in self.taps:
            if not (0 <= dy <= 8 and -8 <= dx <= 8 and (dy > 0 or 0 < dx <= 2)):
                raise UsageError(
                    f"filter '{self.name}': a tap {dy} rows down and {dx} columns ahead; allowed: "
                    "1 or 2 ahead in the row, and up to 8 rows down and 8 columns to either side"
                )
            if (dy, dx) in seen:
                raise UsageError(f"filter '{self.name}': two taps at {dy} down, {dx} ahead")
            if not 0 <= w < float("inf"):
                raise UsageError(f"filter '{self.name}': weight {w!r}; allowed: 0 and above")
            seen.add((dy, dx))
            total += w
        if not (0 < self.divisor < float("inf")) or total > self.divisor * (1 + 1e-9):
            raise UsageError(
                f"filter '{self.name}': weights sum to {total:g}/{self.divisor:g}; allowed: at most "
                "1, or errors grow without bound. Raise the divisor"
            )

    @property
    def conserves(self) -> bool:
        """Whether all of the error is passed on."""
        return abs(sum(w for _, _, w in self.taps) / self.divisor - 1) < 1e-6

    @property
    def exact_side(self) -> int:
        """Side of the square patch from which on every tone is right within 0.5/255.

        What is missing is the error that waits beyond the patch's rim: up to 175/255 of a step times
        the mean distance of the taps, over the side. Measured for the canonical filters, at the
        tones k/255, k/64 and k/48 and both scans; estimated from that rule, rounded up, for others.
        """
        if self.measured_side is not None:
            return self.measured_side
        distance = sum(w * (dy + abs(dx)) for dy, dx, w in self.taps) / self.divisor
        return max(192, -(-int(350 * distance) // 32) * 32)

    @property
    def depth(self) -> int:
        """Rows below that take error."""
        return max((dy for dy, _, _ in self.taps), default=0)

    @property
    def reach(self) -> int:
        """Columns to the farther side that take error."""
        return max((abs(dx) for _, dx, _ in self.taps), default=0)


def four_weights(weights: tuple[float, ...], divisor: float) -> ErrorFilter:
    """A filter with Floyd and Steinberg's four places: ahead, down-back, down, down-ahead."""
    if len(weights) != 4:
        raise UsageError(f"{len(weights)} weights; allowed: 4 (ahead, down-back, down, down-ahead)")
    places = ((0, 1), (1, -1), (1, 0), (1, 1))
    taps = tuple((*place, w) for place, w in zip(places, weights, strict=True))
    text = ",".join(shortest(w) for w in weights)
    return ErrorFilter(f"ed:{text}/{shortest(divisor)}", taps, divisor, "given weights")


def _filter(name: str, divisor: float, source: str, side: int, *rows: dict[int, float]) -> ErrorFilter:
    taps = tuple((dy, dx, w) for dy, row in enumerate(rows) for dx, w in sorted(row.items()))
    return ErrorFilter(name, taps, divisor, source, side)


def _row(first: int, *weights: float) -> dict[int, float]:
    return {first + i: w for i, w in enumerate(weights)}


_STUCKI_ROW = _row(-2, 2, 4, 8, 4, 2)

FILTERS = {
    made.name: made
    for made in (
        _filter("floyd-steinberg", 16, "Floyd & Steinberg 1976", 256, {1: 7}, _row(-1, 3, 5, 1)),
        _filter("false-floyd-steinberg", 8, "folklore, 1980s", 256, {1: 3}, _row(0, 3, 2)),
        _filter(
            "jarvis-judice-ninke",
            48,
            "Jarvis, Judice & Ninke 1976",
            384,
            _row(1, 7, 5),
            _row(-2, 3, 5, 7, 5, 3),
            _row(-2, 1, 3, 5, 3, 1),
        ),
        _filter("stucki", 42, "Stucki 1981", 384, _row(1, 8, 4), _STUCKI_ROW, _row(-2, 1, 2, 4, 2, 1)),
        _filter("burkes", 32, "Burkes 1988", 352, _row(1, 8, 4), _STUCKI_ROW),
        _filter(
            "sierra",
            32,
            "Sierra 1989",
            384,
            _row(1, 5, 3),
            _row(-2, 2, 4, 5, 4, 2),
            _row(-1, 2, 3, 2),
        ),
        _filter("sierra-two-row", 16, "Sierra 1990", 352, _row(1, 4, 3), _row(-2, 1, 2, 3, 2, 1)),
        _filter("sierra-lite", 4, "Sierra 1990", 192, {1: 2}, _row(-1, 1, 1)),
        _filter("atkinson", 8, "Atkinson, 1984", 192, _row(1, 1, 1), _row(-1, 1, 1, 1), {0: 1}),
        _filter(
            "stevenson-arce",
            200,
            "Stevenson & Arce 1985, resampled from its hexagonal grid to a square one",
            512,
            {1: 32},
            _row(-3, 6, 13, 10, 19, 10, 18, 8),
            _row(-1, 12, 26, 12),
            _row(-3, 3, 6, 4, 8, 4, 7, 2),
        ),
        _filter("shiau-fan", 16, "Shiau & Fan 1993", 256, {1: 8}, _row(-3, 1, 1, 2, 4)),
        _filter("shiau-fan-2", 16, "Shiau & Fan 1993", 256, {1: 7}, _row(-2, 1, 3, 5)),
    )
}
