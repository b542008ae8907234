"""Pillow: ``convert("1")``, its Floyd–Steinberg for two levels."""

from __future__ import annotations

import numpy as np

from tests.bench.peers.base import Bytes, Peer, Timed, bits


def load() -> Peer:
    import PIL

    return Peer(
        "Pillow",
        PIL.__version__,
        "integers; a value is clamped to 0 … 255 before its error is taken",
        {"fs": _bytes, "fs-bits": _bits},
    )


def _bytes(codes: Bytes) -> Timed:
    from PIL import Image

    image = Image.fromarray(codes)
    return Timed(lambda: image.convert("1"), lambda made: np.asarray(made).astype(np.uint8))


def _bits(codes: Bytes) -> Timed:
    from PIL import Image

    image = Image.fromarray(codes)
    height, width = codes.shape
    return Timed(
        lambda: image.convert("1").tobytes(),
        lambda made: bits(np.frombuffer(made, np.uint8).reshape(height, -1), width),
    )
