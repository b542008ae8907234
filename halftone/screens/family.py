"""Pattern families: n × n patterns that evolve, each from the one before by adding one dot.

A family is a growth order: which position of the tile rises by one level at each step. Pattern k is
what stands after k steps, so that pattern k is pattern k−1 plus one dot (nesting), from pattern 0,
all at level 0, to the last, all at the highest level. On L levels there are n²·(L−1) + 1 of them.

"On" means above level 0. Patterns are judged as they are seen: tiled over the plane.
"""

from __future__ import annotations

import json
import os
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halftone.errors import OutputError, UsageError
from halftone.screens.order import Screen, from_ranks

__all__ = ["SIZES", "FamilyReport", "PatternFamily", "lines_of", "neighbours_of", "streak_limit"]

SIZES = range(2, 17)
"""Sizes n of the patterns."""

FORMAT = "halftone-pattern-family"
LARGEST_FILE = 4 << 20
"""Bytes; the order of n = 16 on 256 levels takes a tenth of it."""

Grid = NDArray[np.int64]


def lines_of(n: int) -> Grid:
    """Positions of the 4n lines of an n × n tile, (4n, n): rows, columns, wrapped diagonals.

    Diagonals come falling to the right, then falling to the left.
    """
    grid = np.arange(n * n).reshape(n, n)
    i = np.arange(n)
    falling = grid[i, (i[:, None] + i) % n]
    rising = grid[i, (i[:, None] - i) % n]
    return np.concatenate([grid, grid.T, falling, rising])


def neighbours_of(n: int) -> Grid:
    """Positions above, below, left and right of every position of the tiled plane, (n², 4)."""
    grid = np.arange(n * n).reshape(n, n)
    shifts = ((1, 0), (-1, 0), (1, 1), (-1, 1))
    return np.stack([np.roll(grid, by, axis).ravel() for by, axis in shifts], axis=1)


