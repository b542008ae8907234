"""Files out: whole or not at all. They get their name when they are complete."""

# pathlib takes 4 ms to import, which a small picture would notice.
# ruff: noqa: PTH101, PTH104, PTH108, PTH110, PTH113, PTH116, PTH118, PTH120
from __future__ import annotations

import os
import stat
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, BinaryIO, Protocol

from halftone.errors import OutputError

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["Output", "discard_unfinished", "output"]

CHUNK = 1 << 20


class _Unfinished:
    """Files that have no name yet."""

    def __init__(self) -> None:
        self.paths: set[str] = set()
        self.lock = threading.Lock()
        self.closed = False

    def create(self, path: str) -> BinaryIO:
        with self.lock:
            if self.closed:
                raise KeyboardInterrupt
            self.paths.add(path)
            return open(path, "xb")

    def remove(self, path: str) -> None:
        with suppress(OSError):  # it may never have come to be, or have its name
            os.unlink(path)
        self.paths.discard(path)


_UNFINISHED = _Unfinished()


class Output(Protocol):
    """What the writers of file formats ask of a file."""

    def write(self, data: Any, /) -> Any: ...
    def seek(self, place: int, /) -> Any: ...


class _File:
    """A file being written, with errors as ours; BrokenPipeError of stdout goes through."""

    def __init__(self, file: BinaryIO, name: str) -> None:
        self.file, self.name = file, name
        self.size = self.place = 0

    def write(self, data: Any) -> None:
        try:
            self.file.write(data)
        except OSError as error:
            if isinstance(error, BrokenPipeError) and self.name == "stdout":
                raise
            raise _refused(self.name, error) from None
        self.place += memoryview(data).nbytes
        self.size = max(self.size, self.place)

    def seek(self, place: int) -> None:
        self.place = self.file.seek(place)


@contextmanager
def output(path: str | Path, *, overwrite: bool = True, seeks: bool = False) -> Iterator[_File]:
    """A file to write to: stdout for ``-``; else under a temporary name, and renamed at the end.

    seeks : whether the writer goes back; stdout and devices get such a file when it is complete.
    """
    if str(path) == "-":
        if sys.stdout is None:
            raise OutputError("stdout is closed: nothing can be written there")
        with _through(_File(sys.stdout.buffer, "stdout"), seeks) as file:
            yield file
        return
    target = os.fspath(path)
    try:
        there = os.path.exists(target)
        if there and not overwrite:
            raise FileExistsError
        if there and not os.path.isfile(target):  # a device or a pipe takes the bytes directly
            with open(target, "wb") as device, _through(_File(device, f"'{target}'"), seeks) as file:
                yield file
            return
        if there:
            target = os.path.realpath(target)  # what a link points to is replaced, not the link
        name = f".halftone-{os.urandom(6).hex()}.part"
        temporary = os.path.join(os.path.dirname(target), name)
        try:
            with _UNFINISHED.create(temporary) as part:
                yield _File(part, f"'{target}'")
            _give_name(temporary, target, overwrite)
        finally:
            _UNFINISHED.remove(temporary)
    except FileExistsError:
        what = f"'{target}' exists and --no-overwrite was given; nothing was written"
        raise OutputError(what) from None
    except OutputError:
        raise
    except OSError as error:
        raise _refused(f"'{target}'", error) from None


def discard_unfinished() -> None:
    """Take away all files that have no name yet, and make no more: the process is about to end."""
    with _UNFINISHED.lock:
        _UNFINISHED.closed = True
        for path in list(_UNFINISHED.paths):
            _UNFINISHED.remove(path)


@contextmanager
def _through(file: _File, seeks: bool) -> Iterator[_File]:
    """*file* itself, or one that can go back, whose bytes it gets at the end."""
    if not seeks:
        yield file
    else:
        from tempfile import TemporaryFile

        with TemporaryFile() as spool:
            yield (spooled := _File(spool, "a temporary file"))
            spool.seek(0)
            while chunk := spool.read(CHUNK):
                file.write(chunk)
            file.size = spooled.size
    try:
        file.file.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise _refused(file.name, error) from None


def _give_name(temporary: str, target: str, overwrite: bool) -> None:
    if os.path.exists(target):
        os.chmod(temporary, stat.S_IMODE(os.stat(target).st_mode))
    if overwrite:
        os.replace(temporary, target)
        return
    try:
        os.link(temporary, target)  # in one step where the disk can
    except FileExistsError:
        raise
    except OSError:  # FAT and some network disks know no links
        if os.path.exists(target):
            raise FileExistsError from None
        os.rename(temporary, target)


def _refused(name: str, error: OSError) -> OutputError:
    return OutputError(f"{name} cannot be written: {error.strerror or error}")
