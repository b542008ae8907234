"""What goes wrong with a device. Every error is also one of :mod:`halftone.errors`.

::

    DeviceNotFoundError            exit 4
    ├── DevicePermissionError          it is there and may not be opened; says what to do about it
    └── DeviceBusyError                another program or driver holds it; names it
    DeviceFaultError               exit 5
    └── PrintError                     printing broke off; ``report`` says how far it came
        ├── DisconnectedError          unplugged, switched off, or the connection was closed
        ├── DeviceTimeoutError         it took no byte for as long as was allowed, and gave no reason
        ├── StalledError               it refuses data (USB stall); where it stands is unknown
        └── DeviceStateError           it says why it cannot go on: paper, cover, …
    InputFileError                 exit 3
    └── ProtocolError                  bytes that are not what the language allows; ``offset`` says where
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from halftone.errors import DeviceFaultError, DeviceNotFoundError, InputFileError

if TYPE_CHECKING:
    from devices.device import PrintReport

__all__ = [
    "DeviceBusyError",
    "DevicePermissionError",
    "DeviceStateError",
    "DeviceTimeoutError",
    "DisconnectedError",
    "PrintError",
    "ProtocolError",
    "StalledError",
]


class DevicePermissionError(DeviceNotFoundError):
    """The device is there and this user may not open it."""


class DeviceBusyError(DeviceNotFoundError):
    """Another program or a kernel driver holds the device."""


class PrintError(DeviceFaultError):
    """Printing broke off. ``report`` says what the device had accepted, once a print was begun."""

    report: PrintReport | None = None


class DisconnectedError(PrintError):
    """The device went away."""


class DeviceTimeoutError(PrintError):
    """The device took nothing for as long as was allowed, and gave no reason."""


class StalledError(PrintError):
    """The device refuses data, and what it made of the last bytes is unknown."""


class DeviceStateError(PrintError):
    """The device says why it cannot go on, in IPP ``printer-state-reasons`` keywords."""

    def __init__(self, message: str, reasons: frozenset[str]) -> None:
        super().__init__(message)
        self.reasons = reasons


class ProtocolError(InputFileError):
    """Bytes that a strict reader of the language does not allow.

    offset : of the first byte that is wrong, counted from the start of the stream.
    """

    def __init__(self, language: str, offset: int, what: str) -> None:
        super().__init__(f"{language}: {what} at offset {offset}")
        self.language, self.offset, self.what = language, offset, what

    def __reduce__(self) -> tuple[type[ProtocolError], tuple[str, int, str]]:
        return type(self), (self.language, self.offset, self.what)
