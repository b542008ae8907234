"""What a simulated USB printer is, what may happen to it, and what it remembers."""

from __future__ import annotations

import errno
import os
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

from usb.core import USBError

__all__ = [
    "Fail",
    "Outcome",
    "Printer",
    "Rest",
    "Setting",
    "Stall",
    "Take",
    "Timeout",
    "Unplug",
    "device_id",
    "error",
]


@dataclass(frozen=True)
class Take:
    """Takes at most so many bytes of a transfer and says so at once (a short write)."""

    bytes: int


@dataclass(frozen=True)
class Timeout:
    """Takes so many bytes, then none for as long as the host waits."""

    bytes: int = 0


@dataclass(frozen=True)
class Rest:
    """Takes so many bytes, then none for *seconds*, however often the host asks (out of paper)."""

    bytes: int
    seconds: float


@dataclass(frozen=True)
class Stall:
    """Takes so many bytes, then halts the endpoint."""

    bytes: int = 0


@dataclass(frozen=True)
class Unplug:
    """Takes so many bytes, then leaves the bus. first : what the transfer under way says of it."""

    bytes: int = 0
    first: int = errno.ENODEV


@dataclass(frozen=True)
class Fail:
    """Takes so many bytes, then the transfer fails with *code*; the device stays."""

    code: int = errno.EIO
    bytes: int = 0


Outcome = Take | Timeout | Rest | Stall | Unplug | Fail


@dataclass(frozen=True)
class Setting:
    """An alternate setting of an interface. ends : (address, attributes, wMaxPacketSize) of each."""

    interface: int = 0
    setting: int = 0
    kind: int = 7
    protocol: int = 2
    ends: tuple[tuple[int, int, int], ...] = ((0x02, 2, 64), (0x81, 2, 64))
    configuration: int = 1


def device_id(text: str) -> bytes:
    return (len(text) + 2).to_bytes(2, "big") + text.encode()


@dataclass(eq=False)
class Printer:
    """A printer. script : what happens at each write, in turn; then all is taken. at : what happens once
    it has so many bytes, however they are cut into writes (the outcome's own count is not used).

    configuration : the one that is set, 0 for none. drivers : interface → kernel driver, and
    detaches : whether the system can take it away; binds : those that come when a configuration is set.
    holders : interface → another program.
    strings : maker, product, serial number. id : its answer to GET_DEVICE_ID, None stalls.
    status : its answer to GET_PORT_STATUS. replies : transfers that wait in its IN pipe.
    asks_every, says : after so many bytes taken it queues that; with queue_limit waiting it takes none.
    denied : open_device is refused.
    """

    settings: tuple[Setting, ...] = (Setting(),)
    vendor: int = 0x04B8
    product: int = 0x0202
    strings: tuple[str, str, str] = ("EPSON", "TM-T20", "SN1")
    id: bytes | None = device_id("MFG:EPSON;CMD:ESC/POS;MDL:TM-T20;CLS:PRINTER;")
    status: bytes | None = b"\x18"
    port: tuple[int, ...] = (2,)
    configuration: int = 1
    drivers: dict[int, str] = field(default_factory=dict)
    detaches: bool = True
    binds: dict[int, dict[int, str]] = field(default_factory=dict)
    holders: dict[int, str] = field(default_factory=dict)
    denied: bool = False
    script: Iterable[Outcome] = ()
    at: tuple[int, Outcome] | None = None
    replies: deque[bytes] = field(default_factory=deque)
    says: bytes = b""
    asks_every: int = 0
    queue_limit: int = 1 << 30
    in_stalls: int = 0
    answers_control: bool = True
    # what happened
    received: bytearray = field(default_factory=bytearray)
    calls: list[tuple[Any, ...]] = field(default_factory=list)
    plugged: bool = True
    halted: set[int] = field(default_factory=set)
    chosen: dict[int, int] = field(default_factory=dict)
    open_handles: int = 0
    claims: dict[int, object] = field(default_factory=dict)
    removed: dict[int, str] = field(default_factory=dict)
    said_at: int = 0
    rests_until: float = 0.0

    def __post_init__(self) -> None:
        self.script = deque(self.script)

    def places(self) -> dict[int, dict[int, list[Setting]]]:
        """configuration value → interface number → its settings, each in order."""
        tree: dict[int, dict[int, list[Setting]]] = {}
        for setting in self.settings:
            tree.setdefault(setting.configuration, {}).setdefault(setting.interface, []).append(setting)
        return tree

    def current(self, interface: int) -> Setting:
        for setting in self.settings:
            here = setting.configuration == self.configuration and setting.interface == interface
            if here and setting.setting == self.chosen.get(interface, 0):
                return setting
        raise error(errno.ENOENT)

    def room(self) -> int:
        """Bytes it takes before its full IN queue stops it."""
        if not self.asks_every:
            return 1 << 30
        if sum(map(len, self.replies)) >= self.queue_limit:
            return 0
        return self.asks_every - (len(self.received) - self.said_at)

    def next(self, size: int) -> Outcome:
        """What happens to a transfer of *size* bytes."""
        if self.at and len(self.received) + size > self.at[0]:
            position, outcome = self.at
            self.at = None
            return replace(outcome, bytes=position - len(self.received))
        assert isinstance(self.script, deque)
        return self.script.popleft() if self.script else Take(size)

    def take(self, data: bytes, most: int) -> int:
        """Take at most so many bytes, as far as it can."""
        taken = 0
        while taken < min(most, len(data)) and (room := self.room()) > 0:
            part = data[taken : min(most, taken + room)]
            self.received += part
            taken += len(part)
            if self.asks_every and len(self.received) - self.said_at >= self.asks_every:
                self.said_at = len(self.received)
                self.replies.append(self.says)
        return taken


def error(code: int) -> USBError:
    """As pyusb raises it for libusb."""
    return USBError(os.strerror(code), -1, code)
