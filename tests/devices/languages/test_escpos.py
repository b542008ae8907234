"""ESC/POS as a language: round trips, and how a page is cut into commands."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from devices.errors import ProtocolError
from devices.languages import detect, language
from devices.languages.escpos import EscPos
from halftone.errors import UsageError
from tests.devices.languages import contract
from tests.oracle import realtime

COMMANDS = ("raster", "graphics", "column", "dc2")
FINE = st.sampled_from([0, 2, 3, 48])


def calm(picture, command: str, max_rows=240):
    """*picture* (level indices) without real-time commands, as wide as the command can state."""
    if command in ("raster", "dc2"):
        picture = np.pad(picture, ((0, 0), (0, -picture.shape[1] % 8)), constant_values=1)
    dots = (1 - picture).tolist()
    heights = [min(max_rows, len(dots) - top) for top in range(0, len(dots), max_rows)]
    if command == "column":
        done = realtime.calm_columns(dots, 0)
    else:
        done = realtime.calm_rows(dots, heights, len(picture[0]) // 8 if command == "dc2" else 0)
    return 1 - np.array(done, np.uint8)


@pytest.mark.parametrize("command", COMMANDS)
@given(
    picture=contract.pictures(),
    split=st.lists(st.integers(0, 40)),
    cut=st.booleans(),
    feed=st.sampled_from([0, 1, 16, 255, 600]),
    most=st.integers(1, 40),
)
def test_round_trip(command, picture, split, cut, feed, most):
    most = max(most, 24) if command == "column" else most
    picture = calm(picture, command, most)
    escpos = EscPos(command=command, feed=feed, max_rows=most)
    data = contract.check_round_trip(escpos, picture, split, cut=cut)
    contract.check_rows_are_counted(escpos, picture)
    assert detect(data) == "escpos"
    (frame,) = escpos.decode(data)
    assert frame.report["feed"] == feed
    assert frame.report["cut"] == ("partial" if cut else None)


@pytest.mark.parametrize("command", COMMANDS)
@given(picture=contract.pictures(), at=st.floats(0, 1), cut=st.booleans())
def test_abort(command, picture, at, cut):
    escpos = EscPos(command=command, max_rows=24)
    contract.check_abort(escpos, calm(picture, command, 24), at, cut=cut)


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("cut", [False, True])
def test_how_a_page_ends_and_how_a_broken_one(command, cut):
    made = contract.pieces(EscPos(command=command, feed=300), np.zeros((50, 16), np.uint8), cut=cut)
    restored = b"\x1b2" if command == "column" else b""
    end = restored + b"\x1bJ\xff\x1bJ\x2d" + (b"\x1dV\x01" if cut else b"")
    ready = restored + b"\x1b@"
    assert made[-1].data == end
    assert made[-1].close() == made[0].close() == ready
    printed = b"\x1d(L\x02\x0002" if command == "graphics" else b""
    assert made[1].close() == printed + end + ready
    assert made[-2].close() == end + ready


@pytest.mark.parametrize("command", COMMANDS)
@settings(max_examples=20)
@given(picture=contract.pictures(), seed=st.integers(0, 2**32 - 1))
def test_damaged(command, picture, seed):
    rng = np.random.default_rng(seed)
    escpos = EscPos(command=command, auto_status=True, density_command="gs-k")
    data = contract.stream(escpos, picture, picture, cut=True, density=-3)
    for _ in range(100):
        contract.check_damaged(escpos, data, rng)


@given(st.binary(max_size=40))
def test_any_bytes(data):
    try:
        EscPos.decode(data)
    except ProtocolError as error:
        assert 0 <= error.offset <= len(data)  # noqa: PT017


@pytest.mark.parametrize("command", ["raster", "dc2"])
def test_a_width_in_bytes_gains_paper_to_its_right(command):
    picture = np.zeros((3, 13), np.uint8)
    (frame,) = EscPos.decode(contract.stream(EscPos(command=command), picture))
    assert frame.shape == (3, 16)
    assert not frame.indices[:, :13].any()
    assert frame.indices[:, 13:].all()


@pytest.mark.parametrize("command", COMMANDS)
def test_several_pages(command):
    pages = [np.full((n, 16), n % 2, np.uint8) for n in (1, 30, 255)]
    frames = EscPos.decode(contract.stream(EscPos(command=command), *pages))
    assert [frame.shape for frame in frames] == [page.shape for page in pages]
    together = EscPos.decode(contract.stream(EscPos(command=command, reset=False, feed=0), *pages))
    np.testing.assert_array_equal(together[0].indices, np.concatenate(pages))


@given(
    command=st.sampled_from(["raster", "graphics", "dc2"]),
    height=st.integers(1, 700),
    width=st.integers(1, 200),
    most=st.integers(1, 400),
    limit=st.integers(25, 3000),
    avoid=FINE,
)
def test_commands_keep_within_their_bounds(command, height, width, most, limit, avoid):
    assume(avoid == 0 or most > 1)
    escpos = EscPos(
        command=command, max_rows=most, max_bytes=limit, avoid_rows_multiple_of=avoid, feed=0
    )
    picture = np.ones((height, width), np.uint8)
    pieces = [piece for piece in contract.pieces(escpos, picture) if piece.rows]
    assert sum(piece.rows for piece in pieces) == height
    for piece in pieces:
        assert piece.rows <= min(most, 255 if command == "dc2" else most)
        assert len(piece.data) - piece.head == piece.rows * piece.stride <= limit
        assert not avoid or piece.rows % avoid


@pytest.mark.parametrize("second", [4, 5, 20])
def test_no_header_holds_a_real_time_command(second):
    rows = 0x10 + 256 * second
    picture = np.ones((rows, 8), np.uint8)
    for command in ("raster", "graphics"):
        escpos = EscPos(command=command, max_rows=4095, max_bytes=65_536)
        made = [piece.rows for piece in contract.pieces(escpos, picture) if piece.rows]
        if second == 20:
            assert made[0] <= 4095
        elif command == "raster":
            assert made == [rows // 2, rows // 2]
        assert sum(made) == rows
        assert not realtime.pairs(contract.stream(escpos, picture))
    narrow = np.ones((16, 8 * second), np.uint8)
    made = [piece.rows for piece in contract.pieces(EscPos(command="dc2"), narrow) if piece.rows]
    assert made == [8, 8]
    for command in ("graphics", "column"):
        wide = np.ones((1, 16 + 256 * second), np.uint8)
        with pytest.raises(UsageError, match="real-time|at most 2047"):
            contract.stream(EscPos(command=command), wide)


def test_no_length_is_a_real_time_command():
    made = contract.pieces(EscPos(command="graphics", max_rows=4095), np.ones((0x410 - 10, 8), np.uint8))
    assert [piece.rows for piece in made if piece.rows] == [515, 515]


def test_the_long_form_where_the_length_asks_for_it():
    picture = np.ones((911, 576), np.uint8)
    escpos = EscPos(command="graphics", max_rows=4095, max_bytes=1 << 17)
    assert contract.pieces(escpos, picture[:910])[1].data[:5] == b"\x1d(L\xfa\xff"  # 10 + 72 · 910
    assert contract.pieces(escpos, picture)[1].data[:7] == b"\x1d8L\x42\x00\x01\x00"
    contract.check_round_trip(escpos, picture)


def test_paper_within_the_picture_is_rows():
    picture = np.ones((500, 16), np.uint8)
    picture[[0, -1]] = 0
    data = contract.stream(EscPos(max_rows=100, feed=0), picture)
    assert b"\x1bJ" not in data
    assert b"\x1bd" not in data
    assert data.count(b"\x1dv0\x00") == 5


@pytest.mark.parametrize(
    ("command", "density", "sent"),
    [
        ("gs-k", -1, b"\x1d(K\x02\x00\x31\xff"),
        ("gs-k", 6, b"\x1d(K\x02\x00\x31\x06"),
        ("esc-7", 120, b"\x1b7\x07\x78\x02"),
        ("dc2-hash", 10, b"\x12#\x4a"),
    ],
)
def test_density(command, density, sent):
    data = contract.stream(EscPos(density_command=command), np.ones((1, 8), np.uint8), density=density)
    assert data.startswith(b"\x1b@" + sent + b"\x1dv0")
    assert EscPos.decode(data)[0].report["density"] is not None


@pytest.mark.parametrize(
    ("options", "more", "words"),
    [
        ({"command": "rastr"}, {}, "raster"),
        ({"cut": "half"}, {}, "partial"),
        ({"max_rows": 0}, {}, "1 … 4095"),
        ({"max_bytes": (1 << 20) + 1}, {}, "1048576"),
        ({"avoid_rows_multiple_of": 1}, {}, "avoid_rows_multiple_of"),
        ({"feed": -1}, {}, "feed"),
        ({"max_bytes": 1}, {}, "max_bytes"),
        ({"command": "column", "max_rows": 23}, {}, "24"),
        ({"command": "column", "avoid_rows_multiple_of": 12}, {}, "24"),
        ({}, {"copies": 2}, "copies"),
        ({}, {"density": 2}, "density_command"),
        ({"density_command": "gs-k"}, {"density": 128}, "127"),
        ({"density_command": "esc-7"}, {"density": 2}, "3 … 255"),
        ({"density_command": "dc2-hash"}, {"density": 32}, "0 … 31"),
    ],
)
def test_refused(options, more, words):
    with pytest.raises(UsageError, match=words):
        contract.stream(language("escpos", **options), np.ones((2, 16), np.uint8), **more)


def test_rows_are_read_one_command_at_a_time():
    taken = []

    def rows():
        for y in range(10):
            taken.append(y)
            yield np.zeros((100, 2), np.uint8)

    escpos = EscPos(max_rows=50)
    page = contract.page(escpos, np.ones((1000, 16), np.uint8))
    object.__setattr__(page, "rows", rows())
    seen = [len(taken) for piece in escpos.encode([page]) if piece.rows]
    assert all(later - earlier <= 1 for earlier, later in pairwise(seen))
    assert seen[0] == 1
    assert seen[-1] == 10
