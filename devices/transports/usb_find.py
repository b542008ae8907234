"""Which USB printer a URI means, and what URI means a USB printer.

URIs are those of CUPS, ``usb://EPSON/TM-T20?serial=SN1``, or ``usb://04b8:0202`` by vendor and product.
``interface=N`` chooses among the interfaces of a device, ``port=1-2.4`` among devices that say the same.
"""

from __future__ import annotations

import errno
import re
from dataclasses import dataclass
from typing import Any
from urllib.parse import quote

from devices.transports.base import Found, Uri
from devices.transports.device_id import DeviceId
from devices.transports.usb_access import driver, refused, said
from devices.transports.usb_printers import ANSWER, Interface, Printer, device_id, printers, strings
from halftone.errors import DeviceNotFoundError, UsageError

__all__ = ["Names", "find", "found", "library", "name"]


@dataclass(frozen=True)
class Names:
    """What a printer calls itself. problem : why it could not be asked."""

    make: str
    model: str
    serial: str
    languages: tuple[str, ...] = ()
    problem: str = ""
    serials: frozenset[str] = frozenset()
    """That of the USB and that of its device ID, which may differ."""


def library() -> Any:
    """pyusb's way to libusb. Raises DeviceNotFoundError with what to install."""
    try:
        import usb.backend.libusb1
    except ImportError:
        raise DeviceNotFoundError(
            'usb: URIs need pyusb: pip install "halftone-kit[usb]" (or apt install python3-usb)'
        ) from None
    backend = usb.backend.libusb1.get_backend()
    if backend is None:
        raise DeviceNotFoundError(
            "usb: URIs need libusb 1.0: apt install libusb-1.0-0 (brew install libusb)"
        )
    return backend


def find(uri: Uri, backend: Any, timeout: float = 10.0) -> tuple[Printer, tuple[Interface, ...]]:
    """The one printer that *uri* names, and the ways to print to it that it allows, the best first.

    Raises DeviceNotFoundError with the URIs of what is there, UsageError for an unknown option.
    """
    uri.check_query("serial", "interface", "port")
    wanted = uri.number("interface", -1, 0, 255)
    there = [(printer, name(printer, timeout)) for printer in printers(backend)]
    matching = [(printer, names) for printer, names in there if _matches(uri, printer, names)]
    if not matching:
        raise DeviceNotFoundError(f"no USB printer is {uri.text}; {_listing(there)}")
    if len(matching) > 1:
        raise DeviceNotFoundError(f"{len(matching)} USB printers are {uri.text}; {_listing(matching)}")
    printer = matching[0][0]
    if not printer.interfaces:
        raise DeviceNotFoundError(f"{uri.text} {ONLY_IPP}")
    ways = tuple(way for way in printer.interfaces if wanted in (-1, way.number))
    if not ways:
        numbers = ", ".join(str(n) for n in sorted({way.number for way in printer.interfaces}))
        raise DeviceNotFoundError(f"{uri.text}: interface={wanted:g}; allowed: {numbers}")
    return printer, ways


ONLY_IPP = (
    "speaks only IPP over USB: install ipp-usb, which offers it as a printer on the network, and print "
    "to that (ipp://localhost:60000/ipp/print, as with CUPS)"
)


def found(backend: Any = None) -> list[Found]:
    """All USB printers, with the URI that opens each. Raises DeviceNotFoundError without pyusb."""
    there = [(printer, name(printer)) for printer in printers(backend or library())]
    listed = []
    for (printer, names), uri in zip(there, _uris(there), strict=True):
        problem = names.problem
        if not printer.interfaces:
            problem = f"it {ONLY_IPP}"
        elif not problem and driver(printer, _place(printer)) == "usbfs":
            problem = str(refused(OSError(errno.EBUSY, "busy"), printer, _place(printer)))
        title = " ".join(part for part in (names.make, names.model) if part) or str(printer)
        listed.append(Found(uri, title, names.languages, problem))
    return listed


def name(printer: Printer, timeout: float = 10.0) -> Names:
    """What *printer* calls itself: its device ID first, then its strings, as CUPS does."""
    try:
        handle = printer.backend.open_device(printer.device)
    except (OSError, NotImplementedError) as error:
        problem = str(refused(error, printer, _place(printer)))
        identity = DeviceId.of(said(printer, "ieee1284_id"))
        maker, product, serial = (said(printer, key) for key in ("manufacturer", "product", "serial"))
    else:
        problem, wait = "", min(ANSWER, timeout / 8)
        try:
            identity = device_id(printer, handle, wait)
            need = (not identity.make, not identity.model, True)
            maker, product, serial = strings(printer, handle, need, wait)
        finally:
            printer.backend.close_device(handle)
    serials = frozenset(text.casefold() for text in (serial, identity.serial) if text)
    return Names(
        identity.make or maker,
        identity.model or product,
        serial or identity.serial,
        identity.languages,
        problem,
        serials,
    )


def _matches(uri: Uri, printer: Printer, names: Names) -> bool:
    serial, port = uri.query.get("serial", "?"), uri.query.get("port", printer.port)
    if port != printer.port or (serial != "?" and serial.casefold() not in names.serials):
        return False  # CUPS writes ? for a printer without a serial number
    if not uri.host:
        return not uri.path.strip("/")
    numbers = re.fullmatch(r"(?:0x)?([0-9a-f]{1,4}):(?:0x)?([0-9a-f]{1,4})", uri.host.lower())
    if numbers:
        return (int(numbers[1], 16), int(numbers[2], 16)) == (printer.vendor, printer.product)
    model = uri.path.removeprefix("/")
    if not model:
        raise UsageError(f"'{uri.text}'; allowed: usb://MAKE/MODEL, usb://VENDOR:PRODUCT in hex, usb:")
    return (uri.host.casefold(), model.casefold()) == (names.make.casefold(), names.model.casefold())


def _place(printer: Printer) -> tuple[int, int] | None:
    return (
        (printer.interfaces[0].configuration, printer.interfaces[0].number)
        if printer.interfaces
        else None
    )


def _uris(there: list[tuple[Printer, Names]]) -> list[str]:
    """A URI for each as CUPS writes it; where two have the same, with the port they are plugged into."""
    plain = [_uri(printer, names) for printer, names in there]
    return [
        f"{uri}{'&' if '?' in uri else '?'}port={printer.port}" if plain.count(uri) > 1 else uri
        for uri, (printer, _) in zip(plain, there, strict=True)
    ]


def _uri(printer: Printer, names: Names) -> str:
    uri = str(printer)
    if names.make and names.model:
        uri = f"usb://{quote(names.make, safe='')}/{quote(names.model)}"
    number = printer.interfaces[0].number if printer.interfaces else 0
    options = [f"serial={quote(names.serial, safe='')}"] if names.serial else []
    options += [f"interface={number}"] if number else []
    return uri + ("?" + "&".join(options) if options else "")


def _listing(there: list[tuple[Printer, Names]]) -> str:
    if not there:
        return "no USB printer is plugged in and switched on"
    return "allowed: " + ", ".join(_uris(there))
