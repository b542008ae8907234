"""``usb://``, a printer of the USB printer class 1.1, by pyusb and libusb.

Endpoints come from descriptors; a kernel driver that is in the way (usblp) is detached and attached
again on close; a configuration is set only if the printer is not in the one that is set; the device is
never reset: that would make it forget what it has, and tear down its other interfaces.

What libusb transfers but does not report: if a transfer fails (not: times out), it is unknown how much
of it the device took, at most the last :attr:`UsbTransport.chunk` bytes.
"""

from __future__ import annotations

import errno
from array import array
from contextlib import suppress
from typing import Any, Self
from warnings import warn

from devices.errors import DisconnectedError, PrintError, StalledError
from devices.status import Status
from devices.transports.base import Transport, Uri
from devices.transports.usb_access import GONE, refused
from devices.transports.usb_find import find, library
from devices.transports.usb_printers import ANSWER, Interface, Printer, ask, device_id, milliseconds

__all__ = ["UsbTransport"]


class UsbTransport(Transport):
    """An open USB printer. device_id : what it says it is."""

    scheme = "usb"
    chunk = 8192  # as CUPS writes; a failed transfer leaves no more than this unknown

    def __init__(self, printer: Printer, ways: tuple[Interface, ...], timeout: float = 10.0) -> None:
        """Open *printer* by the first of *ways* that its configuration has, else by the first."""
        self.printer, self._backend = printer, printer.backend
        self._handle: Any = None
        self._claimed = self._detached = False
        self._former = 0  # the configuration to go back to
        self._surplus = b""  # bytes of a packet that were more than was asked for
        self._deaf = False  # the IN pipe stalled when it was last read
        self._way = ways[0]
        claiming: tuple[int, int] | None = None
        try:
            self._handle = self._backend.open_device(printer.device)
            active = self._backend.get_configuration(self._handle)
            self._way = next((way for way in ways if way.configuration == active), ways[0])
            claiming = self._way.configuration, self._way.number
            self._claim(active)
        except (OSError, NotImplementedError) as error:
            who = refused(error, printer, claiming)
            self.close()
            raise who from error
        self.reads = self._way.into is not None
        self.device_id = device_id(printer, self._handle, min(ANSWER, timeout / 8))

    @classmethod
    def open(cls, uri: Uri, timeout: float = 10.0, backend: Any = None) -> Self:
        """See :meth:`Transport.open`. backend : a ``usb.backend.IBackend``; None takes libusb."""
        printer, ways = find(uri, backend or library(), timeout)
        return cls(printer, ways, timeout)

    def write(self, data: memoryview, timeout: float) -> int:
        from usb.core import USBError, USBTimeoutError

        if not data:
            return 0
        piece = array("B", bytes(data[: self.chunk]))
        place = self._open_handle(), self._way.out, self._way.number
        try:
            return int(self._backend.bulk_write(*place, piece, milliseconds(timeout)))
        except USBTimeoutError:
            return 0  # pyusb raises it only if nothing was taken
        except USBError as error:
            raise self._broken(error) from error

    def read(self, size: int, timeout: float) -> bytes:
        """All that has come, up to *size* bytes: the device may wait to be rid of it."""
        while len(self._surplus) < size:
            came = self._read_packets(size - len(self._surplus), 0 if self._surplus else timeout)
            self._surplus += came
            if not came:
                break
        answer, self._surplus = self._surplus[:size], self._surplus[size:]
        return answer

    def port_status(self) -> Status | None:
        """GET_PORT_STATUS. None if it does not answer, or with a constant that says nothing."""
        if self._handle is None:
            return None
        try:
            answer = self._ask(0xA1, 1, 0, self._way.number, 1)
        except OSError:
            return None
        return Status.of_port(answer[0]) if len(answer) == 1 else None

    def close(self) -> None:
        handle, self._handle = self._handle, None
        if handle is None:
            return
        backend, number = self._backend, self._way.number
        try:
            if self._claimed:
                with suppress(OSError):  # it may have gone
                    backend.release_interface(handle, number)
            if self._former:
                with suppress(OSError):
                    backend.set_configuration(handle, self._former)
            elif self._detached:
                self._attach(handle)
        finally:
            backend.close_device(handle)

    def _claim(self, active: int) -> None:
        """Take the interface, and from the kernel if need be."""
        backend, handle, way = self._backend, self._handle, self._way
        if active != way.configuration:
            backend.set_configuration(handle, way.configuration)
            self._former = active
        with suppress(NotImplementedError):  # Windows, macOS
            if backend.is_kernel_driver_active(handle, way.number):
                backend.detach_kernel_driver(handle, way.number)
                self._detached = True
        backend.claim_interface(handle, way.number)
        self._claimed = True
        if way.settings > 1:
            backend.set_interface_altsetting(handle, way.number, way.setting)

    def _attach(self, handle: Any) -> None:
        try:
            self._backend.attach_kernel_driver(handle, self._way.number)
        except NotImplementedError:
            pass
        except OSError as error:
            if error.errno not in GONE and not self._gone(handle):
                warn(f"{self.printer} could not be given back to the kernel: {error}", stacklevel=3)

    def _read_packets(self, size: int, timeout: float) -> bytes:
        """What one transfer brings. The buffer holds whole packets: of a packet that is too long for
        it, the device's bytes would be lost."""
        from usb.core import USBError, USBTimeoutError

        handle, way = self._open_handle(), self._way
        if way.into is None or not self.reads:
            return b""
        buffer = array("B", bytes(-(-size // way.packet) * way.packet))
        try:
            count = self._backend.bulk_read(handle, way.into, way.number, buffer, milliseconds(timeout))
            self._deaf = False
        except USBTimeoutError:
            return b""
        except USBError as error:
            if error.errno not in (errno.EPIPE, errno.EOVERFLOW):
                raise self._broken(error) from error
            self.reads = not self._deaf  # twice in a row: it has nothing to say, and that is no fault
            self._deaf = True
            with suppress(OSError):
                self._backend.clear_halt(handle, way.into)
            return b""
        return buffer[:count].tobytes()

    def _broken(self, error: OSError) -> PrintError:
        """What a failed transfer means."""
        if error.errno in GONE or (error.errno != errno.EPIPE and self._gone(self._handle)):
            return DisconnectedError(f"{self.printer} was unplugged or switched off")
        with suppress(OSError):  # so that the next who opens it can write
            self._backend.clear_halt(self._handle, self._way.out)
        how = "refuses data (stall)" if error.errno == errno.EPIPE else f"failed ({error.strerror})"
        return StalledError(
            f"{self.printer} {how}; how much it took of the last {self.chunk} bytes is unknown. "
            "Switch it off and on before the next job"
        )

    def _gone(self, handle: Any) -> bool:
        """Whether it has left the bus: then it does not answer GET_STATUS (USB 2.0 §9.4.5) either."""
        try:
            ask(self._backend, handle, 0x80, 0, 0, 0, 2, ANSWER)
        except OSError as error:
            return error.errno in GONE or error.errno == errno.EIO
        return False

    def _ask(self, kind: int, request: int, value: int, index: int, size: int) -> bytes:
        return ask(self._backend, self._handle, kind, request, value, index, size, ANSWER)

    def _open_handle(self) -> Any:
        if self._handle is None:
            raise DisconnectedError(f"{self.printer} is closed")
        return self._handle
