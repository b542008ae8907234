"""Why a USB printer cannot be opened: who holds it or what forbids it, and what to do about it."""

from __future__ import annotations

import errno
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from devices.errors import DeviceBusyError, DevicePermissionError
from devices.transports.remedies import holders, let_go, permit
from halftone.errors import DeviceNotFoundError

if TYPE_CHECKING:
    from devices.transports.usb_printers import Printer

__all__ = ["GONE", "driver", "holder", "refused", "said"]

GONE = frozenset({errno.ENODEV, errno.ENOENT, errno.ENXIO, errno.ESHUTDOWN})
"""What the kernel and libusb say of a device that is no longer there."""

ROOT = Path("/")
USB = "sys/bus/usb/devices"


def refused(
    error: Exception, printer: Printer, interface: tuple[int, int] | None
) -> DeviceNotFoundError:
    """The error to raise when opening *printer* gave *error*.

    interface : configuration and number of the interface that was to be claimed, if it came so far.
    """
    code = getattr(error, "errno", None)
    if code in (errno.EACCES, errno.EPERM):
        return DevicePermissionError(
            f"{printer} is there, and this user may not open it. {_permit(printer)}"
        )
    if code == errno.EBUSY:
        who, remedy = holder(printer, interface)
        return DeviceBusyError(f"{printer} is held by {who}: {remedy}")
    if code in GONE:
        return DeviceNotFoundError(f"{printer} went away while it was being opened")
    if isinstance(error, NotImplementedError):
        return DeviceNotFoundError(
            f"{printer}: its driver lets no program at it; on Windows give it the driver WinUSB (Zadig)"
        )
    return DeviceNotFoundError(f"{printer} could not be opened: {error}")


def driver(printer: Printer, interface: tuple[int, int] | None) -> str:
    """The driver bound to an interface, as Linux tells: ``usblp``, ``usbfs`` for a program, or empty."""
    if interface is None or not printer.port:
        return ""
    try:
        link = ROOT / USB / "{}:{}.{}".format(printer.port, *interface) / "driver"
        return os.path.basename(os.readlink(link))  # noqa: PTH119, PTH115 (a link, not what it leads to)
    except OSError:
        return ""


def holder(printer: Printer, interface: tuple[int, int] | None) -> tuple[str, str]:
    """Who has the interface, as far as it can be found out, and how to get it back."""
    name = driver(printer, interface)
    if name and name != "usbfs":
        return f"the kernel driver {name}", let_go(name)
    node = f"/dev/bus/usb/{printer.bus:03d}/{printer.address:03d}"
    for process, name in holders(node, ROOT):
        return f"the program {name} (process {process})", let_go(name, process)
    return "another program or a kernel driver", let_go("")


def said(printer: Printer, name: str) -> str:
    """What Linux remembers of what the device said (``manufacturer``, ``serial``); empty if nothing.
    Everybody may read this, also who may not open the device."""
    folders = (
        [ROOT / USB / printer.port, *(ROOT / USB).glob(f"{printer.port}:*")] if printer.port else []
    )
    for folder in folders:
        try:
            return (folder / name).read_bytes().decode("utf-8", "replace").strip()
        except OSError:
            continue
    return ""


def _permit(printer: Printer) -> str:
    if sys.platform != "linux":
        return "Run this as an administrator, or give yourself the right to open it"
    return "To mend it, " + permit(f"{printer.vendor:04x}", f"{printer.product:04x}")
