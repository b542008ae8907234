"""Growing pattern families for any n: a search for the order in which dots spread most evenly.

The visible noise of pattern k is Σ c(p − q) over its pairs of on-positions p, q of the torus, where
c is what the eye blurs one dot into another. Summed over all patterns of an order this is, but for
a constant, −½ Σ c(p − q)·|rank p − rank q|: near positions should come far apart in the order. The
search starts from greedy orders (each dot into the largest void), and swaps pairs of ranks as long
as that sum falls and the rules hold:

* no streaks: up to :func:`streak_limit` no row, column or wrapped diagonal of the tiled plane is
  all on; and, where the search finds it, none is all off from n² − limit on;
* no isolated dots, where asked for: from the stated pattern on, every on-pixel has an on-pixel
  above, below, left or right of it.

A clustered family has the opposite aim: one round dot a tile grows ring by ring, each pixel where it
has most company, to a diamond at the half; from there on the gap between the dots shrinks alike.
All sums are of whole numbers, so that every machine grows the same family.
"""

from __future__ import annotations

import random
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from halftone.errors import UsageError
from halftone.screens.family import SIZES, PatternFamily, lines_of, neighbours_of, streak_limit

__all__ = ["CLASSIC", "FORMS", "classic2", "classic3", "family", "grow"]

FORMS = "classic2, classic3, N (2 … 16), N:isolated=K, N:clustered, N:seed=S, or a saved family's file"

STARTS = 6
"""Greedy orders from which the search sets out; the best result is taken."""
SHAKES = 6000
"""Over n², and at most 150: times the best order is disturbed by random swaps and improved again."""
MENDS = 2000
"""Most swaps that are tried to mend an order that breaks a rule."""
TRIALS = 3000
"""Most swaps that one improvement tries; what the rules forbid counts as well."""

Ranks = NDArray[np.int64]
Numbers = NDArray[np.float64]

_SOURCE = "Hearn & Baker, halftone patterns"
CLASSIC = {
    "classic2": ((3, 1), (2, 4)),
    "classic3": ((8, 3, 7), (5, 1, 2), (4, 9, 6)),
}
"""Position numbers of the classic families; pattern 3 of the 3 × 3 is the L."""


def classic2() -> PatternFamily:
    """The classic 2 × 2 family: 5 patterns."""
    return PatternFamily.from_numbers(CLASSIC["classic2"], "classic2", _SOURCE)


def classic3() -> PatternFamily:
    """The classic 3 × 3 family: 10 patterns."""
    return PatternFamily.from_numbers(CLASSIC["classic3"], "classic3", _SOURCE)


def family(text: str) -> PatternFamily:
    """The family of a text form: one of :data:`FORMS`; ``levels=L`` may follow for L levels."""
    head, *parts = text.strip().split(":")
    name = head.strip().lower()
    if name not in CLASSIC and not name.isdecimal():
        if not Path(text).is_file():
            raise UsageError(f"unknown pattern family '{text}', and no such file; allowed: {FORMS}")
        return replace(PatternFamily.load(text), name=text)
    numbers: dict[str, int] = {}
    clustered = False
    allowed = ("levels",) if name in CLASSIC else ("isolated", "seed", "levels")
    for part in parts:
        key, _, value = part.strip().lower().partition("=")
        if part.strip().lower() == "clustered" and name not in CLASSIC:
            clustered = True
        elif key in allowed and value.isdecimal():
            numbers[key] = int(value[:24])
        else:
            known = ", ".join([*(f"{k}=…" for k in allowed), "clustered"][: len(allowed) + 1])
            raise UsageError(f"'{part}' in the pattern family '{text}' is unknown; allowed: {known}")
    levels = numbers.get("levels", 2)
    if name in CLASSIC:
        return (classic2() if name == "classic2" else classic3()).extended(levels)
    return grow(int(name[:24]), levels, numbers.get("isolated"), clustered, numbers.get("seed", 0))


