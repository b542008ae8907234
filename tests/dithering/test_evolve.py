"""The kernel that evolves class matrices, against its slow twin."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from halftone.dithering._dots_kernels import diffuse_flats
from halftone.dithering.evolve import AROUND
from tests.oracle.dots import diffuse_flats as twin


@given(st.integers(3, 9), st.integers(0, 99))
def test_the_evolving_kernel_equals_its_twin(side, seed):
    classes = np.random.default_rng(seed).permutation(side * side).reshape(side, side)
    tones = np.linspace(0, 1, 17, dtype=np.float32)
    y, x = np.divmod(np.arange(side * side), side)
    near = np.stack([((y + dy) % side) * side + (x + dx) % side for dy, dx in AROUND], axis=1)
    share = np.zeros((side * side, tones.size), np.float32)
    lit = np.zeros(share.shape, np.uint8)
    order = np.argsort(classes, axis=None)
    diffuse_flats(order, classes.ravel().astype(np.int64), np.ascontiguousarray(near), tones, share, lit)
    np.testing.assert_array_equal(lit, twin(classes, tones))
