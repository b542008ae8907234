"""All meshes of a scene as one set of arrays, made once and rendered any number of times."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from halftone.errors import InputError
from halftone.scene.model import Mesh, Scene
from halftone.scene.normals import face_normals, unit, vertex_normals

__all__ = ["Geometry", "geometry_of"]


@dataclass(frozen=True, eq=False)
class Geometry:
    """Triangles for the kernels.

    vertices : float64 (V, 3). faces : int32 (F, 3). materials : int32 (F,). corners : int32 (F, 3)
    into attributes, float32 (A, 6): position and normal; attribute_material : int32 (A,).
    detail : int32 (F,), the face that each lies on, or −1; None without details. plane : int32 (F,),
    faces of one number lie in one plane and share their details; None without details.
    zero_normals : corners whose normal is that of their face, because their own is 0.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int32]
    materials: NDArray[np.int32]
    corners: NDArray[np.int32]
    attributes: NDArray[np.float32]
    attribute_material: NDArray[np.int32]
    detail: NDArray[np.int32] | None
    plane: NDArray[np.int32] | None
    zero_normals: int

    @cached_property
    def table(self) -> NDArray[np.float32]:
        """The attributes as float32 (A · 8,): position, normal, 1 and 0 of each."""
        made = np.zeros((len(self.attributes), 8), np.float32)
        made[:, :6], made[:, 6] = self.attributes, 1
        return made.ravel()


def geometry_of(scene: Scene) -> Geometry:
    """The geometry of a sanitised *scene*. Raises InputError where a mesh has over 2³¹ corners."""
    meshes = [mesh for mesh in scene.meshes if len(mesh.faces)]
    total = sum(len(mesh.faces) * 3 + len(mesh.vertices) for mesh in meshes)
    if total >= 1 << 31:
        raise InputError(f"the scene has {total} corners and vertices; at most 2³¹ − 1 can be rendered")
    vertices, faces, materials, details = [np.zeros((0, 3))], [np.zeros((0, 3), np.int64)], [], []
    corners, attributes, owners = [np.zeros((0, 3), np.int64)], [np.zeros((0, 6))], []
    at = face_at = attribute_at = zero = 0
    for mesh in meshes:
        index, rows, material, missing = _corners(mesh, scene.normals)
        vertices.append(mesh.vertices)
        faces.append(mesh.faces + at)
        materials.append(mesh.material)
        corners.append(index + attribute_at)
        attributes.append(rows)
        owners.append(material)
        on = np.full(len(mesh.faces), -1, np.int64) if mesh.detail is None else mesh.detail
        details.append(np.where(on >= 0, on + face_at, -1))
        zero += missing
        at += len(mesh.vertices)
        face_at += len(mesh.faces)
        attribute_at += len(rows)
    detail = _joined(details)
    all_vertices = np.ascontiguousarray(np.concatenate(vertices), np.float64)
    all_faces = np.ascontiguousarray(np.concatenate(faces), np.int32)
    has_details = bool((detail >= 0).any())
    return Geometry(
        all_vertices,
        all_faces,
        _joined(materials),
        np.ascontiguousarray(np.concatenate(corners), np.int32),
        np.ascontiguousarray(np.concatenate(attributes), np.float32),
        _joined(owners),
        detail if has_details else None,
        _planes(all_vertices, all_faces, detail) if has_details else None,
        zero,
    )


def _joined(parts: list[NDArray[np.int64]]) -> NDArray[np.int32]:
    return np.concatenate(parts).astype(np.int32) if parts else np.zeros(0, np.int32)


def _corners(
    mesh: Mesh, weighting: str
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.int64], int]:
    """Index of every corner (F, 3), the rows they point to (A, 6), their materials, zero normals."""
    count = len(mesh.faces)
    averaged = vertex_normals(mesh.vertices, mesh.faces, weighting, mesh.smooth)
    given = np.zeros((0, 3)) if mesh.normals is None else unit(np.asarray(mesh.normals, np.float64))
    own = unit(face_normals(mesh.vertices, mesh.faces))
    pool = np.concatenate([averaged, given, own])
    # Which normal of the pool each corner has: the vertex's, if not given, or the face's if flat or 0.
    chosen = mesh.faces.astype(np.int64)
    face_own = len(averaged) + len(given) + np.arange(count)[:, None]
    if mesh.smooth is not None:
        chosen = np.where(np.asarray(mesh.smooth, bool)[:, None], chosen, face_own)
    if mesh.normals is not None and mesh.normal_index is not None:
        chosen = np.where(mesh.normal_index >= 0, mesh.normal_index + len(averaged), chosen)
    zero = (pool == 0).all(axis=1)[chosen]
    missing = int(np.count_nonzero(zero))
    if missing:
        chosen = np.where(zero, face_own, chosen)
    first = int(mesh.material[0])
    plain = not missing and mesh.smooth is None and mesh.normal_index is None
    if plain and (mesh.material == first).all():
        rows = np.concatenate([mesh.vertices, averaged], axis=1)
        return mesh.faces, rows, np.full(len(rows), first, np.int64), 0
    material = np.broadcast_to(mesh.material[:, None], (count, 3)).astype(np.int64)
    key = (mesh.faces.astype(np.int64) * len(pool) + chosen).ravel()
    kinds, named = np.unique(key, return_inverse=True)
    pairs, index = np.unique(named * (int(material.max()) + 1) + material.ravel(), return_inverse=True)
    kind, owner = np.divmod(pairs, int(material.max()) + 1)
    vertex, normal = np.divmod(kinds[kind], len(pool))
    rows = np.concatenate([mesh.vertices[vertex], pool[normal]], axis=1)
    return index.reshape(count, 3), rows, owner, missing


def _planes(
    vertices: NDArray[np.float64], faces: NDArray[np.int32], detail: NDArray[np.int32]
) -> NDArray[np.int32]:
    """A number for every face: that of the first face with details in the same plane, else its own."""
    plane = np.arange(len(faces), dtype=np.int32)
    normals = unit(face_normals(vertices, faces.astype(np.int64)))
    extent = float(np.ptp(vertices, axis=0).max())
    bases = detail < 0
    for parent in np.unique(detail[detail >= 0]):
        if not bases[parent] or plane[parent] != parent:
            continue
        point = vertices[faces[parent, 0]]
        away = np.abs((vertices - point) @ normals[parent]) <= 1e-9 * extent
        same = away[faces].all(axis=1) & (normals @ normals[parent] > 0.5) & bases
        plane[same] = parent
    plane[~bases] = np.flatnonzero(~bases)
    return plane