@lru_cache(maxsize=64, typed=True)
def grow(
    n: int,
    levels: int = 2,
    isolated_from: int | None = None,
    clustered: bool = False,
    seed: int = 0,
) -> PatternFamily:
    """The n × n pattern family of a search; the same arguments always give the same family.

    n : 2 … 16. levels : 2 … 256; more than two repeat the order for each level (level-major), so
    that a pattern holds two neighbouring levels at most and every flat level is a pattern.
    isolated_from : the pattern, 2 … n², from which on no on-pixel stands alone, for devices that
    lose or swell single dots; dots then come in groups that spread evenly.
    clustered : one growing cluster a tile, as printers like it; 2 is then its ``isolated_from``.
    seed : another draw among ties and disturbances.
    """
    if isinstance(n, bool) or n not in SIZES:
        raise UsageError(f"patterns of size n={n!r}; allowed: {SIZES[0]} … {SIZES[-1]}")
    if isolated_from is not None and not 2 <= isolated_from <= n * n:
        raise UsageError(
            f"isolated={isolated_from}; allowed for n = {n}: 2 … {n * n} (a single dot is always "
            "isolated)"
        )
    if not 0 <= seed < 1 << 64:
        raise UsageError(f"seed={seed}; allowed: 0 … 2^64 − 1")
    name = str(n)
    name += "" if isolated_from is None else f":isolated={isolated_from}"
    name += ":clustered" if clustered else ""
    name += f":seed={seed}" if seed else ""
    joined = 2 if clustered and isolated_from is None else isolated_from
    rank = _search(n, joined or 0, clustered, seed)
    return PatternFamily(n, 2, np.argsort(rank), name, seed, joined).extended(levels)


class _Rules(NamedTuple):
    """The torus, and what an order of it must keep.

    blur : c(p − q) in whole numbers, (n², n²); lines, neighbours : positions.
    limit : no streaks up to this pattern. joined : no isolated dots from this one on; 0 = never mind.
    """

    blur: Numbers
    lines: Ranks
    neighbours: Ranks
    limit: int
    joined: int

    def broken(self, rank: Ranks) -> int:
        """How many lines and dots break the rules; 0 where *rank* keeps them.

        A dark streak counts least: never is it mended at the cost of a light one or of a lone dot.
        """
        on = rank[self.lines]
        count = np.count_nonzero(on.max(axis=1) < self.limit)
        if self.joined:
            nearest = rank[self.neighbours].min(axis=1)
            count += np.count_nonzero(nearest >= np.maximum(rank, self.joined))
        dark = np.count_nonzero(on.min(axis=1) >= rank.size - self.limit)
        return int(count) * (len(on) + 1) + int(dark)


