"""Bytes to a device, each once: short writes are resumed, a device that says why it waits is waited
for, and every failure ends in a named error within its deadline.

The deadline is one of progress, not of the whole: a long job on a slow line is no failure.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from devices.errors import DeviceStateError, DeviceTimeoutError
from devices.languages.base import Language
from devices.status import Status
from devices.transports.base import Transport
from halftone.errors import UsageError

__all__ = ["Cancelled", "Patience", "Sender"]


class Cancelled(Exception):  # noqa: N818 (no error: it was asked for)
    """The user wants no more of it."""


@dataclass(frozen=True)
class Patience:
    """How long a device may take, in seconds.

    stall : without taking a byte, and without a reason for it. fault : with a reason that a person
    can mend, as no paper or an open cover; None waits for ever. answer : for what it is asked.
    finish : for the bytes that complete a job which is broken off.
    """

    stall: float = 60.0
    fault: float | None = 600.0
    answer: float = 1.5
    finish: float = 10.0

    def __post_init__(self) -> None:
        for name in ("stall", "fault", "answer", "finish"):
            value = getattr(self, name)
            if value is None and name == "fault":
                continue
            if (
                isinstance(value, bool)
                or not isinstance(value, int | float)
                or not 0 <= value < math.inf
            ):
                raise UsageError(f"patience: {name} = {value!r}; allowed: seconds, 0 and more")


POLL = 0.5
"""Seconds between two looks at the status, and to hear of a cancel."""
NOISE = 4096
"""Bytes taken from a device at a time that nobody asked for."""
TAIL = 256
"""Bytes of them that are kept, because the rest of what they say may come later."""


@dataclass
class Sender:
    """The way to one device. taken : bytes it has accepted; sent : of the last data given. seen : all
    reasons it has given. waited : seconds it held the job up for a reason. asleep : what passes the
    time between two looks. broken : whether the transport failed, and may not be written to any more.
    """

    transport: Transport
    language: Language
    patience: Patience
    notify: Callable[[Status], None]
    cancelled: Callable[[], bool]
    clock: Callable[[], float] = time.monotonic
    asleep: Callable[[float], None] = time.sleep
    taken: int = 0
    sent: int = 0
    waited: float = 0.0
    seen: set[str] = field(default_factory=set)
    broken: bool = False
    _said: Status = field(default_factory=Status)
    _heard: bytes = b""
    _told: Status = field(default_factory=Status)
    _drained: float = 0.0

    def give(self, data: bytes, *, cancellable: bool = True) -> None:
        """Hand over *data*, all of it; returns only then. ``sent`` counts within it meanwhile."""
        view, self.sent = memoryview(data), 0
        watch = _Watch(self)
        while self.sent < len(view):
            if (cancellable or not self.sent) and self.cancelled():
                raise Cancelled
            taken = self._write(view[self.sent : self.sent + self.transport.chunk], POLL)
            if taken:
                self.sent, self.taken = self.sent + taken, self.taken + taken
                watch.moved()
                if self.clock() - self._drained > POLL:
                    self.look()
            else:
                watch.held(self.look(), f"{self.taken} bytes")

    def finish(self, data: bytes) -> bool:
        """Hand over what completes a broken-off job; whether the device took it in time."""
        view, end = memoryview(data), self.clock() + self.patience.finish
        while view and (left := end - self.clock()) > 0:
            taken = self._write(view[: self.transport.chunk], min(POLL, left))
            self.taken += taken
            view = view[taken:]
            if not taken:
                self.look()
        return not view and self.transport.flush(max(0.0, end - self.clock()))

    def flush(self) -> None:
        """Wait until all that was taken has left this machine."""
        watch = _Watch(self)
        while not self.transport.flush(POLL):
            if self.cancelled():
                raise Cancelled
            watch.held(self.look(), "all bytes, and some have not left this machine")

    def look(self) -> Status:
        """What the device says without being asked: its port, and what it sent last by itself."""
        self._drained = self.clock()
        if self.transport.reads:
            self._heard += self._read(0)
            said = self.language.unsolicited(self._heard)
            if said is not None:  # it holds until the device says something else
                self._said, self._heard = said, b""
            self._heard = self._heard[-TAIL:]
        status = (self.transport.port_status() or Status()) | self._said
        self.note(status)
        return status

    def ask(self) -> Status | None:
        """What the device answers when it is asked; None if it does not answer."""
        status = self.transport.port_status()
        held = status is not None and status.stopped  # then it may not take the question either
        if self.transport.reads and self.language.status_query and not held:
            status = self._answer()
        if status is not None:
            self.note(status)
        return status

    def wait_until_ready(self, status: Status | None) -> Status | None:
        """Wait while the device says that it cannot go on; its last answer."""
        watch = _Watch(self)
        while status is not None and status.stopped:
            if self.cancelled():
                raise Cancelled
            watch.held(status, "no byte")
            self.asleep(POLL)
            answer = self.ask()
            status = status if answer is None else answer  # silence does not say that it is mended
        watch.moved()
        return status

    def note(self, status: Status) -> None:
        """Remember what it said, and tell the user when it changes."""
        self.seen |= status.reasons
        if status != self._told:
            self._told = status
            self.notify(status)

    def _answer(self) -> Status | None:
        # Once begun it is ended: half a question would garble what follows.
        self.give(self.language.status_query, cancellable=False)
        reply, end = b"", self.clock() + self.patience.answer
        while (left := end - self.clock()) > 0:
            reply += self._read(min(POLL, left))
            status = self.language.parse_status(reply)
            if status is not None:
                self._said = status
                return status | (self.transport.port_status() or Status())
        # Silence does not take back what it has said.
        return None if self._said.stopped else self.transport.port_status()

    def _write(self, data: memoryview, timeout: float) -> int:
        try:
            return self.transport.write(data, timeout)
        except BaseException:  # KeyboardInterrupt too: how much was taken is unknown
            self.broken = True
            raise

    def _read(self, timeout: float) -> bytes:
        try:
            return self.transport.read(NOISE, timeout)
        except BaseException:
            self.broken = True
            raise


class _Watch:
    """How long the device has taken nothing, with a reason and without."""

    def __init__(self, sender: Sender) -> None:
        self.sender = sender
        self.since = sender.clock()  # the last byte, or the last look
        self.idle = self.blocked = 0.0

    def moved(self) -> None:
        self.since = self.sender.clock()
        self.idle = self.blocked = 0.0

    def held(self, status: Status, what: str) -> None:
        """It took nothing; raises when it has done so for too long."""
        now = self.sender.clock()
        passed, self.since = now - self.since, now
        patience = self.sender.patience
        if status.stopped:
            self.idle, self.blocked = 0.0, self.blocked + passed
            self.sender.waited += passed
            if patience.fault is not None and self.blocked >= patience.fault:
                raise DeviceStateError(
                    f"the device says: {status}; it took {what} and was waited for "
                    f"{self.blocked:.0f} s (--wait)",
                    status.reasons,
                )
        else:
            self.idle += passed
            if self.idle >= patience.stall:
                raise DeviceTimeoutError(
                    f"the device took {what}, then nothing for {self.idle:.0f} s, "
                    "and gives no reason (--timeout)"
                )
