"""A stream that is read forwards, whose every fault is named with its offset."""

from __future__ import annotations

from collections.abc import Callable
from typing import NoReturn

from devices.errors import ProtocolError

__all__ = ["Source"]

CHUNK = 1 << 16
"""Bytes that are asked for at a time."""


class Source:
    """What *read* gives: up to so many bytes when asked, none at the end.

    place : offset of the next byte that is not taken. ended : whether *read* has no more.
    """

    def __init__(self, language: str, read: Callable[[int], bytes]) -> None:
        self.language, self.place, self.ended = language, 0, False
        self._read, self._held, self._start = read, b"", 0

    def fail(self, what: str, offset: int | None = None) -> NoReturn:
        raise ProtocolError(self.language, self.place if offset is None else offset, what)

    def peek(self, size: int) -> memoryview:
        """What is held and not taken: *size* bytes or more, fewer only at the end of the stream."""
        have = len(self._held) - self._start
        if have < size and not self.ended:
            parts = [self._held[self._start :]]
            while have < size:
                got = self._read(max(CHUNK, size - have))
                if not got:
                    self.ended = True
                    break
                parts.append(got)
                have += len(got)
            self._held, self._start = b"".join(parts), 0
        return memoryview(self._held)[self._start :]

    def skip(self, size: int) -> None:
        """Take *size* bytes of those that are held."""
        self._start += size
        self.place += size

    def take(self, size: int, what: str) -> memoryview:
        """The next *size* bytes, of *what*; fails if the stream has fewer."""
        got = self.peek(size)
        if len(got) < size:
            self.fail(f"{what}: {size} bytes expected, {len(got)} left", self.place + len(got))
        self.skip(size)
        return got[:size]
