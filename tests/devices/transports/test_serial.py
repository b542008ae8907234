"""serial: over pseudo terminals."""

from __future__ import annotations

import builtins
import errno
import os
import select
import termios
import threading
import time
import tty
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from devices.errors import DeviceBusyError, DevicePermissionError, DisconnectedError
from devices.transports import open_transport
from devices.transports.base import Uri
from devices.transports.serial import AHEAD, SerialTransport
from halftone.errors import DeviceNotFoundError, UsageError

DATA = bytes(range(256)) * 256
SOON, LATE = 0.05, 20.0

pytest.importorskip("serial", reason="pyserial is an optional extra")


class Line:
    """A pseudo terminal: our end is the printer's."""

    def __init__(self) -> None:
        self.main, terminal = os.openpty()
        tty.setraw(terminal)
        self.path = os.ttyname(terminal)
        self._terminal = terminal

    def unplug(self) -> None:
        for descriptor in (self.main, self._terminal):
            if descriptor >= 0:
                os.close(descriptor)
        self.main = self._terminal = -1

    def read(self, size: int) -> bytes:
        got = b""
        while len(got) < size:
            got += os.read(self.main, size - len(got))
        return got

    def quiet(self) -> bool:
        return not select.select([self.main], [], [], SOON)[0]


@pytest.fixture
def line() -> Iterator[Line]:
    made = Line()
    yield made
    made.unplug()


def opened(line: Line, query: str = "flow=none") -> SerialTransport:
    return SerialTransport.open(Uri.parse(f"serial:{line.path}?{query}"))


def give(transport: SerialTransport, data: bytes, timeout: float = LATE) -> int:
    done = 0
    while done < len(data):
        taken = transport.write(memoryview(data)[done:], timeout)
        if not taken:
            break
        done += taken
    return done


@pytest.mark.parametrize("flow", ["none", "xonxoff", "rtscts"])
def test_all_bytes_arrive_once_though_the_reader_stops(line: Line, flow: str) -> None:
    with opened(line, f"baud=115200&flow={flow}") as transport:
        done = give(transport, DATA, SOON)
        assert 0 < done < len(DATA)
        start = time.monotonic()
        assert transport.write(memoryview(DATA)[done:], SOON) == 0
        assert time.monotonic() - start >= SOON
        got: list[bytes] = []
        thread = threading.Thread(target=lambda: got.append(line.read(len(DATA))))
        thread.start()
        assert give(transport, DATA[done:]) == len(DATA) - done
        thread.join()
        assert transport.flush(LATE)
    assert got == [DATA]


def test_answers_are_read(line: Line) -> None:
    with opened(line) as transport:
        assert transport.read(10, SOON) == b""
        os.write(line.main, b"\x12\x00\xff\x11\x13")
        assert transport.read(10, LATE) == b"\x12\x00\xff\x11\x13"


def test_xoff_holds_and_xon_goes_on(line: Line) -> None:
    with opened(line, "flow=xonxoff") as transport:
        os.write(line.main, b"\x13")
        assert not transport.read(1, SOON)  # taken by the line, not by us
        taken = give(transport, DATA[:100], SOON)
        assert line.quiet()
        os.write(line.main, b"\x11")
        assert give(transport, DATA[taken:100]) == 100 - taken
        assert line.read(100) == DATA[:100]


def test_bytes_that_mean_something_to_a_terminal_pass(line: Line) -> None:
    with opened(line, "flow=xonxoff") as transport:
        every = bytes(range(256))
        assert give(transport, every) == 256
        assert line.read(256) == every


def test_dsr_holds_and_goes_on(line: Line, monkeypatch: pytest.MonkeyPatch) -> None:
    with opened(line, "flow=dsrdtr") as transport:
        ready = [False]
        monkeypatch.setattr(type(transport.port), "dsr", property(lambda port: ready[0]))
        assert transport.write(memoryview(DATA), SOON) == 0
        ready[0] = True
        assert transport.write(memoryview(DATA), LATE) == AHEAD
        monkeypatch.setattr("devices.transports.serial.queued", lambda descriptor: 1)
        assert transport.write(memoryview(DATA)[AHEAD:], SOON) == 0  # the last ones are not out yet
        assert line.read(AHEAD) == DATA[:AHEAD]
        assert line.quiet()


