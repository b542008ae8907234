"""usblp's node, played by a pipe: writes to it block as those to a printer; tests.peers.test_vm has the
driver itself."""

from __future__ import annotations

import errno
import os
import signal
import threading
import time
from collections.abc import Iterator
from types import SimpleNamespace

import pytest

from devices.errors import DisconnectedError
from devices.transports import usblp
from devices.transports.usblp import Usblp

DATA = bytes(range(256)) * 1024
SOON, LATE = 0.05, 20.0


class Printer:
    """The other end of the pipe."""

    def __init__(self) -> None:
        self.end, descriptor = os.pipe()
        self.transport = Usblp(descriptor, "printer", False)
        self.got = bytearray()

    def give(self, data: bytes, timeout: float = LATE) -> int:
        done = 0
        while done < len(data):
            taken = self.transport.write(memoryview(data)[done:], timeout)
            if not taken:
                break
            done += taken
        return done

    def read(self, size: int) -> None:
        while len(self.got) < size:
            self.got += os.read(self.end, 1 << 16)

    def leave(self) -> None:
        end, self.end = self.end, -1
        if end >= 0:
            os.close(end)


@pytest.fixture
def printer() -> Iterator[Printer]:
    made = Printer()
    yield made
    made.leave()
    made.transport.close()


def test_all_bytes_arrive_once_though_the_reader_stops(printer: Printer) -> None:
    done = printer.give(DATA, SOON)
    assert 0 < done < len(DATA)
    start = time.monotonic()
    assert printer.transport.write(memoryview(DATA)[done:], SOON) == 0
    assert time.monotonic() - start >= SOON
    assert not printer.transport.flush(SOON)
    reader = threading.Thread(target=printer.read, args=(len(DATA),))
    reader.start()
    assert printer.give(DATA[done:]) == len(DATA) - done
    assert printer.transport.flush(LATE)
    reader.join()
    assert bytes(printer.got) == DATA


def test_no_signal_reaches_the_thread_that_writes(
    printer: Printer, monkeypatch: pytest.MonkeyPatch
) -> None:
    masks = []

    def write(descriptor: int, data: bytes) -> int:
        masks.append(signal.pthread_sigmask(signal.SIG_BLOCK, []))
        return len(data)

    monkeypatch.setattr(os, "write", write)
    printer.give(b"abc")
    assert {signal.SIGINT, signal.SIGTERM, signal.SIGCHLD, signal.SIGALRM} <= masks[0]
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def test_what_fails_later_is_said_later(printer: Printer) -> None:
    done = printer.give(DATA, SOON)
    printer.leave()
    with pytest.raises(DisconnectedError):
        printer.transport.write(memoryview(DATA)[done:], LATE)
    with pytest.raises(DisconnectedError):
        printer.transport.flush(LATE)


def test_close_waits_for_what_is_on_its_way(printer: Printer) -> None:
    done = printer.give(DATA, SOON)
    reader = threading.Timer(SOON, printer.read, (done,))
    reader.start()
    printer.transport.close()
    reader.join()
    assert bytes(printer.got) == DATA[:done]


def test_close_gives_up_what_is_not_taken(printer: Printer, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def ioctl(descriptor: int, request: int, held: bytes | int) -> bytes | int:
        asked.append((request, held))
        if request == usblp.GET_PROTOCOLS:
            return b"\x02\0\0\0\x06\0\0\0"
        printer.leave()  # the driver ends the write with an error
        return 0

    monkeypatch.setattr(usblp, "fcntl", SimpleNamespace(ioctl=ioctl))
    monkeypatch.setattr(usblp, "CLOSING", SOON)
    printer.give(DATA, SOON)
    printer.transport.close()
    assert asked == [(0x80085002, bytes(8)), (0x40005003, 2)]


def test_a_printer_that_only_listens_is_not_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(usblp, "_protocol", lambda descriptor: 1)
    end, descriptor = os.pipe()
    transport = Usblp(descriptor, "printer", True)
    assert not transport.reads
    transport.close()
    os.close(end)


def test_device_id(printer: Printer, monkeypatch: pytest.MonkeyPatch) -> None:
    def ioctl(descriptor: int, request: int, held: bytearray) -> int:
        assert request == 0x84005001
        held[:12] = b"\0\x0cMFG:EPSON;"
        return 0

    assert printer.transport.device_id.make == ""
    monkeypatch.setattr(usblp, "fcntl", SimpleNamespace(ioctl=ioctl))
    assert printer.transport.device_id.make == "EPSON"


def test_errors_have_names(printer: Printer, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(descriptor: int, data: bytes) -> int:
        raise OSError(errno.ENODEV, "No such device")

    monkeypatch.setattr(os, "write", refuse)
    with pytest.raises(DisconnectedError, match="unplugged"):
        printer.give(b"abc")
