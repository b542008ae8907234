"""USB printers on a simulated bus: how one is opened, what its answers mean, how it is given back."""

from __future__ import annotations

import errno
from collections import deque

import pytest

pytest.importorskip("usb", reason="pyusb is not installed (pip install pyusb)")

from devices.errors import (
    DeviceBusyError,
    DevicePermissionError,
    DisconnectedError,
    StalledError,
)
from devices.status import Status
from devices.transports.base import Uri
from devices.transports.usb import UsbTransport
from halftone.errors import DeviceNotFoundError
from tests.devices.simulated_usb import Clock, SimBackend
from tests.devices.simulated_usb_printer import Fail, Printer, Setting, Stall, Take, Timeout, Unplug

ONE_WAY = ((0x03, 2, 64),)
BOTH = ((0x02, 2, 64), (0x81, 2, 64))


def opened(printer: Printer, uri: str = "usb:", clock: Clock | None = None) -> UsbTransport:
    return UsbTransport.open(Uri.parse(uri), 10.0, SimBackend(printer, clock=clock))


def write(transport: UsbTransport, data: bytes, timeout: float = 1.0) -> int:
    return transport.write(memoryview(data), timeout)


def did(printer: Printer, *names: str) -> list[tuple]:
    return [call for call in printer.calls if call[0] in names]


# --- which interface


@pytest.mark.parametrize(
    ("settings", "chosen"),
    [
        ((Setting(protocol=1, ends=ONE_WAY), Setting(setting=1, protocol=2)), (0, 1, 0x02)),
        ((Setting(protocol=2, ends=BOTH), Setting(setting=1, protocol=4)), (0, 0, 0x02)),
        ((Setting(protocol=3), Setting(interface=1, protocol=1, ends=ONE_WAY)), (1, 0, 0x03)),
        ((Setting(kind=3, ends=()), Setting(interface=2)), (2, 0, 0x02)),
        ((Setting(protocol=255),), (0, 0, 0x02)),
        ((Setting(protocol=2, ends=()), Setting(interface=1, protocol=1)), (1, 0, 0x02)),
        ((Setting(ends=((0x83, 3, 8), (0x03, 3, 8), (0x8E, 2, 512), (0x0D, 2, 512))),), (0, 0, 0x0D)),
    ],
    ids=[
        "bidirectional",
        "not IPP",
        "not packets",
        "not a keyboard",
        "of the maker",
        "none",
        "odd ends",
    ],
)
def test_the_best_interface_is_taken(settings, chosen):
    printer = Printer(settings)
    with opened(printer) as transport:
        assert write(transport, b"hello") == 5
        interface, setting, out = chosen
        assert list(printer.claims) == [interface]
        assert did(printer, "transfer") == [("transfer", out)]
        assert printer.current(interface).setting == setting
    assert printer.received == b"hello"


def test_a_setting_is_set_only_where_there_is_a_choice():
    one, two = Printer(), Printer((Setting(), Setting(setting=1, protocol=1)))
    for printer, calls in ((one, 0), (two, 1)):
        opened(printer).close()
        assert len(did(printer, "set_interface_altsetting")) == calls


def test_only_ipp_says_so():
    printer = Printer((Setting(protocol=4), Setting(setting=1, protocol=3)))
    with pytest.raises(DeviceNotFoundError, match="only IPP over USB: install ipp-usb"):
        opened(printer)
    assert not did(printer, "claim_interface", "set_configuration")


def test_interface_by_number():
    printer = Printer((Setting(), Setting(interface=1, protocol=1, ends=ONE_WAY)))
    with opened(printer, "usb://04b8:0202?interface=1") as transport:
        assert not transport.reads
        assert transport.read(10, 1.0) == b""
        assert list(printer.claims) == [1]
    with pytest.raises(DeviceNotFoundError, match="interface=2; allowed: 0, 1"):
        opened(printer, "usb://04b8:0202?interface=2")


# --- configuration, kernel driver, claim


def test_a_configuration_is_set_only_if_none_is():
    configured, bare = Printer(), Printer(configuration=0)
    for printer, calls in ((configured, []), (bare, [("set_configuration", 1)])):
        with opened(printer) as transport:
            assert write(transport, b"x") == 1
        assert did(printer, "set_configuration") == calls
        assert printer.configuration == 1


def test_the_configuration_that_is_set_is_kept_if_it_prints():
    """Though the other would answer, and this one only listens."""
    printer = Printer((Setting(protocol=1, ends=ONE_WAY), Setting(configuration=2)), configuration=1)
    with opened(printer):
        pass
    assert not did(printer, "set_configuration")


