"""``file:``: a path to write to, whatever is there: a device node, a pipe, a file, or ``-``, stdout."""

from __future__ import annotations

import errno
import os
import select
import stat
import sys
import time
from contextlib import AbstractContextManager
from pathlib import Path
from types import TracebackType
from typing import Any, Self, cast

from devices.errors import DevicePermissionError
from devices.transports.base import Transport, Uri
from devices.transports.descriptor import PAUSE, DescriptorTransport
from halftone.errors import DeviceNotFoundError, HalftoneError, OutputError, UsageError
from halftone.images.output import output

__all__ = ["FileTransport", "PipeTransport", "RegularFile"]


class FileTransport(Transport):
    """``file:/dev/usb/lp0``, ``file:out.bin``, ``file:-``. What opens is one of its kinds."""

    scheme = "file"

    @classmethod
    def open(cls, uri: Uri, timeout: float = 10.0) -> Self:
        uri.check_query()
        if uri.host or not uri.path:
            raise UsageError(f"'{uri.text}' is not of the form file:/path, file:name or file:-")
        return cast("Self", _open(uri.path, timeout))


class RegularFile(FileTransport):
    """A file, which gets its name at close(), and only if there is a whole job in it: if flush()
    followed the last write, no error came between, and nobody called spoil()."""

    def __init__(self, path: str) -> None:
        self._output: AbstractContextManager[Any] | None = output(path)
        self._file = self._output.__enter__()
        self._whole = self._spoiled = False

    def write(self, data: memoryview, timeout: float) -> int:
        self._whole = False
        try:
            self._file.write(data)
        except BaseException:
            self._spoiled = True
            raise
        return len(data)

    def flush(self, timeout: float) -> bool:
        self._whole = True
        return True

    def spoil(self) -> None:
        """The job is broken off: what was written, and what may follow to complete it, is not kept."""
        self._spoiled = True

    def close(self) -> None:
        opened, self._output = self._output, None
        if opened is None:
            return
        if self._whole and not self._spoiled:
            opened.__exit__(None, None, None)
        else:
            why = _Unfinished()
            opened.__exit__(_Unfinished, why, None)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is not None:
            self.spoil()
        self.close()


class _Unfinished(Exception):  # noqa: N818 (no error: it tells the file not to take its name)
    """The job is not whole."""


class PipeTransport(DescriptorTransport, FileTransport):
    """A named pipe, or what stdout is. most : bytes that can be written without blocking, where the
    descriptor is shared with others and O_NONBLOCK is not ours to set; None if it is."""

    def __init__(self, descriptor: int, name: str, most: int | None = None) -> None:
        super().__init__(descriptor, name)
        self.most = most

    def close(self) -> None:
        self._close_descriptor()

    def _put(self, data: memoryview) -> int:
        if self.most is not None:
            poll = select.poll()
            poll.register(self.descriptor, select.POLLOUT)
            if not poll.poll(0):
                return 0
            data = data[: self.most]
        return super()._put(data)

    def _lost(self, error: OSError) -> HalftoneError:
        if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
            self.failed = True
            return OutputError(f"{self.name} cannot be written: {error.strerror}")
        return super()._lost(error)


def _open(path: str, timeout: float) -> Transport:
    if path == "-":
        return _stdout()
    try:
        mode = Path(path).stat().st_mode
    except FileNotFoundError:
        if Path(path).absolute().is_relative_to("/dev"):  # a file there helps nobody
            raise DeviceNotFoundError(
                f"there is no {path}: is the printer connected and switched on? "
                "'halftone devices list' shows what is there"
            ) from None
        return RegularFile(path)
    except OSError as error:
        raise DevicePermissionError(f"{path} cannot be looked at: {error.strerror}") from error
    if stat.S_ISREG(mode):
        return RegularFile(path)
    if stat.S_ISCHR(mode):
        from devices.transports.character import open_node

        return open_node(path)
    if stat.S_ISFIFO(mode):
        return _fifo(path, timeout)
    raise UsageError(
        f"{path} is neither a character device nor a pipe nor a file: nothing is written there"
    )


def _stdout() -> PipeTransport:
    if sys.stdout is None:
        raise OutputError("stdout is closed: nothing can be written there")
    sys.stdout.flush()
    number = sys.stdout.fileno()
    if os.isatty(number):
        raise UsageError(
            "stdout is a terminal, which would change the bytes; send it into a file or a pipe"
        )
    whole = stat.S_ISREG(os.fstat(number).st_mode)
    return PipeTransport(os.dup(number), "stdout", None if whole else select.PIPE_BUF)


def _fifo(path: str, timeout: float) -> PipeTransport:
    end = time.monotonic() + timeout
    while True:
        try:
            return PipeTransport(os.open(path, os.O_WRONLY | os.O_NONBLOCK | os.O_CLOEXEC), path)
        except OSError as error:
            if error.errno == errno.EACCES:
                raise DevicePermissionError(
                    f"the pipe {path} may not be written by this user"
                ) from error
            if error.errno != errno.ENXIO:
                raise DeviceNotFoundError(f"{path}: {error.strerror}") from error
            if time.monotonic() >= end:
                raise DeviceNotFoundError(f"nobody reads the pipe {path} ({timeout:g} s)") from error
            time.sleep(PAUSE)
