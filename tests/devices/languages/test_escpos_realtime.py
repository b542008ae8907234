"""Real-time commands that arise in pictures: none is left, and nothing else is changed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import devices.languages.escpos as module
from devices.languages._realtime import harmless
from devices.languages.escpos import EscPos
from tests.devices.languages import contract
from tests.devices.languages.test_escpos import COMMANDS, calm
from tests.devices.simulated_escpos import SimulatedEscPos
from tests.oracle import realtime

BYTES = st.sampled_from([0x10, 0x04, 0x05, 0x14, 0x01, 0x02, 0x08, 0x00, 0xFF, 0x20])


@st.composite
def wild(draw, command):
    """Pictures full of them, in the rows or in the columns."""
    if command == "column":
        width, bands = draw(st.integers(1, 60)), draw(st.integers(1, 3))
        data = draw(st.lists(BYTES, min_size=width * bands * 3, max_size=width * bands * 3))
        bits = np.unpackbits(np.array(data, np.uint8).reshape(bands, width, 3), axis=2)
        dots = bits.transpose(0, 2, 1).reshape(bands * 24, width)
        return np.ascontiguousarray(1 - dots[: draw(st.integers(1, bands * 24))])
    size, height = draw(st.sampled_from([1, 2, 3, 16])), draw(st.integers(1, 40))
    data = draw(st.lists(BYTES, min_size=size * height, max_size=size * height))
    return 1 - np.unpackbits(np.array(data, np.uint8).reshape(height, size), axis=1)


@pytest.mark.parametrize("command", COMMANDS)
@given(data=st.data())
def test_one_dot_moves_by_one_place_for_each(command, data):
    picture = data.draw(wild(command))
    escpos = EscPos(command=command, max_rows=24)
    stream = contract.stream(escpos, picture, cut=True)
    assert not realtime.pairs(stream)
    (frame,) = escpos.decode(stream)
    expected = calm(picture, command, 24)
    np.testing.assert_array_equal(frame.indices, expected)
    # every difference is a dot that has moved to paper: to the left, and in columns upwards
    step = (1, 0) if command == "column" else (0, 1)
    gone = np.argwhere((picture == 0) & (frame.indices == 1))
    come = np.argwhere((picture == 1) & (frame.indices == 0))
    assert {tuple(dot - step) for dot in gone} == {tuple(dot) for dot in come}


@given(st.integers(0, 255), st.lists(BYTES | st.integers(0, 255), min_size=1, max_size=60))
def test_as_byte_by_byte(before, data):
    got = harmless(bytes((0x1D, before)), bytes(data))
    assert list(got) == realtime.calm(before, data)
    assert not realtime.pairs([before, *got])
    changed = [a != b for a, b in zip(data, got, strict=True)]
    assert sum(changed) == len(realtime.pairs([before, *data]))
    for old, new in zip(data, got, strict=True):
        assert old.bit_count() == new.bit_count()


@pytest.mark.parametrize("command", COMMANDS)
@given(data=st.data(), at=st.floats(0, 1))
def test_none_when_broken_off(command, data, at):
    picture = data.draw(wild(command))
    pieces = contract.pieces(EscPos(command=command, max_rows=24), picture)
    place = int(at * (len(pieces) - 1))
    part = int(at * 7919) % len(pieces[place].data)
    sent = b"".join(piece.data for piece in pieces[:place]) + pieces[place].data[:part]
    assert not realtime.pairs(sent + pieces[place].abort(part))


def adversary(command: str) -> np.ndarray:
    """A picture whose data is one real-time command after the other: status, recover, clear, power
    off, drawer, clear."""
    text = bytes.fromhex("100401 100402 100403 100404 100501 100502 1014010105 10140801031401060208")
    text += bytes.fromhex("1014020108")
    data = np.frombuffer((text * 400)[: 72 * 120], np.uint8)
    if command == "column":
        bits = np.unpackbits(data.reshape(5, 576, 3), axis=2)
        return np.ascontiguousarray(1 - bits.transpose(0, 2, 1).reshape(120, 576))
    return 1 - np.unpackbits(data.reshape(120, 72), axis=1)


def printed(command: str, picture, lag: int) -> SimulatedEscPos:
    printer = SimulatedEscPos(lag)
    printer.write(contract.stream(EscPos(command=command), picture, cut=True))
    printer.finish()
    return printer


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("lag", [0, 700, 1 << 20])
def test_a_printer_that_executes_them(command, lag):
    picture = adversary(command)
    printer = printed(command, picture, lag)
    assert printer.executed == []
    assert not printer.off
    assert printer.replies == printer.garbage == printer.unfinished == b""
    assert printer.cuts == [1]
    expected = 1 - calm(picture, command)
    np.testing.assert_array_equal(np.array(printer.rows)[: len(expected)], expected)
    assert not np.any(printer.rows[len(expected) :])
    assert printer.fed[-1][1] == 120


@pytest.mark.parametrize("command", COMMANDS)
def test_without_the_treatment_it_goes_wrong(command, monkeypatch):
    monkeypatch.setattr(module, "harmless", lambda header, data: data)
    picture = adversary(command)
    assert printed(command, picture, 700).off
    # the same without the one that switches off: buffers are emptied, and rows are lost
    monkeypatch.setattr(
        module, "harmless", lambda header, data: data.replace(b"\x10\x14\x02\x01\x08", b"\0" * 5)
    )
    printer = printed(command, picture, 700)
    assert {found[1] for found in printer.executed} == {0x04, 0x05, 0x14}
    assert printer.replies
    assert len(printer.rows) < len(picture)
    assert printer.garbage or printer.unfinished


@pytest.mark.parametrize("command", COMMANDS)
@given(data=st.data())
def test_any_picture_is_printed(command, data):
    picture = data.draw(wild(command) | contract.pictures())
    printer = printed(command, picture, 100)
    expected = 1 - calm(picture, command)
    assert printer.executed == []
    np.testing.assert_array_equal(np.array(printer.rows)[: len(expected)], expected)


def test_status_between_commands():
    printer = SimulatedEscPos(0, states=(0x1A, 0x32, 0x12, 0x72))
    printer.write(b"\x1b@" + EscPos.status_query + b"\x1dv0\x00\x01\x00\x01\x00\x80")
    printer.finish()
    assert printer.rows == [[1, 0, 0, 0, 0, 0, 0, 0]]
    assert str(EscPos().parse_status(bytes(printer.replies))) == "no paper, it is offline"
