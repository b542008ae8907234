"""IEEE 1284 device IDs, as they should be and as printers send them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from devices.transports.device_id import DeviceId

TEXT = b"MFG:EPSON;CMD:ESC/POS,ESC/P2;MDL:TM-T20;CLS:PRINTER;SN:J4XF012345;"


def lengths(text: bytes) -> dict[str, bytes]:
    n = len(text)
    return {
        "as it should be": (n + 2).to_bytes(2, "big"),
        "low byte first": (n + 2).to_bytes(2, "little"),
        "not counting itself": n.to_bytes(2, "big"),
        "low byte first, not counting itself": n.to_bytes(2, "little"),
        "too long": (n + 40).to_bytes(2, "big"),
        "too short": (n - 7).to_bytes(2, "big"),
        "zero": b"\0\0",
        "absent": b"",
    }


@pytest.mark.parametrize("padding", [b"", b"\0" * 30, b"\0MFG:OTHER;"], ids=["", "zeros", "leftovers"])
@pytest.mark.parametrize("kind", lengths(TEXT))
def test_any_length_in_front_gives_the_same_id(kind, padding):
    parsed = DeviceId.parse(lengths(TEXT)[kind] + TEXT + padding)
    assert parsed == DeviceId.of(TEXT.decode())
    assert (parsed.make, parsed.model, parsed.serial) == ("EPSON", "TM-T20", "J4XF012345")
    assert parsed.languages == ("ESC/POS", "ESC/P2")


def test_a_stated_length_cuts_off_what_follows():
    for kind in ("as it should be", "low byte first", "not counting itself"):
        answer = lengths(TEXT)[kind] + TEXT + b"CMD:OLD;MODEL:OLD;"
        assert DeviceId.parse(answer) == DeviceId.of(TEXT.decode())


def test_the_last_semicolon_may_be_missing():
    whole, cut = (
        (len(TEXT) + 2).to_bytes(2, "big") + TEXT,
        (len(TEXT) + 1).to_bytes(2, "big") + TEXT[:-1],
    )
    assert DeviceId.parse(cut).fields == DeviceId.parse(whole).fields


def test_rubbish_after_the_last_semicolon_is_left_out():
    assert DeviceId.parse(b"\x03\xff" + TEXT + b"\xff\xff\xff").text == TEXT.decode()


def test_long_names_of_the_keys():
    text = " manufacturer : Zebra Technologies ;COMMAND  SET:ZPL, EPL ,;Model:ZTC ZD420;SERIALNUMBER:D2;"
    parsed = DeviceId.of(text)
    assert (parsed.make, parsed.model, parsed.serial) == ("Zebra Technologies", "ZTC ZD420", "D2")
    assert parsed.languages == ("ZPL", "EPL")


@pytest.mark.parametrize(
    ("text", "make", "model"),
    [
        ("MFG:Brother;MDL:Brother QL-800;", "Brother", "QL-800"),
        ("MFG:Hewlett-Packard;MDL:HP LaserJet 4;", "HP", "LaserJet 4"),
        ("MFG:Hewlett-Packard;MDL:Hewlett-Packard DeskJet;", "HP", "DeskJet"),
        ("MFG:Lexmark International;MDL:Lexmark E120;", "Lexmark", "E120"),
        ("MFG:STAR;DES:TSP100;", "STAR", "TSP100"),
        ("MFG:A;MFG:B;MDL::;", "A", ":"),
        ("nothing here", "", ""),
    ],
)
def test_make_and_model_are_those_of_cups(text, make, model):
    parsed = DeviceId.of(text)
    assert (parsed.make, parsed.model) == (make, model)


@given(st.binary(max_size=80) | st.binary(max_size=9).map(lambda rest: rest + TEXT[:30]))
def test_whatever_comes_is_read(answer):
    parsed = DeviceId.parse(answer)
    assert len(parsed.text.encode()) <= 3 * len(answer)
    assert all(key == key.upper() and value for key, value in parsed.fields.items())
    assert not (parsed.languages and "" in parsed.languages)
