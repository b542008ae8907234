"""The strict reader of ESC/POS: what it allows, and the offset of what it does not."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from devices.errors import ProtocolError
from devices.languages.escpos import EscPos

DOT = b"\x1dv0\x00\x01\x00\x01\x00\x80"
STORE = b"\x1d(L\x0b\x000p0\x01\x011\x01\x00\x01\x00\x80"
PRINT = b"\x1d(L\x02\x0002"
COLUMN = b"\x1b*\x21\x01\x00\x80\x00\x00"


def ink(data: bytes) -> list[list[int]]:
    (frame,) = EscPos.decode(data)
    return (1 - frame.indices).tolist()


@pytest.mark.parametrize(
    ("data", "offset"),
    [
        (b"", 0),
        (b"\x1b@Hello", 2),
        (b"\x1b@\x1b\x69", 2),
        (b"\x1b", 1),
        (b"\x1dv0\x04\x01\x00\x01\x00\x80", 3),
        (b"\x1dv1\x00\x01\x00\x01\x00\x80", 0),
        (b"\x1dv0\x00\x00\x00\x01\x00", 4),
        (b"\x1dv0\x00\x01\x00\x00\x00", 4),
        (b"\x1dv0\x00\xff\xff\xff\xff\x00", 4),
        (DOT[:-1], 8),
        (DOT + b"\x80", 9),
        (STORE + STORE + PRINT, 16),
        (STORE, 16),
        (STORE + b"\x1b@", 16),
        (STORE + DOT + PRINT, 16),
        (PRINT, 0),
        (b"\x1d(L\x03\x0002", 3),
        (b"\x1d(L\x02\x0003", 6),
        (b"\x1d(L\x0c" + STORE[4:] + b"\x00" + PRINT, 3),
        (STORE[:7] + b"1" + STORE[8:], 7),
        (STORE[:8] + b"\x03" + STORE[9:], 8),
        (STORE[:10] + b"2" + STORE[11:], 10),
        (STORE[:15] + b"\x40" + PRINT, 15),
        (b"\x1b*\x02\x01\x00\x00", 2),
        (b"\x1b*\x21\x00\x00", 3),
        (b"\x1b*\x21\x01\x00\x80\x00\x00", 8),
        (b"\x1b*\x21\x01\x00\x80\x00\x00\x1dV\x00", 8),
        (b"\x1b*\x21\x01\x00\x80\x00\x00" + DOT, 8),
        (b"\x12*\x00\x01", 2),
        (b"\x12*\x01\x00", 2),
        (b"\x1dV\x02", 2),
        (b"\x1ba\x03", 2),
        (b"\x1ba\x01" + DOT + b"\x1ba\x00" + DOT, 15),
        (b"\x1ba\x01" + DOT + b"\x1dv0\x00\x02\x00\x01\x00\x80\x80", 12),
        (b"\x1dL\x08\x00" + DOT + b"\x1dL\x00\x00" + DOT, 17),
        (b"\x1b{\x01", 2),
        (b"\x10\x04\x05", 2),
        (b"\x10\x05\x02", 2),
        (b"\x10\x14\x02\x01\x08", 2),
        (b"\x1d(K\x02\x00\x32\x00", 5),
    ],
)
def test_the_offset_of_what_is_wrong(data, offset):
    with pytest.raises(ProtocolError) as caught:
        EscPos.decode(data)
    assert caught.value.offset == offset


@pytest.mark.parametrize(
    ("mode", "expected"),
    [
        (0, [[1, 0, 1]]),
        (1, [[1, 1, 0, 0, 1, 1]]),
        (2, [[1, 0, 1]] * 2),
        (51, [[1, 1, 0, 0, 1, 1]] * 2),
    ],
)
def test_large_dots(mode, expected):
    width = len(expected[0])
    got = ink(b"\x1dv0" + bytes((mode,)) + b"\x01\x00\x01\x00\xa0")
    assert [row[:width] for row in got] == expected
    across, down = 1 + mode % 2, 1 + mode % 48 // 2
    stored = bytes((0x1D, 0x28, 0x4C, 11, 0, 48, 112, 48, across, down, 49, 3, 0, 1, 0, 0xA0))
    assert ink(stored + PRINT) == expected


@pytest.mark.parametrize(("mode", "across", "down"), [(0, 2, 3), (1, 1, 3), (32, 2, 1), (33, 1, 1)])
def test_columns_of_all_kinds(mode, across, down):
    column = [1, 0, 0, 1, 1, 0, 0, 0] + [0] * (16 if down == 1 else 0)
    data = np.packbits(column).tobytes() * 2
    got = ink(b"\x1b*" + bytes((mode, 2, 0)) + data + b"\x1b3\x10\n")
    np.testing.assert_array_equal(got, np.repeat(np.array([column] * 2 * across).T, down, axis=0))


def test_columns_side_by_side():
    one = b"\x1b*\x21\x01\x00"
    got = ink(one + b"\x80\x00\x00" + one + b"\x00\x00\x01\x1bJ\x18")
    assert [sum(row) for row in got] == [1] + [0] * 22 + [1]
    assert got[0] == [1, 0]
    assert got[23] == [0, 1]


@pytest.mark.parametrize(
    ("feed", "rows"),
    [(b"\x1bJ\x01", 1), (b"\x1bJ\x07", 7), (b"\x1bJ\x30", 24), (b"\n", 24), (b"\x1bd\x02", 24)],
)
def test_a_last_band_is_as_high_as_its_feed(feed, rows):
    assert len(ink(COLUMN + feed)) == rows
    (frame,) = EscPos.decode(COLUMN[:-1] + b"\x01" + feed)  # ink in its lowest row
    assert len(frame.indices) == 24
    assert frame.report["feed"] == max(0, {b"\n": 30, b"\x1bd\x02": 60}.get(feed, feed[-1]) - 24)


@pytest.mark.parametrize(
    ("between", "rows"),
    [
        (b"", 0),
        (b"\x1bJ\x05", 5),
        (b"\n", 30),
        (b"\x1b3\x07\n\n", 14),
        (b"\x1b3\x07\x1bd\x03\x1b2", 21),
        (b"\x10\x04\x01\x10\x05\x00\x10\x14\x01\x00\x05", 0),
    ],
)
def test_pictures_below_each_other(between, rows):
    got = ink(b"\n" + DOT + between + DOT + b"\n\x1bJ\x09")
    assert [row[0] for row in got] == [1] + [0] * rows + [1]


@pytest.mark.parametrize(
    ("cut", "name"),
    [(b"\x00", "full"), (b"1", "partial"), (b"A\x03", "full"), (b"B\x00", "partial")],
)
def test_a_cut_ends_a_page(cut, name):
    frames = EscPos.decode(DOT + b"\x1dV" + cut + b"\n" + DOT)
    assert [frame.report["cut"] for frame in frames] == [name, None]
    assert frames[0].report["feed"] == (3 if cut == b"A\x03" else 0)


def test_where_it_lies_is_reported():
    (frame,) = EscPos.decode(b"\x1dL\x10\x01\x1dW\x40\x02\x1ba\x01" + DOT + DOT)
    assert (frame.report["align"], frame.report["left"]) == ("center", 272)
    assert frame.shape == (2, 8)


@pytest.mark.parametrize(
    ("data", "pixels"),
    [
        (DOT + b"\x1dV\x00" + DOT, 16),
        (DOT + b"\x1bJ\x0a" + DOT, 96),
        (STORE + PRINT, 1),
        (b"\x1dv0\x03" + DOT[4:], 32),
        (COLUMN * 4 + b"\n", 96),
        ((COLUMN * 2 + b"\x1bJ\x18") * 2, 96),
        (b"\x1b*\x00" + COLUMN[3:6] + b"\n", 48),
        (b"\x12*\x02\x01\xff\xff", 16),
    ],
)
def test_the_limit_of_pixels(data, pixels):
    assert sum(frame.indices.size for frame in EscPos.decode(data, pixels)) == pixels
    with pytest.raises(ProtocolError, match="pixels"):
        EscPos.decode(data, pixels - 1)


def test_the_limit_is_kept_before_memory_is_taken():
    with pytest.raises(ProtocolError, match="pixels") as caught:
        EscPos.decode(COLUMN * 4 + b"\n", 95)
    assert caught.value.offset == 3 * len(COLUMN) + 3
    fed = DOT + b"\x1b3\xff" + b"\x1bd\xff" * 10_000 + DOT  # 650 million rows of paper
    tracemalloc.start()
    try:
        with pytest.raises(ProtocolError, match="pixels"):
            EscPos.decode(fed)
        assert tracemalloc.get_traced_memory()[1] < 1_000_000
    finally:
        tracemalloc.stop()


def test_many_short_commands_take_time_in_proportion():
    assert len(ink(COLUMN * 20_000 + b"\n")[0]) == 20_000
    assert len(ink(DOT * 20_000)) == 20_000


@pytest.mark.parametrize(
    "head",
    [
        b"^XA^PW8^FS",
        b"\x1bE\x1b&l0E\x1b*r1A",
        b"\x1b%-12345X@PJL\r\n",
        bytes(200) + b"\x1b@\x1bia\x01",
        b"\x1b@\x1bia\x01",
        b"RaS2PwgRaster\0",
        b"\x89PNG\r\n\x1a\n",
        b"P4\n8 1\n\x00",
        b"\n\n\n",
        b"\n",
        b"",
        b"\x1b",
        b"\x1b*rA",
        b"\x1b" * 100 + b"\x1b@",
    ],
)
def test_other_languages_are_not_taken_for_it(head):
    assert not EscPos.sniff(head)


def test_sniff_needs_the_beginning_only():
    data = b"\x1b@\x1dv0\x00\x48\x00\xf0\x00" + bytes(72 * 240)
    for size in (2, 3, 10, 1024, len(data)):
        assert EscPos.sniff(data[:size])
