"""What ESC/POS printers answer and send unasked."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from devices.languages.escpos import EscPos

ESCPOS = EscPos()
READY = (0x12, 0x12, 0x12, 0x12)
NOISE = st.lists(st.integers(0, 255).filter(lambda byte: byte & 0x93 != 0x12)).map(bytes)


def reasons(*answers: int) -> set[str]:
    status = ESCPOS.parse_status(bytes(answers))
    assert status is not None
    return set(status.reasons)


@pytest.mark.parametrize(
    ("answers", "expected"),
    [
        (READY, set()),
        ((0x16, 0x12, 0x12, 0x12), set()),  # the drawer is no matter of printing
        ((0x1A, 0x12, 0x12, 0x12), {"offline-error"}),
        ((0x1A, 0x16, 0x12, 0x12), {"offline-report", "cover-open-error"}),
        ((0x1A, 0x1A, 0x12, 0x12), {"offline-report", "paused-report"}),
        ((0x1A, 0x32, 0x12, 0x72), {"offline-report", "media-empty-error"}),
        ((0x12, 0x12, 0x12, 0x72), {"media-empty-error"}),
        ((0x12, 0x12, 0x12, 0x7E), {"media-empty-error"}),
        ((0x12, 0x12, 0x12, 0x1E), {"media-low-warning"}),
        ((0x1A, 0x52, 0x1A, 0x12), {"offline-report", "marker-failure-error"}),
        ((0x1A, 0x52, 0x32, 0x12), {"offline-report", "other-error"}),
        ((0x1A, 0x52, 0x16, 0x12), {"offline-report", "other-error"}),
        ((0x1A, 0x52, 0x52, 0x12), {"offline-report", "other-warning"}),
        ((0x12, 0x52, 0x12, 0x12), {"other-error"}),
    ],
)
def test_answers(answers, expected):
    assert reasons(*answers) == expected


def test_the_bits_that_stop_it():
    for bit in range(8):
        for n in range(4):
            answers = [0x12] * 4
            answers[n] |= 1 << bit
            if answers[n] & 0x93 != 0x12:
                assert ESCPOS.parse_status(bytes(answers)) is None
                continue
            stops = {(0, 3), (1, 2), (1, 5), (1, 6), (2, 2), (2, 3), (2, 5), (3, 5), (3, 6)}
            assert ESCPOS.parse_status(bytes(answers)).stopped == ((n, bit) in stops)


ANSWER = st.integers(0, 255).map(lambda byte: byte & 0x6C | 0x12)


@given(st.lists(ANSWER, min_size=4, max_size=4), st.lists(NOISE, min_size=5, max_size=5))
def test_noise_is_passed_over(answers, noise):
    received = noise[0] + b"".join(
        bytes((answer,)) + more for answer, more in zip(answers, noise[1:], strict=True)
    )
    assert ESCPOS.parse_status(received) == ESCPOS.parse_status(bytes(answers))


@given(st.lists(ANSWER, min_size=4, max_size=4), st.lists(ANSWER))
def test_late_answers_are_passed_over(answers, late):
    assert ESCPOS.parse_status(bytes(late + answers)) == ESCPOS.parse_status(bytes(answers))


@given(st.lists(ANSWER, max_size=3), NOISE)
def test_an_answer_that_is_not_complete(answers, noise):
    assert ESCPOS.parse_status(noise + bytes(answers)) is None


@given(st.binary())
def test_any_bytes(received):
    for status in (ESCPOS.parse_status(received), ESCPOS.unsolicited(received)):
        assert status is None or str(status)


PACKET = st.tuples(
    st.integers(0, 255).map(lambda byte: byte & 0x6C | 0x10),
    *[st.integers(0, 255).map(lambda byte: byte & 0x6F)] * 3,
).map(bytes)
STRAY = st.lists(st.integers(0, 255).filter(lambda byte: byte & 0x93 != 0x10), max_size=9).map(bytes)


@given(PACKET, STRAY, STRAY)
def test_a_packet_among_other_bytes(packet, before, after):
    alone = ESCPOS.unsolicited(packet)
    assert alone is not None
    assert ESCPOS.unsolicited(before + packet + after) == alone
    assert ESCPOS.unsolicited(packet[:3] + packet) == alone
    assert ESCPOS.unsolicited(before + packet[:3]) is None


@pytest.mark.parametrize(
    ("packet", "expected"),
    [
        ("10000000", set()),
        ("1400000f", set()),
        ("18000000", {"offline-error"}),
        ("38000000", {"offline-report", "cover-open-error"}),
        ("58020000", {"offline-report", "paused-report"}),
        ("18000f00", {"offline-report", "media-empty-error"}),
        ("10000300", {"media-low-warning"}),
        ("18080000", {"offline-report", "marker-failure-error"}),
        ("18200000", {"offline-report", "other-error"}),
        ("18400000", {"offline-report", "other-warning"}),
    ],
)
def test_packets(packet, expected):
    status = ESCPOS.unsolicited(bytes.fromhex(packet))
    assert status is not None
    assert set(status.reasons) == expected
    # answers to DLE EOT that lie between do not disturb
    assert ESCPOS.unsolicited(bytes(READY) + bytes.fromhex(packet) + bytes(READY)) == status


def test_nothing_unasked():
    assert ESCPOS.unsolicited(b"") is None
    assert ESCPOS.unsolicited(bytes(READY)) is None
