"""What devices are there, as the kernel's tables show: nothing is opened, pyusb is not needed."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from devices.transports.base import Found
from devices.transports.device_id import DeviceId

__all__ = ["UsbPrinter", "found", "usb_printers"]

PRINTER_CLASS, IPP_OVER_USB = "07", "04"
PORTS = ("ttyUSB*", "ttyACM*", "rfcomm*")
"""Serial ports that are there only if something is plugged in; ttyS0 … 31 always are."""


@dataclass(frozen=True)
class UsbPrinter:
    """One interface of the printer class, from sysfs.

    interface, port : its folder's name, as ``1-2:1.0``, and the device's, ``1-2``. number : of the
    interface. vendor, product : ids, four hexadecimal digits. driver : of the kernel; usbfs if a program
    holds it. node : of the device, which libusb opens; lp : usblp's, if it has one, as ``lp0``.
    ipp : whether it speaks only IPP over USB.
    """

    interface: str
    port: str
    number: int
    vendor: str
    product: str
    title: str
    serial: str
    identity: DeviceId
    driver: str
    node: str
    lp: str
    ipp: bool

    @property
    def uri(self) -> str:
        """As CUPS writes it if it has said its name; else by vendor and product."""
        make, model = (quote(name, safe="") for name in (self.identity.make, self.identity.model))
        place = f"{make}/{model}" if make and model else f"{self.vendor}:{self.product}"
        options = [f"serial={quote(self.serial, safe='')}"] if self.serial else []
        options += [f"interface={self.number}"] if self.number else []
        return f"usb://{place}" + ("?" + "&".join(options) if options else "")


def found(root: str | Path = "/") -> list[Found]:
    """All devices that can be seen here: USB printers, nodes of usblp, serial ports.

    root : another folder to look in, with sys and dev. What is on the network does not show.
    """
    top = Path(root)
    printers = usb_printers(top)
    listed = [
        Found(_apart(each, printers), each.title, each.identity.languages, _problem(each, top))
        for each in printers
    ]
    listed += [_node(path, printers, top) for path in sorted((top / "dev/usb").glob("lp*"))]
    return listed + _serial_ports(top)


def usb_printers(root: Path) -> list[UsbPrinter]:
    """All interfaces of the printer class, in the order of the bus."""
    folders = sorted((root / "sys/bus/usb/devices").glob("*:*"))
    return [_printer(each, root) for each in folders if _text(each / "bInterfaceClass") == PRINTER_CLASS]


def _printer(folder: Path, root: Path) -> UsbPrinter:
    port = folder.name.partition(":")[0]
    device = folder.parent / port
    identity = DeviceId.of(_text(folder / "ieee1284_id"))
    maker, model = (_text(device / name) for name in ("manufacturer", "product"))
    names = [identity.make or maker, identity.model or model]
    bus, address = (_number(_text(device / name)) for name in ("busnum", "devnum"))
    return UsbPrinter(
        folder.name,
        port,
        _number(_text(folder / "bInterfaceNumber"), 16),
        _text(device / "idVendor"),
        _text(device / "idProduct"),
        " ".join(name for name in names if name) or f"USB printer at {port}",
        _text(device / "serial") or identity.serial,
        identity,
        _driver(folder),
        f"/dev/bus/usb/{bus:03d}/{address:03d}",
        next((path.name for path in sorted((folder / "usbmisc").glob("lp*"))), ""),
        _text(folder / "bInterfaceProtocol") == IPP_OVER_USB,
    )


def _apart(printer: UsbPrinter, others: list[UsbPrinter]) -> str:
    """Its URI, with the port it is plugged into where two have the same."""
    uri = printer.uri
    if sum(other.uri == uri for other in others) == 1:
        return uri
    return f"{uri}{'&' if '?' in uri else '?'}port={printer.port}"


def _problem(printer: UsbPrinter, root: Path) -> str:
    if printer.ipp:
        return "it speaks IPP over USB: print to it by ipp-usb"
    if printer.driver == "usbfs":
        return "another program holds it; 'halftone devices doctor' names it"
    return _permission(printer.node, root)


def _node(path: Path, printers: list[UsbPrinter], root: Path) -> Found:
    owner = next((each for each in printers if each.lp == path.name), None)
    title = owner.title if owner else f"USB printer {path.name}"
    languages = owner.identity.languages if owner else ()
    node = f"/dev/usb/{path.name}"
    return Found(f"file:{node}", title, languages, _permission(node, root))


def _serial_ports(root: Path) -> list[Found]:
    """Serial ports by the names that stay when they are plugged in elsewhere, where they have one."""
    named = sorted((root / "dev/serial/by-id").glob("*"))
    known = {os.path.basename(os.readlink(path)) for path in named if path.is_symlink()}  # noqa: PTH115, PTH119
    plain = [
        path for kind in PORTS for path in sorted((root / "dev").glob(kind)) if path.name not in known
    ]
    return [_serial_port(path, root) for path in [*named, *plain]]


def _serial_port(path: Path, root: Path) -> Found:
    place = f"/{path.relative_to(root)}"
    title = path.name.replace("_", " ") if path.parent.name == "by-id" else f"serial port {path.name}"
    return Found(f"serial:{quote(place)}", title, (), _permission(place, root))


def _permission(node: str, root: Path) -> str:
    path = root / node.lstrip("/")
    if not path.exists() or os.access(path, os.W_OK):
        return ""
    return f"this user may not write to {node}; 'halftone devices doctor' says what to do"


def _driver(folder: Path) -> str:
    try:
        return os.path.basename(os.readlink(folder / "driver"))  # noqa: PTH115, PTH119
    except OSError:
        return ""


def _text(path: Path) -> str:
    """One attribute of sysfs; empty if it is not there, or the device has just gone."""
    try:
        return path.read_text("utf-8", "replace").strip()
    except OSError:
        return ""


def _number(text: str, base: int = 10) -> int:
    try:
        return int(text, base)
    except ValueError:
        return 0
