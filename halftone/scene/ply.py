"""PLY: ascii and binary of both byte orders, vertices with normals, faces of any number of corners."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone.errors import InputFileError
from halftone.scene.model import Material, Mesh
from halftone.scene.obj import Found
from halftone.scene.paths import contents
from halftone.scene.polygons import triangles

__all__ = ["read_ply"]

TYPES = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2"},
    **{"int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8"},
}
FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
LISTS = ("vertex_indices", "vertex_index")
HEADER = 1 << 20  # bytes within which the header must end


@dataclass
class _Property:
    """A value of type *kind*, or a list of them whose length has the type *count*."""

    name: str
    kind: str
    count: str | None = None


@dataclass
class _Element:
    name: str
    size: int
    properties: list[_Property] = field(default_factory=list)


def read_ply(path: Path) -> Found:
    """The mesh of a PLY file, in plain gray. Raises InputFileError for a truncated or damaged one."""
    data = contents(path)
    order, elements, start = _header(path, data)
    if order:
        body = _Body(path, data, start, order)
    else:  # all numbers of an ascii file are read at once, which leaves a binary file of doubles
        body = _Body(path, _numbers(path, data, start), 0, "=")
        for prop in (prop for element in elements for prop in element.properties):
            prop.kind, prop.count = "f8", "f8" if prop.count else None
    notes: list[str] = []
    vertices, normals = np.zeros((0, 3)), None
    sides, corners = np.zeros(0, np.int64), np.zeros(0, np.int64)
    for element in elements:
        columns, lists = body.read(element)
        if element.name == "vertex":
            vertices, normals = _vertices(path, element, columns)
            known = {"x", "y", "z", "nx", "ny", "nz"}
        elif element.name == "face":
            name = next((name for name in LISTS if name in lists), None)
            if name is None and element.size:
                raise _damaged(path, f"its faces have no list {' or '.join(LISTS)}")
            if name is not None:
                sides, corners = lists[name]
            known = set(LISTS)
        else:
            notes.append(f"{path.name}: {element.size} × element '{element.name}' left out")
            continue
        spare = [p.name for p in element.properties if p.name not in known]
        if spare:
            notes.append(f"{path.name}: {element.name} properties left out: {', '.join(spare)}")
    few = sides < 3
    if few.any():
        notes.append(f"{path.name}: {int(few.sum())} faces of fewer than 3 corners dropped")
        corners, sides = corners[np.repeat(~few, sides)], sides[~few]
    cut, _ = triangles(sides, vertices, corners)
    faces = np.ascontiguousarray(corners[cut])
    material = Material(ambient=(0.8,) * 3, diffuse=(0.8,) * 3)
    index = None if normals is None else faces
    mesh = Mesh(vertices, faces, np.zeros(len(faces), np.int64), normals, index, name=path.stem)
    return Found(mesh, (material,), notes)


def _vertices(
    path: Path, element: _Element, columns: dict[str, NDArray[Any]]
) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    missing = [name for name in "xyz" if name not in columns]
    if missing:
        raise _damaged(path, f"its vertices have no {', '.join(missing)}")

    def together(*names: str) -> NDArray[np.float64]:
        return np.stack([columns[name].astype(np.float64) for name in names], axis=1)

    has_normals = all(name in columns for name in ("nx", "ny", "nz"))
    return together("x", "y", "z"), together("nx", "ny", "nz") if has_normals else None


def _header(path: Path, data: bytes) -> tuple[str, list[_Element], int]:
    """(byte order, or "" for ascii; elements; where the body starts)."""
    if data[:3] != b"ply":
        raise _damaged(path, "it does not start with 'ply'")
    order: str | None = None
    elements: list[_Element] = []
    at, number = 0, 0
    while True:
        end = data.find(b"\n", at, HEADER)
        if end < 0:
            raise _damaged(path, "its header has no end_header: it is truncated")
        words = data[at:end].decode("utf-8", "replace").split()
        at, number = end + 1, number + 1
        key = words[0] if words else "comment"
        try:
            if key == "end_header":
                break
            if key == "format":
                order = FORMATS[words[1]]
            elif key == "element":
                elements.append(_Element(words[1], int(words[2])))
                if elements[-1].size < 0:
                    raise ValueError
            elif key == "property" and words[1] == "list":
                count, kind = TYPES[words[2]], TYPES[words[3]]
                if count[0] == "f":
                    raise ValueError
                elements[-1].properties.append(_Property(words[4], kind, count))
            elif key == "property":
                elements[-1].properties.append(_Property(words[2], TYPES[words[1]]))
            elif key not in ("ply", "comment", "obj_info"):
                raise ValueError
        except (KeyError, IndexError, ValueError):
            raise InputFileError(
                f"{path}:{number}: '{' '.join(words)[:60]}' is damaged; allowed: format "
                f"{'|'.join(FORMATS)}, element NAME COUNT, property [list COUNT-TYPE] TYPE NAME"
            ) from None
    if order is None:
        raise _damaged(path, "its header has no format line")
    return order, elements, at


Columns = dict[str, NDArray[Any]]
Lists = dict[str, tuple[NDArray[np.int64], NDArray[np.int64]]]


class _Body:
    """The body of a file, read element by element."""

    def __init__(self, path: Path, data: bytes, start: int, order: str) -> None:
        self.path, self.data, self.at, self.order = path, data, start, order

    def read(self, element: _Element) -> tuple[Columns, Lists]:
        """Scalars of *element* as columns, and lists as (lengths, values)."""
        parts: list[tuple[tuple[int, ...], NDArray[Any]]] = []
        done = 0 if element.properties else element.size
        while done < element.size:
            lengths = self._lengths(element)
            rows = self._alike(element, lengths, element.size - done)
            parts.append((lengths, rows))
            done += len(rows)
            self.at += rows.nbytes
        return _gathered(element, parts)

    def _lengths(self, element: _Element) -> tuple[int, ...]:
        """The lengths of the lists in the next row."""
        at, found = self.at, []
        for prop in element.properties:
            if prop.count is not None:
                count = self._one(prop.count, at, element)
                if not (0 <= count < 1 << 32 and count == int(count)):
                    raise _damaged(self.path, f"a list of {count} items in an element '{element.name}'")
                found.append(int(count))
                at += np.dtype(prop.count).itemsize + found[-1] * np.dtype(prop.kind).itemsize
            else:
                at += np.dtype(prop.kind).itemsize
        if at > len(self.data):
            raise self._truncated(element)
        return tuple(found)

    def _one(self, kind: str, at: int, element: _Element) -> Any:
        if at + np.dtype(kind).itemsize > len(self.data):
            raise self._truncated(element)
        return np.frombuffer(self.data, self.order + kind, 1, at)[0]

    def _alike(self, element: _Element, lengths: tuple[int, ...], most: int) -> NDArray[Any]:
        """The following rows whose lists are as long as those of the next."""
        fields: list[Any] = []
        left = iter(lengths)
        for k, prop in enumerate(element.properties):
            if prop.count is None:
                fields.append((f"p{k}", self.order + prop.kind))
            else:
                fields.append((f"n{k}", self.order + prop.count))
                fields.append((f"p{k}", self.order + prop.kind, (next(left),)))
        row = np.dtype(fields)
        fit = min(most, (len(self.data) - self.at) // row.itemsize)
        if not lengths:
            if fit < most:
                raise self._truncated(element)
            return np.frombuffer(self.data, row, fit, self.at)
        # Few at first: where lengths vary, looking at all that follows each time would be quadratic.
        size, rows = 16, np.empty(0, row)
        names = [f"n{k}" for k, prop in enumerate(element.properties) if prop.count is not None]
        while True:
            rows = np.frombuffer(self.data, row, min(size, fit), self.at)
            same = np.ones(len(rows), bool)
            for name, length in zip(names, lengths, strict=True):
                same &= rows[name] == length
            if not same.all():
                return rows[: int(same.argmin())]
            if len(rows) == fit:
                return rows
            size *= 4

    def _truncated(self, element: _Element) -> InputFileError:
        return _damaged(self.path, f"it ends within its {element.size} × '{element.name}': truncated")


def _gathered(
    element: _Element, parts: list[tuple[tuple[int, ...], NDArray[Any]]]
) -> tuple[Columns, Lists]:
    """Rows of all parts as columns and lists."""
    columns: Columns = {}
    lists: Lists = {}
    number = -1
    for k, prop in enumerate(element.properties):
        values = [rows[f"p{k}"] for _, rows in parts]
        if prop.count is None:
            columns[prop.name] = np.concatenate(values) if values else np.zeros(0)
            continue
        number += 1
        lengths = [
            np.full(len(v), part[0][number], np.int64) for part, v in zip(parts, values, strict=True)
        ]
        flat = [_indices(v) for v in values]
        empty = np.zeros(0, np.int64)
        lists[prop.name] = (np.concatenate([empty, *lengths]), np.concatenate([empty, *flat]))
    return columns, lists


def _indices(values: NDArray[Any]) -> NDArray[np.int64]:
    """Indices as int64; what is no whole number becomes −1, which is out of range."""
    flat = values.ravel()
    if flat.dtype.kind != "f":
        return flat.astype(np.int64)
    sound = (np.abs(flat) < 2**53) & (flat == np.floor(flat))
    return np.where(sound, flat, -1).astype(np.int64)


def _numbers(path: Path, data: bytes, start: int) -> bytes:
    """The doubles of an ascii body."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return np.fromstring(data[start:], np.float64, sep=" ").tobytes()
        except (ValueError, DeprecationWarning):
            raise _first_bad_line(path, data, start) from None


def _first_bad_line(path: Path, data: bytes, start: int) -> InputFileError:
    first = data.count(b"\n", 0, start) + 1
    for number, line in enumerate(data[start:].decode("utf-8", "replace").splitlines(), first):
        try:
            [float(word) for word in line.split()]
        except ValueError:
            return InputFileError(f"{path}:{number}: '{line[:60]}' is damaged; allowed: numbers only")
    return _damaged(path, "its body is not numbers only")


def _damaged(path: Path, why: str) -> InputFileError:
    return InputFileError(f"{path} is damaged: {why}. Write or copy the file again")
