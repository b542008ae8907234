"""``mem:``, bytes kept in memory: for dry runs, tests, and to see what would be sent."""

from __future__ import annotations

from typing import Self

from devices.transports.base import Transport, Uri

__all__ = ["MemoryTransport"]


class MemoryTransport(Transport):
    """Takes everything. ``data`` is what was written; ``replies`` is what it will answer."""

    scheme = "mem"

    def __init__(self, replies: bytes = b"") -> None:
        self.written = bytearray()
        self.replies = replies
        self.reads = bool(replies)
        self.closed = False

    @classmethod
    def open(cls, uri: Uri, timeout: float = 10.0) -> Self:
        uri.check_query()
        return cls()

    @property
    def data(self) -> bytes:
        return bytes(self.written)

    def write(self, data: memoryview, timeout: float) -> int:
        self.written += data
        return len(data)

    def read(self, size: int, timeout: float) -> bytes:
        answer, self.replies = self.replies[:size], self.replies[size:]
        return answer

    def close(self) -> None:
        self.closed = True
