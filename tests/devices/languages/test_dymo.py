"""DYMO LabelWriter: what is written is read back; wrong streams are named by offset."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from devices.errors import ProtocolError
from devices.languages.dymo import CLEAR, Dymo
from devices.status import Status
from halftone.errors import UsageError
from tests.devices.languages import contract

coders = st.builds(
    Dymo, length=st.sampled_from([0, 40, 3058]), graphics=st.booleans(), roll=st.integers(0, 2)
)


def filled(picture):
    """*picture* with paper to its right, up to a whole byte."""
    return np.pad(picture, ((0, 0), (0, -picture.shape[1] % 8)), constant_values=1)


@given(coders, contract.pictures(), st.lists(st.integers(0, 40)))
def test_round_trip(language, picture, split):
    contract.check_round_trip(language, filled(picture), split)
    contract.check_rows_are_counted(language, picture)
    (frame,) = language.decode(contract.stream(language, picture))
    np.testing.assert_array_equal(frame.indices, filled(picture))


@given(coders, contract.pictures(), st.floats(0, 1))
def test_abort(language, picture, at):
    contract.check_abort(language, filled(picture), at)


@settings(max_examples=10)
@given(st.floats(0, 1), st.integers(0, 2**32 - 1))
def test_abort_among_many_pieces(at, seed):
    picture = np.random.default_rng(seed).integers(0, 2, (900, 672)).astype(np.uint8)
    assert len(contract.pieces(Dymo(), picture)) > 3
    contract.check_abort(Dymo(), picture, at)


@settings(max_examples=20)
@given(coders, contract.pictures(), st.integers(0, 2**32 - 1))
def test_damaged(language, picture, seed):
    rng = np.random.default_rng(seed)
    data = contract.stream(language, picture)
    for _ in range(100):
        contract.check_damaged(language, data, rng)


def test_the_bytes_of_a_job():
    """Short form feeds between labels, a long one after the last."""
    picture = np.zeros((2, 9), np.uint8)
    begin = b"\x1bL\x0b\xf2\x1bB\0\x1bD\x02\x1bi\x1bg\x1bq2"
    rows = b"\x16\xff\x80\x16\xff\x80"
    data = contract.stream(Dymo(roll=2), picture, picture, density=4)
    assert data == CLEAR + begin + rows + b"\x1bG" + begin + rows + b"\x1bE"
    frames = Dymo.decode(data)
    assert [frame.report["density"] for frame in frames] == [4, 4]
    assert contract.stream(Dymo(length=0), picture)[len(CLEAR) :].startswith(b"\x1bL\xff\xff")


def test_what_is_no_option_is_refused():
    for options in ({"dots": 0}, {"length": -1}, {"roll": 3}):
        with pytest.raises(UsageError, match="allowed"):
            Dymo(**options)


@pytest.mark.parametrize(
    ("shape", "page"),
    [
        ((1, 673), {}),
        ((3059, 8), {}),
        ((1, 8), {"copies": 2}),
        ((1, 8), {"cut": True}),
        ((1, 8), {"density": 5}),
    ],
)
def test_a_page_that_cannot_be_printed_is_refused(shape, page):
    with pytest.raises(UsageError):
        contract.stream(Dymo(), np.ones(shape, np.uint8), **page)


def test_tabs_and_skipped_rows_move_the_dots():
    (frame,) = Dymo.decode(b"\x1bD\1\x1bz\x1bf\1\2\x16\xf0\x1bB\1\x16\x0f\x1bE")
    shown = ["".join(".#"[1 - dot] for dot in row) for row in frame.indices]
    assert shown == ["." * 16, "." * 16, "####" + "." * 12, "." * 12 + "####"]
    assert frame.dpi == (300.0, 203.0)


@pytest.mark.parametrize(
    "marked",
    [
        b"|A",
        b"\x1b|",
        b"|\x1bX",
        b"\x1b\x1b\x1b|A",
        b"\x1bD|\0",
        b"\x1bq|3",
        b"\x1bf|\2\1",
        b"\x1bf\1|",
        b"\x1bL\1|",
        b"|\x1bE",
        b"|\x17\xff",
        b"\x16" + bytes(83) + b"|",
        b"\x16" + bytes(84) + b"|",
        b"\x16" + bytes(84) + b"|\x1b@",
        b"\x1bD\xff" + b"\x1bf\1\xff" * 2 + b"|\x1bf\1\xff",
    ],
)
def test_the_offset_of_what_is_wrong(marked):
    with pytest.raises(ProtocolError) as caught:
        Dymo.decode(marked.replace(b"|", b"", 1), 1 << 20)
    assert caught.value.offset == marked.index(b"|")


@pytest.mark.parametrize(
    ("reply", "status"),
    [
        (b"", None),
        (b"\x1c", None),
        (b"\x03", Status()),
        (b"\x01", Status()),
        (b"\xa1", Status.of("media-empty-error")),
        (b"\xc1", Status.of("media-jam-error")),
        (b"\x81", Status.of("other-error")),
        (b"\x10\x21", Status.of("media-empty-error")),
    ],
)
def test_status(reply, status):
    assert Dymo().parse_status(reply) == status
