"""Why a device cannot be printed to, and what to do about it."""

from __future__ import annotations

import importlib.util
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from devices.discovery import UsbPrinter, usb_printers
from devices.transports import transport_type
from devices.transports.base import Uri
from devices.transports.remedies import holders, let_go, permit
from devices.transports.usb_find import library
from halftone.errors import DeviceNotFoundError, UsageError

__all__ = ["Finding", "examine"]


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at. what : what was found. ok : whether printing works with it so.
    remedy : what to do, empty if nothing."""

    what: str
    ok: bool = True
    remedy: str = ""


def examine(uri: str | None = None, root: str | Path = "/", timeout: float = 5.0) -> list[Finding]:
    """Look at the device at *uri*, or at all that are there.

    root : another folder to look in, with sys, dev, proc, etc. timeout : seconds for a host to answer.
    Nothing is printed, and no device is opened but a network connection. Raises UsageError.
    """
    top = Path(root)
    if uri is None:
        return _all(top)
    place = Uri.parse(uri)
    transport_type(place.scheme)
    if place.scheme == "usb":
        place.check_query("serial", "interface", "port")
        return [_libraries("usb"), *_usb(place, top)]
    if place.scheme == "socket":
        return _socket(place, timeout)
    if place.scheme == "serial":
        return [_libraries("serial"), *_node(place.path, top, "dialout")]
    if place.scheme == "file" and place.path.startswith("/dev/"):
        return _node(place.path, top, "lp")
    return [Finding(f"{uri}: nothing is known that could be in its way")]


def _all(root: Path) -> list[Finding]:
    printers = usb_printers(root)
    findings = [_libraries("usb"), _libraries("serial")]
    for printer in printers:
        findings += _usb_printer(printer, root)
    for path in sorted((root / "dev/usb").glob("lp*")):
        findings += _node(f"/dev/usb/{path.name}", root, "lp")
    for kind in ("ttyUSB*", "ttyACM*"):
        for path in sorted((root / "dev").glob(kind)):
            findings += _node(f"/dev/{path.name}", root, "dialout")
    if not printers:
        findings.append(Finding("no USB printer is plugged in and switched on"))
    return findings


def _libraries(scheme: str) -> Finding:
    """Whether the library that URIs of *scheme* need is installed."""
    if scheme == "serial":
        if importlib.util.find_spec("serial") is not None:
            return Finding("pyserial is installed")
        return Finding("pyserial is not installed", False, 'pip install "halftone-kit[serial]"')
    try:
        library()
    except DeviceNotFoundError as error:
        what, _, remedy = str(error).partition(": ")[2].partition(": ")
        return Finding(what, False, remedy)
    return Finding("pyusb and libusb are installed")


def _usb(uri: Uri, root: Path) -> Iterator[Finding]:
    printers = usb_printers(root)
    meant = [each for each in printers if _is_meant(uri, each)]
    if not meant:
        there = ", ".join(sorted({each.uri for each in printers})) or "none"
        remedy = f"switch it on and check the cable; USB printers that are there: {there}"
        yield Finding(f"{uri.text} is not there", False, remedy)
    for printer in meant:
        yield from _usb_printer(printer, root, uri.text)


def _is_meant(uri: Uri, printer: UsbPrinter) -> bool:
    """Whether *uri* may mean *printer*. What it says of itself is known only if usblp has asked for it;
    else its make stands in its strings, if it has any."""
    serial = uri.query.get("serial", "?").casefold()
    if (
        serial not in (printer.serial.casefold(), "?")
        or uri.query.get("port", printer.port) != printer.port
    ):
        return False
    numbers = re.fullmatch(r"(?:0x)?([0-9a-f]{1,4}):(?:0x)?([0-9a-f]{1,4})", uri.host.lower())
    if numbers:
        return [int(number, 16) for number in numbers.groups()] == [
            int(printer.vendor, 16),
            int(printer.product, 16),
        ]
    asked = f"{uri.host}{uri.path}".casefold()
    names = printer.identity
    if asked and not names.model:
        return printer.title.startswith("USB printer") or uri.host.casefold() in printer.title.casefold()
    return not asked or asked == f"{names.make}/{names.model}".casefold()


def _usb_printer(printer: UsbPrinter, root: Path, asked: str = "") -> Iterator[Finding]:
    who = f"{printer.title} ({printer.uri})"
    yield Finding(f"{who} is plugged in at {printer.port}")
    node = root / printer.node.lstrip("/")
    if not node.exists():
        remedy = "give the container or sandbox the folder /dev/bus/usb"
        yield Finding(f"{printer.node} is not there", False, remedy)
    elif not os.access(node, os.R_OK | os.W_OK):
        yield Finding(
            f"this user may not open {printer.node}", False, permit(printer.vendor, printer.product)
        )
    programs = list(holders(printer.node, root))
    for pid, name in programs:
        yield Finding(f"{printer.node} is held by {name} (process {pid})", False, let_go(name, pid))
    if printer.driver == "usbfs" and not programs:
        remedy = "close it; run the doctor as root to learn its name: sudo halftone devices doctor"
        yield Finding("another program holds the printer", False, remedy)
    elif printer.driver == "usblp":
        node_too = f"; or print to file:/dev/usb/{printer.lp}" if printer.lp else ""
        yield Finding(f"the kernel driver usblp has it, and lends it out while we print{node_too}")
    elif printer.driver not in ("", "usbfs"):
        remedy = f"echo {printer.interface} | sudo tee /sys/bus/usb/drivers/{printer.driver}/unbind"
        yield Finding(f"the kernel driver {printer.driver} has it", False, remedy)
    if printer.ipp:
        yield Finding("it speaks IPP over USB only", False, "print by IPP: sudo apt install ipp-usb")
    yield from _queues(printer, asked, root)


def _queues(printer: UsbPrinter, asked: str, root: Path) -> Iterator[Finding]:
    """CUPS queues that print to the same device; its file may be read by root and lp only."""
    try:
        text = (root / "etc/cups/printers.conf").read_text("utf-8", "replace")
    except OSError:
        return
    queue = ""
    for line in text.splitlines():
        if begin := re.match(r"<(?:Default)?Printer (.+)>", line):
            queue = begin[1]
        key, _, uri = line.strip().partition(" ")
        if key != "DeviceURI" or not uri.startswith("usb:"):
            continue
        try:
            known = bool(printer.identity.model)
            same = uri == asked or (known and _is_meant(Uri.parse(uri), printer))
        except UsageError:
            continue
        if same:
            what = f"the CUPS queue {queue} prints to it too; jobs of both would wait for each other"
            yield Finding(what, True, f"to keep it for yourself: cupsdisable {queue}")


def _socket(uri: Uri, timeout: float) -> list[Finding]:
    from devices.transports.tcp import TcpTransport

    try:
        with TcpTransport.open(uri, timeout) as transport:
            return [Finding(f"{transport.name} answers")]
    except DeviceNotFoundError as error:
        remedy = (
            f"ping {uri.host}\n"
            "print the printer's own network page and compare the address; switch on raw printing (port "
            "9100, JetDirect, AppSocket) in its settings"
        )
        return [Finding(str(error), False, remedy)]


def _node(node: str, root: Path, group: str) -> list[Finding]:
    """A device node: is it there, may it be opened, and who has it open?"""
    path = root / node.lstrip("/")
    if not path.exists():
        remedy = "switch it on and check the cable; 'halftone devices list' shows what is there"
        return [Finding(f"{node} is not there", False, remedy)]
    findings = [Finding(f"{node} is there")]
    if not os.access(path, os.R_OK | os.W_OK):
        remedy = f"sudo usermod -aG {_group(path) or group} $USER\nthen log in again"
        findings = [Finding(f"{node} is there, and this user may not open it", False, remedy)]
    for pid, name in holders(node, root):
        findings.append(Finding(f"{node} is open in {name} (process {pid})", False, let_go(name, pid)))
    return findings


def _group(path: Path) -> str:
    """The group of a node, if it is one that users are put into."""
    try:
        name = path.group()
    except (KeyError, OSError):
        return ""
    return "" if name == "root" else name
