"""Scene files: scene.toml, whose keys are the fields of model.py, and bare meshes, .obj and .ply."""

from __future__ import annotations

import inspect
import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from halftone.errors import InputError, InputFileError, UsageError, near
from halftone.scene.check import checked
from halftone.scene.framing import camera_for, framed
from halftone.scene.later import refuse_later
from halftone.scene.model import Camera, Fresnel, Light, Material, Mesh, Scene
from halftone.scene.obj import Found, read_obj
from halftone.scene.paths import contents, inside
from halftone.scene.placing import inline, placed
from halftone.scene.ply import read_ply
from halftone.scene.shapes import SHAPES

__all__ = ["load", "named", "read_scene"]

READERS: dict[str, Callable[[Path], Found]] = {".obj": read_obj, ".ply": read_ply}
PLACING = ("scale", "rotate", "translate")
COLOURS = ("ambient", "diffuse", "specular", "intensity", "background")
GRAY = (0.2126, 0.7152, 0.0722)  # BT.709: a mesh file's colours in a scene of one channel
AROUND = 0.15  # I_a of a bare mesh
PAPER = 1.0  # its background: most devices that show it have white paper


def load(path: str | Path, aspect: float = 1.0) -> Scene:
    """The scene in a file: ``.toml``, ``.obj`` or ``.ply``.

    aspect : width over height of the picture that a bare mesh, or a scene without a camera, is framed
    for (:func:`halftone.scene.framing.framed`). Files that it names must lie in its folder.

    Raises InputFileError for a file that is missing, damaged, or asks for what is not there: with the
    place, and the nearest name for an unknown key.
    """
    return read_scene(path, aspect)[0]


def read_scene(path: str | Path, aspect: float = 1.0) -> tuple[Scene, list[str]]:
    """As :func:`load`, and one line for each kind of thing in mesh files that was left out."""
    path = Path(path)
    kind = path.suffix.lower()
    if kind in READERS:
        found = READERS[kind](path)
        around, paper = (AROUND,) * 3, (PAPER,) * 3
        scene = Scene((found.mesh,), found.materials, (), None, around, paper, name=path.stem)
        return framed(scene, aspect), found.notes
    if kind != ".toml":
        raise InputFileError(f"{path} is no scene; allowed: .toml, {', '.join(READERS)}")
    data = contents(path)
    try:
        table = tomllib.loads(data.decode("utf-8"))
    except (ValueError, RecursionError) as error:  # a number of too many digits is a ValueError
        raise InputFileError(f"{path} is not TOML: {error}") from error
    notes: list[str] = []
    with named(path):
        scene = _Reader(path.parent, notes).scene(table)
        checked(scene)
    if scene.camera is None:
        scene = replace(scene, camera=camera_for(scene.meshes, aspect))
    return scene, notes


@contextmanager
def named(path: str | Path) -> Iterator[None]:
    """Errors of a scene as those of its file."""
    try:
        yield
    except InputFileError:
        raise
    except InputError as error:
        raise InputFileError(f"{path}: {error}") from error


