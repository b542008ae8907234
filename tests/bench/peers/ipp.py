"""Intel's Integrated Performance Primitives: ippiReduceBits, after ippcc.h of 2026.1."""

from __future__ import annotations

import ctypes
import importlib.metadata
from collections.abc import Callable
from ctypes import POINTER, Structure, byref, c_int, c_ubyte, c_void_p
from pathlib import Path

import numpy as np

from tests.bench.peers.base import Bytes, Peer, Timed, bits

FS, JJN, STUCKI = 1, 2, 3
ONE_CHANNEL = 1
MIDDLE = 128


class _Size(Structure):
    _fields_ = (("width", c_int), ("height", c_int))


def load() -> Peer:
    try:
        package = importlib.metadata.distribution("ipp")
    except importlib.metadata.PackageNotFoundError as error:
        raise ImportError("the package is not installed") from error
    found = {Path(str(f)).name: package.locate_file(f) for f in package.files or ()}
    for name in ("libippcore.so.12", f"libippcc{_processor()}.so.12"):
        if name not in found:
            raise OSError(f"the package has no {name}")
        lib = ctypes.CDLL(str(Path(str(found[name])).resolve()), mode=ctypes.RTLD_GLOBAL)
    steps = [c_void_p, c_int, c_void_p, c_int]
    lib.ippiReduceBits_8u1u_C1R.argtypes = [
        *steps, c_int, _Size, c_int, c_int, c_int, c_ubyte, c_void_p,
    ]  # fmt: skip
    lib.ippiReduceBits_8u_C1R.argtypes = [*steps, _Size, c_int, c_int, c_int, c_void_p]
    lib.ippiReduceBitsGetBufferSize.argtypes = [c_int, _Size, c_int, c_int, POINTER(c_int)]
    return Peer(
        "Intel IPP",
        package.version,
        "not documented; Stucki gives packed bits in both rows, the others bytes",
        {
            "stucki": _bits(lib),
            "stucki-bits": _bits(lib),
            "jarvis": _levels(lib, JJN, 2),
            "fs": _levels(lib, FS, 2),
            "fs-4": _levels(lib, FS, 4),
            "fs-5": _levels(lib, FS, 5),
            "fs-16": _levels(lib, FS, 16),
            "fs-17": _levels(lib, FS, 17),
        },
    )


def _processor() -> str:
    """Which of IPP's builds this processor takes.

    Its own dispatcher looks for names that the package lacks (….so.12.1) and ends the process.
    """
    flags = Path("/proc/cpuinfo").read_text().split()
    if "avx512bw" in flags:
        return "k0"
    return "l9" if "avx2" in flags else "y8"


def _room(lib: ctypes.CDLL, size: _Size, dither: int) -> Bytes:
    need = c_int()
    failed = lib.ippiReduceBitsGetBufferSize(ONE_CHANNEL, size, 0, dither, byref(need))
    if failed:
        raise RuntimeError(f"IPP refuses the size with {failed}")
    return np.empty(max(need.value, 1), np.uint8)


def _bits(lib: ctypes.CDLL) -> Callable[[Bytes], Timed]:
    def timed(codes: Bytes) -> Timed:
        height, width = codes.shape
        size, row = _Size(width, height), (width + 7) // 8
        room = _room(lib, size, STUCKI)

        def call() -> Bytes:
            out = np.empty((height, row), np.uint8)
            failed = lib.ippiReduceBits_8u1u_C1R(
                codes.ctypes.data, width, out.ctypes.data, row, 0, size, 0, 0, STUCKI, MIDDLE,
                room.ctypes.data,
            )  # fmt: skip
            if failed:
                raise RuntimeError(f"IPP failed with {failed}")
            return out

        return Timed(call, lambda made: bits(made, width))

    return timed


def _levels(lib: ctypes.CDLL, dither: int, count: int) -> Callable[[Bytes], Timed]:
    def timed(codes: Bytes) -> Timed:
        height, width = codes.shape
        size = _Size(width, height)
        room = _room(lib, size, dither)

        def call() -> Bytes:
            out = np.empty((height, width), np.uint8)
            failed = lib.ippiReduceBits_8u_C1R(
                codes.ctypes.data, width, out.ctypes.data, width, size, 0, dither, count,
                room.ctypes.data,
            )  # fmt: skip
            if failed:
                raise RuntimeError(f"IPP failed with {failed}")
            return out

        return Timed(call, lambda made: np.unique(made, return_inverse=True)[1].reshape(made.shape))

    return timed
