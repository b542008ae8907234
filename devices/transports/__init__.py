"""The transports, by the scheme of their URI: one file and one line of the table each."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any

from devices.transports.base import Transport, Uri
from halftone.errors import UsageError, near

__all__ = ["open_transport", "schemes", "transport_type"]

TABLE = {
    "usb": "devices.transports.usb:UsbTransport",
    "socket": "devices.transports.tcp:TcpTransport",
    "file": "devices.transports.file:FileTransport",
    "serial": "devices.transports.serial:SerialTransport",
    "mem": "devices.transports.memory:MemoryTransport",
}

GROUP = "halftone.transports"


def schemes() -> list[str]:
    """All schemes: ours, then those that other packages add as entry points *halftone.transports*."""
    return [*TABLE, *sorted(set(_others()) - set(TABLE))]


def transport_type(scheme: str) -> type[Transport]:
    """The class for *scheme*. Raises UsageError with the near matches for an unknown one."""
    if scheme in TABLE:
        module, _, kind = TABLE[scheme].partition(":")
        found: Any = getattr(import_module(module), kind)
    elif scheme in _others():
        found = _others()[scheme].load()
    else:
        raise UsageError(near(scheme, schemes(), "kind of device URI"))
    if not (isinstance(found, type) and issubclass(found, Transport)):
        raise UsageError(f"the transport '{scheme}' is no devices.transports.base.Transport")
    return found


def open_transport(uri: Uri, timeout: float = 10.0) -> Transport:
    """Open *uri* within *timeout* seconds; see :meth:`Transport.open` for what it raises."""
    return transport_type(uri.scheme).open(uri, timeout)


@cache
def _others() -> dict[str, Any]:
    from importlib.metadata import entry_points

    return {point.name: point for point in entry_points(group=GROUP)}
