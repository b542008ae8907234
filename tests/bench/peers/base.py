"""What a peer is, and help for calling C libraries."""

from __future__ import annotations

import ctypes
import ctypes.util
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Bytes", "Peer", "Timed", "aligned", "bits", "library"]

Bytes = NDArray[np.uint8]


@dataclass(frozen=True)
class Timed:
    """One way to do a job: ``call`` is what is timed, ``indices`` reads its result afterwards."""

    call: Callable[[], Any]
    indices: Callable[[Any], Bytes]


@dataclass(frozen=True)
class Peer:
    """A library and the jobs it can do.

    arithmetic : what it computes in, for the table's notes.
    jobs : key of the job → from the picture (uint8, gray) to what is timed. What is made before the
    timed call (contexts, aligned copies, other pixel formats) is in the peer's favour.
    slow : timed on small pictures only.
    """

    name: str
    version: str
    arithmetic: str
    jobs: dict[str, Callable[[Bytes], Timed]]
    slow: bool = False


def library(name: str, *files: str) -> ctypes.CDLL:
    """A shared library by its name, or by the first of *files* that loads."""
    for file in (ctypes.util.find_library(name), *files):
        if file:
            try:
                return ctypes.CDLL(file, mode=ctypes.RTLD_GLOBAL)
            except OSError:
                continue
    raise OSError(f"lib{name} is not installed")


def aligned(shape: tuple[int, int], to: int = 64) -> Bytes:
    """An empty uint8 array whose start and rows are multiples of *to* bytes; a view."""
    stride = -(-shape[1] // to) * to
    room = np.empty(shape[0] * stride + to, np.uint8)
    start = -room.ctypes.data % to
    return room[start : start + shape[0] * stride].reshape(shape[0], stride)[:, : shape[1]]


def bits(packed: Bytes, width: int) -> Bytes:
    """Packed rows, the leftmost pixel in the highest bit, as level indices."""
    return np.unpackbits(packed.reshape(packed.shape[0], -1), axis=1)[:, :width]
