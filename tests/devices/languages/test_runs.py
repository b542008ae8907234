"""The line compression of the raster languages: the kernels are their slow twins, bit for bit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from devices.languages._runs_kernels import FULL, LINES, LONG, MORE, pack_lines, unpack_lines
from devices.languages.runs import blank_lines, longest_line
from tests.oracle import runs as slow


@st.composite
def lines(draw):
    """Rows of bytes with runs, literals longer than 128, and equal neighbours."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    size, height = draw(st.integers(1, 400)), draw(st.integers(1, 4))
    rows = rng.integers(0, draw(st.sampled_from([2, 3, 256])), (height, size)).astype(np.uint8)
    if draw(st.booleans()):
        rows = np.repeat(rows, rng.integers(1, 200), axis=1)[:, :size]
    times = rng.integers(1, draw(st.sampled_from([2, 5, 300])), height)
    return np.ascontiguousarray(np.repeat(rows, times, axis=0))


def packed(rows, cuts=()):
    """The kernel's lines, given the rows in bands."""
    size = rows.shape[1]
    last, state, made = np.empty(size, np.uint8), np.zeros(3, np.int64), b""
    bands = [band for band in np.split(rows, sorted(c for c in cuts if c <= len(rows))) if len(band)]
    for number, band in enumerate(bands):
        room = (len(band) + 1) * (size + size // 128 + 2)
        out = np.full(room, 0xAA, np.uint8)
        pack_lines(band, last, out, state, int(number == len(bands) - 1))
        assert state[1] <= room
        assert (out[state[1] :] == 0xAA).all()
        made += out[: state[1]].tobytes()
    return made


def unpacked(data, height, size, unit, paper):
    """The kernel's rows, or ValueError as its twin raises it; what lies around them is not touched."""
    around = np.full((height + 2, size), 0xAA, np.uint8)
    state = np.zeros(5, np.int64)
    line = np.zeros(size, np.uint8)
    unpack_lines(np.frombuffer(data, np.uint8), around[1:-1], line, state, unit, paper, height)
    assert (around[[0, -1]] == 0xAA).all()
    why = int(state[3])
    if why == FULL:
        return [row.tobytes() for row in around[1:-1]], int(state[0])
    raise ValueError(
        {MORE: "more", LONG: "long", LINES: "lines"}[why], len(data) if why == MORE else int(state[4])
    )


def attempt(function, *arguments):
    """What it returns, or what is wrong and where."""
    try:
        return function(*arguments)
    except ValueError as error:
        return error.args


@given(lines(), st.lists(st.integers(1, 500), max_size=4))
def test_packing_is_the_twin_for_any_cut(rows, cuts):
    assert packed(rows, cuts) == slow.pack_lines(rows.tolist())


@given(lines())
def test_unpacking_is_the_inverse(rows):
    data = packed(rows)
    assert len(data) <= len(rows) * longest_line(rows.shape[1])
    got, place = unpacked(data, len(rows), rows.shape[1], 1, 0)
    assert place == len(data)
    assert b"".join(got) == rows.tobytes()


@given(
    st.lists(st.sampled_from([0, 1, 2, 3, 127, 128, 129, 253, 254, 255]) | st.integers(0, 255)),
    st.integers(1, 40),
    st.integers(1, 12),
    st.sampled_from([1, 2, 3]),
)
def test_unpacking_any_bytes_is_the_twin(data, height, units, unit):
    data = bytes(data)
    arguments = data, height, units * unit, unit, 255
    assert attempt(unpacked, *arguments) == attempt(slow.unpack_lines, *arguments)


@pytest.mark.parametrize(
    ("line", "packets"),
    [
        (b"a", b"\0a"),
        (b"aa", b"\1a"),
        (b"ab", b"\xffab"),
        (b"abb", b"\xfeabb"),
        (b"abbb", b"\0a\2b"),
        (b"a" * 129, b"\x7fa\0a"),
        (bytes(range(129)), b"\x81" + bytes(range(128)) + b"\0\x80"),
    ],
)
def test_packets(line, packets):
    assert packed(np.frombuffer(line, np.uint8)[None]) == b"\0" + packets


def test_the_worst_line_takes_its_length_and_one_more_for_every_128():
    for size in range(1, 11):
        for number in range(1 << size):
            line = [number >> k & 1 for k in range(size)]
            assert len(slow.pack_line(line)) <= size + 1
    rng = np.random.default_rng(0)
    for _ in range(300):
        blocks = rng.choice([1, 1, 2, 3, 126, 127, 128, 129], 6)
        parts = [np.full(n, n) if rng.random() < 0.5 else np.arange(n) for n in blocks]
        line = np.concatenate(parts).astype(np.uint8)
        assert len(packed(line[None])) <= 1 + line.size + line.size // 128 + 1


def test_no_packet_128():
    """Readers differ on what it is."""
    for n in range(1, 400):
        row = np.arange(n, dtype=np.uint8)[None]
        assert slow.unpack_lines(packed(row), 1, n, 1, 0xAA)[0][0] == row.tobytes()


@given(st.integers(0, 1000), st.integers(1, 300), st.sampled_from([0, 255]))
def test_blank_lines(count, size, paper):
    got, place = slow.unpack_lines(blank_lines(count, size, paper), count, size, 1, 0xAA)
    assert place == len(blank_lines(count, size, paper))
    assert got == [bytes([paper]) * size] * count
