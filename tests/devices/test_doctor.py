"""The doctor names what is in the way, and the words that remove it."""

from __future__ import annotations

import importlib.util
import os
import socket
from pathlib import Path

import pytest

from devices import doctor
from devices.doctor import Finding, examine
from halftone.errors import DeviceNotFoundError, UsageError
from tests.devices.test_discovery import ID, Machine

URI = "usb://EPSON/TM-T20?serial=SN1"
RULE = (
    'SUBSYSTEM=="usb", ATTR{idVendor}=="04b8", ATTR{idProduct}=="0202", MODE="0660", GROUP="lp", '
    'TAG+="uaccess"'
)


@pytest.fixture
def machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Machine:
    monkeypatch.setattr(doctor, "library", lambda: None)
    made = Machine(tmp_path)
    made.device(serial="SN1")
    made.interface(driver="usblp", id=ID)
    return made


def problems(machine: Machine, uri: str | None = URI) -> list[Finding]:
    return [finding for finding in examine(uri, machine.root) if not finding.ok]


def process(machine: Machine, pid: int, name: str, file: str) -> None:
    machine.write(f"proc/{pid}/comm", f"{name}\n")
    machine.link(f"proc/{pid}/fd/3", file)


def test_all_is_well(machine: Machine) -> None:
    findings = examine(URI, machine.root)
    assert not problems(machine)
    assert any("usblp has it" in each.what and "/dev/usb/lp0" in each.what for each in findings)
    assert any("plugged in at 1-2" in each.what for each in findings)


@pytest.mark.parametrize("uri", [URI, "usb://04b8:0202", "usb://4b8:0x202", "usb:", None])
def test_the_permission_with_its_rule(
    machine: Machine, monkeypatch: pytest.MonkeyPatch, uri: str | None
) -> None:
    monkeypatch.setattr(os, "access", lambda path, mode: not str(path).endswith("001/005"))
    (finding,) = problems(machine, uri)
    assert finding.what == "this user may not open /dev/bus/usb/001/005"
    assert RULE in finding.remedy.splitlines()
    assert "usermod -aG lp" in finding.remedy


@pytest.mark.parametrize("uri", ["usb://EPSON/TM-T88", "usb://04b8:0203", "usb://EPSON/TM-T20?serial=2"])
def test_another_printer_is_there(machine: Machine, uri: str) -> None:
    (finding,) = problems(machine, uri)
    assert finding.what == f"{uri} is not there"
    assert URI in finding.remedy


def test_who_holds_it(machine: Machine) -> None:
    process(machine, 71, "ipp-usb", "/dev/bus/usb/001/005")
    process(machine, 72, "innocent", "/dev/bus/usb/001/004")
    process(machine, os.getpid(), "ourselves", "/dev/bus/usb/001/005")
    (finding,) = problems(machine)
    assert "ipp-usb (process 71)" in finding.what
    assert "systemctl stop ipp-usb" in finding.remedy


def test_who_has_the_node_open(machine: Machine) -> None:
    process(machine, 73, "cat", "/dev/usb/lp0")
    (finding,) = problems(machine, "file:/dev/usb/lp0")
    assert "cat (process 73)" in finding.what
    assert "kill 73" in finding.remedy


def test_someone_unknown_holds_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "library", lambda: None)
    machine = Machine(tmp_path)
    machine.device()
    machine.interface(driver="usbfs")
    (finding,) = problems(machine, "usb://04b8:0202")
    assert "another program" in finding.what
    assert "sudo" in finding.remedy


def test_another_driver_has_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "library", lambda: None)
    machine = Machine(tmp_path)
    machine.device()
    machine.interface(driver="uss720", protocol="04")
    driver, ipp = problems(machine, "usb:")
    assert "uss720" in driver.what
    assert driver.remedy == "echo 1-2:1.0 | sudo tee /sys/bus/usb/drivers/uss720/unbind"
    assert "IPP over USB" in ipp.what


def test_a_sandbox_without_usb(machine: Machine) -> None:
    (machine.root / "dev/bus/usb/001/005").unlink()
    (finding,) = problems(machine)
    assert "not there" in finding.what
    assert "container" in finding.remedy


def test_a_queue_of_cups(machine: Machine) -> None:
    machine.write(
        "etc/cups/printers.conf",
        "<DefaultPrinter till>\nDeviceURI usb://EPSON/TM-T20?serial=SN1\n</DefaultPrinter>\n"
        "<Printer other>\nDeviceURI usb://HP/LaserJet\n</Printer>\n"
        "<Printer far>\nDeviceURI socket://far\n</Printer>\n",
    )
    queues = [each for each in examine(URI, machine.root) if "CUPS" in each.what]
    assert len(queues) == 1
    assert "queue till" in queues[0].what
    assert "cupsdisable till" in queues[0].remedy


def test_without_pyusb(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing() -> None:
        raise DeviceNotFoundError("usb: URIs need pyusb: pip install pyusb")

    monkeypatch.setattr(doctor, "library", missing)
    (finding,) = problems(machine)
    assert finding == Finding("URIs need pyusb", False, "pip install pyusb")


def test_without_pyserial(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    machine.write("dev/ttyUSB0", "")
    (finding,) = problems(machine, "serial:/dev/ttyUSB0")
    assert "pip install" in finding.remedy


@pytest.mark.parametrize(
    ("uri", "group"), [("serial:/dev/ttyUSB0", "dialout"), ("file:/dev/usb/lp0", "lp")]
)
def test_a_node_without_permission(
    machine: Machine, monkeypatch: pytest.MonkeyPatch, uri: str, group: str
) -> None:
    machine.write("dev/ttyUSB0", "")
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    monkeypatch.setattr(Path, "group", lambda path: "root")
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: object())
    (finding,) = problems(machine, uri)
    assert "may not open it" in finding.what
    assert f"usermod -aG {group} $USER" in finding.remedy


def test_a_node_that_is_not_there(machine: Machine) -> None:
    assert problems(machine, "file:/dev/usb/lp7")[0].what == "/dev/usb/lp7 is not there"


def test_a_host_that_answers_and_one_that_refuses(machine: Machine) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        uri = f"socket://127.0.0.1:{server.getsockname()[1]}"
        assert problems(machine, uri + "?waiteof=false") == []
    (finding,) = problems(machine, uri)
    assert "refuses port" in finding.what
    assert "9100" in finding.remedy


def test_nothing_to_examine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "library", lambda: None)
    assert "no USB printer is plugged in and switched on" in [
        each.what for each in examine(root=tmp_path)
    ]
    assert [each.ok for each in examine("mem:", tmp_path)] == [True]
    with pytest.raises(UsageError):
        examine("nonsense", tmp_path)
