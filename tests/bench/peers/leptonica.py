"""Leptonica: pixDitherToBinary, and to 4 levels."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from ctypes import byref, c_char_p, c_int, c_void_p
from typing import Any

import numpy as np

from tests.bench.peers.base import Bytes, Peer, Timed, library


def load() -> Peer:
    lib = library("lept", "liblept.so.5", "libleptonica.so.6")
    for name in ("pixCreate", "pixGetData", "getLeptonicaVersion"):
        getattr(lib, name).restype = c_void_p
    lib.pixCreate.argtypes = [c_int] * 3
    lib.getLeptonicaVersion.restype = c_char_p
    for name in ("pixGetData", "pixGetWpl", "pixEndianByteSwap"):
        getattr(lib, name).argtypes = [c_void_p]
    for name, arguments in (("pixDitherToBinary", []), ("pixDitherTo2bpp", [c_int])):
        getattr(lib, name).restype = c_void_p
        getattr(lib, name).argtypes = [c_void_p, *arguments]

    return Peer(
        "Leptonica",
        (lib.getLeptonicaVersion() or b"?").decode().removeprefix("leptonica-"),
        "integers, 3/8, 3/8 and 1/4 to three neighbours, nothing from pixels near black or white",
        {"fs-bits": _job(lib, 1, lib.pixDitherToBinary), "fs-4": _job(lib, 2, lib.pixDitherTo2bpp, 0)},
    )


def _job(
    lib: ctypes.CDLL, depth: int, dither: Callable[..., int], *arguments: int
) -> Callable[[Bytes], Timed]:
    def timed(codes: Bytes) -> Timed:
        height, width = codes.shape
        pix = lib.pixCreate(width, height, 8)
        _words(lib, pix, height)[:, :width] = codes
        lib.pixEndianByteSwap(pix)  # its pixels stand in words of the machine's byte order

        def indices(made: _Pix) -> Bytes:
            words = _words(lib, made.address, height)
            lib.pixEndianByteSwap(made.address)
            all_bits = np.unpackbits(words, axis=1)[:, : width * depth].reshape(height, width, depth)
            if depth == 1:
                return 1 - all_bits[:, :, 0]  # its 1 is black
            return all_bits @ np.array([2, 1], np.uint8)

        return Timed(lambda: _Pix(lib, dither(pix, *arguments)), indices)

    return timed


class _Pix:
    """A picture of Leptonica's that is freed with this object."""

    def __init__(self, lib: ctypes.CDLL, address: int) -> None:
        self.lib, self.address = lib, address

    def __del__(self) -> None:
        self.lib.pixDestroy(byref(c_void_p(self.address)))


def _words(lib: ctypes.CDLL, pix: int, height: int) -> Bytes:
    """The rows of a picture as bytes, not copied."""
    size = 4 * int(lib.pixGetWpl(pix))
    room: Any = (ctypes.c_uint8 * (height * size)).from_address(lib.pixGetData(pix))
    return np.frombuffer(room, np.uint8).reshape(height, size)