@pytest.mark.parametrize(
    "act",
    [
        lambda transport: give(transport, DATA),
        lambda transport: transport.read(1, LATE),
        lambda transport: transport.flush(LATE),
    ],
    ids=["write", "read", "flush"],
)
def test_unplugged(line: Line, act: Callable[[SerialTransport], object]) -> None:
    with opened(line) as transport:
        line.unplug()
        with pytest.raises(DisconnectedError, match="unplugged"):
            act(transport)
        transport.close()
        transport.close()


def test_flush_is_bounded(line: Line, monkeypatch: pytest.MonkeyPatch) -> None:
    with opened(line) as transport:
        monkeypatch.setattr("devices.transports.serial.queued", lambda descriptor: 5)
        start = time.monotonic()
        assert not transport.flush(SOON)
        assert time.monotonic() - start >= SOON


@pytest.mark.parametrize("query", ["baud=19200&parity=even&stop=2", "baud=19200+parity=even+stop=2"])
def test_the_line_is_set_as_asked(line: Line, query: str) -> None:
    with opened(line, query) as transport:
        _, _, control, _, _, speed, _ = termios.tcgetattr(transport.descriptor)
        assert speed == termios.B19200
        assert transport.port.parity == "E"  # pseudo terminals have none themselves
        assert control & termios.CSTOPB
        assert control & termios.CRTSCTS  # not said: a port holds its sender
        assert transport.port.rtscts


@pytest.mark.parametrize(
    ("name", "flow"), [("hard", "rtscts"), ("soft", "xonxoff"), ("dtrdsr", "dsrdtr"), ("none", "none")]
)
def test_flow_by_the_names_of_cups(line: Line, name: str, flow: str) -> None:
    with opened(line, f"baud=9600+flow={name}") as transport:
        on = {
            "rtscts": transport.port.rtscts,
            "xonxoff": transport.port.xonxoff,
            "dsrdtr": transport.dsr,
        }
        assert [key for key, value in on.items() if value] == [flow] * (flow != "none")


def test_a_port_is_opened_once(line: Line) -> None:
    with opened(line), pytest.raises(DeviceBusyError, match="another program"):
        opened(line)
    opened(line).close()


def test_no_such_port() -> None:
    with pytest.raises(DeviceNotFoundError, match="no serial port /dev/ttyUSB97"):
        open_transport(Uri.parse("serial:/dev/ttyUSB97"))


def test_not_a_port() -> None:
    with pytest.raises(DeviceNotFoundError, match="no serial port that can be set"):
        open_transport(Uri.parse("serial:/dev/null"))


def test_not_permitted(line: Line, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*args: Any) -> int:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(os, "open", refuse)
    with pytest.raises(DevicePermissionError, match="usermod -aG dialout"):
        opened(line)


def test_without_pyserial(line: Line, monkeypatch: pytest.MonkeyPatch) -> None:
    really = builtins.__import__

    def missing(name: str, *args: Any) -> Any:
        if name == "serial":
            raise ImportError
        return really(name, *args)

    monkeypatch.setattr(builtins, "__import__", missing)
    with pytest.raises(DeviceNotFoundError, match="pip install"):
        opened(line)


@pytest.mark.parametrize(
    "query", ["baud=fast", "baud=1", "flow=maybe", "parity=mark", "bits=9", "stop=3", "speed=9600"]
)
def test_options_that_are_refused(line: Line, query: str) -> None:
    with pytest.raises(UsageError, match=r"allowed|unknown option"):
        opened(line, query)


@pytest.mark.parametrize("text", ["serial:", "serial://host/dev/ttyS0"])
def test_uris_that_are_refused(text: str) -> None:
    with pytest.raises(UsageError, match="not of the form"):
        open_transport(Uri.parse(text))
