"""What sockets, device nodes, pipes and serial ports share: a file descriptor that does not block."""

from __future__ import annotations

import errno
import fcntl
import os
import select
import struct
import time
from collections.abc import Iterator
from contextlib import suppress

from devices.errors import DisconnectedError
from devices.transports.base import Transport
from halftone.errors import HalftoneError

__all__ = ["DescriptorTransport", "queued"]

CLOSED = "it has closed the connection"
PAUSE = 0.01
"""Seconds between two looks where the kernel has nothing to wake us with."""


class DescriptorTransport(Transport):
    """A transport over a descriptor with O_NONBLOCK.

    name : of the device, for messages. ends : whether an empty read says that the other side has gone
    (as of a socket), or only that nothing came (as of usblp).
    """

    ends = True

    def __init__(self, descriptor: int, name: str) -> None:
        self.descriptor, self.name = descriptor, name
        self.failed = False
        """Whether an error broke it off; then nothing more is waited for."""

    def write(self, data: memoryview, timeout: float) -> int:
        for _ in self._rounds(select.POLLOUT, timeout if data else 0):
            try:
                taken = self._put(data)
            except BlockingIOError:
                continue
            except OSError as error:
                raise self._lost(error) from error
            if taken:
                return taken
        self._nothing_taken()
        return 0

    def read(self, size: int, timeout: float) -> bytes:
        poll = select.poll()
        poll.register(self.descriptor, select.POLLIN)
        for _ in self._rounds(select.POLLIN, timeout):
            if not poll.poll(0):
                continue
            try:
                data = os.read(self.descriptor, size)
            except BlockingIOError:
                continue
            except OSError as error:
                raise self._lost(error) from error
            if data:
                return data
            if self.ends:
                raise self._lost(OSError(errno.EPIPE, CLOSED))
        return b""

    def _put(self, data: memoryview) -> int:
        """One attempt to write; BlockingIOError or 0 if it takes nothing now."""
        return os.write(self.descriptor, data)

    def _nothing_taken(self) -> None:
        """Called when a write has waited in vain: may raise what the kernel knows of the reason."""

    def _lost(self, error: OSError) -> HalftoneError:
        """What an error of the kernel says."""
        self.failed = True
        return DisconnectedError(f"{self.name} went away: {error.strerror or error}")

    def _rounds(self, event: int, timeout: float) -> Iterator[None]:
        """At once, and again whenever the kernel says that it is worth it, until *timeout* has passed.

        Some drivers say so and then refuse (usblp without paper): a short sleep comes between.
        """
        end = time.monotonic() + timeout
        poll = select.poll()
        poll.register(self.descriptor, event)
        told = False
        while True:
            yield
            if told:
                time.sleep(max(0.0, min(PAUSE, end - time.monotonic())))
            if (left := end - time.monotonic()) <= 0:
                return
            told = bool(poll.poll(max(1, int(left * 1000))))

    def _close_descriptor(self) -> None:
        descriptor, self.descriptor = self.descriptor, -1
        if descriptor >= 0:
            with suppress(OSError):  # a device that has gone says so here too
                os.close(descriptor)


def queued(descriptor: int) -> int | None:
    """Bytes that the kernel still holds (SIOCOUTQ, TIOCOUTQ); None where it does not say."""
    import termios

    try:
        return int(struct.unpack("i", fcntl.ioctl(descriptor, termios.TIOCOUTQ, struct.pack("i", 0)))[0])
    except OSError as error:
        if error.errno in (errno.EIO, errno.ENODEV):
            raise
        return None
