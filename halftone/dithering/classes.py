"""Class matrices for dot diffusion: in which order the pixels of a tile are decided."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halftone.dithering.base import EXACT, NO_CLAIM, Claim
from halftone.errors import InputFileError, OutputError, UsageError, near

__all__ = ["AROUND", "CLASSES", "ClassMatrix", "classes", "load_classes", "neighbours"]

Classes = NDArray[Any]

AROUND = ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1))
"""The eight neighbours, (rows down, columns right), in raster order."""


@dataclass(frozen=True, eq=False)
class ClassMatrix:
    """A permutation of 0 … h·w−1, repeated over the picture; class 0 is decided first.

    classes : (h, w), whole numbers, at most 65,536 of them; kept as uint16.
    name : the text form; source : where it was published.
    claim : what was measured of its tone at full strength.
    """

    classes: Classes
    name: str
    source: str = "—"
    claim: Claim = NO_CLAIM

    def __post_init__(self) -> None:
        object.__setattr__(self, "classes", _permutation(self.classes, self.name))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ClassMatrix) and np.array_equal(self.classes, other.classes)

    def __hash__(self) -> int:
        return hash((self.classes.shape, self.classes.tobytes()))

    @property
    def barons(self) -> tuple[int, ...]:
        """Classes without a neighbour of higher class: what they could not show is lost."""
        higher = np.zeros(self.classes.shape, np.bool_)
        for other in neighbours(self.classes):
            higher |= other > self.classes
        return tuple(sorted(int(c) for c in self.classes[~higher]))

    def reach(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Rows that chains of ascending classes from each place reach down and up, (h, w) each.

        A pixel acts on no row farther away. Finite, because classes rise along a chain, and a
        chain through a neighbouring tile meets the same classes.
        """
        return _reach(self.classes, 1), _reach(self.classes, -1)

    def save(self, path: str | Path) -> None:
        """Write ``.npz`` (array ``classes``) or, for any other ending, rows of numbers with commas.

        OutputError if the file cannot be written.
        """
        try:
            if Path(path).suffix == ".npz":
                np.savez_compressed(path, classes=self.classes)
            else:
                np.savetxt(path, self.classes, "%d", ",")
        except OSError as error:
            raise OutputError(f"the class matrix cannot be written to '{path}': {error}") from error


def neighbours(array: NDArray[Any]) -> Iterator[NDArray[Any]]:
    """*array*, repeated in both directions, as each of the eight neighbours sees it."""
    for dy, dx in AROUND:
        yield np.roll(array, (-dy, -dx), (0, 1))


def _reach(array: Classes, sign: int) -> NDArray[np.int64]:
    """Most rows, counted down for *sign* 1 and up for −1, of an ascending chain from each place."""
    reach = np.zeros(array.shape, np.int64)
    while True:
        longer = reach
        around = zip(AROUND, neighbours(array), neighbours(reach), strict=True)
        for (dy, _), other, further in around:
            longer = np.where(other > array, np.maximum(longer, sign * dy + further), longer)
        if np.array_equal(longer, reach):
            return reach
        reach = longer


def _permutation(given: ArrayLike, name: str) -> Classes:
    """*given* as read-only uint16; UsageError unless it holds each of 0 … h·w−1 once."""
    array = np.asarray(given)
    if array.ndim != 2 or not 1 <= array.size <= 65_536 or array.dtype.kind not in "iuf":
        raise UsageError(
            f"class matrix '{name}': {array.dtype} of shape {array.shape}; allowed: whole numbers, "
            "(h, w) with 1 … 65,536 places"
        )
    wrong = array[~((array >= 0) & (array < array.size) & (array == np.floor(array)))]
    if wrong.size:
        raise UsageError(
            f"class matrix '{name}' holds {wrong[0]:g}; allowed: 0 … {array.size - 1}, each once. "
            "Count from 0"
        )
    counts = np.bincount(array.astype(np.int64).ravel(), minlength=array.size)
    if (counts != 1).any():
        missing = ", ".join(str(c) for c in np.flatnonzero(counts == 0)[:5])
        doubled = ", ".join(str(c) for c in np.flatnonzero(counts > 1)[:5])
        raise UsageError(
            f"class matrix '{name}': {doubled} comes more than once and {missing} is missing; "
            f"allowed: each of 0 … {array.size - 1} once"
        )
    kept = np.array(array, np.uint16, order="C")
    kept.flags.writeable = False
    return kept