class _Reader:
    """Tables of one file to the dataclasses of the model."""

    def __init__(self, folder: Path, notes: list[str]) -> None:
        self.folder, self.notes = folder, notes
        self.channels = 3
        self.materials: list[Material] = []

    def scene(self, table: Mapping[str, Any]) -> Scene:
        allowed = {f.name for f in fields(Scene)}
        _known(table, allowed, "the scene")
        self.channels = max(_lengths(table), default=3)
        self.materials = [
            self.material(part, f"materials[{i}]") for i, part in enumerate(_tables(table, "materials"))
        ]
        if not self.materials:
            self.materials = [self.material({}, "materials[0]")]
        lights = [self.light(part, f"lights[{i}]") for i, part in enumerate(_tables(table, "lights"))]
        meshes = [self.mesh(part, f"meshes[{i}]") for i, part in enumerate(_tables(table, "meshes"))]
        camera = table.get("camera")
        plain = {k: v for k, v in table.items() if k not in ("materials", "lights", "meshes", "camera")}
        return Scene(
            **self.values(Scene, plain, "the scene"),
            materials=tuple(self.materials),
            lights=tuple(lights),
            meshes=tuple(meshes),
            camera=None if camera is None else self.camera(camera),
        )

    def camera(self, table: Any) -> Camera:
        return Camera(**self.values(Camera, table, "camera"))

    def light(self, table: Any, at: str) -> Light:
        return Light(**self.values(Light, table, at))

    def material(self, table: Any, at: str) -> Material:
        values = self.values(Material, table, at)
        if values.get("fresnel") is not None:
            values["fresnel"] = Fresnel(**self.values(Fresnel, table["fresnel"], f"{at}.fresnel"))
        return Material(**values)

    def values(self, kind: type, table: Any, at: str) -> dict[str, Any]:
        """Keyword arguments for *kind*: lists as tuples, a number for a colour as gray."""
        if not isinstance(table, dict):
            raise InputError(f"{at}={table!r}; allowed: a table of {', '.join(_names(kind))}")
        _known(table, _names(kind), at)
        found = {}
        for field in fields(kind):
            if field.name in COLOURS:
                # All defaults are gray (those of a Scene's ambient are white).
                default = field.default[0] if isinstance(field.default, tuple) else 1.0
                given: Any = table.get(field.name, default)
                number = isinstance(given, int | float) and not isinstance(given, bool)
                found[field.name] = (given,) * self.channels if number else _tuples(given)
            elif field.name in table:
                value = table[field.name]
                if field.type in ("bool", "str") and not isinstance(value, _TYPES[field.type]):
                    raise InputError(f"{at}.{field.name}={value!r}; allowed: {_TEXTS[field.type]}")
                found[field.name] = _tuples(value)
        return found

    def mesh(self, table: Any, at: str) -> Mesh:
        """A mesh from a file, a shape, or vertices and faces that stand in the scene file itself."""
        if not isinstance(table, dict):
            raise InputError(f"{at}={table!r}; allowed: a table with file, shape, or vertices and faces")
        ways = [key for key in ("file", "shape", "vertices") if key in table]
        common = {"material", "smooth", "name", *PLACING}
        if len(ways) != 1:
            allowed = common | {"file", "shape", "vertices", "faces", "detail"}
            _known(table, allowed | set() if not ways else set(table), at)
            got = " and ".join(ways) or "none of them"
            raise InputError(f"{at} has {got}; allowed: one of file, shape, vertices (with faces)")
        own: set[str] = set()
        if ways[0] == "file":
            _known(table, common | {"file"}, at)
            mesh = self._from_file(_text(table["file"], f"{at}.file"), at)
        elif ways[0] == "shape":
            mesh, own = _from_shape(table, common, at)
        else:
            _known(table, common | {"vertices", "faces", "detail"}, at)
            mesh = self._inline(table, at)
        given = table.get("material")
        if given is not None and not isinstance(given, list):
            number = self._number(given, f"{at}.material")
            mesh = replace(mesh, material=np.full(len(mesh.faces), number, np.int64))
        elif given is not None and ways[0] != "vertices":
            raise InputError(f"{at}.material={given!r}; allowed: one material, as text or number")
        if "smooth" in table:
            if not isinstance(table["smooth"], bool):
                raise InputError(f"{at}.smooth={table['smooth']!r}; allowed: true or false")
            flat = np.full(len(mesh.faces), table["smooth"])
            mesh = replace(mesh, smooth=flat, normals=None, normal_index=None)
        name = _text(table.get("name", mesh.name), f"{at}.name")
        steps = {key: table[key] for key in PLACING if key in table and key not in own}
        return placed(replace(mesh, name=name), steps, at)

    def _inline(self, table: Mapping[str, Any], at: str) -> Mesh:
        """A mesh that stands in the scene file; its material may be a list, one for each face."""
        mesh = inline(table, at)
        given = table.get("material", 0)
        if not isinstance(given, list):
            return replace(mesh, material=np.zeros(len(mesh.faces), np.int64))
        if len(given) != len(table["faces"]):
            raise InputError(
                f"{at}.material has {len(given)} items; allowed: one material, or a list of "
                f"{len(table['faces'])}, one for each face"
            )
        numbers = np.array([self._number(one, f"{at}.material") for one in given], np.int64)
        return replace(mesh, material=numbers[mesh.material])

    def _from_file(self, name: str, at: str) -> Mesh:
        path = inside(self.folder, name, f"{at}.file")
        reader = READERS.get(path.suffix.lower())
        if reader is None:
            raise InputError(f"{at}.file='{name}'; allowed: files that end in {', '.join(READERS)}")
        found = read_obj(path, self.folder) if reader is read_obj else reader(path)
        self.notes += found.notes
        first = len(self.materials)
        self.materials += [self._in_channels(material, name) for material in found.materials]
        return replace(found.mesh, material=found.mesh.material + first)

    def _in_channels(self, material: Material, name: str) -> Material:
        """A mesh file's material of R, G, B, or its luminance in a scene of one channel."""
        if self.channels == 3:
            return material
        changed = {}
        for key in ("ambient", "diffuse", "specular"):
            colour = getattr(material, key)
            if self.channels != 1 and len(set(colour)) > 1:
                raise InputError(
                    f"'{name}' has materials of R, G, B, and the scene {self.channels} channels; "
                    "allowed: 3 or 1. Give the mesh a material of the scene"
                )
            gray = sum(w * c for w, c in zip(GRAY, colour, strict=True))
            changed[key] = (colour[0] if len(set(colour)) == 1 else gray,) * self.channels
        return replace(material, **changed)  # type: ignore[arg-type]

    def _number(self, given: Any, place: str) -> int:
        names = [material.name for material in self.materials]
        if isinstance(given, int) and not isinstance(given, bool) and 0 <= given < len(names):
            return given
        if isinstance(given, str) and given in names:
            return names.index(given)
        raise InputError(f"{place}: {near(str(given), names, 'material')}")


