"""Why a USB printer cannot be opened: who holds it or what forbids it, and what to do about it."""

from __future__ import annotations

import errno
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from devices.errors import DeviceBusyError, DevicePermissionError
from halftone.errors import DeviceNotFoundError

if TYPE_CHECKING:
    from devices.transports.usb_printers import Printer

__all__ = ["GONE", "driver", "holder", "refused", "rule", "said"]

GONE = frozenset({errno.ENODEV, errno.ENOENT, errno.ENXIO, errno.ESHUTDOWN})
"""What the kernel and libusb say of a device that is no longer there."""

SYS, PROC = Path("/sys/bus/usb/devices"), Path("/proc")


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
        who = holder(printer, interface) or "another program or a kernel driver"
        return DeviceBusyError(f"{printer} is held by {who}. {_let_go(who)}")
    if code in GONE:
        return DeviceNotFoundError(f"{printer} went away while it was being opened")
    if isinstance(error, NotImplementedError):
        return DeviceNotFoundError(
            f"{printer}: its driver lets no program at it; on Windows give it the driver WinUSB (Zadig)"
        )
    return DeviceNotFoundError(f"{printer} could not be opened: {error}")


def rule(printer: Printer) -> str:
    """The line for udev that lets the user at the machine, and the group lp, open *printer*."""
    return (
        f'SUBSYSTEM=="usb", ATTR{{idVendor}}=="{printer.vendor:04x}", '
        f'ATTR{{idProduct}}=="{printer.product:04x}", GROUP="lp", MODE="0660", TAG+="uaccess"'
    )


def driver(printer: Printer, interface: tuple[int, int] | None) -> str:
    """The driver bound to an interface, as Linux tells: ``usblp``, ``usbfs`` for a program, or empty."""
    if interface is None or not printer.port:
        return ""
    try:
        link = SYS / "{}:{}.{}".format(printer.port, *interface) / "driver"
        return os.path.basename(os.readlink(link))  # noqa: PTH119, PTH115 (a link, not what it leads to)
    except OSError:
        return ""


def holder(printer: Printer, interface: tuple[int, int] | None) -> str:
    """Who has the interface, as far as it can be found out; empty if it cannot."""
    name = driver(printer, interface)
    if name and name != "usbfs":
        return f"the kernel driver {name}"
    return _program(f"/dev/bus/usb/{printer.bus:03d}/{printer.address:03d}")


def said(printer: Printer, name: str) -> str:
    """What Linux remembers of what the device said (``manufacturer``, ``serial``); empty if nothing.
    Everybody may read this, also who may not open the device."""
    folders = [SYS / printer.port, *SYS.glob(f"{printer.port}:*")] if printer.port else []
    for folder in folders:
        try:
            return (folder / name).read_bytes().decode("utf-8", "replace").strip()
        except OSError:
            continue
    return ""


def _program(node: str) -> str:
    """The program that has the file *node* open, if we may see its files."""
    for folder in PROC.glob("[0-9]*"):
        if folder.name == str(os.getpid()):
            continue
        try:
            files = [os.readlink(file) for file in (folder / "fd").iterdir()]  # noqa: PTH115
            if node in files:
                return f"the program {(folder / 'comm').read_text().strip()} (process {folder.name})"
        except OSError:  # it has ended, or belongs to someone else
            continue
    return ""


def _permit(printer: Printer) -> str:
    if sys.platform != "linux":
        return "Run this as an administrator, or give yourself the right to open it"
    return (
        "Write this line to "
        f"/etc/udev/rules.d/70-halftone-{printer.vendor:04x}-{printer.product:04x}.rules:\n"
        f"    {rule(printer)}\n"
        "then run\n"
        "    sudo udevadm control --reload && sudo udevadm trigger --subsystem-match=usb\n"
        "and plug the printer in again"
    )


def _let_go(who: str) -> str:
    if "ipp-usb" in who:
        return "Print by IPP, which ipp-usb offers for it, or stop it: sudo systemctl stop ipp-usb"
    if who.startswith("the kernel driver usblp"):
        return "Print to file:/dev/usb/lp0 and the like, or let go of it: sudo modprobe -r usblp"
    return "Close the program that has it open (cups, ipp-usb, a virtual machine?)"
