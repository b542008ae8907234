"""Where a picture comes from: a file, a pipe or stdin, as a path that can be opened again."""

from __future__ import annotations

import os
import stat
import sys
from typing import TYPE_CHECKING, BinaryIO

from halftone.errors import InputFileError

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["Place"]

CHUNK = 1 << 20


class Place:
    """An open picture file. name : for messages. path : under which it can be opened until closed."""

    def __init__(self, path: str | Path, limit: int) -> None:
        """Raises InputFileError; *limit* is the most bytes of a stream."""
        self.name = "stdin" if str(path) == "-" else f"'{path}'"
        self._file = self._opened(path, limit)
        by_name = self._is_file and self.name != "stdin" and str(path).isprintable()
        # The ending helps to find the format; but some names no library takes.
        self.path = str(path) if by_name else f"/proc/self/fd/{self._file.fileno()}"

    _is_file = False

    def _opened(self, path: str | Path, limit: int) -> BinaryIO:
        if self.name == "stdin":
            if sys.stdin is None:
                raise InputFileError("stdin is closed: no picture was piped in")
            return self._in_memory(sys.stdin.buffer, limit)
        try:
            file = open(path, "rb")  # noqa: SIM115 (as long as the place)
            try:
                if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):  # a pipe, as <(…)
                    memory = self._in_memory(file, limit)
                    file.close()
                    return memory
                if not file.read(1):
                    raise InputFileError(f"{self.name} is empty (0 bytes)")
            except BaseException:
                file.close()
                raise
        except IsADirectoryError:
            raise InputFileError(f"{self.name} is a folder; name the pictures in it") from None
        except OSError as error:
            raise InputFileError(f"{self.name} cannot be read: {error.strerror}") from None
        self._is_file = True
        return file

    def _in_memory(self, stream: BinaryIO, limit: int) -> BinaryIO:
        """All of a stream as a file without a place on a disk: libraries read files only."""
        memory = os.fdopen(os.memfd_create("halftone"), "wb")
        try:
            size = 0
            while chunk := stream.read(CHUNK):
                size += memory.write(chunk)
                if size > limit:
                    raise InputFileError(
                        f"{self.name} holds more than {limit >> 20} MiB; raise --max-memory"
                    )
            if not size:
                raise InputFileError(f"{self.name} is empty: no picture was piped in")
            memory.flush()
        except BaseException:
            memory.close()
            raise
        return memory

    def close(self) -> None:
        """Let the file go."""
        self._file.close()

    def __del__(self) -> None:
        file = getattr(self, "_file", None)  # missing where __init__ raised
        if file is not None:
            file.close()
