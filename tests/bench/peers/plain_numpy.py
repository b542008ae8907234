"""NumPy's one line for ordered dither: a comparison and packbits."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tests.bench.peers.base import Bytes, Peer, Timed, bits


def load() -> Peer:
    return Peer(
        "NumPy",
        np.__version__,
        "`np.packbits(codes > thresholds, axis=1)`, thresholds tiled to the picture before timing",
        {"bayer-bits": _job("bayer8"), "noise-bits": _job("blue-noise")},
    )


def _job(name: str) -> Callable[[Bytes], Timed]:
    def timed(codes: Bytes) -> Timed:
        thresholds = _whole(_cuts(name), codes.shape)
        return Timed(
            lambda: np.packbits(codes > thresholds, axis=1), lambda made: bits(made, codes.shape[1])
        )

    return timed


def _cuts(name: str) -> Bytes:
    """The largest code that stays dark at each place of a screen, for codes that are light."""
    from halftone.dithering.screened import screen

    light = (np.arange(256) / 255).astype(np.float32)
    made = screen(name)
    first = np.searchsorted(light, made.thresholds, side="right")  # the first code above
    return (first - 1).astype(np.uint8)


def _whole(tile: Bytes, shape: tuple[int, ...]) -> Bytes:
    times = (-(-shape[0] // tile.shape[0]), -(-shape[1] // tile.shape[1]))
    return np.ascontiguousarray(np.tile(tile, times)[: shape[0], : shape[1]])
