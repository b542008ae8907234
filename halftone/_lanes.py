"""Short vectors, whose elements (lanes) a processor works on at once: the words of wavefront kernels.

A kernel marked ``@kernel(…, lanes=True)`` may call these functions and use + − * / >> << & >= and < on
their results. Compiled, a vector is one LLVM value (:mod:`halftone._lanes_ir`), which becomes whatever
registers the processor has. In plain Python it is a NumPy array, and the same lines give the same
bytes: every operation rounds lane by lane as IEEE 754 says, and none is reordered.

Arrays are flat; *at* is a place in them. *lanes* must be a number known when compiling.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "acquire",
    "added",
    "copy",
    "gather",
    "load",
    "release",
    "select",
    "shifted",
    "splat",
    "store",
    "transpose",
]
__all__ += ["as_bytes", "as_floats", "as_places", "prefetch", "widened"]

Vector = NDArray[Any]

TILE = 16
"""Side of what :func:`transpose` moves."""


def load(array: Vector, at: int, lanes: int) -> Vector:
    """array[at : at + lanes]."""
    return array[at : at + lanes].copy()


def store(array: Vector, at: int, vector: Vector) -> None:
    """array[at : at + lanes] = vector."""
    array[at : at + vector.size] = vector


def copy(source: Vector, at: int, target: Vector, to: int, count: int) -> None:
    """target[to : to + count] = source[at : at + count], of one type; the two may overlap."""
    target[to : to + count] = source[at : at + count]


def added(early: Vector, late: Vector) -> Vector:
    """early + late of int16, saturating. The compiler keeps this sum apart from those before it, so
    that only one addition waits for *late*.
    """
    total = early.astype(np.int32) + late
    return np.clip(total, -32768, 32767).astype(np.int16)


def prefetch(array: Vector, at: int) -> None:
    """Say that array[at] and what lies around it will be wanted soon; any place is allowed."""


def splat(value: Any, lanes: int) -> Vector:
    """*value* in all lanes, of its own type."""
    return np.full(lanes, value)


def select(mask: Vector, yes: Any, no: Any) -> Vector:
    """Lane by lane, *yes* where *mask* is true, else *no*."""
    chosen: Vector = np.where(mask, yes, no)
    return chosen


def shifted(vector: Vector, first: Any) -> Vector:
    """Every lane one place up: *first*, vector[0], vector[1], … without the last."""
    return np.concatenate([np.full(1, first, vector.dtype), vector[:-1]])


def widened(vector: Vector) -> Vector:
    """uint8 as int16."""
    return vector.astype(np.int16)


def as_bytes(mask: Vector) -> Vector:
    """A mask as uint8, 1 where it is true; or int32 without its upper bits."""
    return mask.astype(np.uint8)


def as_places(vector: Vector) -> Vector:
    """float32 as int32, towards 0; within ±2³⁰."""
    return vector.astype(np.int32)


def as_floats(vector: Vector) -> Vector:
    """int32 or uint8 as float32."""
    return vector.astype(np.float32)


def gather(table: Vector, places: Vector) -> Vector:
    """table[places]."""
    return table[places]


def transpose(source: Vector, at: int, pitch: int, target: Vector, to: int, step: int) -> None:
    """Bytes of 16 rows to 16 columns: target[to + step·t + r] = source[at + pitch·r + t], t, r < 16."""
    for r in range(TILE):
        row = at + pitch * r
        target[to + r : to + r + step * (TILE - 1) + 1 : step] = source[row : row + TILE]


def acquire(array: Vector, at: int) -> Any:
    """array[at], of int64, as another thread released it, with all it wrote before."""
    return array[at]


def release(array: Vector, at: int, value: int) -> None:
    """array[at] = value, for other threads, after all that was written before."""
    array[at] = value
