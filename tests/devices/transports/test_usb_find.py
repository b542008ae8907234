"""Which printer a USB URI means, and the URIs that printers are listed with."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("usb", reason="pyusb is not installed (pip install pyusb)")

from devices.transports import usb_find
from devices.transports.base import Uri
from devices.transports.usb import UsbTransport
from devices.transports.usb_find import found
from halftone.errors import DeviceNotFoundError, UsageError
from tests.devices.simulated_usb import SimBackend
from tests.devices.simulated_usb_printer import Printer, Setting, device_id

EPSON = {"port": (2,)}
ZEBRA = {
    "vendor": 0x0A5F,
    "product": 0x00A3,
    "strings": ("Zebra Technologies", "ZTC ZD420", "D2J 1/4+5"),
    "id": device_id("MANUFACTURER:Zebra Technologies;COMMAND SET:ZPL,EPL;MODEL:ZTC ZD420;CLS:PRINTER;"),
    "port": (3, 1),
}
KEYBOARD = {"vendor": 0x04B8, "product": 0x0001, "settings": (Setting(kind=3, ends=()),)}


def bus(*devices: dict) -> SimBackend:
    return SimBackend(*(Printer(**each) for each in devices))


def taken(uri: str, backend: SimBackend) -> Printer:
    with UsbTransport.open(Uri.parse(uri), 10.0, backend) as transport:
        return transport.printer.device


@pytest.mark.parametrize(
    "uri",
    [
        "usb://0a5f:00a3",
        "usb://0A5F:A3",
        "usb://0x0a5f:0x00a3",
        "zpl+usb://0a5f:00a3?serial=D2J%201%2f4%2B5",
        "usb://0a5f:00a3?serial=d2j%201/4+5",
        "usb://Zebra%20Technologies/ZTC%20ZD420",
        "usb://zebra%20technologies/ztc%20zd420?serial=D2J%201%2F4+5&interface=0",
        "usb://Zebra%20Technologies/ZTC%20ZD420?serial=?",
        "usb:?port=1-3.1",
        "usb://?port=1-3.1",
    ],
)
def test_uris_that_mean_the_zebra(uri):
    backend = bus(EPSON, ZEBRA, KEYBOARD)
    assert taken(uri, backend) is backend.devices[1]


@pytest.mark.parametrize(
    "uri",
    [
        "usb://0a5f:00a4",
        "usb://Zebra%20Technologies/ZD420",
        "usb://EPSON/TM-T20?serial=SN2",
        "usb://EPSON/TM-T20?port=1-3.1",
        "usb://04b8:0001",
    ],
)
def test_what_is_not_there_is_refused_with_what_is(uri):
    with pytest.raises(DeviceNotFoundError) as caught:
        taken(uri, bus(EPSON, ZEBRA, KEYBOARD))
    assert str(caught.value) == (
        f"no USB printer is {uri}; allowed: usb://EPSON/TM-T20?serial=SN1, "
        "usb://Zebra%20Technologies/ZTC%20ZD420?serial=D2J%201%2F4%2B5"
    )


def test_nothing_there():
    with pytest.raises(DeviceNotFoundError, match="no USB printer is plugged in and switched on"):
        taken("usb:", bus(KEYBOARD))


@pytest.mark.parametrize(
    "uri", ["usb://EPSON", "usb://04b8:zz", "usb://04b8", "usb://EPSON/?serial=SN1"]
)
def test_half_a_name_is_refused(uri):
    with pytest.raises(UsageError, match="allowed: usb://MAKE/MODEL"):
        taken(uri, bus(EPSON))


@pytest.mark.parametrize("uri", ["usb:?baud=9600", "usb:?interface=a", "usb:?interface=256"])
def test_options_are_never_ignored(uri):
    with pytest.raises(UsageError, match="allowed"):
        taken(uri, bus(EPSON))


def test_two_alike_are_told_apart_by_serial_number():
    backend = bus(EPSON, {**EPSON, "strings": ("EPSON", "TM-T20", "SN2"), "port": (4,)})
    with pytest.raises(DeviceNotFoundError) as caught:
        taken("usb://04b8:0202", backend)
    assert str(caught.value).startswith("2 USB printers are usb://04b8:0202; allowed: ")
    uris = str(caught.value).rpartition("allowed: ")[2].split(", ")
    assert [taken(uri, backend) for uri in uris] == list(backend.devices)


def test_two_that_say_the_same_are_told_apart_by_port():
    same = {"strings": ("EPSON", "TM-T20", "")}
    backend = bus({**same, "port": (4,)}, {**same, "port": (2, 1)})
    uris = [each.uri for each in found(backend)]
    assert uris == ["usb://EPSON/TM-T20?port=1-4", "usb://EPSON/TM-T20?port=1-2.1"]
    assert [taken(uri, backend) for uri in uris] == list(backend.devices)


def test_the_serial_number_of_the_device_id_is_one_too():
    backend = bus({"id": device_id("MFG:EPSON;MDL:TM-T20;SN:J4X;")})
    for uri in ("usb://EPSON/TM-T20?serial=J4X", "usb://EPSON/TM-T20?serial=SN1"):
        assert taken(uri, backend) is backend.devices[0]


def test_without_a_device_id_the_strings_count():
    backend = bus({"id": None, "strings": ("STAR", "TSP143", "")})
    assert [each.uri for each in found(backend)] == ["usb://STAR/TSP143"]
    assert taken("usb://star/tsp143", backend) is backend.devices[0]


def test_without_any_name_the_numbers_count():
    backend = bus({"id": None, "strings": ("", "", "")})
    assert [(each.uri, each.title) for each in found(backend)] == [("usb://04b8:0202",) * 2]


def test_found():
    ipp = {**ZEBRA, "settings": (Setting(interface=0, protocol=4),)}
    second = {"settings": (Setting(kind=8), Setting(interface=1)), "strings": ("", "", "")}
    backend = bus(EPSON, KEYBOARD, ipp, {**EPSON, "denied": True}, second)
    epson, zebra, denied, other = found(backend)
    assert (epson.uri, epson.title, epson.languages, epson.problem) == (
        "usb://EPSON/TM-T20?serial=SN1",
        "EPSON TM-T20",
        ("ESC/POS",),
        "",
    )
    assert zebra.title == "Zebra Technologies ZTC ZD420"
    assert "only IPP over USB" in zebra.problem
    assert (denied.uri, denied.title) == ("usb://04b8:0202", "usb://04b8:0202")
    assert "udev" in denied.problem
    assert other.uri == "usb://EPSON/TM-T20?interface=1"


def test_looking_changes_nothing():
    backend = bus({**EPSON, "drivers": {0: "usblp"}, "configuration": 0})
    found(backend)
    printer = backend.devices[0]
    assert printer.drivers == {0: "usblp"}
    assert printer.open_handles == 0
    assert {call[0] for call in printer.calls} == {"ctrl_transfer"}


TEXT = st.text(
    st.characters(codec="utf-8", exclude_characters=";\0:", exclude_categories=("Cc",)), max_size=8
)


@given(TEXT, TEXT, TEXT, st.integers(0, 3))
def test_every_listed_uri_opens_its_printer(make, model, serial, number):
    odd = {
        "id": device_id(f"MFG:{make};MDL:{model};"),
        "strings": ("maker", "product", serial.strip()),
        "settings": (Setting(interface=number),),
        "port": (9,),
    }
    backend = bus(odd, EPSON)
    assert taken(found(backend)[0].uri, backend) is backend.devices[0]


def test_without_pyusb_or_libusb(monkeypatch):
    import sys

    import usb.backend.libusb1

    monkeypatch.setattr(usb.backend.libusb1, "get_backend", lambda: None)
    with pytest.raises(DeviceNotFoundError, match="apt install libusb-1.0-0"):
        UsbTransport.open(Uri.parse("usb:"))
    monkeypatch.setitem(sys.modules, "usb", None)
    monkeypatch.setitem(sys.modules, "usb.backend", None)
    monkeypatch.setitem(sys.modules, "usb.backend.libusb1", None)
    with pytest.raises(DeviceNotFoundError, match=r'pip install "halftone-kit\[usb\]"'):
        UsbTransport.open(Uri.parse("usb:"))


def test_a_device_that_leaves_while_it_is_read_is_left_out(monkeypatch):
    backend = bus(EPSON, ZEBRA)
    given = backend.get_device_descriptor

    def gone(device: Printer) -> object:
        if device is backend.devices[0]:
            raise OSError(19, "No such device")
        return given(device)

    monkeypatch.setattr(backend, "get_device_descriptor", gone)
    assert [each.title for each in found(backend)] == ["Zebra Technologies ZTC ZD420"]
    assert usb_find.found(backend)[0].languages == ("ZPL", "EPL")
