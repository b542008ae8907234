"""What ZPL printers say of themselves."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from devices.languages.zpl import ERRORS, Zpl
from tests.devices.simulated_zpl import SimulatedZpl

READY: frozenset[str] = frozenset()
REASONS = {
    "media_out": "media-empty-error",
    "ribbon_out": "marker-supply-empty-error",
    "head_open": "cover-open-error",
    "head_hot": "fuser-over-temp-error",
    "paused": "paused-error",
}
"""What both answers can say."""
ONLY_BITS = {"cutter_fault": "marker-failure-error", "media_low": "media-low-warning"}


def reasons(reply: bytes) -> frozenset[str] | None:
    status = Zpl().parse_status(reply)
    return None if status is None else status.reasons


@given(st.sets(st.sampled_from([*REASONS, *ONLY_BITS])))
def test_errors_and_warnings(state):
    printer = SimulatedZpl(set(state))
    assert reasons(printer(Zpl.status_query)) == {(REASONS | ONLY_BITS)[name] for name in state}
    assert printer.asked == ["~HQES"]


@given(st.sets(st.sampled_from([*REASONS])))
def test_three_strings(state):
    assert reasons(SimulatedZpl(set(state), strict=False)(b"~HS")) == {REASONS[name] for name in state}


def test_a_printer_with_an_error_need_not_answer_hs():
    printer = SimulatedZpl({"head_open"})
    assert printer(b"~HS") == b""
    assert reasons(printer(Zpl.status_query)) == {"cover-open-error"}


@pytest.mark.parametrize("query", [b"~HQES\n", b"~HS\n"])
def test_an_answer_that_is_not_complete_is_none(query):
    whole = SimulatedZpl({"paused"})(query)
    needed = len(whole.rstrip(b"\r\n\x03")) + (query == b"~HS\n")
    for size in range(len(whole) + 1):
        assert reasons(whole[:size]) == (None if size < needed else {"paused-error"})


@given(st.binary(max_size=40), st.binary(max_size=40))
def test_noise_around_an_answer_is_passed_over(before, after):
    noise = bytes.maketrans(b"\x02\x03", b"  ")
    for query in (b"~HQES\n", b"~HS\n"):
        whole = SimulatedZpl({"paused"})(query)
        assert reasons(before.translate(noise) + whole + after.translate(noise)) == {"paused-error"}
        assert reasons(before) is None


def test_the_last_answer_counts():
    printer = SimulatedZpl({"media_out"}, {8: ("media_out", False)})
    assert reasons(printer(Zpl.status_query + Zpl.status_query)) == READY
    assert reasons(SimulatedZpl({"paused"})(b"~HQES~HS")) == {"paused-error"}


@pytest.mark.parametrize(
    ("errors", "warnings", "expected"),
    [
        ("0 00000000 00000000", "0 00000000 00000000", READY),
        ("1 00000000 00000005", "0 00000000 00000000", {"media-empty-error", "cover-open-error"}),
        (
            "0 00000000 00000000",
            "1 00000000 0000000E",
            {"media-low-warning", "marker-failure-warning", "other-warning"},
        ),
        ("1 00000000 80000000", "0 00000000 00000000", {"other-error"}),
        ("1 00000000 00000000", "0 00000000 00000000", {"other-error"}),
        ("1 00000000 0000D000", "1 00000000 00000FF0", {"media-jam-error"}),
    ],
)
def test_bits(errors, warnings, expected):
    text = f"\x02\r\n  PRINTER STATUS  \r\n  ERRORS:  {errors}\r\n  WARNINGS:  {warnings}\r\n\x03"
    assert reasons(text.encode()) == expected


def test_no_bit_has_two_names():
    assert sum(ERRORS) == sum(bit for bit in (1 << i for i in range(32)) if any(m & bit for m in ERRORS))


def test_other_conditions_of_three_strings():
    one, two, three = "030,0,0,1218,000,1,0,0,000,1,1,0", "000,0,0,0,0,2,6,0,00000000,1,000", "1234,0"
    reply = "".join(f"\x02{s}\x03\r\n" for s in (one, two, three)).encode()
    assert reasons(reply) == {"spool-area-full-report", "other-error", "other-warning"}
    assert reasons(reply.replace(b",000,1,1,0", b",000,1,1")) is None


def test_a_query_between_two_pieces_changes_nothing():
    printer = SimulatedZpl(script={30: ("head_open", True)})
    job = [b"^XA^PW8^LL2\n", b"^FO0,0^GFA,1,1,1,80^FS\n", b"^PQ1^XZ\n"]
    seen = []
    for piece in job:
        assert printer(piece) == b""
        seen.append(reasons(printer(Zpl.status_query)))
    assert seen == [READY, {"cover-open-error"}, {"cover-open-error"}]
    (frame,) = Zpl.decode(bytes(printer.received))
    assert frame.shape == (2, 8)
