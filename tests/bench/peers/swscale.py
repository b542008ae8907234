"""FFmpeg's libswscale: 8-bit gray to packed bits by error diffusion or Bayer's screen."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from ctypes import c_char_p, c_int, c_int64, c_void_p

import numpy as np

from tests.bench.peers.base import Bytes, Peer, Timed, bits, library

ERRORS = 16  # of av_log_set_level: no warnings


def load() -> Peer:
    util = library("avutil", "libavutil.so.57", "libavutil.so.59")
    lib = library("swscale", "libswscale.so.6", "libswscale.so.8")
    lib.sws_alloc_context.restype = c_void_p
    lib.sws_init_context.argtypes = [c_void_p] * 3
    lib.sws_scale.argtypes = [c_void_p, c_void_p, c_void_p, c_int, c_int, c_void_p, c_void_p]
    util.av_opt_set.argtypes = [c_void_p, c_char_p, c_char_p, c_int]
    util.av_opt_set_int.argtypes = [c_void_p, c_char_p, c_int64, c_int]
    util.av_log_set_level(ERRORS)
    number = lib.swscale_version()
    return Peer(
        "swscale",
        f"{number >> 16}.{number >> 8 & 255}.{number & 255}",
        "integers, errors rounded to whole codes, white 220 codes above black (video range)",
        {"fs-bits": _job(lib, util, b"ed"), "bayer-bits": _job(lib, util, b"bayer")},
    )


def _job(lib: ctypes.CDLL, util: ctypes.CDLL, dither: bytes) -> Callable[[Bytes], Timed]:
    def timed(codes: Bytes) -> Timed:
        height, width = codes.shape
        context = lib.sws_alloc_context()
        numbers = {
            b"srcw": width, b"dstw": width, b"srch": height, b"dsth": height,
            b"src_format": util.av_get_pix_fmt(b"gray"),
            b"dst_format": util.av_get_pix_fmt(b"monob"),
            b"src_range": 1, b"dst_range": 1,
        }  # fmt: skip
        refused = [util.av_opt_set_int(context, name, value, 0) for name, value in numbers.items()]
        refused.append(util.av_opt_set(context, b"sws_dither", dither, 0))
        if any(refused) or lib.sws_init_context(context, None, None) < 0:
            raise RuntimeError("libswscale refuses gray to bits")
        row = (width + 7) // 8

        def call() -> Bytes:
            out = np.empty((height, row), np.uint8)
            source, source_step = (c_void_p * 4)(codes.ctypes.data), (c_int * 4)(width)
            target, target_step = (c_void_p * 4)(out.ctypes.data), (c_int * 4)(row)
            lib.sws_scale(context, source, source_step, 0, height, target, target_step)
            return out

        return Timed(call, lambda made: bits(made, width))

    return timed
