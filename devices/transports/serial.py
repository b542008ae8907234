"""``serial:/dev/ttyUSB0?baud=115200&flow=rtscts``: a serial port, by pyserial (an optional extra)."""

from __future__ import annotations

import errno
import os
import termios
import time
from contextlib import suppress
from dataclasses import replace
from typing import Any, Self
from urllib.parse import parse_qsl

from devices.errors import DeviceBusyError, DevicePermissionError, DisconnectedError
from devices.transports.base import Uri
from devices.transports.descriptor import PAUSE, DescriptorTransport, queued
from halftone.errors import DeviceNotFoundError, HalftoneError, UsageError

__all__ = ["SerialTransport"]

CHOICES = {
    "flow": ("rtscts", "none", "xonxoff", "dsrdtr"),
    "parity": ("none", "even", "odd"),
    "bits": ("8", "7"),
    "stop": ("1", "2"),
}
"""Options and what they allow; the first is the default."""
CUPS_FLOW = {"hard": "rtscts", "soft": "xonxoff", "dtrdsr": "dsrdtr"}
BAUD = 9600
AHEAD = 64
"""Bytes written at a time with flow=dsrdtr: a printer that has lowered the line takes that many more."""


class SerialTransport(DescriptorTransport):
    """A serial port. Options: ``baud`` (9600), ``flow`` (rtscts, none, xonxoff, dsrdtr),
    ``parity`` (none, even, odd), ``bits`` (8, 7), ``stop`` (1, 2); between them & or, as in CUPS, +.

    A printer without flow control loses what it has no room for, so a port has it unless told otherwise;
    on a cable of three wires nothing moves then, and flow=none is needed.
    pyserial sets the port up; bytes go through the descriptor, as pyserial's own writes either block
    or spin. dsrdtr, which Linux does not know, is done here, a few bytes at a time.
    """

    scheme = "serial"
    reads = True
    chunk = 1 << 12

    def __init__(self, port: Any, name: str, dsr: bool = False) -> None:
        super().__init__(port.fileno(), name)
        self.port, self.dsr = port, dsr

    @classmethod
    def open(cls, uri: Uri, timeout: float = 10.0) -> Self:
        query = dict(parse_qsl(uri.text.partition("?")[2].replace("+", "&"), keep_blank_values=True))
        query["flow"] = CUPS_FLOW.get(query.get("flow", ""), query.get("flow", CHOICES["flow"][0]))
        uri = replace(uri, query=query)
        uri.check_query("baud", *CHOICES)
        if uri.host or not uri.path:
            raise UsageError(f"'{uri.text}' is not of the form serial:/dev/ttyUSB0?baud=115200")
        chosen = {key: uri.query.get(key, allowed[0]) for key, allowed in CHOICES.items()}
        for key, value in chosen.items():
            if value not in CHOICES[key]:
                raise UsageError(f"{uri.text}: {key}={value}; allowed: {', '.join(CHOICES[key])}")
        baud = uri.number("baud", BAUD, 50, 4_000_000)
        try:
            import serial
        except ImportError:
            raise DeviceNotFoundError(
                'serial: URIs need pyserial: pip install "halftone-kit[serial]" '
                "(or apt install python3-serial)"
            ) from None
        try:
            port = serial.Serial(
                uri.path,
                int(baud),
                bytesize=int(chosen["bits"]),
                parity=chosen["parity"][0].upper(),
                stopbits=int(chosen["stop"]),
                timeout=0,
                write_timeout=0,
                xonxoff=chosen["flow"] == "xonxoff",
                rtscts=chosen["flow"] == "rtscts",
                exclusive=True,
            )
        except (OSError, ValueError, termios.error) as error:  # SerialException is an OSError
            raise _refused(uri.path, error) from error
        return cls(port, uri.path, chosen["flow"] == "dsrdtr")

    def flush(self, timeout: float) -> bool:
        end = time.monotonic() + timeout
        try:
            while queued(self.descriptor):
                if (left := end - time.monotonic()) <= 0:
                    return False
                time.sleep(min(PAUSE, left))
            termios.tcdrain(self.descriptor)  # what the chip holds, some bytes: nothing stops it now
        except (OSError, termios.error) as error:
            raise self._lost(error) from error
        return True

    def close(self) -> None:
        """The kernel goes on sending what it has, for 30 s at most; after an error it is dropped."""
        if self.descriptor < 0:
            return
        with suppress(OSError, termios.error):
            if self.failed:
                termios.tcflush(self.descriptor, termios.TCOFLUSH)
        self.descriptor = -1
        with suppress(OSError, termios.error):  # a port that has gone says so here too
            self.port.close()

    def _put(self, data: memoryview) -> int:
        if not self.dsr:
            return os.write(self.descriptor, data)
        if queued(self.descriptor) or not self.port.dsr:
            time.sleep(PAUSE / 10)  # the descriptor is writable all the time: nothing else would wait
            return 0
        return os.write(self.descriptor, data[:AHEAD])

    def _lost(self, error: OSError | termios.error) -> HalftoneError:
        self.failed = True
        return DisconnectedError(f"{self.name} went away ({error.args[-1]}): was it unplugged?")


def _refused(path: str, error: Exception) -> HalftoneError:
    code = getattr(error, "errno", None)
    if code in (errno.EACCES, errno.EPERM):
        return DevicePermissionError(
            f"{path} may not be opened by this user; join the group of serial ports: "
            "sudo usermod -aG dialout $USER, then log in again"
        )
    if code == errno.ENOENT:
        return DeviceNotFoundError(
            f"there is no serial port {path}: is it plugged in? "
            "'halftone devices list' shows what is there"
        )
    if code in (errno.EBUSY, errno.EAGAIN) or "exclusively lock" in str(error):
        return DeviceBusyError(f"{path} is open in another program; 'halftone devices doctor' names it")
    if isinstance(error, ValueError):
        return UsageError(f"{path}: {error}")
    return DeviceNotFoundError(f"{path} is no serial port that can be set so: {error}")