def load_classes(path: str | Path) -> ClassMatrix:
    """A class matrix from ``.npz`` (array ``classes``) or text: rows of numbers, commas or blanks.

    Lines that begin with # are left out. InputFileError if the file cannot be read; UsageError if
    it holds no permutation.
    """
    try:
        if Path(path).suffix == ".npz":
            with np.load(path) as file:
                array = file["classes"]
        else:
            text = Path(path).read_text(encoding="utf-8")
            rows = [line.replace(",", " ").split() for line in text.splitlines()]
            array = np.array([[int(c) for c in row] for row in rows if row and row[0][0] != "#"])
    except (OSError, ValueError, KeyError, OverflowError, EOFError) as error:
        raise InputFileError(
            f"the class matrix '{path}' cannot be read: {error}; allowed: rows of whole numbers, all "
            "of one length, or a .npz file with an array 'classes'"
        ) from error
    return ClassMatrix(array, str(path), "given class matrix")


@lru_cache
def _shipped(name: str) -> ClassMatrix:
    if name in _TABLES:
        table, source, claim = _TABLES[name]
        return ClassMatrix(
            np.array([row.split() for row in table.strip().splitlines()], int), name, source, claim
        )
    path, claim = _OWN[name]
    array = load_classes(Path(__file__).parent / "data" / path).classes
    return ClassMatrix(array, name, "evolved for this library", claim)


def classes(text: str) -> ClassMatrix:
    """The class matrix *text* names: one of :data:`CLASSES`, or a file.

    A text with a ``.`` or a path separator is a file. UsageError for an unknown name.
    """
    if text.lower() in CLASSES:
        return _shipped(text.lower())
    if any(c in text for c in "./\\"):
        return load_classes(text)
    raise UsageError(near(text, CLASSES, "class matrix") + ", or a file")


_KNUTH = """
    34 48 40 32 29 15 23 31
    42 58 56 53 21  5  7 10
    50 62 61 45 13  1  2 18
    38 46 54 37 25 17  9 26
    28 14 22 30 35 49 41 33
    20  4  6 11 43 59 57 52
    12  0  3 19 51 63 60 44
    24 16  8 27 39 47 55 36
"""

_MESE8 = """
    47 31 51 24 27 45  5 21
    37 63 53 11 22  4  1 33
    61  0 57 16 26 29 46  8
    20 14  9 62 18 41 38  6
    17 13 25 15 55 48 52 58
     3  7  2 32 30 34 56 60
    28 40 36 39 49 43 35 10
    54 23 50 12 42 59 44 19
"""

_MESE16 = """
    207   0  13  17  28  55  18 102  81  97  74 144 149 169 170 172
      3   6  23  36  56  50  65  87 145 130 137 158 182 184 195 221
      7  14  24  37  67  69  86   5 106 152 150 165 183 192 224   1
     15  26  43  53  51 101 115 131 139 136 166 119 208 223 226   4
     22  39  52  71  84 103 164 135 157 173 113 190 222 225 227  16
     40  85  72  83 104 117 167 133 168 180 200 219 231 228  12  21
     47 120  54 105 123 132 146 176 179 202 220 230 245   2  20  41
     76  73 127 109 138 134 178 181 206 196 229 244 246  19  42  49
     80  99 112 147 142 171 177 203 218 232 243 248 247  33  48  68
    108 107 140 143 185 163 204 217 233 242 249 255  44  45  70  79
    110 141  88  75 175 205 214 234 241 250 254  38  46  77 116 100
    111 148 160 174 201 215 235 240 251 252 253  61  62  93  94 125
    151 159 189 199 197 216 236 239  25  31  60  82  92  95 124 114
    156 188 191 209 213 237 238  29  32  59  64  91 118  78 128 155
    187 194 198 212   9  10  30  35  58  63  90  96 122 129 154 161
    193 210 211   8  11  27  34  57  66  89  98 121 126 153 162 186
"""

_TABLES = {
    "knuth": (_KNUTH, "Knuth 1987", Claim("tones", 32)),
    "mese8": (_MESE8, "Mese & Vaidyanathan 2000", Claim("tones", 16)),
    "mese16": (_MESE16, "Mese & Vaidyanathan 2000", EXACT),
}

_OWN = {"64": ("classes64.npz", EXACT)}

CLASSES = (*_TABLES, *_OWN)
"""Names of the class matrices that ship."""