_TYPES = {"bool": bool, "str": str}
_TEXTS = {"bool": "true or false", "str": "a text"}


def _from_shape(table: Mapping[str, Any], common: set[str], at: str) -> tuple[Mesh, set[str]]:
    shape = _text(table["shape"], f"{at}.shape")
    if shape not in SHAPES:
        raise InputError(f"{at}.shape: {near(shape, SHAPES, 'shape')}")
    own = set(inspect.signature(SHAPES[shape]).parameters)
    _known(table, common | own | {"shape"}, at)
    given = {key: table[key] for key in own if key in table}
    for key, value in given.items():
        if isinstance(value, bool) != (key == "exact") or not isinstance(value, int | float):
            allowed = "true or false" if key == "exact" else "a number"
            raise InputError(f"{at}.{key}={value!r}; allowed: {allowed}")
    try:
        return SHAPES[shape](**given), own
    except UsageError as error:
        raise InputError(f"{at}.{error}") from error


def _known(table: Mapping[str, Any], allowed: Any, at: str) -> None:
    refuse_later(table, allowed, at)
    for key in table:
        if key not in allowed:
            raise InputError(f"{at}: {near(key, allowed, 'key')}")


def _names(kind: type) -> list[str]:
    return [field.name for field in fields(kind)]


def _tables(table: Mapping[str, Any], key: str) -> list[Any]:
    value = table.get(key, [])
    if not isinstance(value, list):
        raise InputError(f"{key} is one table; allowed: an array of tables, [[{key}]]")
    return value


def _tuples(value: Any) -> Any:
    return tuple(_tuples(part) for part in value) if isinstance(value, list) else value


def _text(value: Any, place: str) -> str:
    if not isinstance(value, str):
        raise InputError(f"{place}={value!r}; allowed: a text")
    return value


def _lengths(table: Mapping[str, Any]) -> Iterator[int]:
    """How many channels the colours of the file have."""
    for part in (table, *_tables(table, "materials"), *_tables(table, "lights")):
        if isinstance(part, dict):
            yield from (len(part[key]) for key in COLOURS if isinstance(part.get(key), list))
