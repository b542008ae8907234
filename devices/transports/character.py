"""A device node that takes bytes: ``/dev/lp0``, ``/dev/null``, and with usblp.py ``/dev/usb/lp0``."""

from __future__ import annotations

import errno
import fcntl
import os
import select
import struct
import time
from pathlib import Path

from devices.errors import (
    DeviceBusyError,
    DevicePermissionError,
    DeviceStateError,
    DisconnectedError,
    StalledError,
)
from devices.status import Status
from devices.transports.descriptor import PAUSE, DescriptorTransport
from devices.transports.file import FileTransport
from halftone.errors import DeviceNotFoundError, HalftoneError, OutputError, UsageError

__all__ = ["CharacterDevice", "open_node"]

LPGETSTATUS = 0x060B
"""linux/lp.h; usblp answers it too, with the byte of the printer class's GET_PORT_STATUS."""
USBLP_MAJOR, USBLP_MINORS, LP_MAJOR = 180, 16, 6
DEPARTURE = 1.0
"""Seconds that the node of a device which was unplugged may still be there."""
FLAGS = os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC


class CharacterDevice(DescriptorTransport, FileTransport):
    """An open device node. printer : whether a printer driver of the kernel is behind it."""

    ends = False

    def __init__(self, descriptor: int, path: str, reads: bool) -> None:
        super().__init__(descriptor, path)
        self.reads = reads
        self.number = os.fstat(descriptor).st_rdev
        self.printer = os.major(self.number) in (USBLP_MAJOR, LP_MAJOR)

    def port_status(self) -> Status | None:
        held = bytearray(struct.pack("i", 0))
        try:
            fcntl.ioctl(self.descriptor, LPGETSTATUS, held)
        except OSError:  # it has no such port; or it has gone, which the next write will say
            return None
        return Status.of_port(struct.unpack("i", held)[0])

    def flush(self, timeout: float) -> bool:
        poll = select.poll()
        poll.register(self.descriptor, select.POLLOUT)
        return bool(poll.poll(timeout * 1000))

    def close(self) -> None:
        self._close_descriptor()

    def _lost(self, error: OSError) -> HalftoneError:
        self.failed = True
        if error.errno == errno.ENOSPC and not self.printer:
            return OutputError(f"{self.name} cannot be written: {error.strerror}")
        if error.errno == errno.ENOSPC:  # a printer driver that was told to give up (LPABORT)
            return DeviceStateError(f"{self.name}: no paper", frozenset({"media-empty-error"}))
        if error.errno == errno.EIO and self._stays():
            return StalledError(
                f"{self.name} refuses data ({error.strerror}); switch the printer off and on"
            )
        return DisconnectedError(
            f"{self.name} went away ({error.strerror}): was it unplugged or switched off?"
        )

    def _stays(self) -> bool:
        """Whether the device is still there a little later: the kernel says EIO in both cases."""
        end = time.monotonic() + DEPARTURE
        while time.monotonic() < end:
            try:
                if Path(self.name).stat().st_rdev != self.number:
                    return False
            except OSError:
                return False
            time.sleep(PAUSE)
        return True


def open_node(path: str) -> CharacterDevice:
    """Open the node at *path*, for reading too where that is permitted and has a sense."""
    try:
        try:
            descriptor, reads = os.open(path, FLAGS | os.O_RDWR), True
        except OSError as error:
            if error.errno not in (errno.EACCES, errno.EINVAL, errno.EROFS, errno.ENOSYS):
                raise
            descriptor, reads = os.open(path, FLAGS | os.O_WRONLY), False
    except OSError as error:
        raise _refused(path, error) from error
    if os.isatty(descriptor):
        os.close(descriptor)
        raise UsageError(f"{path} is a terminal or serial port, which changes bytes: use serial:{path}")
    number = os.fstat(descriptor).st_rdev
    if os.major(number) == USBLP_MAJOR and os.minor(number) < USBLP_MINORS:
        from devices.transports.usblp import Usblp

        return Usblp(descriptor, path, reads)
    return CharacterDevice(descriptor, path, reads)


def _refused(path: str, error: OSError) -> DeviceNotFoundError:
    if error.errno in (errno.EACCES, errno.EPERM):
        return DevicePermissionError(
            f"{path} may not be opened by this user; join its group: "
            f"sudo usermod -aG {_group(path)} $USER, then log in again"
        )
    if error.errno == errno.EBUSY:
        return DeviceBusyError(f"{path} is open in another program; 'halftone devices doctor' names it")
    if error.errno in (errno.ENODEV, errno.ENXIO):
        return DeviceNotFoundError(
            f"{path} is there and no device answers behind it: is it switched on?"
        )
    return DeviceNotFoundError(f"{path} cannot be opened: {error.strerror}")


def _group(path: str) -> str:
    try:
        name = Path(path).group()
    except (KeyError, OSError):
        return "lp"
    return "lp" if name == "root" else name
