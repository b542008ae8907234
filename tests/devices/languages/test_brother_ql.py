"""Brother QL: what is written is read back; wrong streams are named by offset."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from devices.errors import ProtocolError
from devices.languages.base import Page
from devices.languages.brother_ql import MEDIA, BrotherQl
from halftone.errors import UsageError
from halftone.tone.levels import Levels
from tests.devices.languages import contract

DPI = (300.0, 300.0)
options = st.sampled_from([("12", 720), ("12", 1296), ("12x12", 720), ("12x12", 1296)])
coders = st.builds(
    lambda media, compress, cutter, margin: BrotherQl(
        media[0], media[1], compress=compress, cutter=cutter, margin=margin
    ),
    options, st.booleans(), st.booleans(), st.integers(0, 1500),
)  # fmt: skip


def widened(language, picture):
    """*picture* on the whole width of the media, with paper to its right."""
    width = MEDIA[tuple(map(int, language.media.split("x"))) if "x" in language.media else (12, 0)].dots
    whole = np.ones((len(picture), width), np.uint8)
    whole[:, : picture.shape[1]] = picture
    return whole


@given(coders, contract.pictures(), st.lists(st.integers(0, 40)))
def test_round_trip(language, picture, split):
    whole = widened(language, picture)
    contract.check_round_trip(language, whole, split, dpi=DPI)
    contract.check_rows_are_counted(language, picture, dpi=DPI)
    (frame,) = language.decode(contract.stream(language, picture, dpi=DPI))
    np.testing.assert_array_equal(frame.indices, whole)


@given(coders, contract.pictures(), st.floats(0, 1))
def test_abort(language, picture, at):
    contract.check_abort(language, widened(language, picture), at, dpi=DPI)


@settings(max_examples=10)
@given(st.booleans(), st.floats(0, 1), st.integers(0, 2**32 - 1))
def test_abort_among_many_pieces(compress, at, seed):
    picture = np.random.default_rng(seed).integers(0, 2, (700, 696)).astype(np.uint8)
    language = BrotherQl(compress=compress)
    assert len(contract.pieces(language, picture, dpi=DPI)) > 3
    assert max(len(piece.data) for piece in contract.pieces(language, picture, dpi=DPI)) < 1 << 15
    contract.check_abort(language, picture, at, dpi=DPI)


@settings(max_examples=20)
@given(coders, contract.pictures(), st.integers(0, 2**32 - 1))
def test_damaged(language, picture, seed):
    rng = np.random.default_rng(seed)
    data = contract.stream(language, picture, dpi=DPI)
    for _ in range(100):
        contract.check_damaged(language, data, rng)


@pytest.mark.parametrize("media", MEDIA)
@pytest.mark.parametrize("dpi", [DPI, (300.0, 600.0)])
def test_every_media(media, dpi):
    name = f"{media[0]}x{media[1]}" if media[1] else str(media[0])
    window = MEDIA[media]
    picture = np.random.default_rng(3).integers(0, 2, (window.rows or 9, window.dots)).astype(np.uint8)
    for pins in (720, 1296) if media[0] < 102 else (1296,):
        language = BrotherQl(name, pins)
        contract.check_round_trip(language, picture, dpi=dpi)
        (frame,) = language.decode(contract.stream(language, picture, dpi=dpi))
        assert frame.dpi == dpi
        assert frame.report["media"] == media


def test_the_bytes_of_a_small_page():
    """The order is that of Brother's reference: clear, reset, then what belongs to each page."""
    picture = np.ones((2, 696), np.uint8)
    picture[0, 0] = picture[1, 695] = 0
    page = (
        "1b6961 01 1b697a ce0a3e00 02000000 0000 1b694d 40 1b6941 01 1b694b 08 1b6964 2300"
        + "67005a" + "00" * 88 + "1000"  # the left edge is pin 707, sent last but 12
        + "67005a" + "0008" + "00" * 88
    )  # fmt: skip
    other = page.replace("02000000 0000", "02000000 0100")
    data = contract.stream(BrotherQl(), picture, picture, dpi=DPI, cut=True)
    assert data.hex() == ("00" * 400 + "1b40" + page + "0c" + other + "1a").replace(" ", "")


def test_pages_are_ended_by_form_feeds_and_the_last_by_sub():
    pictures = [np.full((n, 106), n % 2, np.uint8) for n in (1, 2, 3)]
    made = contract.pieces(BrotherQl("12"), *pictures, dpi=DPI)
    assert [piece.data[-1:] for piece in made] == [b"\x0c", b"\x0c", b"\x1a"]
    frames = BrotherQl.decode(b"".join(piece.data for piece in made))
    assert [len(frame.indices) for frame in frames] == [1, 2, 3]


def test_compressed_rows_are_shorter():
    picture = np.ones((50, 696), np.uint8)
    picture[:, 100:300] = 0
    plain = contract.stream(BrotherQl(), picture, dpi=DPI)
    packed = contract.stream(BrotherQl(compress=True), picture, dpi=DPI)
    assert len(plain) > 50 * 93
    assert len(packed) < 50 * 17 + 500


