"""What is plugged in, read from a tree as sysfs has it."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from devices.discovery import found
from devices.transports.base import Uri

ID = "MFG:EPSON;CMD:ESC/POS,BDC;MDL:TM-T20;CLS:PRINTER;"


class Machine:
    """A folder with sys, dev, proc and etc."""

    def __init__(self, root: Path) -> None:
        self.root = root

    def write(self, path: str, text: str) -> None:
        place = self.root / path
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text)

    def link(self, path: str, target: str) -> None:
        place = self.root / path
        place.parent.mkdir(parents=True, exist_ok=True)
        place.symlink_to(target)

    def device(self, port: str = "1-2", address: int = 5, **attributes: str) -> None:
        given = {"idVendor": "04b8", "idProduct": "0202", "busnum": "1", "devnum": str(address)}
        for name, text in {**given, **attributes}.items():
            self.write(f"sys/bus/usb/devices/{port}/{name}", f"{text}\n")
        self.write(f"dev/bus/usb/001/{address:03d}", "")

    def interface(
        self,
        name: str = "1-2:1.0",
        *,
        kind: str = "07",
        protocol: str = "02",
        driver: str = "",
        id: str = "",
    ) -> None:
        folder = f"sys/bus/usb/devices/{name}"
        self.write(f"{folder}/bInterfaceClass", f"{kind}\n")
        self.write(f"{folder}/bInterfaceProtocol", f"{protocol}\n")
        self.write(f"{folder}/bInterfaceNumber", f"0{name[-1]}\n")
        if id:
            self.write(f"{folder}/ieee1284_id", f"{id}\n")
        if driver:
            self.link(f"{folder}/driver", f"../../../../../bus/usb/drivers/{driver}")
        if driver == "usblp":
            (self.root / folder / "usbmisc/lp0").mkdir(parents=True)
            self.write("dev/usb/lp0", "")


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return Machine(tmp_path)


def test_nothing_there(machine: Machine) -> None:
    assert found(machine.root) == []


def test_a_printer_that_usblp_has(machine: Machine) -> None:
    machine.device(serial="SN 1", manufacturer="Seiko Epson", product="Receipt printer")
    machine.interface(driver="usblp", id=ID)
    usb, node = found(machine.root)
    assert usb.uri == "usb://EPSON/TM-T20?serial=SN%201"
    assert (usb.title, usb.languages, usb.problem) == ("EPSON TM-T20", ("ESC/POS", "BDC"), "")
    assert node.uri == "file:/dev/usb/lp0"
    assert (node.title, node.languages, node.problem) == ("EPSON TM-T20", ("ESC/POS", "BDC"), "")
    assert Uri.parse(usb.uri).query == {"serial": "SN 1"}


def test_a_printer_that_no_driver_has_asked(machine: Machine) -> None:
    """Its strings need not be what its device ID says, by which it is found: so by its numbers."""
    machine.device(manufacturer="Seiko Epson", product="Receipt printer")
    machine.interface("1-2:1.1")
    (usb,) = found(machine.root)
    assert usb.uri == "usb://04b8:0202?interface=1"
    assert usb.title == "Seiko Epson Receipt printer"


def test_a_printer_that_says_nothing(machine: Machine) -> None:
    machine.device()
    machine.interface()
    assert found(machine.root)[0].title == "USB printer at 1-2"


def test_other_classes_are_none(machine: Machine) -> None:
    machine.device()
    machine.interface(kind="03")
    machine.write("sys/bus/usb/devices/usb1/idVendor", "1d6b\n")
    assert found(machine.root) == []


def test_two_of_a_kind(machine: Machine) -> None:
    for k in (1, 2):
        machine.device(f"1-{k}", k)
        machine.interface(f"1-{k}:1.0")
    uris = [each.uri for each in found(machine.root)]
    assert uris == ["usb://04b8:0202?port=1-1", "usb://04b8:0202?port=1-2"]


@pytest.mark.parametrize(
    ("protocol", "driver", "says"),
    [("04", "", "ipp-usb"), ("02", "usbfs", "another program"), ("02", "", "")],
)
def test_problems(machine: Machine, protocol: str, driver: str, says: str) -> None:
    machine.device()
    machine.interface(protocol=protocol, driver=driver)
    (usb,) = found(machine.root)
    assert says in usb.problem
    assert bool(usb.problem) == bool(says)


def test_no_permission(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    machine.device()
    machine.interface(driver="usblp", id=ID)
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    usb, node = found(machine.root)
    assert "may not write to /dev/bus/usb/001/005" in usb.problem
    assert "may not write to /dev/usb/lp0" in node.problem


def test_a_node_without_a_printer_in_sysfs(machine: Machine) -> None:
    machine.write("dev/usb/lp3", "")
    (node,) = found(machine.root)
    assert (node.uri, node.title) == ("file:/dev/usb/lp3", "USB printer lp3")


def test_serial_ports(machine: Machine) -> None:
    machine.link("dev/serial/by-id/usb-FTDI_UART-if00-port0", "../../ttyUSB0")
    for name in ("ttyUSB0", "ttyACM1", "ttyS0", "rfcomm0"):
        machine.write(f"dev/{name}", "")
    assert [(each.uri, each.title) for each in found(machine.root)] == [
        ("serial:/dev/serial/by-id/usb-FTDI_UART-if00-port0", "usb-FTDI UART-if00-port0"),
        ("serial:/dev/ttyACM1", "serial port ttyACM1"),
        ("serial:/dev/rfcomm0", "serial port rfcomm0"),
    ]


def test_a_printer_that_goes_while_it_is_read(machine: Machine) -> None:
    machine.interface()  # its device's folder is gone already
    (usb,) = found(machine.root)
    assert usb.title == "USB printer at 1-2"
