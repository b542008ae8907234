"""Who holds a USB printer and what it said, from files as Linux has them in /sys and /proc."""

from __future__ import annotations

import errno
import os

import pytest

pytest.importorskip("usb", reason="pyusb is not installed (pip install pyusb)")

from devices.errors import DeviceBusyError, DevicePermissionError
from devices.transports import usb_access
from devices.transports.base import Uri
from devices.transports.usb import UsbTransport
from devices.transports.usb_find import found
from halftone.errors import DeviceNotFoundError
from tests.devices.simulated_usb import SimBackend
from tests.devices.simulated_usb_printer import Printer


@pytest.fixture
def linux(tmp_path, monkeypatch):
    """Empty /sys/bus/usb/devices and /proc; the simulated printer has port 1-2 and node 001/002."""
    for name in (usb_access.USB, "proc"):
        (tmp_path / name).mkdir(parents=True)
    monkeypatch.setattr(usb_access, "ROOT", tmp_path)
    return tmp_path


def bind(linux, driver: str) -> None:
    folder = linux / usb_access.USB / "1-2:1.0"
    folder.mkdir()
    (folder / "driver").symlink_to(f"../../drivers/{driver}")


def run(linux, name: str, number: int = 812) -> None:
    files = linux / "proc" / str(number) / "fd"
    files.mkdir(parents=True)
    (files.parent / "comm").write_text(f"{name}\n")
    (files / "0").symlink_to("/dev/null")
    (files / "7").symlink_to("/dev/bus/usb/001/002")


def problem(**printer) -> str:
    with pytest.raises(DeviceBusyError) as caught:
        UsbTransport.open(Uri.parse("usb:"), 1.0, SimBackend(Printer(**printer)))
    return str(caught.value)


def test_the_kernel_driver_is_named(linux):
    bind(linux, "usblp")
    said = problem(drivers={0: "usblp"}, detaches=False)
    assert said.startswith(
        "usb://04b8:0202 is held by the kernel driver usblp: print to file:/dev/usb/lp0"
    )


@pytest.mark.parametrize("bound", [True, False])
def test_the_program_is_named(linux, bound):
    if bound:
        bind(linux, "usbfs")
    run(linux, "ipp-usb")
    (linux / "proc" / "900").mkdir()  # one whose files we may not see
    said = problem(holders={0: "ipp-usb"})
    assert "is held by the program ipp-usb (process 812): print by IPP" in said
    assert "systemctl stop ipp-usb" in said


def test_ourselves_are_not_the_holder(linux):
    run(linux, "python3", os.getpid())
    assert "another program or a kernel driver" in problem(holders={0: "?"})


def test_a_printer_held_is_listed_with_its_holder(linux):
    assert found(SimBackend(Printer()))[0].problem == ""
    bind(linux, "usbfs")
    run(linux, "cups-browsed")
    listed = found(SimBackend(Printer()))[0]
    assert "the program cups-browsed (process 812): wait until it is done" in listed.problem


def test_usblp_is_no_problem(linux):
    bind(linux, "usblp")
    assert found(SimBackend(Printer(drivers={0: "usblp"})))[0].problem == ""


def test_a_printer_that_may_not_be_opened_has_the_names_that_linux_remembers(linux):
    for folder, name, text in [
        ("1-2", "manufacturer", "EPSON\n"),
        ("1-2", "product", "TM-T20II\n"),
        ("1-2", "serial", "SN 7\n"),
        ("1-2:1.0", "ieee1284_id", "MFG:EPSON;CMD:ESC/POS;MDL:TM-T20;"),
    ]:
        (linux / usb_access.USB / folder).mkdir(exist_ok=True)
        (linux / usb_access.USB / folder / name).write_text(text)
    backend = SimBackend(Printer(denied=True))
    listed = found(backend)[0]
    assert (listed.uri, listed.title) == ("usb://EPSON/TM-T20?serial=SN%207", "EPSON TM-T20")
    assert listed.languages == ("ESC/POS",)
    with pytest.raises(DevicePermissionError, match="may not open it"):
        UsbTransport.open(Uri.parse(listed.uri), 1.0, backend)


@pytest.mark.parametrize("code", [errno.ENODEV, errno.ENOENT])
def test_gone_while_it_is_opened(code):
    printer = Printer()
    backend = SimBackend(printer)
    given, calls = backend.open_device, []

    def opens(device: Printer) -> object:
        calls.append(device)
        if len(calls) == 2:  # after its names were read
            raise OSError(code, "gone")
        return given(device)

    backend.open_device = opens
    with pytest.raises(DeviceNotFoundError, match="went away while it was being opened"):
        UsbTransport.open(Uri.parse("usb:"), 1.0, backend)
    assert printer.open_handles == 0


def test_windows_without_winusb():
    backend = SimBackend(Printer())

    def opens(device: Printer) -> object:
        raise NotImplementedError("Operation not supported or unimplemented on this platform")

    backend.open_device = opens
    with pytest.raises(DeviceNotFoundError, match="WinUSB"):
        UsbTransport.open(Uri.parse("usb://04b8:0202"), 1.0, backend)


def test_other_systems_have_no_udev(monkeypatch):
    monkeypatch.setattr(usb_access.sys, "platform", "darwin")
    with pytest.raises(DevicePermissionError, match="as an administrator"):
        UsbTransport.open(Uri.parse("usb://04b8:0202"), 1.0, SimBackend(Printer(denied=True)))