def _search(n: int, joined: int, clustered: bool, seed: int) -> Ranks:
    """The best order found, as the rank of each position, (n²,)."""
    draw = random.Random(seed)  # whose random() is the same in every version of Python
    blur = _blur(n)
    rules = _Rules(-blur if clustered else blur, lines_of(n), neighbours_of(n), streak_limit(n), joined)
    if clustered:
        return _mended(_greedy(rules, _draws(draw, n * n), joined, _shells(n)), rules)
    ranks = []
    for start in range(STARTS):
        # Past the middle few dots are alone anyway: pairs from the first are one way of two.
        groups = 0 if start % 2 and joined > rules.limit else joined
        rank = _greedy(rules, _draws(draw, n * n), groups)
        ranks.append(_improved(_mended(rank, rules), rules))
    best = max(ranks, key=lambda rank: (-rules.broken(rank), _spread(rank, blur)))
    allowed, most = rules.broken(best), _spread(best, blur)
    for _ in range(min(150, SHAKES // n**2)):
        rank = best.copy()
        for _ in range(3):
            p, q = (int(draw.random() * n * n) for _ in range(2))
            rank[p], rank[q] = rank[q], rank[p]
        if rules.broken(rank) > allowed:
            continue
        rank = _improved(rank, rules)
        if (found := _spread(rank, blur)) > most:
            best, most = rank, found
    return best


def _blur(n: int) -> Numbers:
    """c(p − q) = Σ (2² + d²)^(−3/2) over the images of q on the tiled plane, in units of 2^−16.

    The form of the eye's point spread function after Näsänen (1984); 2 pixels is about the width
    for 200 dots per inch at 30 cm. Only + · / √, which round alike everywhere.
    """
    near = np.minimum(np.arange(n), n - np.arange(n))
    total = np.zeros((n, n))
    for i in range(-3, 4):
        for j in range(-3, 4):
            square = 4.0 + (near + i * n)[:, None] ** 2 + (near + j * n) ** 2
            total += 1 / (square * np.sqrt(square))
    kernel = np.rint(total / total[0, 0] * 2.0**16)
    y, x = np.divmod(np.arange(n * n), n)
    blur: Numbers = kernel[(y[:, None] - y) % n, (x[:, None] - x) % n]
    return blur


def _draws(draw: random.Random, count: int) -> Ranks:
    """A random permutation of 0 … count−1."""
    return np.argsort(np.array([draw.random() for _ in range(count)]), kind="stable")


def _spread(rank: Ranks, blur: Numbers) -> float:
    """Σ c(p − q)·|rank p − rank q|: the larger, the less noise is seen over all patterns."""
    return float((blur * np.abs(rank[:, None] - rank)).sum())


def _shells(n: int) -> Ranks:
    """The shell of each position: what is filled in turn as a cluster grows in the tile's middle.

    Rings about the middle as far as the diamond that covers half of the tile, which is round at
    first; then, mirrored, rings about the tile's corner from the outside in.
    """
    near = 2 * np.abs(np.arange(n) - n // 2)
    near = np.minimum(near, 2 * n - near)
    y, x = near[:, None], near
    diamond = np.sign(y + x - n)
    ring = np.where(diamond < 0, y**2 + x**2, 2 * n**2 - (n - y) ** 2 - (n - x) ** 2)
    ring[diamond == 0] = 0
    shells: Ranks = (diamond * 4 * n**2 + ring).ravel()
    return shells


def _greedy(rules: _Rules, tie: Ranks, joined: int, shells: Ranks | None = None) -> Ranks:
    """Each dot in turn where the blurred pattern is darkest; ties by *tie*.

    joined : dots come in pairs up to this pattern, and later ones touch an earlier one.
    shells : of each position; a lower one is filled before a higher one.
    """
    size = tie.size
    n = rules.lines.shape[1]
    on = np.zeros(size, bool)
    field = np.zeros(size)
    rank = np.zeros(size, np.int64)
    for k in range(size):
        allowed = ~on
        if shells is not None:
            allowed &= shells == shells[allowed].min()
        elif joined and k:
            lone = on & ~on[rules.neighbours].any(axis=1)
            if k < joined and lone.any():
                allowed &= lone[rules.neighbours].any(axis=1)
            elif k >= joined - 1:
                allowed &= on[rules.neighbours].any(axis=1)
        if k < rules.limit:
            closing = np.zeros(size, bool)
            closing[rules.lines[on[rules.lines].sum(axis=1) == n - 1]] = True
            if (allowed & ~closing).any():
                allowed &= ~closing
        p = int(np.argmin(np.where(allowed, field * size + tie, np.inf)))
        on[p] = True
        rank[p] = k
        field += rules.blur[p]
    return rank


def _gains(rank: Ranks, blur: Numbers, apart: Numbers, product: Numbers) -> Numbers:
    """By how much (half) the spread grows if the ranks of p and q are swapped, for every pair.

    apart : |rank p − rank q|; product : blur @ apart.
    """
    own = product.diagonal()
    gains: Numbers = product + product.T - own[:, None] - own - 2 * apart * (blur[0, 0] - blur)
    return gains


def _mended(rank: Ranks, rules: _Rules) -> Ranks:
    """*rank* after the swaps, best spread first, that leave fewer rules broken."""
    rank = rank.copy()
    first, second = np.triu_indices(rank.size, 1)
    trials = 0
    while broken := rules.broken(rank):
        apart = np.abs(rank[:, None] - rank).astype(np.float64)
        gain = _gains(rank, rules.blur, apart, rules.blur @ apart)[first, second]
        for t in np.argsort(-gain, kind="stable")[: MENDS - trials]:
            p, q = first[t], second[t]
            rank[p], rank[q] = rank[q], rank[p]
            trials += 1
            if rules.broken(rank) < broken:
                break
            rank[p], rank[q] = rank[q], rank[p]
        else:
            break  # the family reports what is left
    return rank


def _improved(rank: Ranks, rules: _Rules) -> Ranks:
    """*rank* after the swaps, the best first, that spread it more and keep the rules."""
    rank = rank.copy()
    blur = rules.blur
    first, second = np.triu_indices(rank.size, 1)
    apart = np.abs(rank[:, None] - rank).astype(np.float64)
    product = blur @ apart
    trials = 0
    allowed = rules.broken(rank)
    while trials < TRIALS:
        gain = _gains(rank, blur, apart, product)[first, second]
        better = np.flatnonzero(gain > 0)
        for t in better[np.argsort(-gain[better], kind="stable")][: TRIALS - trials]:
            p, q = first[t], second[t]
            rank[p], rank[q] = rank[q], rank[p]
            trials += 1
            if rules.broken(rank) <= allowed:
                break
            rank[p], rank[q] = rank[q], rank[p]
        else:
            break
        # Rows and columns p and q of *apart* change places; the product follows by a rank-one step.
        change = np.abs(rank[p] - rank) - apart[p]
        change[[p, q]] = 0
        apart[p] += change
        apart[q] -= change
        apart[:, p], apart[:, q] = apart[p], apart[q]
        product += np.outer(blur[:, p] - blur[:, q], change)
        product[:, p], product[:, q] = blur @ apart[p], blur @ apart[q]
    return rank
