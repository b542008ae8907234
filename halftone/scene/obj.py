"""Wavefront OBJ: vertices, normals, faces of any number of corners, materials and smoothing groups.

Lines of one kind are parsed by NumPy at once; lines that are unlike their neighbours one by one,
which also finds the number of a damaged line.
"""

from __future__ import annotations

import warnings
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from halftone.errors import InputFileError
from halftone.scene.model import Material, Mesh
from halftone.scene.mtl import read_mtl
from halftone.scene.paths import contents, inside
from halftone.scene.polygons import triangles

__all__ = ["Found", "read_obj"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]

BLANK = np.zeros(256, bool)
BLANK[[9, 11, 12, 13, 32]] = True
MOST = 1 << 62  # indices beyond it are out of range anyway, and must fit int64
SILENT = ("g", "o", "vt", "#", "")  # names, texture coordinates and comments change no picture yet


@dataclass
class Found:
    """What a mesh file holds. notes : what was left out, one line each."""

    mesh: Mesh
    materials: tuple[Material, ...]
    notes: list[str] = field(default_factory=list)


def read_obj(path: Path, folder: Path | None = None) -> Found:
    """The mesh and the materials of an OBJ file.

    folder : where its material files must lie; the file's own by default. Without any ``s`` line
    all faces are smooth; with one, faces before the first are flat, and groups share no normals.
    Raises InputFileError, with the line's number, for a damaged line.
    """
    lines = _Lines(path, contents(path))
    vertices = lines.numbers("v", 3)
    normals = lines.numbers("vn", 3)
    sides, corners, normal_index = lines.faces(len(vertices), len(normals))
    cut, owner = triangles(sides, vertices, corners)
    notes: list[str] = []
    materials, material = _materials(lines, path, folder or path.parent, notes)
    groups = lines.groups()
    faces = corners[cut]
    smooth = None
    if groups is not None and not len(normals):
        vertices, faces = _parted(vertices, faces, groups[owner])
        smooth = groups[owner] > 0
    for word, count in sorted(lines.unknown.items()):
        notes.append(f"{path.name}: {count} × '{word}' left out, which is not read")
    mesh = Mesh(
        vertices,
        np.ascontiguousarray(faces),
        material[owner],
        normals if len(normals) else None,
        np.ascontiguousarray(normal_index[cut]) if len(normals) else None,
        smooth=smooth,
        name=path.stem,
    )
    return Found(mesh, materials, notes)