def test_a_printer_in_another_configuration_is_reached_and_left_as_it_was():
    settings = (Setting(kind=255), Setting(configuration=2))
    printer = Printer(settings, configuration=1, binds={1: {0: "vendor"}, 2: {0: "usblp"}})
    with opened(printer) as transport:
        assert printer.configuration == 2
        assert write(transport, b"x") == 1
    assert (printer.configuration, printer.drivers) == (1, {0: "vendor"})
    assert not did(printer, "attach_kernel_driver")


def test_the_kernel_driver_is_detached_and_attached_again():
    printer = Printer(drivers={0: "usblp"})
    transport = opened(printer)
    assert printer.drivers == {}
    transport.close()
    assert printer.drivers == {0: "usblp"}
    assert printer.open_handles == 0
    transport.close()
    assert len(did(printer, "attach_kernel_driver")) == 1


def test_a_driver_that_was_not_there_is_not_attached():
    printer = Printer()
    opened(printer).close()
    assert not did(printer, "detach_kernel_driver", "attach_kernel_driver")


def test_a_system_without_detaching_is_borne():
    printer = Printer(detaches=False)
    with opened(printer) as transport:
        assert write(transport, b"x") == 1
    assert printer.open_handles == 0


def test_a_driver_of_another_interface_is_left_alone():
    printer = Printer((Setting(kind=8), Setting(interface=1)), drivers={0: "usb-storage"})
    opened(printer).close()
    assert printer.drivers == {0: "usb-storage"}
    assert not did(printer, "detach_kernel_driver")


def test_a_driver_that_cannot_be_given_back_is_said():
    printer = Printer(drivers={0: "usblp"})
    transport = opened(printer)
    printer.removed.clear()  # the kernel would have it, and refuses
    backend = transport._backend
    backend.attach_kernel_driver = lambda handle, number: (_ for _ in ()).throw(
        OSError(errno.EBUSY, "busy")
    )
    with pytest.warns(UserWarning, match="could not be given back to the kernel: .*busy"):
        transport.close()
    assert printer.open_handles == 0


def test_never_a_reset():
    printer = Printer(drivers={0: "usblp"}, script=[Timeout(), Take(1), Stall()])
    with opened(printer) as transport:
        assert [write(transport, b"abc"), write(transport, b"abc")] == [0, 1]
        with pytest.raises(StalledError):
            write(transport, b"bc")
    assert not did(printer, "reset_device")


def test_held_by_another_program():
    printer = Printer(holders={0: "ipp-usb"})
    with pytest.raises(DeviceBusyError, match="usb://04b8:0202 is held by another program"):
        opened(printer)
    assert printer.open_handles == 0


def test_a_driver_is_given_back_when_opening_fails_later():
    printer = Printer(drivers={0: "usblp"}, holders={0: "someone"})
    with pytest.raises(DeviceBusyError):
        opened(printer)
    assert printer.drivers == {0: "usblp"}


def test_not_permitted_gives_the_rule():
    with pytest.raises(DevicePermissionError) as caught:
        opened(Printer(denied=True, vendor=0x0A5F, product=0x00A3), "usb://0a5f:00a3")
    text = str(caught.value)
    assert (
        'SUBSYSTEM=="usb", ATTR{idVendor}=="0a5f", ATTR{idProduct}=="00a3", '
        'MODE="0660", GROUP="lp", TAG+="uaccess"'
    ) in text
    assert "/etc/udev/rules.d/70-halftone-0a5f-00a3.rules" in text
    assert "udevadm control --reload" in text


# --- bytes to it


def test_a_transfer_is_at_most_8_kib():
    printer = Printer()
    with opened(printer) as transport:
        assert write(transport, bytes(20000)) == 8192 == transport.chunk
        assert write(transport, b"") == 0
    assert len(printer.received) == 8192
    assert len(did(printer, "transfer")) == 1


@pytest.mark.parametrize(
    ("outcome", "count", "seconds"),
    [(Take(3), 3, 0), (Timeout(0), 0, 2.5), (Timeout(4), 4, 2.5), (Take(99), 10, 0)],
)
def test_short_writes_and_timeouts_are_counts(outcome, count, seconds):
    printer, clock = Printer(script=[outcome]), Clock()
    with opened(printer, clock=clock) as transport:
        start = clock()
        assert write(transport, b"0123456789", 2.5) == count
        assert clock() - start == seconds
    assert printer.received == b"0123456789"[:count]


def test_no_time_is_one_millisecond_not_for_ever():
    clock = Clock()
    with opened(Printer(script=[Timeout()]), clock=clock) as transport:
        start = clock()
        assert write(transport, b"x", 0.0) == 0
        assert transport.read(4, 0.0) == b""
        assert clock() - start == pytest.approx(0.002)
        assert write(transport, b"x", float("inf")) == 1


