"""halftone.packing against a plain twin: every bit in its place, and back again."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halftone.errors import UsageError
from halftone.frame import Frame
from halftone.packing import Packing, bytes_per_row, pack, unpack
from halftone.tone.levels import Levels
from tests.images.strategies import packings, sizes
from tests.oracle.packing import pack_row, unpack_row

Spec = tuple[int, str, tuple[int, ...] | None]


def _indices(spec: Spec, size: tuple[int, int], seed: int) -> np.ndarray:
    count = 1 << spec[0] if spec[2] is None else len(spec[2])
    return np.random.default_rng(seed).integers(0, count, size, np.uint8)


@given(packings(), sizes, st.integers(0, 2**32 - 1))
def test_packs_as_the_plain_twin_and_back(spec: Spec, size: tuple[int, int], seed: int) -> None:
    indices = _indices(spec, size, seed)
    before = indices.copy()
    packed = pack(indices, Packing(*spec))
    assert packed.dtype == np.uint8
    assert packed.shape == (size[0], bytes_per_row(size[1], spec[0]))
    assert packed.flags.c_contiguous
    assert packed.tolist() == [pack_row(row, *spec) for row in indices.tolist()]
    assert [unpack_row(row, size[1], *spec) for row in packed.tolist()] == indices.tolist()
    assert np.array_equal(unpack(packed, size[1], Packing(*spec)), indices)
    assert np.array_equal(indices, before)


@given(packings(), sizes, st.integers(0, 2**32 - 1))
def test_bits_after_the_last_pixel_are_0(spec: Spec, size: tuple[int, int], seed: int) -> None:
    packed = pack(_indices(spec, size, seed), Packing(*spec))
    order = "big" if spec[1] == "msb" else "little"
    stream = np.unpackbits(packed, axis=1, bitorder=order)
    assert not stream[:, size[1] * spec[0] :].any()


@given(packings(), sizes)
def test_packs_views_that_are_not_contiguous(spec: Spec, size: tuple[int, int]) -> None:
    indices = _indices(spec, (2 * size[0], 3 * size[1]), 7)
    view = indices[::-2, ::3]
    packing = Packing(*spec)
    assert np.array_equal(pack(view, packing), pack(view.copy(), packing))
    assert np.array_equal(pack(indices.T, packing), pack(indices.T.copy(), packing))


@pytest.mark.parametrize(
    ("bits", "order", "codes", "row", "expected"),
    [
        (1, "msb", None, [1, 0, 0, 0, 0, 0, 0, 0, 1], [0x80, 0x80]),
        (1, "lsb", None, [1, 0, 0, 0, 0, 0, 0, 0, 1], [0x01, 0x01]),
        (1, "msb", (1, 0), [0, 1, 1], [0x80]),
        (2, "msb", None, [3, 0, 1, 2, 1], [0xC6, 0x40]),
        (2, "lsb", None, [3, 0, 1, 2, 1], [0x93, 0x01]),
        (4, "msb", None, [1, 2, 3], [0x12, 0x30]),
        (4, "lsb", None, [1, 2, 3], [0x21, 0x03]),
        (8, "msb", (7, 200), [1, 0], [200, 7]),
    ],
)
def test_by_hand(
    bits: int, order: str, codes: tuple[int, ...] | None, row: list[int], expected: list[int]
) -> None:
    assert pack(np.array([row], np.uint8), Packing(bits, order, codes)).tolist() == [expected]


@pytest.mark.parametrize(
    ("args", "word"),
    [
        ((3,), "3"),
        ((16,), "16"),
        ((0,), "0"),
        ((1, "big"), "'big'"),
        ((1, "msb", (0, 2)), "2"),
        ((4, "msb", (0, -1)), "-1"),
        ((2, "msb", (1, 2, 1)), "twice"),
    ],
)
def test_packings_that_are_none(args: tuple, word: str) -> None:
    with pytest.raises(UsageError) as caught:
        Packing(*args)
    assert word in str(caught.value)


@pytest.mark.parametrize(
    ("packing", "index"),
    [(Packing(1), 2), (Packing(2), 4), (Packing(4), 16), (Packing(2, "msb", (3, 0)), 2)],
)
def test_a_level_that_does_not_fit(packing: Packing, index: int) -> None:
    with pytest.raises(UsageError, match=f"level {index}"):
        pack(np.array([[0, index]], np.uint8), packing)
    frame = Frame(np.array([[0, index]], np.uint8), Levels.of(2), packing=packing)
    with pytest.raises(UsageError, match=f"level {index}"):
        frame.packed()  # anybody may make a frame: its indices are looked at


def test_unpack_refuses_wrong_widths_and_strange_codes() -> None:
    rows = np.array([[0b0001_1011]], np.uint8)
    assert unpack(rows, 4, Packing(2)).tolist() == [[0, 1, 2, 3]]
    for width in (0, 5, 40):
        with pytest.raises(UsageError, match="bytes"):
            unpack(rows, width, Packing(2))
    with pytest.raises(UsageError, match="code 0"):
        unpack(rows, 4, Packing(2, "msb", (3, 2, 1)))


def test_a_frame_packs_as_its_device_wants() -> None:
    indices = np.array([[0, 1, 1]], np.uint8)
    assert Frame(indices, Levels.of(2)).packed().tolist() == [[0b0110_0000]]
    device = Frame(indices, Levels.of(2), packing=Packing(1, "lsb", (1, 0)))
    assert device.packed().tolist() == [[0b001]]
    assert device.packed(Packing(8)).tolist() == [[0, 1, 1]]
