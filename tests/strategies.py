"""Hypothesis strategies for pictures, levels and methods."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from halftone.dithering.registry import NAMES

__all__ = ["ladders", "light", "method_names", "shapes", "texts"]

shapes = st.tuples(st.integers(1, 40), st.integers(1, 40))
"""(M, N), from 1 × 1 on."""

SAME_SIZE = [name for name in NAMES if NAMES[name] != "patterns" or name.startswith("growth")]
"""Methods that give a pixel for every pixel."""

method_names = st.sampled_from([name for name in SAME_SIZE if name != "threshold"])
"""… and that work on any number of levels."""

DIFFUSION = [name for name, family in NAMES.items() if family == "diffusion"]

texts = st.one_of(
    method_names,
    st.builds(
        "{}{}{}{}".format,
        st.sampled_from(DIFFUSION),
        st.sampled_from(["", ":raster"]),
        st.sampled_from(["", ":right"]),
        st.sampled_from(["", ":strength=0.75", ":strength=0"]),
    ),
    st.builds(
        "random:{}:seed={}".format, st.sampled_from(["uniform", "triangular"]), st.integers(1, 99)
    ),
)
"""Text forms of methods with options."""


@st.composite
def light(draw: st.DrawFn, low: float = 0.0, high: float = 1.0) -> np.ndarray:
    """A float32 picture with values of low … high, smooth, noisy, flat or extreme."""
    shape = draw(shapes)
    seed = draw(st.integers(0, 2**32 - 1))
    random = np.random.default_rng(seed)
    kind = draw(st.sampled_from(["noise", "flat", "ramp", "ends"]))
    if kind == "noise":
        picture = random.random(shape)
    elif kind == "flat":
        picture = np.full(shape, random.random())
    elif kind == "ramp":
        picture = np.add.outer(np.linspace(0, 1, shape[0]), np.linspace(0, 1, shape[1])) / 2
    else:
        picture = random.integers(0, 2, shape).astype(float)
    return (low + (high - low) * picture).astype(np.float32)


@st.composite
def ladders(draw: st.DrawFn) -> list[float]:
    """2 … 17 luminances that never fall, at least two of them different; some nearly equal."""
    count = draw(st.integers(2, 17))
    seed = draw(st.integers(0, 2**32 - 1))
    random = np.random.default_rng(seed)
    kind = draw(st.sampled_from(["any", "close", "log", "repeated"]))
    if kind == "close":
        values = 0.5 + np.arange(count) * 1e-6
    elif kind == "log":
        values = 0.01 ** np.linspace(1, 0, count)
    else:
        values = np.sort(random.random(count))
        if kind == "repeated" and count > 2:
            values[1] = values[0]
    values = np.sort(values)
    if np.float32(values[0]) == np.float32(values[-1]):
        values[-1] = values[0] + 0.25
    return [float(v) for v in values]
