"""The printers on the USB as their descriptors show them, and the questions that any of them answers.

Nothing is claimed, detached or set here: looking leaves a device as it is.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from devices.transports.device_id import MOST, DeviceId

__all__ = ["ANSWER", "Interface", "Printer", "ask", "device_id", "milliseconds", "printers", "strings"]

CLASS, PACKETS, IPP = 7, 3, 4
"""The printer class, and its protocols that we do not speak: IEEE 1284.4 packets, and IPP over USB."""
BULK, INPUT = 2, 0x80
ANSWER = 1.0
"""Seconds that a device gets to answer one question."""


@dataclass(frozen=True)
class Interface:
    """A way to print: one alternate setting of an interface of class 7 that takes bytes.

    configuration, index : the value that selects it, and its place among the others. number,
    setting : of the interface, one of *settings*. protocol : 1 takes bytes, 2 answers too.
    out, into : addresses of the endpoints. packet : bytes of the largest packet that comes in.
    """

    configuration: int
    index: int
    number: int
    setting: int
    settings: int
    protocol: int
    out: int
    into: int | None
    packet: int


@dataclass(frozen=True)
class Printer:
    """A device with an interface of class 7. interfaces : those that we can print to, the best first;
    empty if it offers only IPP. strings : numbers of its maker, product and serial number.
    port : where it is plugged in, as Linux writes it: ``1-2.4``.
    """

    backend: Any
    device: Any
    vendor: int
    product: int
    bus: int
    address: int
    port: str
    strings: tuple[int, int, int]
    interfaces: tuple[Interface, ...]

    def __str__(self) -> str:
        return f"usb://{self.vendor:04x}:{self.product:04x}"


def printers(backend: Any) -> list[Printer]:
    """All devices with an interface of class 7, in the order of the bus."""
    listed: list[Printer] = []
    for device in backend.enumerate_devices():
        with suppress(OSError):  # it went away meanwhile, or its descriptors cannot be read
            listed += _printer(backend, device)
    return listed


def device_id(printer: Printer, handle: Any, timeout: float) -> DeviceId:
    """GET_DEVICE_ID (USB printer class 1.1 §4.2.1), which Linux allows without a claim."""
    if not printer.interfaces:
        return DeviceId()
    way = printer.interfaces[0]
    with suppress(OSError):
        request = (0xA1, 0, way.index, way.number << 8 | way.setting, MOST)
        return DeviceId.parse(ask(printer.backend, handle, *request, timeout))
    return DeviceId()


def ask(
    backend: Any, handle: Any, kind: int, request: int, value: int, index: int, size: int, timeout: float
) -> bytes:
    """A question on the control pipe. Raises OSError (usb.core.USBError)."""
    buffer = array("B", bytes(size))
    count = backend.ctrl_transfer(handle, kind, request, value, index, buffer, milliseconds(timeout))
    return buffer[:count].tobytes()


def milliseconds(seconds: float) -> int:
    """For libusb, which takes 0 as for ever."""
    return max(1, math.ceil(min(seconds * 1000, 2**31 - 1)))


def strings(
    printer: Printer, handle: Any, need: tuple[bool, ...], timeout: float
) -> tuple[str, str, str]:
    """Maker, product and serial number (USB 2.0 §9.6.7), those that are needed and can be read."""
    texts, language = ["", "", ""], b""
    with suppress(OSError):
        for k, number in enumerate(printer.strings):
            if need[k] and number:
                language = language or ask(printer.backend, handle, 0x80, 6, 0x300, 0, 255, timeout)[2:4]
                code = int.from_bytes(language, "little")
                answer = ask(printer.backend, handle, 0x80, 6, 0x300 | number, code, 255, timeout)
                text = answer[2 : answer[0] & 0xFE] if answer else b""
                texts[k] = text.decode("utf-16-le", "replace").strip(" \0")
    return texts[0], texts[1], texts[2]


def _printer(backend: Any, device: Any) -> Iterator[Printer]:
    told = backend.get_device_descriptor(device)
    every = list(_interfaces(backend, device, told.bNumConfigurations))
    if not every:
        return
    ways = [way for way in every if way.out and way.protocol not in (PACKETS, IPP)]
    ways.sort(key=lambda way: ((2, 1).index(way.protocol) if way.protocol in (2, 1) else 2, way.index))
    ports = told.port_numbers or ()
    yield Printer(
        backend,
        device,
        told.idVendor,
        told.idProduct,
        told.bus or 0,
        told.address or 0,
        f"{told.bus}-{'.'.join(map(str, ports))}" if ports else "",
        (told.iManufacturer, told.iProduct, told.iSerialNumber),
        tuple(ways),
    )


def _interfaces(backend: Any, device: Any, configurations: int) -> Iterator[Interface]:
    """Every alternate setting of class 7; out is 0 where it takes no bytes."""
    for index in range(configurations):
        configuration = backend.get_configuration_descriptor(device, index)
        for place in range(configuration.bNumInterfaces):
            settings = list(_settings(backend, device, index, place))
            for setting, described in enumerate(settings):
                if described.bInterfaceClass == CLASS:
                    ends = [
                        backend.get_endpoint_descriptor(device, k, place, setting, index)
                        for k in range(described.bNumEndpoints)
                    ]
                    bulk = [end for end in ends if end.bmAttributes & 3 == BULK]
                    out = [end.bEndpointAddress for end in bulk if not end.bEndpointAddress & INPUT]
                    into = [end for end in bulk if end.bEndpointAddress & INPUT]
                    yield Interface(
                        configuration.bConfigurationValue,
                        index,
                        described.bInterfaceNumber,
                        described.bAlternateSetting,
                        len(settings),
                        described.bInterfaceProtocol,
                        out[0] if out else 0,
                        into[0].bEndpointAddress if into else None,
                        max(1, into[0].wMaxPacketSize & 0x7FF) if into else 1,
                    )


def _settings(backend: Any, device: Any, index: int, place: int) -> Iterator[Any]:
    setting = 0
    while True:
        try:
            yield backend.get_interface_descriptor(device, place, setting, index)
        except IndexError:
            return
        setting += 1