def test_a_cancelled_page_says_so():
    made = contract.pieces(BrotherQl(), np.zeros((400, 696), np.uint8), dpi=DPI)
    (frame,) = BrotherQl.decode(made[0].data + made[0].close())
    assert frame.report["cancelled"]
    assert len(frame.indices) == made[0].rows


@pytest.mark.parametrize(
    "given",
    [
        {"media": "63"},
        {"media": "62x"},
        {"media": "-62"},
        {"media": "29x91"},
        {"media": "102"},
        {"pins": 721},
        {"cut_every": 0},
        {"margin": -1},
        {"invalidate": 100},
    ],
)
def test_what_is_no_option_is_refused(given):
    with pytest.raises(UsageError, match="allowed|needs"):
        BrotherQl(**given)


@pytest.mark.parametrize(
    ("language", "shape", "page"),
    [
        (BrotherQl(), (1, 697), {}),
        (BrotherQl(), (11_812, 8), {}),
        (BrotherQl("62x29"), (272, 8), {}),
        (BrotherQl(), (1, 8), {"copies": 2}),
        (BrotherQl(), (1, 8), {"density": 2}),
        (BrotherQl(), (1, 8), {"dpi": (203.0, 203.0)}),
        (BrotherQl(cutter=False), (1, 8), {"cut": True}),
        (BrotherQl(cutter=False), (1, 8), {"dpi": (300.0, 600.0)}),
    ],
)
def test_a_page_that_cannot_be_printed_is_refused(language, shape, page):
    with pytest.raises(UsageError):
        contract.stream(language, np.ones(shape, np.uint8), **{"dpi": DPI, **page})


PAGE = bytes.fromhex("1b697a 8e0a0c00 01000000 0000")
ROW = b"g\0\x5a" + bytes(90)


@pytest.mark.parametrize(
    "marked",
    [
        b"|A",
        b"\x1b|",
        b"|\x1bX",
        b"|\x1bi?",
        b"\x1bia|\x00",
        b"\x1biM|\x80",
        b"\x1biA|\x00",
        b"\x1biK|\x01",
        b"\x1biz|\x01\x0a\x0c\0\1\0\0\0\0\0",
        b"\x1biz\x8e|\x0d\x0c\0\1\0\0\0\0\0",
        b"\x1biz\x8e\x0a\x0c\0|\0\0\0\0\0\0",
        b"\x1biz\x8e\x0a\x0c\0|\0\0\0\1\0\0",
        b"\x1biz\x8e\x0a\x0c\0\1\0\0\0|\2\0",
        b"\x1biz\x8e\x0a\x0c\0\1\0\0\0\0|\1",
        b"\x1biz\x8e\x0a\x0c\0\1\0|",
        b"|g",
        b"|\x1a",
        b"M|\x01",
        PAGE + b"|\x1a",
        PAGE + b"|",
        PAGE + b"|\x1b@",
        PAGE + b"|w\x01\x5a" + bytes(90),
        PAGE + b"|Z\x1a",
        PAGE + b"g|\x01\x5a",
        PAGE + b"g\0|\0",
        PAGE + b"g\0\x5a" + bytes(89) + b"|",
        PAGE + b"|g\0\xff" + bytes(255) + b"\x1a",
        PAGE + b"M\x02|g\0\x02\xa8\0\x1a",
        PAGE + b"M\x02g\0\x02|\x05\0\x1a",
        PAGE + ROW + b"|" + ROW + b"\x1a",
        PAGE + ROW + b"|" + PAGE + b"\x1a",
        PAGE + ROW + b"\x0c|",
        PAGE + b"g\0\x5a" + b"\xff" * 90 + b"|\x1a",
        PAGE.replace(b"\x01\0\0\0\0\0", b"\x02\0\0\0\0\0") + ROW + b"|g\0\xa2" + bytes(162) + b"\x1a",
    ],
)
def test_the_offset_of_what_is_wrong(marked):
    with pytest.raises(ProtocolError) as caught:
        BrotherQl.decode(marked.replace(b"|", b"", 1), 1 << 20)
    assert caught.value.offset == marked.index(b"|")


def test_blank_rows_are_read_where_rows_are_compressed():
    page = PAGE.replace(b"\x01\0\0\0", b"\x03\0\0\0")
    (frame,) = BrotherQl.decode(page + b"M\x02Zg\0\x02\xa7\0Z\x1a")
    assert frame.shape == (3, 106)
    assert frame.indices.min() == 1


def test_a_metre_of_a_roll_takes_the_memory_of_a_band():
    taken = 0

    def bands():
        nonlocal taken
        for _ in range(11_811):
            taken += 1
            yield np.full((1, 87), 0xA5, np.uint8)

    page = Page(696, 11_811, bands(), Levels.of(2), DPI)
    contract.stream(
        BrotherQl(compress=True), np.eye(9, dtype=np.uint8), dpi=DPI
    )  # the kernel is loaded now
    tracemalloc.start()
    try:
        sent = 0
        for piece in BrotherQl(compress=True).encode([page]):
            sent += piece.rows
            assert taken <= sent + 400
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert sent == 11_811
    assert peak < 1 << 21