def test_a_stall_is_cleared_once_and_named():
    printer = Printer(script=[Stall(2)])
    with opened(printer) as transport:
        with pytest.raises(StalledError, match="of the last 8192 bytes is unknown"):
            write(transport, b"abcdef")
        assert did(printer, "clear_halt") == [("clear_halt", 0x02)]
        assert not printer.halted
    assert printer.received == b"ab"


@pytest.mark.parametrize("first", [errno.ENODEV, errno.ESHUTDOWN, errno.ENOENT, errno.EIO, errno.EPROTO])
def test_unplugged(first):
    printer = Printer(drivers={0: "usblp"}, script=[Take(2), Unplug(0, first)])
    transport = opened(printer)
    assert write(transport, b"abc") == 2
    with pytest.raises(DisconnectedError, match="unplugged or switched off"):
        write(transport, b"c")
    with pytest.raises(DisconnectedError):
        transport.read(1, 0.1)
    assert transport.port_status() is None
    transport.close()
    transport.close()
    assert printer.open_handles == 0
    with pytest.raises(DisconnectedError, match="is closed"):
        write(transport, b"c")
    assert transport.port_status() is None


def test_a_failed_transfer_to_a_printer_that_is_still_there_is_no_unplugging():
    with (
        opened(Printer(script=[Fail(errno.EIO, 1)])) as transport,
        pytest.raises(StalledError, match="Input/output error"),
    ):
        write(transport, b"abc")


# --- bytes from it


def test_all_that_waits_is_read():
    printer, clock = Printer(replies=deque([b"\x12\x00", b"\x14\x01\x02"])), Clock()
    with opened(printer, clock=clock) as transport:
        assert transport.reads
        start = clock()
        assert transport.read(4096, 3.0) == b"\x12\x00\x14\x01\x02"
        assert clock() - start < 0.01
        assert transport.read(4096, 3.0) == b""
        assert clock() - start == pytest.approx(3, abs=0.01)


def test_a_packet_longer_than_asked_for_is_kept():
    printer = Printer(replies=deque([bytes(range(100)), b"next"]))
    with opened(printer) as transport:
        got = [transport.read(30, 1.0) for _ in range(5)]
    assert b"".join(got) == bytes(range(100)) + b"next"
    assert all(len(part) <= 30 for part in got)


def test_a_status_pipe_that_stalls_is_not_the_end():
    printer = Printer(in_stalls=1, replies=deque([b"ok"]))
    with opened(printer) as transport:
        assert transport.read(4, 0.1) == b""
        assert transport.read(4, 0.1) == b"ok"
        printer.in_stalls = 9
        assert [transport.read(4, 0.1) for _ in range(3)] == [b"", b"", b""]
        assert printer.in_stalls == 7
        assert not transport.reads
        assert write(transport, b"x") == 1


def test_a_printer_that_stops_until_it_is_read():
    printer = Printer(says=b"\x14\x00\x00\x0f", asks_every=100, queue_limit=12)
    data, done, heard = bytes(range(256)) * 8, 0, b""
    with opened(printer) as transport:
        while done < len(data):
            done += write(transport, data[done:], 0.5)
            heard += transport.read(4096, 0)
    assert printer.received == data
    assert len(heard) == 4 * (len(data) // 100)


# --- what it says


@pytest.mark.parametrize(
    ("answer", "status"),
    [
        (b"\x18", Status()),
        (b"\x30", Status.of("media-empty-error")),
        (b"\x38", Status.of("media-empty-error")),
        (b"\x10", Status.of("other-error")),
        (b"\x08", Status.of("offline-error")),
        (b"\x28", Status.of("media-empty-error", "offline-error")),
        (b"\xdf", Status()),
        (b"\x00", None),
        (b"\xff", None),
        (b"", None),
        (None, None),
    ],
)
def test_port_status(answer, status):
    with opened(Printer(status=answer)) as transport:
        assert transport.port_status() == status


def test_the_device_id_is_read():
    with opened(Printer()) as transport:
        assert (transport.device_id.model, transport.device_id.languages) == ("TM-T20", ("ESC/POS",))
    with opened(Printer(id=None)) as transport:
        assert transport.device_id.fields == {}


def test_a_printer_that_answers_no_question_is_opened_in_time():
    clock = Clock()
    printer = Printer(answers_control=False)
    backend = SimBackend(printer, clock=clock)
    with UsbTransport.open(Uri.parse("usb://04b8:0202"), 4.0, backend) as transport:
        assert clock() <= 4.0
        assert transport.port_status() is None
        assert write(transport, b"x") == 1
