"""The slow twins of tests/oracle as references for timed results: the first rows of each must agree."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import halftone
from halftone.dithering import FILTERS
from halftone.dithering.screened import screen
from tests.bench.peers.base import Bytes
from tests.oracle import diffusion, dots, point, toned

__all__ = [
    "ROWS",
    "SPARE",
    "Twin",
    "codes_twin",
    "dots_twin",
    "light_twin",
    "ordered_twin",
    "toned_twin",
]

ROWS = 36
"""Rows of a large picture that are compared: more than a block of 32 rows of a wavefront."""
SPARE = 64
"""Rows and columns beyond which no error of dot diffusion comes from."""

Twin = Callable[[Bytes, np.ndarray, np.ndarray, int], np.ndarray]
"""Codes and their light, the levels' luminance, how many rows → indices from the top left on."""


def codes_twin(serpentine: bool) -> Twin:
    """Floyd–Steinberg in integers."""
    return lambda codes, light, levels, rows: diffusion.diffuse_codes(codes[:rows], serpentine)


def light_twin(name: str, serpentine: bool) -> Twin:
    """An error filter in float32."""
    table = FILTERS[name]
    return lambda codes, light, levels, rows: diffusion.diffuse_light(
        light[:rows], levels, list(table.taps), table.divisor, serpentine
    )


def toned_twin(name: str) -> Twin:
    """Tone-dependent error diffusion, serpentine."""

    def twin(codes: Bytes, light: np.ndarray, levels: np.ndarray, rows: int) -> np.ndarray:
        from halftone.dithering.toned import PLACES, tone_table

        weights, width = (table.astype(np.float32) for table in tone_table(name))
        return toned.diffuse_toned(
            light[:rows], levels, list(PLACES), weights, True, False, width if width.any() else 0.0
        )

    return twin


def ordered_twin(name: str) -> Twin:
    """A screen."""
    return lambda codes, light, levels, rows: point.step_up(
        light[:rows], screen(name).thresholds, levels
    )


def dots_twin(name: str) -> Twin:
    """Dot diffusion: its twin is slow and needs all neighbours, so only a corner is compared."""

    def twin(codes: Bytes, light: np.ndarray, levels: np.ndarray, rows: int) -> np.ndarray:
        classes = halftone.method(name).classes.classes
        # Errors go on to higher classes only: they reach over fewer pixels than there are classes.
        assert classes.size <= SPARE
        corner = light[: ROWS + SPARE, : ROWS + SPARE]
        return dots.diffuse(corner, levels, classes.tolist())[0][:ROWS, :ROWS]

    return twin
