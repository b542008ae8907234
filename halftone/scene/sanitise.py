"""A scene made fit for float32: what cannot be shown is dropped and counted, lengths are normalised.

The middle of the bounding box of all faces goes to the origin, and half its longest side becomes 1,
in float64. Camera, lights, attenuation and flaps follow, so the picture stays the same at any scale
and at any place; a scale that is a power of two gives the same bits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone.errors import InputError
from halftone.scene.check import checked
from halftone.scene.model import Camera, Flap, Light, Material, Mesh, Scene, Vector

__all__ = ["Counts", "sanitised"]

Floats = NDArray[np.float64]

FAR = 1e18  # sizes of the scene: squares of it still fit float32
CHUNK = 1 << 13  # faces handled at a time, which the processor's cache holds
STEEPEST = 1e37  # attenuation beyond it is darkness, and float32 must hold it


@dataclass(frozen=True)
class Counts:
    """What was kept, dropped and mended, and the normalisation: shown = (given − centre)/scale."""

    vertices: int = 0
    faces: int = 0
    nonfinite_vertices: int = 0
    nonfinite_faces: int = 0
    out_of_range_faces: int = 0
    degenerate_faces: int = 0
    mended_normals: int = 0
    mended_materials: int = 0
    mended_details: int = 0
    centre: Vector = (0.0, 0.0, 0.0)
    scale: float = 1.0

    @property
    def visible(self) -> bool:
        """Whether anything is left to see."""
        return self.faces > 0

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)

    def notes(self) -> list[str]:
        """One line for each kind of repair."""
        texts = {
            "nonfinite_vertices": "vertices with NaN or infinity dropped",
            "nonfinite_faces": "faces at such vertices dropped",
            "out_of_range_faces": "faces with indices beyond the vertices dropped",
            "degenerate_faces": "faces without area dropped",
            "mended_normals": "normals that were zero or not finite replaced by the face's",
            "mended_materials": "faces of an unknown material given the first",
            "mended_details": "details that lay on no face made plain faces",
        }
        lines = [f"{getattr(self, key)} {text}" for key, text in texts.items() if getattr(self, key)]
        return lines if self.visible else [*lines, "nothing is visible: no face is left"]


def sanitised(scene: Scene) -> tuple[Scene, Counts]:
    """*scene* mended and normalised, and what was done to it. The input is not changed.

    A scene without any face is no error: :attr:`Counts.visible` says so. A scene without a camera
    gets the one of :func:`halftone.scene.framing.framed`. Raises InputError for numbers of camera,
    lights and materials that have no meaning.
    """
    checked(scene)
    count: dict[str, int] = {}
    materials = tuple(scene.materials) or (Material(),)
    meshes = [_mended(mesh, len(materials), count) for mesh in scene.meshes]
    centre, scale = _frame(meshes)
    kept = []
    for mesh in meshes:
        with np.errstate(over="ignore"):
            points = (mesh.vertices - centre) / scale
        np.clip(points, -1.0, 1.0, out=points)  # all that faces use is inside
        kept.append(_mended_normals(_with_area(replace(mesh, vertices=points), count), count))
    place = _Place(centre, scale)
    camera = scene.camera
    if camera is None:
        from halftone.scene.framing import camera_for

        camera = camera_for(kept)
    else:
        camera = place.camera(camera)
    lights = tuple(place.light(light, i) for i, light in enumerate(scene.lights))
    counts = Counts(
        vertices=sum(len(mesh.vertices) for mesh in kept),
        faces=sum(len(mesh.faces) for mesh in kept),
        centre=(float(centre[0]), float(centre[1]), float(centre[2])),
        scale=scale,
        **count,
    )
    return replace(scene, meshes=tuple(kept), materials=materials, lights=lights, camera=camera), counts


@dataclass(frozen=True)
class _Place:
    """The normalisation of places and lengths."""

    centre: Floats
    scale: float

    def point(self, given: Vector, what: str) -> Vector:
        x, y, z = ((float(g) - float(c)) / self.scale for g, c in zip(given, self.centre, strict=True))
        if not max(abs(x), abs(y), abs(z)) < FAR:
            raise InputError(
                f"{what}={tuple(given)} lies more than {FAR:g} sizes of the scene away; allowed: "
                "nearer. Use kind 'distant' for a light at infinity, projection 'parallel' for an eye"
            )
        return x, y, z

    def camera(self, camera: Camera) -> Camera:
        return replace(
            camera,
            eye=self.point(camera.eye, "camera.eye"),
            target=self.point(camera.target, "camera.target"),
            height=camera.height / self.scale,
            near=None if camera.near is None else camera.near / self.scale,
        )

    def light(self, light: Light, number: int) -> Light:
        a0, a1, a2 = (float(a) for a in light.attenuation)
        steep = (a0, a1 * self.scale, a2 * self.scale * self.scale)
        flaps = [self._flap(flap, c) for flap, c in zip(light.flaps, self.centre, strict=True)]
        if light.kind != "distant":
            light = replace(light, position=self.point(light.position, f"lights[{number}].position"))
        return replace(
            light,
            attenuation=(min(steep[0], STEEPEST), min(steep[1], STEEPEST), min(steep[2], STEEPEST)),
            flaps=(flaps[0], flaps[1], flaps[2]),
        )

    def _flap(self, flap: Flap, centre: float) -> Flap:
        low, high = flap
        return (float(low) - float(centre)) / self.scale, (float(high) - float(centre)) / self.scale


def _frame(meshes: Sequence[Mesh]) -> tuple[Floats, float]:
    """Middle and half the longest side of the box around all vertices that faces use."""
    lows, highs = [], []
    for mesh in meshes:
        if len(mesh.faces):
            used = np.zeros(len(mesh.vertices), bool)
            used[mesh.faces.ravel()] = True
            points = mesh.vertices if used.all() else mesh.vertices[used]
            # By columns: NumPy reduces a narrow array over its rows several times slower.
            lows.append([points[:, axis].min() for axis in range(3)])
            highs.append([points[:, axis].max() for axis in range(3)])
    if not lows:
        return np.zeros(3), 1.0
    low, high = np.min(lows, axis=0), np.max(highs, axis=0)
    half = float((high / 2 - low / 2).max())  # halves first: the sides may overflow
    return low / 2 + high / 2, half if half > 0 else 1.0


def _mended(mesh: Mesh, materials: int, count: dict[str, int]) -> Mesh:
    """*mesh* typed, without faces at vertices that are not there or not finite."""
    mesh = _typed(mesh)
    bad = (mesh.material < 0) | (mesh.material >= materials)
    if bad.any():
        mesh = replace(mesh, material=np.where(bad, 0, mesh.material))
        _add(count, "mended_materials", int(bad.sum()))
    size = len(mesh.vertices)
    if len(mesh.faces) and not (mesh.faces.min() >= 0 and mesh.faces.max() < size):
        inside = np.asarray(((mesh.faces >= 0) & (mesh.faces < size)).all(axis=1))
        _add(count, "out_of_range_faces", int((~inside).sum()))
        mesh = _only(mesh, inside, count)
    if not np.isfinite(mesh.vertices).all():
        finite = np.asarray(np.isfinite(mesh.vertices).all(axis=1))
        _add(count, "nonfinite_vertices", int((~finite).sum()))
        inside = np.asarray(finite[mesh.faces].all(axis=1))
        _add(count, "nonfinite_faces", int((~inside).sum()))
        mesh = _only(mesh, inside, count)
        new = np.cumsum(finite) - 1
        mesh = replace(mesh, vertices=mesh.vertices[finite], faces=new[mesh.faces])
    return _mended_details(mesh, count)


def _with_area(mesh: Mesh, count: dict[str, int]) -> Mesh:
    """*mesh* without triangles that have no area, and without vertices that nothing can hold."""
    columns = [np.ascontiguousarray(mesh.vertices[:, axis]) for axis in range(3)]
    solid = np.empty(len(mesh.faces), bool)
    for start in range(0, len(solid), CHUNK):
        part = slice(start, start + CHUNK)
        a, b, c = mesh.faces[part].T
        from_a = [column[a] for column in columns]
        ux, uy, uz = (column[b] - at for column, at in zip(columns, from_a, strict=True))
        vx, vy, vz = (column[c] - at for column, at in zip(columns, from_a, strict=True))
        solid[part] = (uy * vz != uz * vy) | (uz * vx != ux * vz) | (ux * vy != uy * vx)
    if not solid.all():
        _add(count, "degenerate_faces", int((~solid).sum()))
        mesh = _only(mesh, solid, count)
    return mesh


def _mended_normals(mesh: Mesh, count: dict[str, int]) -> Mesh:
    """Normals of length 1; corners whose normal is zero, not finite or not there get the face's."""
    if mesh.normals is None or mesh.normal_index is None:
        return mesh
    normals, index = mesh.normals, mesh.normal_index
    with np.errstate(all="ignore"):
        most = np.abs(normals).max(axis=1, keepdims=True) if len(normals) else np.ones((0, 1))
        unit = normals / most  # first by the largest part: squares of tiny ones would be 0
        unit = unit / np.sqrt((unit * unit).sum(axis=1, keepdims=True))
    sound = np.isfinite(unit).all(axis=1)
    if sound.all() and index.max(initial=-1) < len(unit):
        return replace(mesh, normals=unit)
    wrong = index >= len(unit)
    wrong |= ~np.append(sound, True)[np.where(wrong | (index < 0), len(unit), index)]
    if not wrong.any():
        if not sound.all():
            unit[~sound] = 0.0
        return replace(mesh, normals=unit)
    faces, corners = np.nonzero(wrong)
    _add(count, "mended_normals", len(faces))
    own, which = np.unique(faces, return_inverse=True)
    a, b, c = (mesh.vertices[mesh.faces[own, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    across = across / np.abs(across).max(axis=1, keepdims=True)
    across = across / np.linalg.norm(across, axis=1, keepdims=True)
    index = index.copy()
    index[faces, corners] = len(unit) + which
    unit[~sound] = 0.0
    return replace(mesh, normals=np.concatenate([unit, across]), normal_index=index)


def _mended_details(mesh: Mesh, count: dict[str, int]) -> Mesh:
    """Details that lie on no face, on themselves or on each other in a ring become plain faces."""
    detail = mesh.detail
    if detail is None:
        return mesh
    faces = len(mesh.faces)
    wrong = (detail < -1) | (detail >= faces)
    following = np.append(np.where(wrong, -1, detail), -1)
    for _ in range(max(faces, 1).bit_length()):  # twice as far each time: only rings go on for ever
        following = following[following]
    wrong |= following[:faces] >= 0
    if not wrong.any():
        return mesh
    _add(count, "mended_details", int(wrong.sum()))
    return replace(mesh, detail=np.where(wrong, -1, detail))


def _only(mesh: Mesh, kept: NDArray[np.bool_], count: dict[str, int]) -> Mesh:
    """The faces of *mesh* that are *kept*, in their order; details follow the faces they lie on."""
    detail = mesh.detail
    if detail is not None:
        new = np.append(np.where(kept, np.cumsum(kept) - 1, -1), -1)
        inside = (detail >= 0) & (detail < len(kept))
        moved = np.where(inside, new[np.where(inside, detail, -1)], detail)
        _add(count, "mended_details", int((inside & (moved < 0) & kept).sum()))
        detail = moved[kept]
    return replace(
        mesh,
        faces=mesh.faces[kept],
        material=mesh.material[kept],
        normal_index=None if mesh.normal_index is None else mesh.normal_index[kept],
        detail=detail,
        smooth=None if mesh.smooth is None else mesh.smooth[kept],
    )


def _typed(mesh: Mesh) -> Mesh:
    """*mesh* with C-contiguous arrays of the types that model.py states, of shapes that agree."""
    name = mesh.name
    vertices = _array(mesh.vertices, "f", np.float64, (None, 3), f"mesh '{name}': vertices")
    faces = _array(mesh.faces, "iu", np.int64, (None, 3), f"mesh '{name}': faces")
    size = len(faces)
    normals, index = mesh.normals, mesh.normal_index
    if normals is not None:
        normals = _array(normals, "f", np.float64, (None, 3), f"mesh '{name}': normals")
        if index is None:
            if len(normals) != len(vertices):
                raise InputError(
                    f"mesh '{name}': {len(normals)} normals for {len(vertices)} vertices; allowed: one "
                    "for each vertex, or any number with normal_index (F, 3)"
                )
            index = faces
    if index is not None:
        index = _array(index, "iu", np.int64, (size, 3), f"mesh '{name}': normal_index")
    material = _array(mesh.material, "iu", np.int64, (size,), f"mesh '{name}': material")
    detail, smooth = mesh.detail, mesh.smooth
    if detail is not None:
        detail = _array(detail, "iu", np.int64, (size,), f"mesh '{name}': detail")
    if smooth is not None:
        smooth = _array(smooth, "b", np.bool_, (size,), f"mesh '{name}': smooth")
    return Mesh(vertices, faces, material, normals, index, detail, smooth, name)


def _array(given: Any, kinds: str, kind: Any, shape: tuple[int | None, ...], what: str) -> NDArray[Any]:
    array = np.asarray(given)
    wanted = tuple(
        have if want is None else want for want, have in zip(shape, array.shape, strict=False)
    )
    fits = array.ndim == len(shape) and array.shape == wanted
    if array.size == 0 and array.ndim <= 2 and shape[0] in (None, 0):
        return np.zeros((0, *shape[1:]), kind)  # type: ignore[arg-type]
    if not fits or (array.dtype.kind not in kinds and not (kinds == "f" and array.dtype.kind in "iu")):
        text = ", ".join("any" if s is None else str(s) for s in shape)
        raise InputError(
            f"{what} has shape {array.shape} and type {array.dtype}; allowed: shape ({text}) of "
            f"{np.dtype(kind).name}"
        )
    return np.ascontiguousarray(array, kind)


def _add(count: dict[str, int], key: str, number: int) -> None:
    count[key] = count.get(key, 0) + number
