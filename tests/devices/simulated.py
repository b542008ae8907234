"""A transport with a script: what the device does with each write, on a clock that nobody waits for."""

from __future__ import annotations

from dataclasses import dataclass, field

from devices.errors import DisconnectedError, StalledError
from devices.status import Status
from devices.transports.base import Transport, Uri


class Clock:
    """Time that passes only when somebody waits."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += max(0.0, seconds)


@dataclass(frozen=True)
class Take:
    """The device takes up to *size* bytes, and time passes."""

    size: int
    seconds: float = 0.001


@dataclass(frozen=True)
class Hold:
    """The device takes nothing for *seconds*, and its port says *reasons*."""

    seconds: float
    reasons: tuple[str, ...] = ()


@dataclass(frozen=True)
class Gone:
    """The device is unplugged."""


@dataclass(frozen=True)
class Stall:
    """The device refuses data."""


@dataclass(frozen=True)
class Say:
    """The device sends bytes that nobody asked for; until they are read it takes nothing."""

    data: bytes


@dataclass
class Scripted(Transport):
    """Follows *script* step by step, then takes everything. got : every byte, in order."""

    script: list[object]
    clock: Clock
    scheme = "mem"
    reads = True
    chunk: int = 512
    got: bytearray = field(default_factory=bytearray)
    waiting: bytes = b""
    until: float = 0.0
    reasons: tuple[str, ...] = ()
    dead: bool = False
    closed: bool = False

    @classmethod
    def open(cls, uri: Uri, timeout: float = 10.0) -> Scripted:
        raise NotImplementedError

    def write(self, data: memoryview, timeout: float) -> int:
        assert not self.dead, "written to after it failed"
        assert len(data)
        end = self.clock.now + timeout
        while True:
            if self.waiting:  # full: it wants to be read first
                self.clock.now = end
                return 0
            if self.clock.now < self.until:
                self.clock.now = min(end, self.until)
                if self.clock.now == end:
                    return 0
            self.reasons = ()
            step = self.script.pop(0) if self.script else Take(1 << 20)
            if isinstance(step, Take):
                self.clock.now += step.seconds
                self.got += data[: step.size]
                return min(step.size, len(data))
            if isinstance(step, Hold):
                self.until, self.reasons = self.clock.now + step.seconds, step.reasons
            elif isinstance(step, Say):
                self.waiting += step.data
            else:
                self.dead = True
                raise DisconnectedError("gone") if isinstance(step, Gone) else StalledError("stalled")

    def read(self, size: int, timeout: float) -> bytes:
        if not self.waiting:
            self.clock.now += timeout
        said, self.waiting = self.waiting[:size], self.waiting[size:]
        return said

    def port_status(self) -> Status | None:
        return Status(frozenset(self.reasons)) if self.clock.now < self.until else Status()

    def close(self) -> None:
        self.closed = True