class _Lines:
    """The lines of a file by their first word: where each starts and ends, and its line number."""

    def __init__(self, path: Path, data: bytes) -> None:
        self.path = path
        self.breaks = np.flatnonzero(np.frombuffer(data, np.uint8) == 10)
        for end in (b"\\\r\n", b"\\\n"):  # a line goes on in the next: blanks of the same length
            data = data.replace(end, b" " * len(end))
        if b"\n" not in data:
            data = data.replace(b"\r", b"\n")
            self.breaks = np.flatnonzero(np.frombuffer(data, np.uint8) == 10)
        if not data.endswith(b"\n"):
            data += b"\n"
        self.data = data + b"   "
        self.buffer: Bytes = np.frombuffer(self.data, np.uint8)
        self.ends = np.flatnonzero(self.buffer[: len(data)] == 10)
        self.starts = _after_blanks(self.buffer, np.append(0, self.ends[:-1] + 1))
        self.unknown: Counter[str] = Counter()
        self.words: list[tuple[int, str, str]] = []
        self.of = self._sorted_out()

    def _sorted_out(self) -> dict[str, Ints]:
        """Line indices of vertices, normals and faces; all other lines go to words."""
        first, second, third = (self.buffer[self.starts + k] for k in range(3))
        kinds = {
            "v": (first == ord("v")) & BLANK[second],
            "vn": (first == ord("v")) & (second == ord("n")) & BLANK[third],
            "f": (first == ord("f")) & BLANK[second],
        }
        rest = ~(kinds["v"] | kinds["vn"] | kinds["f"])
        rest &= ~((first == ord("v")) & (second == ord("t")) & BLANK[third])
        rest &= (first != ord("#")) & (self.starts < self.ends)
        for line in np.flatnonzero(rest).tolist():
            word, _, text = self.text(line).partition(" ")
            text = text.partition("#")[0].strip()
            if word in ("usemtl", "mtllib", "s"):
                self.words.append((line, word, text))
            elif word not in SILENT and not word.startswith("#"):
                self.unknown[word] += 1
        return {kind: np.flatnonzero(lines) for kind, lines in kinds.items()}

    def text(self, line: int) -> str:
        """A line, each run of blanks in it as one."""
        raw = self.data[self.starts[line] : self.ends[line]]
        return " ".join(raw.decode("utf-8", "replace").split())

    def joined(self, kind: str) -> bytes:
        """All lines of a kind, one after another."""
        lines = self.of[kind]
        cuts = np.flatnonzero(np.diff(lines) != 1) + 1
        low = self.starts[lines[np.append(0, cuts)]].tolist()
        high = (self.ends[lines[np.append(cuts, len(lines)) - 1]] + 1).tolist()
        return b"".join(self.data[a:b] for a, b in zip(low, high, strict=True))

    def numbers(self, kind: str, least: int) -> Floats:
        """The first *least* numbers of each line of a kind: (lines, least)."""
        lines = self.of[kind]
        if not len(lines):
            return np.zeros((0, least))
        joined = self.joined(kind)
        if b"#" not in joined:
            counts = _counts(joined)
            values = _parsed(joined.replace(kind.encode(), b" " * len(kind)), np.float64)
            even = (counts == counts[0]).all() and counts[0] > least
            if even and values is not None and len(values) == len(lines) * (counts[0] - 1):
                return np.ascontiguousarray(values.reshape(len(lines), -1)[:, :least])
        return np.array([self._few(line, least) for line in lines.tolist()], np.float64)

    def _few(self, line: int, least: int) -> list[float]:
        parts = self.text(line).partition("#")[0].split()[1:]
        try:
            values = [float(part) for part in parts]
        except ValueError:
            raise self.damaged(line, "numbers only") from None
        if len(values) < least:
            raise self.damaged(line, f"at least {least} numbers")
        return values[:least]

    def faces(self, vertices: int, normals: int) -> tuple[Ints, Ints, Ints]:
        """(corners of each face, vertex of each corner, normal of each corner or −1)."""
        lines = self.of["f"]
        if not len(lines):
            return np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0, np.int64)
        found = self._even_faces()
        if found is None:
            listed = [self._corners(line) for line in lines.tolist()]
            sides = np.array([len(face) for face in listed], np.int64)
            table = np.array([corner for face in listed for corner in face], np.int64)
        else:
            sides, table = found
        if sides.min() < 3:
            raise self.damaged(int(lines[sides.argmin()]), "a face of at least 3 corners")
        # Negative numbers count back from the last vertex, or normal, before the line.
        before = [np.searchsorted(self.of[kind], lines) for kind in ("v", "vn")]
        index = _resolved(table[:, 0], np.repeat(before[0], sides), vertices)
        normal = _resolved(table[:, 1], np.repeat(before[1], sides), normals)
        return sides, index, np.where(table[:, 1] == 0, -1, normal)

    def _even_faces(self) -> tuple[Ints, Ints] | None:
        """Faces whose corners all have one form: v, v/t, v/t/n or v//n; None where they differ."""
        joined = self.joined("f")
        if b"#" in joined:
            return None
        sides = _counts(joined) - 1
        corners = int(sides.sum())
        text = joined.replace(b"f", b" ")
        empty = text.count(b"//")
        slashes = text.count(b"/")
        if slashes not in (0, corners, 2 * corners) or empty not in (0, corners):
            return None
        if slashes and not _even_slashes(text, slashes // corners):
            return None
        columns = slashes // corners + 1 - (1 if empty else 0)
        values = _parsed(text.replace(b"/", b" "), np.int64)
        if values is None or len(values) != corners * columns:
            return None
        table = np.zeros((corners, 2), np.int64)
        values = values.reshape(corners, columns)
        table[:, 0] = values[:, 0]
        if slashes == 2 * corners:
            table[:, 1] = values[:, -1]
        return sides, table

    def _corners(self, line: int) -> list[tuple[int, int]]:
        found = []
        for corner in self.text(line).partition("#")[0].split()[1:]:
            parts = corner.split("/")
            try:
                numbers = [max(-MOST, min(int(part), MOST)) if part else 0 for part in parts]
            except ValueError:
                raise self.damaged(line, "corners as v, v/t, v/t/n or v//n, whole numbers") from None
            if len(numbers) > 3 or not parts[0]:
                raise self.damaged(line, "corners as v, v/t, v/t/n or v//n")
            found.append((numbers[0], numbers[2] if len(numbers) == 3 else 0))
        return found

    def groups(self) -> Ints | None:
        """The smoothing group of each face, 0 for flat; None where the file has no ``s``."""
        marks = [(line, text) for line, word, text in self.words if word == "s"]
        if not marks:
            return None
        names: dict[str, int] = {"off": 0, "0": 0, "": 0}
        codes = [names.setdefault(text.lower(), len(names)) for _, text in marks]
        return self.in_force([line for line, _ in marks], codes, 0)

    def in_force(self, lines: list[int], codes: list[int], before: int) -> Ints:
        """For each face the code of the last of *lines* before it."""
        at = np.searchsorted(np.array(lines, np.int64), self.of["f"])
        return np.array([before, *codes], np.int64)[at]

    def damaged(self, line: int, allowed: str) -> InputFileError:
        number = int(np.searchsorted(self.breaks, self.starts[line])) + 1
        text = self.text(line)
        text = text if len(text) <= 60 else f"{text[:57]}…"
        return InputFileError(f"{self.path}:{number}: '{text}' is damaged; allowed: {allowed}")


def _after_blanks(buffer: Bytes, starts: Ints) -> Ints:
    """*starts*, moved past blanks."""
    blank = np.flatnonzero(BLANK[buffer[starts]])
    if len(blank):
        solid = np.flatnonzero(~BLANK[buffer])
        starts = starts.copy()
        at = np.searchsorted(solid, starts[blank])
        starts[blank] = np.append(solid, len(buffer) - 3)[at]
    return starts


def _counts(joined: bytes) -> Ints:
    """The number of words of each line."""
    buffer = np.frombuffer(joined, np.uint8)
    gap = BLANK[buffer] | (buffer == 10)
    word = ~gap
    word[1:] &= gap[:-1]
    ends = np.flatnonzero(buffer == 10)
    return np.diff(np.searchsorted(np.flatnonzero(word), ends), prepend=0).astype(np.int64)


def _even_slashes(text: bytes, each: int) -> bool:
    """Whether every word of *text* has *each* slashes."""
    buffer = np.frombuffer(text, np.uint8)
    gap = BLANK[buffer] | (buffer == 10)
    word = ~gap
    word[1:] &= gap[:-1]
    slash = np.flatnonzero(buffer == ord("/"))
    owner = np.searchsorted(np.flatnonzero(word), slash, side="right")
    return bool((owner.reshape(-1, each) == np.arange(1, len(slash) // each + 1)[:, None]).all())


def _parsed(text: bytes, kind: type) -> NDArray[np.generic] | None:
    """Numbers between blanks; None where there is anything else."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return np.fromstring(text, kind, sep=" ")
        except (ValueError, DeprecationWarning, OverflowError):
            return None


def _resolved(given: Ints, before: Ints, size: int) -> Ints:
    """Indices from 0 of numbers from 1, or from −1 back; what is out of range becomes *size*."""
    index = np.where(given > 0, given - 1, before + given)
    return np.where((given == 0) | (index < 0), size, index)


def _materials(
    lines: _Lines, path: Path, folder: Path, notes: list[str]
) -> tuple[tuple[Material, ...], Ints]:
    """The materials in use and that of each face; faces without one have a plain gray."""
    known: dict[str, Material] = {}
    marks: list[tuple[int, str]] = []
    for line, word, text in lines.words:
        if word == "usemtl":
            marks.append((line, text))
        elif word == "mtllib":
            _read_library(text, path, folder, known, notes)
    plain = Material(ambient=(0.8,) * 3, diffuse=(0.8,) * 3)
    used: dict[str, int] = {}
    materials: list[Material] = []
    codes = []
    for _, name in marks:
        if name not in used:
            used[name] = len(materials)
            if name not in known:
                notes.append(f"{path.name}: the material '{name}' is in no file that was read: gray")
            materials.append(known.get(name, plain))
        codes.append(used[name])
    plain_at = len(materials)
    material = lines.in_force([line for line, _ in marks], codes, plain_at)
    if not materials or (material == plain_at).any():
        materials.append(plain)
    return tuple(materials), material


def _read_library(
    text: str, path: Path, folder: Path, known: dict[str, Material], notes: list[str]
) -> None:
    """Materials of the files of one mtllib line; a name may have blanks in it."""
    whole = inside(path.parent, text, f"{path.name}: mtllib")
    names = [text] if whole.is_file() else text.split()
    for name in names:
        library = inside(path.parent, name, f"{path.name}: mtllib")
        inside(folder, str(library.relative_to(folder)), f"{path.name}: mtllib")
        if library.is_file():
            known.update(read_mtl(library, notes))
        else:
            notes.append(f"{path.name}: the material file '{name}' is not there")


def _parted(vertices: Floats, faces: Ints, groups: Ints) -> tuple[Floats, Ints]:
    """Vertices once for each smoothing group that uses them, so that groups share no normals."""
    smooth = groups[groups > 0]
    if not len(smooth) or smooth.min() == smooth.max():
        return vertices, faces
    key = faces * (int(groups.max()) + 1) + groups[:, None]
    own, index = np.unique(key, return_inverse=True)
    at = own // (int(groups.max()) + 1)
    extra = np.concatenate([vertices, np.full((1, 3), np.nan)])  # indices out of range stay so
    return extra[np.clip(at, 0, len(vertices))], index.reshape(-1, 3)
