"""``file:/dev/usb/lp0``: a USB printer that the kernel's driver usblp has.

Three traps of that driver (drivers/usb/class/usblp.c) decide how it is written to:

- with O_NONBLOCK it presumes that what it sends will arrive, and tells nobody if not;
- a signal interrupts a blocking write whose bytes are on their way all the same, and Python would
  write them again;
- what is on its way when it is closed is thrown away.

So a thread that no signal reaches writes, a piece at a time, and close() waits for it.
"""

from __future__ import annotations

import fcntl
import os
import signal
import struct
import threading
import time
from contextlib import suppress

from devices.transports.character import CharacterDevice
from devices.transports.device_id import DeviceId
from halftone.errors import HalftoneError

__all__ = ["Usblp"]

ID_SIZE = 1024
GET_DEVICE_ID = 2 << 30 | ID_SIZE << 16 | ord("P") << 8 | 1
GET_PROTOCOLS = 2 << 30 | 8 << 16 | ord("P") << 8 | 2
SET_PROTOCOL = 1 << 30 | ord("P") << 8 | 3
"""_IOC(read or write, 'P', number, size) of usblp.c."""
ONLY_LISTENS = 1
CLOSING = 2.0
"""Seconds that close() waits for the printer to take what is on its way."""


class Usblp(CharacterDevice):
    """The printer behind an open node of usblp.

    A piece that the printer does not take in time counts as taken, for the kernel has it; if it fails
    later, the next call says so.
    """

    chunk = 1 << 13  # what the driver sends at a time

    def __init__(self, descriptor: int, path: str, reads: bool) -> None:
        super().__init__(descriptor, path, reads and _protocol(descriptor) != ONLY_LISTENS)
        os.set_blocking(descriptor, True)
        self._writer: threading.Thread | None = None
        self._error: OSError | None = None

    @property
    def device_id(self) -> DeviceId:
        """What it says it is; empty if it does not say."""
        held = bytearray(ID_SIZE)
        try:
            fcntl.ioctl(self.descriptor, GET_DEVICE_ID, held)
        except OSError:
            return DeviceId()
        return DeviceId.parse(bytes(held))

    def write(self, data: memoryview, timeout: float) -> int:
        end = time.monotonic() + timeout
        if not data or not self.flush(timeout):
            return 0
        piece = bytes(data[: self.chunk])
        self._writer = threading.Thread(target=self._write_all, args=(piece,), daemon=True)
        self._writer.start()
        self.flush(max(0.0, end - time.monotonic()))
        return len(piece)

    def flush(self, timeout: float) -> bool:
        """Wait for the printer to take what it was given; raises what went wrong with it."""
        if self._writer is not None:
            self._writer.join(timeout)
            if self._writer.is_alive():
                return False
            self._writer = None
        if self._error is not None:
            raise self._lost(self._error) from self._error
        return True

    def close(self) -> None:
        try:
            if self.descriptor >= 0 and not self.flush(0.0 if self.failed else CLOSING):
                self._give_up()
        except HalftoneError:
            pass  # it went away; whoever wanted to know asked flush()
        finally:
            self._close_descriptor()

    def _write_all(self, piece: bytes) -> None:
        signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
        try:
            while piece:
                piece = piece[os.write(self.descriptor, piece) :]
        except OSError as error:
            self._error = error

    def _give_up(self) -> None:
        """Make the driver drop what the printer does not take: to set its protocol again does."""
        with suppress(OSError):
            fcntl.ioctl(self.descriptor, SET_PROTOCOL, _protocol(self.descriptor))
            self.flush(CLOSING)


def _protocol(descriptor: int) -> int:
    """Of the interface: 1 only listens, 2 answers too; 0 if the driver does not say."""
    try:
        answer = fcntl.ioctl(descriptor, GET_PROTOCOLS, bytes(8))
    except OSError:
        return 0
    return int(struct.unpack("ii", answer)[0])
