"""Printers on a USB that is not there: a backend for pyusb, in Python alone, that does what it is told.

A printer (tests/devices/simulated_usb_printer.py) has the descriptors, the strings and the faults it was
given; it remembers every byte it took, and every call. Time is a number: a timeout moves it, and nothing
sleeps.

What libusb and pyusb do is done here too: a timeout after some bytes returns their count; a timeout
after none raises USBTimeoutError; a stall or an unplugged cable raises, and hides what was taken before;
an IN packet that is longer than the buffer is lost (EOVERFLOW); a claimed interface is claimed for one
handle; an interface that a kernel driver has cannot be claimed.
"""

from __future__ import annotations

import errno
from array import array
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from usb.backend import IBackend
from usb.core import USBTimeoutError

from tests.devices.simulated_usb_printer import (
    Fail,
    Printer,
    Rest,
    Setting,
    Stall,
    Take,
    Timeout,
    Unplug,
    error,
)

__all__ = ["Clock", "Forever", "SimBackend"]


class Forever(BaseException):
    """The host waits with no limit for what never comes. No Exception: nothing can swallow it."""


@dataclass
class Clock:
    now: float = 0.0

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds


@dataclass(eq=False)
class Handle:
    printer: Printer
    open: bool = True


class SimBackend(IBackend):  # type: ignore[misc]
    """The bus. clock : moved by every timeout."""

    def __init__(self, *devices: Printer, clock: Clock | None = None) -> None:
        self.devices = devices
        self.clock = clock or Clock()
        # python-escpos detaches a kernel driver only for a backend whose module is called so.
        self.__module__ = "usb.backend.libusb1"

    # --- descriptors

    def enumerate_devices(self) -> list[Printer]:
        return [printer for printer in self.devices if printer.plugged]

    def get_parent(self, dev: Printer) -> None:
        return None

    def get_device_descriptor(self, dev: Printer) -> SimpleNamespace:
        maker, product, serial = (k * bool(text) for k, text in zip((1, 2, 3), dev.strings, strict=True))
        return SimpleNamespace(
            bLength=18,
            bDescriptorType=1,
            bcdUSB=0x0200,
            bDeviceClass=0,
            bDeviceSubClass=0,
            bDeviceProtocol=0,
            bMaxPacketSize0=64,
            idVendor=dev.vendor,
            idProduct=dev.product,
            bcdDevice=0x0100,
            iManufacturer=maker,
            iProduct=product,
            iSerialNumber=serial,
            bNumConfigurations=len(dev.places()),
            address=self.devices.index(dev) + 2,
            bus=1,
            port_number=dev.port[-1] if dev.port else None,
            port_numbers=dev.port or None,
            speed=3,
        )

    def get_configuration_descriptor(self, dev: Printer, config: int) -> SimpleNamespace:
        places = dev.places()
        value = sorted(places)[config]
        return SimpleNamespace(
            bLength=9,
            bDescriptorType=2,
            wTotalLength=32,
            bNumInterfaces=len(places[value]),
            bConfigurationValue=value,
            iConfiguration=0,
            bmAttributes=0xC0,
            bMaxPower=1,
            extra_descriptors=[],
        )

    def _setting(self, dev: Printer, intf: int, alt: int, config: int) -> Setting:
        places = dev.places()
        interfaces = places[sorted(places)[config]]
        return interfaces[sorted(interfaces)[intf]][alt]

    def get_interface_descriptor(
        self, dev: Printer, intf: int, alt: int, config: int
    ) -> SimpleNamespace:
        setting = self._setting(dev, intf, alt, config)
        return SimpleNamespace(
            bLength=9,
            bDescriptorType=4,
            bInterfaceNumber=setting.interface,
            bAlternateSetting=setting.setting,
            bNumEndpoints=len(setting.ends),
            bInterfaceClass=setting.kind,
            bInterfaceSubClass=1,
            bInterfaceProtocol=setting.protocol,
            iInterface=0,
            extra_descriptors=[],
        )

    def get_endpoint_descriptor(
        self, dev: Printer, ep: int, intf: int, alt: int, config: int
    ) -> SimpleNamespace:
        address, attributes, packet = self._setting(dev, intf, alt, config).ends[ep]
        return SimpleNamespace(
            bLength=7,
            bDescriptorType=5,
            bEndpointAddress=address,
            bmAttributes=attributes,
            wMaxPacketSize=packet,
            bInterval=0,
            bRefresh=0,
            bSynchAddress=0,
            extra_descriptors=[],
        )

    # --- handles, drivers, claims

    def _use(self, dev_handle: Handle, *call: Any) -> Printer:
        assert dev_handle.open, f"{call} on a closed handle"
        printer = dev_handle.printer
        printer.calls.append(call)
        if not printer.plugged:
            raise error(errno.ENODEV)
        return printer

    def open_device(self, dev: Printer) -> Handle:
        if dev.denied:
            raise error(errno.EACCES)
        if not dev.plugged:
            raise error(errno.ENODEV)
        dev.open_handles += 1
        return Handle(dev)

    def close_device(self, dev_handle: Handle) -> None:
        assert dev_handle.open, "a handle was closed twice"
        dev_handle.open = False
        printer = dev_handle.printer
        printer.open_handles -= 1
        printer.claims = {n: owner for n, owner in printer.claims.items() if owner is not dev_handle}

    def get_configuration(self, dev_handle: Handle) -> int:
        return self._use(dev_handle, "get_configuration").configuration

    def set_configuration(self, dev_handle: Handle, config_value: int) -> None:
        printer = self._use(dev_handle, "set_configuration", config_value)
        if printer.claims or printer.drivers:
            raise error(errno.EBUSY)
        assert config_value in printer.places()
        printer.configuration, printer.chosen = config_value, {}
        printer.drivers = dict(printer.binds.get(config_value, {}))

    def set_interface_altsetting(self, dev_handle: Handle, intf: int, altsetting: int) -> None:
        printer = self._use(dev_handle, "set_interface_altsetting", intf, altsetting)
        assert printer.claims.get(intf) is dev_handle, "not claimed"
        printer.chosen[intf] = altsetting
        printer.current(intf)

    def claim_interface(self, dev_handle: Handle, intf: int) -> None:
        printer = self._use(dev_handle, "claim_interface", intf)
        taken = printer.claims.get(intf, dev_handle) is not dev_handle
        if intf in printer.drivers or intf in printer.holders or taken:
            raise error(errno.EBUSY)
        if intf not in printer.places().get(printer.configuration, {}):
            raise error(errno.ENOENT)
        printer.claims[intf] = dev_handle

    def release_interface(self, dev_handle: Handle, intf: int) -> None:
        printer = self._use(dev_handle, "release_interface", intf)
        if printer.claims.pop(intf, None) is None:
            raise error(errno.ENOENT)
        printer.chosen.pop(intf, None)  # Linux goes back to setting 0

    def is_kernel_driver_active(self, dev_handle: Handle, intf: int) -> bool:
        printer = self._use(dev_handle, "is_kernel_driver_active", intf)
        if not printer.detaches:
            raise NotImplementedError
        return intf in printer.drivers

    def detach_kernel_driver(self, dev_handle: Handle, intf: int) -> None:
        printer = self._use(dev_handle, "detach_kernel_driver", intf)
        if not printer.detaches:
            raise NotImplementedError
        if intf not in printer.drivers:
            raise error(errno.ENOENT)
        printer.removed[intf] = printer.drivers.pop(intf)

    def attach_kernel_driver(self, dev_handle: Handle, intf: int) -> None:
        printer = self._use(dev_handle, "attach_kernel_driver", intf)
        if not printer.detaches:
            raise NotImplementedError
        if intf in printer.claims:
            raise error(errno.EBUSY)
        if intf not in printer.removed:
            raise error(errno.ENOENT)
        printer.drivers[intf] = printer.removed.pop(intf)

    def reset_device(self, dev_handle: Handle) -> None:
        self._use(dev_handle, "reset_device")

    def clear_halt(self, dev_handle: Handle, ep: int) -> None:
        self._use(dev_handle, "clear_halt", ep).halted.discard(ep)

    # --- transfers

    def _wait(self, timeout: int) -> None:
        """The host waits for *timeout* milliseconds in vain."""
        if not timeout:
            raise Forever
        self.clock.sleep(timeout / 1000)

    def _rested(self, printer: Printer, timeout: int) -> bool:
        """Wait until the printer goes on, or for *timeout* milliseconds; whether it goes on."""
        left = printer.rests_until - self.clock.now
        if left > 0 and timeout and timeout / 1000 < left:
            self._wait(timeout)
            return False
        if left == float("inf"):
            raise Forever
        self.clock.sleep(max(0.0, left))
        return True

    def _end(self, dev_handle: Handle, ep: int, intf: int) -> tuple[Printer, int]:
        """The printer, and the packet size of the endpoint."""
        printer = self._use(dev_handle, "transfer", ep)
        assert printer.claims.get(intf) is dev_handle, "not claimed"
        for address, attributes, packet in printer.current(intf).ends:
            if address == ep and attributes & 3 == 2:
                if ep in printer.halted:
                    raise error(errno.EPIPE)
                return printer, packet
        raise error(errno.ENOENT)

    def bulk_write(self, dev_handle: Handle, ep: int, intf: int, data: array[int], timeout: int) -> int:
        printer, _ = self._end(dev_handle, ep, intf)
        assert data.typecode == "B"
        assert not ep & 0x80
        if not self._rested(printer, timeout):
            raise USBTimeoutError("Operation timed out", -7, errno.ETIMEDOUT)
        outcome = printer.next(len(data))
        taken = printer.take(data.tobytes(), outcome.bytes)
        match outcome:
            case Take() if taken:
                if taken < min(outcome.bytes, len(data)):
                    self._wait(timeout)  # its IN pipe is full
                return taken
            case Take() | Timeout():
                self._wait(timeout)
                if not taken:
                    raise USBTimeoutError("Operation timed out", -7, errno.ETIMEDOUT)
                return taken
            case Rest():
                printer.rests_until = self.clock.now + outcome.seconds
                if self._rested(printer, timeout):  # it goes on within the time the host allows
                    return taken + printer.take(data.tobytes()[taken:], len(data))
                return taken
            case Stall():
                printer.halted.add(ep)
                raise error(errno.EPIPE)
            case Unplug():
                printer.plugged = False
                raise error(outcome.first)
            case Fail():
                raise error(outcome.code)

    def bulk_read(self, dev_handle: Handle, ep: int, intf: int, buff: array[int], timeout: int) -> int:
        printer, packet = self._end(dev_handle, ep, intf)
        assert ep & 0x80
        if printer.in_stalls:
            printer.in_stalls -= 1
            printer.halted.add(ep)
            raise error(errno.EPIPE)
        count = 0
        while printer.replies and count < len(buff):
            part = printer.replies[0][:packet]
            if len(part) > len(buff) - count:
                printer.replies.popleft()
                raise error(errno.EOVERFLOW)
            buff[count : count + len(part)] = array("B", part)
            count += len(part)
            rest = printer.replies.popleft()[packet:]
            if rest:
                printer.replies.appendleft(rest)
            if len(part) < packet:
                return count
        if not count:
            self._wait(timeout)
            raise USBTimeoutError("Operation timed out", -7, errno.ETIMEDOUT)
        if count < len(buff):
            self._wait(timeout)  # the last packet was full: the host waits for more
        return count

    def ctrl_transfer(
        self,
        dev_handle: Handle,
        bmRequestType: int,
        bRequest: int,
        wValue: int,
        wIndex: int,
        data: array[int],
        timeout: int,
    ) -> int:
        printer = self._use(dev_handle, "ctrl_transfer", bmRequestType, bRequest, wValue, wIndex)
        if not printer.answers_control:
            self._wait(timeout)
            raise USBTimeoutError("Operation timed out", -7, errno.ETIMEDOUT)
        answer = self._answer(dev_handle, bmRequestType, bRequest, wValue, wIndex)
        if answer is None:
            raise error(errno.EPIPE)
        answer = answer[: len(data)]
        data[: len(answer)] = array("B", answer)
        return len(answer)

    def _answer(self, handle: Handle, kind: int, request: int, value: int, index: int) -> bytes | None:
        printer = handle.printer
        if (kind, request) == (0xA1, 0):  # the one class request that needs no claim
            places = printer.places()
            settings = places[sorted(places)[value]].get(index >> 8, [])
            good = any(s.setting == index & 0xFF and s.kind == 7 for s in settings)
            return printer.id if good else None
        if (kind, request) == (0xA1, 1):
            if printer.claims.get(index) is not handle:
                raise error(errno.EBUSY)
            return printer.status
        if (kind, request, value) == (0x80, 0, 0):
            return b"\1\0"
        if (kind, request) == (0x80, 6) and value >> 8 == 3:
            if not value & 0xFF:
                return b"\4\3\x09\x04"
            text = printer.strings[(value & 0xFF) - 1].encode("utf-16-le")
            return bytes([len(text) + 2, 3]) + text if index == 0x409 else None
        return None