def streak_limit(n: int) -> int:
    """The pattern up to which no line of the tiled plane should be all on: 1, 3, then ⌊n²/2⌋."""
    return {2: 1, 3: 3}.get(n, n * n // 2)


@dataclass(frozen=True)
class FamilyReport:
    """What :meth:`PatternFamily.check` found.

    patterns : how many there are.
    nested : whether each pattern is the one before with one position one level higher.
    first_streak : the first pattern with a full row, column or wrapped diagonal of on-pixels;
    streak : which line it is; streak_limit : the pattern up to which there should be none.
    isolated_from : the pattern the family promises to have no isolated dots from, or None;
    first_isolated : the first pattern from there on (from 1 on if nothing is promised) in which an
    on-pixel has no on-pixel above, below, left or right of it, or None if there is none.
    joined_from : the first pattern from which on none has an isolated dot.
    """

    patterns: int
    nested: bool
    first_streak: int
    streak: str
    streak_limit: int
    isolated_from: int | None
    first_isolated: int | None
    joined_from: int

    @property
    def sound(self) -> bool:
        """Nested, free of streaks up to the limit, and true to its promise of isolated dots."""
        kept = self.isolated_from is None or self.first_isolated is None
        return self.nested and self.first_streak > self.streak_limit and kept


@dataclass(frozen=True, eq=False)
class PatternFamily:
    """A family of n × n patterns on L levels, as the order in which its positions rise.

    n : 2 … 16. levels : L, 2 … 256.
    order : positions (row·n + column), (n²·(L−1),); each position L−1 times.
    name : the text form. seed : of the search that grew it. isolated_from : from this pattern on
    no on-pixel is isolated, or None. source : who published it.

    Two families are equal if their patterns are.
    """

    n: int
    levels: int
    order: Grid
    name: str
    seed: int = 0
    isolated_from: int | None = None
    source: str = "grown by search"

    def __post_init__(self) -> None:
        for what, value, allowed in (("n", self.n, SIZES), ("levels", self.levels, range(2, 257))):
            if isinstance(value, bool) or value not in allowed:
                raise UsageError(
                    f"pattern family '{self.name}': {what}={value!r}; "
                    f"allowed: {allowed[0]} … {allowed[-1]}"
                )
        array = np.array(self.order)
        if array.ndim != 1 or array.dtype.kind not in "iu":
            raise UsageError(
                f"pattern family '{self.name}': an order of shape {array.shape} and type "
                f"{array.dtype}; allowed: a list of whole numbers"
            )
        array = array.astype(np.int64)
        cells, steps = self.n**2, self.levels - 1
        beyond = np.flatnonzero((array < 0) | (array >= cells))
        if beyond.size:
            raise UsageError(
                f"pattern family '{self.name}': step {beyond[0] + 1} of the order names position "
                f"{array[beyond[0]]}; allowed: 0 … {cells - 1}"
            )
        counts = np.bincount(array, minlength=cells)
        wrong = np.flatnonzero(counts != steps)
        if wrong.size:
            p = int(wrong[0])
            raise UsageError(
                f"pattern family '{self.name}': position {p} (row {p // self.n}, column "
                f"{p % self.n}) comes {counts[p]} times in the order, and {wrong.size - 1} others come "
                f"a wrong number of times; allowed: every position 0 … {cells - 1}, {steps} times"
            )
        array.flags.writeable = False
        object.__setattr__(self, "order", array)

    @classmethod
    def from_numbers(cls, numbers: ArrayLike, name: str, source: str = "—") -> PatternFamily:
        """A bilevel family from position numbers 1 … n², (n, n): a pixel is on iff its number ≤ k."""
        array = np.asarray(numbers)
        if array.ndim != 2 or array.shape[0] != array.shape[1] or array.dtype.kind not in "iu":
            raise UsageError(
                f"pattern family '{name}': numbers of shape {array.shape} and type {array.dtype}; "
                "allowed: whole numbers, (n, n)"
            )
        missing = sorted(set(range(1, array.size + 1)) - set(array.ravel().tolist()))
        if missing:
            raise UsageError(
                f"pattern family '{name}': the position number {missing[0]} is missing; allowed: "
                f"every number 1 … {array.size} once"
            )
        return cls(array.shape[0], 2, np.argsort(array.ravel()), name, source=source)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, PatternFamily) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def _key(self) -> tuple[int, int, bytes]:
        return self.n, self.levels, self.order.tobytes()

    def __len__(self) -> int:
        """The number of patterns, n²·(L−1) + 1."""
        return self.order.size + 1

    @property
    def level_major(self) -> bool:
        """Whether it passes through every flat level: pattern n²·i is level i everywhere.

        It then has the least contrast: no pattern holds more than two levels, next to each other.
        """
        steps = np.sort(self.order.reshape(self.levels - 1, -1), axis=1)
        return bool((steps == np.arange(self.n**2)).all())

    @property
    def ranks(self) -> Grid:
        """The step, 0 …, at which each position first rises above level 0, (n, n)."""
        first = np.unique(self.order, return_index=True)[1]
        return first.reshape(self.n, self.n)

    @property
    def numbers(self) -> Grid:
        """Position numbers, 1 …, (n, n): a pixel is on in pattern k iff its number ≤ k."""
        return self.ranks + 1

    def pattern(self, k: int) -> NDArray[np.uint8]:
        """Level indices of pattern *k*, uint8 (n, n), 0 = the darkest."""
        if not 0 <= k < len(self):
            raise UsageError(f"pattern {k} of the family '{self.name}'; allowed: 0 … {len(self) - 1}")
        counts = np.bincount(self.order[:k], minlength=self.n**2)
        return counts.astype(np.uint8).reshape(self.n, self.n)

    def patterns(self) -> NDArray[np.uint8]:
        """Level indices of all patterns, uint8 (patterns, n, n)."""
        steps = np.zeros((len(self), self.n**2), np.uint8)
        steps[np.arange(1, len(self)), self.order] = 1
        return np.cumsum(steps, axis=0, dtype=np.uint8).reshape(-1, self.n, self.n)

    def extended(self, levels: int) -> PatternFamily:
        """A bilevel family on *levels* levels, level-major: the same order again for each level."""
        if levels == self.levels:
            return self
        if self.levels != 2:
            raise UsageError(
                f"the pattern family '{self.name}' has {self.levels} levels and {levels} were asked "
                "for; allowed: as many, or a family of 2 levels, which fits any number"
            )
        name = f"{self.name}:levels={levels}"
        return replace(self, levels=levels, order=np.tile(self.order, levels - 1), name=name)

    def screen(self) -> Screen:
        """A threshold array of the same spatial order, for ordered dither at full resolution."""
        first = self.order[: self.n**2]
        if not np.array_equal(self.order, np.tile(first, self.levels - 1)):
            raise UsageError(
                f"the pattern family '{self.name}' has another order on each of its levels, which "
                "no threshold array can say; use a family of 2 levels"
            )
        return from_ranks(self.ranks, f"growth:{self.name}", self.source)

    def check(self) -> FamilyReport:
        """Prove the family: nesting, count, streaks and isolated dots, from its patterns."""
        flat = self.patterns().reshape(len(self), -1)
        steps = flat[1:] - flat[:-1]  # uint8: a fall would show as 255
        nested = bool((steps.sum(axis=1) == 1).all()) and not flat[0].any()
        rank = self.ranks.ravel()
        full = rank[lines_of(self.n)].max(axis=1) + 1
        worst = int(full.argmin())
        kind = ("row", "column", "diagonal falling right", "diagonal falling left")[worst // self.n]
        nearest = rank[neighbours_of(self.n)].min(axis=1)
        # A dot is alone in the patterns after its own step up to its first neighbour's.
        alone = np.zeros(len(self) + 1, np.int64)
        lone = nearest > rank
        np.add.at(alone, rank[lone] + 1, 1)
        np.add.at(alone, nearest[lone] + 1, -1)
        isolated = np.flatnonzero(alone.cumsum() > 0)
        promised = isolated[isolated >= (self.isolated_from or 1)]
        return FamilyReport(
            patterns=len(self),
            nested=nested,
            first_streak=int(full[worst]),
            streak=f"{kind} {worst % self.n}",
            streak_limit=streak_limit(self.n),
            isolated_from=self.isolated_from,
            first_isolated=int(promised[0]) if promised.size else None,
            joined_from=int(isolated[-1]) + 1 if isolated.size else 1,
        )

    def sheet(
        self, magnify: int = 4, repeat: int = 1, across: int = 0, gap: int = 6, background: int = 255
    ) -> NDArray[np.uint8]:
        """A picture of all patterns in reading order, uint8 gray codes (height, width).

        Every pattern is tiled repeat × repeat, each of its pixels drawn as magnify × magnify, with a
        frame of middle gray and *gap* pixels of the *background* code between. across : patterns in
        a row; 0 gives a sheet about as wide as high. Level i of L has the code 255·i/(L−1).
        """
        for what, value, least in (("magnify", magnify, 1), ("repeat", repeat, 1), ("gap", gap, 0)):
            if not least <= value <= 64:
                raise UsageError(f"{what}={value!r}; allowed: {least} … 64")
        across = across or max(1, round(len(self) ** 0.5))
        down = -(-len(self) // across)
        codes = np.rint(np.arange(self.levels) * 255 / (self.levels - 1)).astype(np.uint8)
        side = self.n * repeat * magnify
        sheet = np.full(((side + 2 + gap) * down + gap, (side + 2 + gap) * across + gap), background)
        for k, pattern in enumerate(self.patterns()):
            y = gap + (k // across) * (side + 2 + gap)
            x = gap + (k % across) * (side + 2 + gap)
            sheet[y : y + side + 2, x : x + side + 2] = 128
            big = np.tile(codes[pattern], (repeat, repeat)).repeat(magnify, 0).repeat(magnify, 1)
            sheet[y + 1 : y + 1 + side, x + 1 : x + 1 + side] = big
        return sheet.astype(np.uint8)

    def save(self, path: str | Path) -> None:
        """Write the family as a JSON file, whole or not at all."""
        content = {
            "format": FORMAT,
            "version": 1,
            "n": self.n,
            "levels": self.levels,
            "name": self.name,
            "seed": self.seed,
            "isolated_from": self.isolated_from,
            "source": self.source,
            "order": self.order.tolist(),
        }
        target = Path(path)
        temporary = target.with_name(f".halftone-{os.urandom(6).hex()}.part")
        try:
            temporary.write_text(json.dumps(content, ensure_ascii=False) + "\n", encoding="utf-8")
            temporary.replace(target)
        except OSError as error:
            raise OutputError(f"'{target}' cannot be written: {error.strerror or error}") from None
        finally:
            with suppress(OSError):
                temporary.unlink()

    @classmethod
    def load(cls, path: str | Path) -> PatternFamily:
        """Read what :meth:`save` wrote; UsageError for a missing, damaged or foreign file."""
        content = _read(Path(path))
        missing = [k for k in ("n", "levels", "name", "order") if k not in content]
        if missing:
            raise UsageError(f"the pattern family in '{path}' lacks '{missing[0]}'")
        order = content["order"]
        whole = isinstance(order, list) and all(type(p) is int and abs(p) < 1 << 31 for p in order)
        seed, isolated = content.get("seed", 0), content.get("isolated_from")
        texts = (content["name"], content.get("source", "—"))
        kinds = (
            ("order", whole),
            ("n", type(content["n"]) is int),
            ("levels", type(content["levels"]) is int),
            ("seed", type(seed) is int),
            ("isolated_from", isolated is None or type(isolated) is int),
            ("name or source", all(isinstance(text, str) for text in texts)),
        )
        for what, right in kinds:
            if not right:
                raise UsageError(
                    f"the pattern family in '{path}' has a wrong {what}; allowed: what "
                    "PatternFamily.save writes (whole numbers; the order as a list of positions)"
                )
        try:
            array = np.array(order, np.int64)
            return cls(content["n"], content["levels"], array, texts[0], seed, isolated, texts[1])
        except UsageError as error:
            raise UsageError(f"'{path}' is damaged: {error}") from None


def _read(path: Path) -> dict[str, Any]:
    """The JSON object in *path*, if it is a pattern family of ours."""
    try:
        with open(path, "rb") as file:
            data = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise UsageError(
            f"the pattern family '{path}' cannot be read: {error.strerror or error}"
        ) from None
    try:
        if len(data) > LARGEST_FILE:
            raise ValueError(f"more than {LARGEST_FILE >> 20} MiB")
        content = json.loads(data)
        if not isinstance(content, dict) or content.get("format") != FORMAT:
            raise ValueError(f"no '{FORMAT}'")
        if content.get("version") != 1:
            raise ValueError(f"version {content.get('version')!r}, and 1 is understood")
    except (ValueError, RecursionError) as error:
        raise UsageError(
            f"'{path}' holds no pattern family ({error}); allowed: a file that PatternFamily.save wrote"
        ) from None
    return content
