"""What a Brother QL says of itself, and the simulated one that says it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from devices.languages.brother_ql import BrotherQl
from devices.status import Status
from tests.devices.languages import contract
from tests.devices.simulated_brother import FAULT, NOTICE, PHASE, PRINTED, SimulatedBrother, packet

LANGUAGE = BrotherQl()


@pytest.mark.parametrize(
    ("faults", "reasons"),
    [
        ({}, []),
        ({"first": 0x01}, ["media-empty-error"]),
        ({"first": 0x02}, ["media-empty-error"]),
        ({"first": 0x04}, ["marker-failure-error"]),
        ({"first": 0x08}, ["other-error"]),
        ({"first": 0x80}, ["other-error"]),
        ({"second": 0x01}, ["media-needed-error"]),
        ({"second": 0x02}, ["spool-area-full-error"]),
        ({"second": 0x10}, ["cover-open-error"]),
        ({"second": 0x40}, ["media-jam-error", "media-empty-error"]),
        ({"first": 0x01, "second": 0x10}, ["media-empty-error", "cover-open-error"]),
        ({"media": 0}, ["media-empty-error"]),
    ],
)
def test_faults_in_the_words_of_ipp(faults, reasons):
    assert LANGUAGE.parse_status(packet(**faults)) == Status.of(*reasons)
    pushed = reasons if {"first", "second"} & set(faults) else ["other-error"]
    assert LANGUAGE.unsolicited(packet(FAULT, **faults)) == Status.of(*pushed)


def test_phases_and_finished_pages_are_no_faults():
    for kind in (PRINTED, PHASE, NOTICE):
        assert LANGUAGE.unsolicited(packet(kind, phase=1)) == Status()
        assert LANGUAGE.unsolicited(packet(kind, media=0)) == Status()
    assert LANGUAGE.unsolicited(packet(NOTICE, notice=1)) == Status.of("cover-open-error")
    assert LANGUAGE.unsolicited(packet(NOTICE, notice=3)) == Status.of("fuser-over-temp-warning")
    assert LANGUAGE.unsolicited(packet(0x04)) == Status.of("offline-error")
    assert LANGUAGE.unsolicited(packet(FAULT)) == Status.of("other-error")


@given(st.binary(max_size=40), st.binary(max_size=40), st.integers(0, 31))
def test_an_answer_is_found_among_noise_when_it_is_whole(before, after, cut):
    noise = before.replace(b"\x80", b"")
    reply = packet(second=0x10)
    assert LANGUAGE.parse_status(noise + reply[:cut]) is None
    assert LANGUAGE.parse_status(noise + reply + after) == Status.of("cover-open-error")
    assert LANGUAGE.unsolicited(noise + reply[:cut]) is None


def test_an_answer_is_told_from_what_comes_by_itself():
    pushed = packet(PHASE, phase=1) + packet(FAULT, first=1)
    assert LANGUAGE.parse_status(pushed) is None
    assert LANGUAGE.parse_status(pushed + packet()) == Status()
    assert LANGUAGE.unsolicited(pushed) == Status.of("media-empty-error")
    assert LANGUAGE.unsolicited(pushed + packet(PHASE)) == Status()  # the last one counts


@given(contract.pictures(), st.integers(1, 40), st.booleans())
def test_the_simulated_printer_prints(picture, part, compress):
    printer = SimulatedBrother()
    whole = np.ones((len(picture), 696), np.uint8)
    whole[:, : picture.shape[1]] = picture
    data = contract.stream(BrotherQl(compress=compress), whole, whole, dpi=(300.0, 300.0))
    data = LANGUAGE.status_query + data
    for start in range(0, len(data), part):
        assert printer.write(data[start : start + part]) == len(data[start : start + part])
    assert [page.tolist() for page in printer.pages] == [whole.tolist()] * 2
    heard = printer.read()
    assert LANGUAGE.parse_status(heard) == LANGUAGE.unsolicited(heard) == Status()
    assert len(heard) == 32 * (1 + 2 * 3)  # the answer, and three for each page


def test_the_simulated_printer_answers_nothing_within_rows():
    dots = np.unpackbits(np.frombuffer(LANGUAGE.status_query * 25, np.uint8))[:590]
    data = contract.stream(BrotherQl("54"), 1 - dots[None, ::-1], dpi=(300.0, 300.0))
    assert LANGUAGE.status_query * 24 in data
    printer = SimulatedBrother()
    printer.write(data)
    assert len(printer.pages) == 1
    assert LANGUAGE.parse_status(printer.read()) is None


def test_the_simulated_printer_holds_a_page_until_it_is_mended():
    printer = SimulatedBrother()
    data = contract.stream(LANGUAGE, np.zeros((3, 696), np.uint8), dpi=(300.0, 300.0))
    printer.fault(second=0x10)
    assert LANGUAGE.unsolicited(printer.read()) == Status.of("cover-open-error")
    assert printer.write(data) == len(data)
    assert printer.write(b"\0") == 0
    assert LANGUAGE.unsolicited(printer.read()) == Status.of("cover-open-error")
    assert not printer.pages
    printer.mend()
    assert len(printer.pages) == 1
    assert LANGUAGE.unsolicited(printer.read()) == Status()
    assert printer.write(b"\0") == 1


def test_the_simulated_printer_gives_up_a_cancelled_page():
    printer = SimulatedBrother()
    picture = np.zeros((400, 696), np.uint8)
    made = contract.pieces(LANGUAGE, picture, dpi=(300.0, 300.0))
    printer.write(made[0].data[:5000])
    printer.write(made[0].abort(5000))
    printer.write(contract.stream(LANGUAGE, picture[:7], dpi=(300.0, 300.0)))
    assert [len(page) for page in printer.pages] == [7]
