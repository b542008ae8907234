"""zimg (z.lib): the fastest Floyd–Steinberg in a C library. ctypes, after zimg.h of API 2.4.

Its rows must start at multiples of 64 bytes, so it gets a copy of the picture made before timing.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from ctypes import POINTER, Structure, byref, c_char, c_double, c_int, c_ssize_t, c_uint, c_void_p

import numpy as np

from tests.bench.peers.base import Bytes, Peer, Timed, aligned, bits, library

API = 2 << 8 | 4
FULL_RANGE = 1
WHOLE = 2**32 - 1  # ZIMG_BUFFER_MAX: all rows are in memory
CPU_AUTO_64B = 2
ORDERED, RANDOM, ERROR_DIFFUSION = 1, 2, 3


class _Plane(Structure):
    _fields_ = (("data", c_void_p), ("stride", c_ssize_t), ("mask", c_uint))


class _Buffer(Structure):
    _fields_ = (("version", c_uint), ("plane", _Plane * 4))


class _Format(Structure):
    _fields_ = (
        *((name, c_uint) for name in ("version", "width", "height")),
        ("pixel_type", c_int),
        *((name, c_uint) for name in ("subsample_w", "subsample_h")),
        *((name, c_int) for name in ("color_family", "matrix", "transfer", "primaries")),
        ("depth", c_uint),
        *((name, c_int) for name in ("pixel_range", "field_parity", "chroma_location")),
        ("active_region", c_double * 4),
        ("alpha", c_int),
    )


class _Parameters(Structure):
    _fields_ = (
        ("version", c_uint),
        ("resample_filter", c_int),
        ("filter_params", c_double * 2),
        ("resample_filter_uv", c_int),
        ("filter_params_uv", c_double * 2),
        *((name, c_int) for name in ("dither_type", "cpu_type")),
        ("nominal_peak_luminance", c_double),
        ("allow_approximate_gamma", c_char),
    )


def load() -> Peer:
    lib = library("zimg", "libzimg.so.2")
    lib.zimg_filter_graph_build.restype = c_void_p
    lib.zimg_filter_graph_build.argtypes = [
        POINTER(_Format),
        POINTER(_Format),
        POINTER(_Parameters),
    ]
    lib.zimg_filter_graph_get_tmp_size.argtypes = [c_void_p, POINTER(ctypes.c_size_t)]
    lib.zimg_filter_graph_process.argtypes = [c_void_p, POINTER(_Buffer), POINTER(_Buffer)] + [
        c_void_p
    ] * 5
    if lib.zimg_get_api_version(None, None) < API:
        raise OSError("libzimg is older than API 2.4")
    version = [c_uint() for _ in range(3)]
    lib.zimg_get_version_info(*(byref(v) for v in version))

    def job(dither: int, depth: int, packed: bool = False) -> Callable[[Bytes], Timed]:
        return lambda codes: _timed(lib, codes, dither, depth, packed)

    return Peer(
        "zimg",
        ".".join(str(v.value) for v in version),
        "float32, fused multiply-add; a value is clamped to the levels' range before its error is taken",
        {
            "fs": job(ERROR_DIFFUSION, 1),
            "fs-bits": job(ERROR_DIFFUSION, 1, packed=True),
            "fs-4": job(ERROR_DIFFUSION, 2),
            "fs-16": job(ERROR_DIFFUSION, 4),
            "bayer-bits": job(ORDERED, 1, packed=True),
            "noise-bits": job(RANDOM, 1, packed=True),
        },
    )


def _timed(lib: ctypes.CDLL, codes: Bytes, dither: int, depth: int, packed: bool) -> Timed:
    height, width = codes.shape
    source = aligned(codes.shape)
    source[:] = codes
    formats = []
    for bit_depth in (8, depth):
        made = _Format()
        lib.zimg_image_format_default(byref(made), API)
        made.width, made.height, made.depth = width, height, bit_depth
        made.pixel_type, made.pixel_range = 0, FULL_RANGE
        formats.append(made)
    parameters = _Parameters()
    lib.zimg_graph_builder_params_default(byref(parameters), API)
    parameters.dither_type, parameters.cpu_type = dither, CPU_AUTO_64B
    graph = lib.zimg_filter_graph_build(byref(formats[0]), byref(formats[1]), byref(parameters))
    if not graph:
        raise RuntimeError("zimg refuses to build the graph")
    size = ctypes.c_size_t()
    lib.zimg_filter_graph_get_tmp_size(graph, byref(size))
    room = aligned((1, size.value + 64))

    def call() -> Bytes:
        given, out = _buffer(source), aligned((height, width))
        failed = lib.zimg_filter_graph_process(
            graph, byref(given), byref(_buffer(out)), room.ctypes.data, None, None, None, None
        )
        if failed:
            raise RuntimeError(f"zimg failed with {failed}")
        return np.packbits(out, axis=1) if packed else out

    return Timed(call, (lambda made: bits(made, width)) if packed else lambda made: made)


def _buffer(array: Bytes) -> _Buffer:
    made = _Buffer(version=API)
    made.plane[0] = _Plane(array.ctypes.data, array.strides[0], WHOLE)
    return made
