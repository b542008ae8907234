"""TSPL as a language."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from devices.errors import ProtocolError
from devices.languages.tspl import Tspl
from devices.status import Status
from halftone.errors import UsageError
from tests.devices.languages import contract

dialects = st.builds(Tspl, speed=st.integers(0, 18), media=st.sampled_from(["", "continuous"]))


@given(dialects, contract.pictures(), st.lists(st.integers(0, 40)))
def test_round_trip(tspl, picture, split):
    contract.check_round_trip(tspl, picture, split)
    contract.check_rows_are_counted(tspl, picture)


@settings(max_examples=200)
@given(dialects, contract.pictures(), st.floats(0, 1))
def test_abort(tspl, picture, at):
    contract.check_abort(tspl, picture, at)


@settings(max_examples=20)
@given(dialects, contract.pictures(), st.integers(0, 2**32 - 1))
def test_damaged(tspl, picture, seed):
    rng = np.random.default_rng(seed)
    data = contract.stream(tspl, picture)
    for _ in range(100):
        contract.check_damaged(tspl, data, rng)


def test_the_bytes():
    picture = np.ones((2, 10), np.uint8)
    picture[1] = 0
    tspl = Tspl("mm", speed=4, media="continuous")
    data = contract.stream(tspl, picture, dpi=(203.2, 203.2), copies=3, density=9, cut=True)
    assert data == (
        b"SIZE 1.25 mm,0.25 mm\r\nGAP 0 mm,0 mm\r\nDIRECTION 1,0\r\nREFERENCE 0,0\r\nSPEED 4\r\n"
        b"DENSITY 9\r\nSET CUTTER 1\r\nCLS\r\nBITMAP 0,0,2,2,0,\xff\xff\x00\x3f\r\nPRINT 1,3\r\n"
    )
    (frame,) = Tspl.decode(data)
    assert frame.shape == (2, 16)
    assert (frame.indices[:, :10] == picture).all()
    assert frame.report.items() >= {"copies": 3, "density": 9, "speed": 4}.items()


def test_a_tall_picture_is_in_several_bitmaps():
    picture = np.random.default_rng(1).integers(0, 2, (2000, 576)).astype(np.uint8)
    made = contract.pieces(Tspl(), picture)
    assert [piece.rows for piece in made] == [0, 910, 910, 180, 0]
    (frame,) = Tspl.decode(b"".join(piece.data for piece in made))
    np.testing.assert_array_equal(frame.indices, picture)


@pytest.mark.parametrize(
    ("tspl", "shape", "more", "named"),
    [
        (Tspl(), (1, 8), {"density": 16}, "density.*0 … 15"),
        (Tspl(), (32_001, 1), {}, "height"),
        (Tspl("mm"), (1, 8), {"dpi": None}, "needs the page's dpi"),
    ],
)
def test_pages_that_do_not_fit(tspl, shape, more, named):
    with pytest.raises(UsageError, match=named):
        contract.stream(tspl, np.ones(shape, np.uint8), **more)


@pytest.mark.parametrize("options", [{"unit": "inch"}, {"media": "gap"}, {"speed": 19}])
def test_wrong_options(options):
    with pytest.raises(UsageError, match="tspl"):
        Tspl(**options)


START = b"SIZE 8 dot,2 dot\r\nCLS\r\n"


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (b"|", "command expected"),
        (b"|CLS", "ends with its line"),
        (b"|TEXT 1\r\n", "unknown command"),
        (b"|SIZE 8\r\n", "parameters"),
        (b"|DENSITY 16\r\n", "parameters"),
        (START + b"|PRINT 1\r\n", "without a bitmap"),
        (START + b"BITMAP| 0,0,1,1,2,x", "mode 0 or 1"),
        (START + b"BITMAP 0,0,|0,1,0,x", "without dots"),
        (START + b"BITMAP 0,0,1,2,0,x|", "2 bytes expected, 1 left"),
        (START + b"|BITMAP 0,1,1,2,0,xx\r\nPRINT 1\r\n", "ink outside"),
        (START + b"|BITMAP 8,0,1,2,0,xx\r\nPRINT 1\r\n", "ink outside"),
        (START + b"BITMAP 0,0,1,1,0,x\r\n|PRINT 0\r\n", "0 copies"),
    ],
)
def test_the_offset_of_what_is_wrong(data, what):
    """The bar stands where the fault is, and is taken out."""
    with pytest.raises(ProtocolError, match=what) as caught:
        Tspl.decode(data.replace(b"|", b""))
    assert caught.value.offset == data.index(b"|")


def test_a_label_stays_until_it_is_cleared_and_modes_overlay():
    data = START + b"BITMAP 0,0,1,2,0,\x0f\xff\r\nPRINT 1\r\nBITMAP 0,0,1,1,1,\xf0PRINT 2,2\r\n"
    frames = Tspl.decode(data + b"BITMAP 3,0,1,1,0,\xf7PRINT 1\r\nCLS\r\nBITMAP 0,0,1,1,0,\0PRINT 1\r\n")
    assert [frame.report["copies"] for frame in frames] == [1, 4, 1, 1]
    rows = ["".join("#."[v] for v in frame.indices[0]) for frame in frames]
    assert rows == ["####....", "########", "###....#", "########"]


def test_declared_sizes_are_checked_first():
    with pytest.raises(ProtocolError, match="pixels"):
        Tspl.decode(START + b"BITMAP 0,0,60000,60000,0,", 1 << 16)
    with pytest.raises(ProtocolError, match="pixels"):
        Tspl.decode(b"SIZE 60000 dot,60000 dot\r\nBITMAP 0,0,1,1,0,xPRINT 1\r\n", 1 << 16)


@pytest.mark.parametrize(
    ("reply", "reasons"),
    [
        (b"\x00", set()),
        (b"\x20", set()),
        (b"\x05", {"cover-open-error", "media-empty-error"}),
        (b"\x00\x1a", {"media-jam-error", "marker-supply-empty-error", "paused-error"}),
    ],
)
def test_status(reply, reasons):
    assert Tspl().parse_status(reply) == Status(frozenset(reasons))


def test_no_answer_is_no_status():
    assert Tspl().parse_status(b"") is None
