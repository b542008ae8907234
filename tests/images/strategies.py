"""Hypothesis strategies: frames of random levels and sizes."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from halftone.frame import Frame
from halftone.tone.levels import Levels

__all__ = ["frames", "packings", "sizes"]

sizes = st.one_of(
    st.sampled_from([(1, 1), (1, 70), (70, 1), (3, 7), (5, 8), (5, 9), (2, 63), (2, 65)]),
    st.tuples(st.integers(1, 70), st.integers(1, 70)),
)
"""(M, N), the awkward ones often."""


@st.composite
def packings(draw: st.DrawFn) -> tuple[int, str, tuple[int, ...] | None]:
    """Bits, bit order and codes; codes for 1 … 2^bits levels, or none."""
    bits = draw(st.sampled_from([1, 2, 4, 8]))
    order = draw(st.sampled_from(["msb", "lsb"]))
    if draw(st.booleans()):
        return bits, order, None
    count = draw(st.one_of(st.just(1 << bits), st.integers(1, 1 << bits)))
    shuffled = np.random.default_rng(draw(st.integers(0, 2**32 - 1))).permutation(1 << bits)
    return bits, order, tuple(int(code) for code in shuffled[:count])


@st.composite
def frames(draw: st.DrawFn, most: int = 256) -> Frame:
    """Random indices of 2 … *most* levels: a count, or a ladder whose sRGB codes all differ."""
    count = draw(st.one_of(st.integers(2, min(most, 17)), st.integers(2, most)))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    if draw(st.booleans()):
        levels = Levels.of(count)
    else:
        codes = np.sort(random.permutation(256)[:count]) / 255
        light = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
        levels = Levels.of(light.tolist())
    indices = random.integers(0, count, draw(sizes), np.uint8)
    dpi = draw(st.sampled_from([None, (203.2, 203.2), (119.0, 59.5), (72.0, 1200.0)]))
    return Frame(indices, levels, dpi=dpi)
