"""The calls that a Linux frame buffer takes (linux/fb.h), and what it means if one fails."""

from __future__ import annotations

import errno
import mmap
import struct
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from devices.errors import DeviceBusyError, DevicePermissionError
from devices.fbscreen import FIX, VAR
from halftone.errors import DeviceFaultError, DeviceNotFoundError, HalftoneError, UsageError

if TYPE_CHECKING:
    from io import FileIO

__all__ = ["FrameBufferNode", "Kernel"]

GET_VAR, PUT_VAR, GET_FIX, GET_MAP, PUT_MAP = 0x4600, 0x4601, 0x4602, 0x4604, 0x4605
MAP = struct.Struct("@IIPPPP")
"""fb_cmap: first entry, entries, and where red, green, blue and transparency lie."""

Tables = NDArray[np.uint16]


class Kernel:
    """The calls into Linux, so that a test can stand in for it."""

    def open(self, path: str) -> FileIO:
        return open(path, "r+b", buffering=0)

    def ioctl(self, file: FileIO, request: int, argument: bytearray) -> None:
        import fcntl  # not every system has it

        fcntl.ioctl(file, request, argument)

    def map(self, file: FileIO, length: int) -> mmap.mmap:
        return mmap.mmap(file.fileno(), length)


class FrameBufferNode:
    """An open frame buffer. Its methods raise UsageError for what the driver refuses or after close(),
    else errors of the device."""

    def __init__(self, path: str, kernel: Kernel) -> None:
        self.path, self._kernel = path, kernel
        self._memory: mmap.mmap | None = None
        try:
            self._file = kernel.open(path)
        except OSError as error:
            raise _not_opened(path, error) from error

    @property
    def closed(self) -> bool:
        return self._file.closed

    def fix(self) -> bytes:
        """fb_fix_screeninfo."""
        return self._ask(GET_FIX, bytearray(FIX.size))

    def var(self) -> bytes:
        """fb_var_screeninfo."""
        return self._ask(GET_VAR, bytearray(VAR.size))

    def put_var(self, var: bytes) -> None:
        self._ask(PUT_VAR, bytearray(var))

    def colours(self, entries: int) -> Tables:
        """The first *entries* of the colour map: uint16 (3, entries), of red, green, blue."""
        tables = np.zeros((3, entries), np.uint16)
        self._ask(GET_MAP, _cmap(tables))
        return tables

    def put_colours(self, tables: Tables) -> None:
        self._ask(PUT_MAP, _cmap(tables))

    def map(self, length: int) -> None:
        """Map the memory, anew if it was."""
        self._unmap()
        try:
            self._memory = self._kernel.map(self._file, length)
        except (OSError, ValueError) as error:
            raise DeviceFaultError(f"{self.path}: {length} bytes cannot be mapped: {error}") from error

    @property
    def memory(self) -> mmap.mmap:
        if self._memory is None:
            raise UsageError(f"{self.path} was closed; open it again")
        return self._memory

    def flush(self) -> None:
        """For screens that are sent what has changed (deferred I/O)."""
        try:
            self.memory.flush()
        except OSError as error:
            if error.errno != errno.EINVAL:  # a kernel without deferred I/O: there is nothing to do
                raise DeviceFaultError(f"{self.path} was not brought up to date: {error}") from error

    def close(self) -> None:
        self._unmap()
        self._file.close()

    def _unmap(self) -> None:
        memory, self._memory = self._memory, None
        if memory is not None:
            memory.close()

    def _ask(self, request: int, argument: bytearray) -> bytes:
        if self.closed:
            raise UsageError(f"{self.path} was closed; open it again")
        try:
            self._kernel.ioctl(self._file, request, argument)
        except OSError as error:
            raise _refused(self.path, request, error) from error
        return bytes(argument)


def _cmap(tables: Tables) -> bytearray:
    """fb_cmap of all entries; *tables* must live as long as it."""
    return bytearray(MAP.pack(0, tables.shape[1], *(row.ctypes.data for row in tables), 0))


def _not_opened(path: str, error: OSError) -> HalftoneError:
    if error.errno in (errno.EACCES, errno.EPERM):
        return DevicePermissionError(
            f"{path} may not be opened by this user: 'sudo usermod -aG video $USER', then log in again"
        )
    if error.errno == errno.EBUSY:
        return DeviceBusyError(f"{path} is held by another program; end it, then try again")
    return DeviceNotFoundError(
        f"{path} cannot be opened ({error.strerror or error}): 'ls /dev/fb*' shows the frame buffers; "
        "to try without a screen: 'sudo modprobe vfb vfb_enable=1'"
    )


def _refused(path: str, request: int, error: OSError) -> HalftoneError:
    """What a failed call means."""
    if error.errno == errno.ENOTTY:
        return DeviceNotFoundError(
            f"{path} is not a frame buffer, or its driver lacks call {request:#x}"
        )
    if error.errno in (errno.EACCES, errno.EPERM):
        return DevicePermissionError(f"{path}: this user may not change it")
    if error.errno == errno.EBUSY:
        return DeviceBusyError(f"{path} is held by another program; end it, then try again")
    if error.errno == errno.ENOMEM:
        return UsageError(f"{path}: not enough video memory; ask for fewer pixels or bits")
    if error.errno == errno.EINVAL:
        return UsageError(f"{path}: the driver refuses what was asked (call {request:#x})")
    return DeviceFaultError(f"{path}: call {request:#x} failed: {error}")
