"""PackBits and PCL's delta rows: the kernels, their twins, and back."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from devices.errors import ProtocolError
from devices.languages._delta_kernels import delta_rows
from devices.languages.packbits import packed_rows, unpacked
from devices.languages.reader import Reader
from tests.oracle import delta, packbits


@st.composite
def byte_rows(draw):
    """Rows of bytes with runs, noise, blanks and rows alike."""
    n, size = draw(st.integers(1, 9)), draw(st.integers(1, 400))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    rows = rng.integers(0, draw(st.sampled_from([2, 3, 256])), (n, size)).astype(np.uint8)
    kind = draw(st.sampled_from(["noise", "runs", "sparse", "alike"]))
    if kind == "runs":
        rows = np.repeat(rows, rng.integers(1, 200), axis=1)[:, :size]
    elif kind == "sparse":
        rows[rng.random(rows.shape) < 0.99] = 0
    elif kind == "alike":
        rows[1:] = np.where(rng.random(rows[1:].shape) < 0.02, rows[1:], rows[0])
    return np.ascontiguousarray(rows)


def parts(data, starts):
    return [list(data[a:b]) for a, b in pairwise(starts)]


@given(byte_rows(), st.booleans())
def test_packed_rows_are_those_of_the_twin(rows, trim):
    data, starts = packed_rows(rows, trim=trim)
    made = parts(data, starts)
    assert made == [packbits.pack_row(row.tolist(), trim) for row in rows]
    size = rows.shape[1]
    for row, packed in zip(rows, made, strict=True):
        assert len(packed) <= size + -(-size // 128)
        back = unpacked(Reader("a", bytes(packed)), len(packed), size)
        assert back.ljust(size if trim else 0, b"\0") == row.tobytes()
        assert packbits.unpack_row(packed) == list(back)


def kernel_delta(rows, seed):
    n, size = rows.shape
    out = np.empty(n * (size + -(-size // 8)), np.uint8)
    ends = np.zeros(n + 1, np.int64)
    delta_rows(rows, seed, out, ends[1:])
    return parts(out.tolist(), ends)


@given(byte_rows(), st.integers(0, 2**32 - 1))
def test_delta_rows_are_those_of_the_twin(rows, number):
    size = rows.shape[1]
    seed = np.random.default_rng(number).integers(0, 2, size).astype(np.uint8)
    before = seed.tolist()
    for row, made in zip(rows.tolist(), kernel_delta(rows, seed), strict=True):
        assert made == delta.delta_row(row, before)
        assert len(made) <= size + -(-size // 8)
        assert delta.undelta_row(made, before) == row
        before = row


@pytest.mark.parametrize("skip", [0, 30, 31, 32, 285, 286, 287, 541, 1000])
def test_delta_rows_leave_any_number_of_bytes(skip):
    row = np.zeros((1, skip + 9), np.uint8)
    row[0, skip:] = 7
    (made,) = kernel_delta(row, np.zeros(skip + 9, np.uint8))
    assert made == delta.delta_row(row[0].tolist(), [0] * (skip + 9))
    assert delta.undelta_row(made, [0] * (skip + 9)) == row[0].tolist()


def test_known_packets():
    """The example of Brother's raster command reference for the QL-800, page 32."""
    row = bytes(20) + bytes.fromhex("22 22 23 BA BF A2 22 2B")
    data, _ = packed_rows(np.frombuffer(row, np.uint8).reshape(1, -1))
    assert data == bytes.fromhex("ED 00 FF 22 05 23 BA BF A2 22 2B")


@pytest.mark.parametrize(
    ("packed", "offset"),
    [("00 01 05 01 02", 4), ("81", 2), ("00 00 80 FE 07", 5), ("04 00 00 00 00 00", 2)],
)
def test_a_wrong_packet_is_named_by_its_offset(packed, offset):
    data = b"ab" + bytes.fromhex(packed)
    with pytest.raises(ProtocolError) as caught:
        unpacked(Reader("a", data, 2), len(data) - 2, 3)
    assert caught.value.offset == offset
