"""A printer at the device end of a USB cable: Linux's usb_f_printer over dummy_hcd; see tests.peers.vm.

https://docs.kernel.org/usb/gadget_printer.html
"""

from __future__ import annotations

import fcntl
import os
import select
import threading
import time
from collections.abc import Callable
from pathlib import Path

__all__ = ["GOOD", "NODE", "PAPER_OUT", "Gadget", "until"]

FOLDER = Path("/sys/kernel/config/usb_gadget/printer")
NODE = Path("/dev/usb/lp0")
"""Where usblp shows it at the host's end."""
ID = "MFG:EPSON;CMD:ESC/POS;MDL:TM-T20;CLS:PRINTER;"
SET_STATUS = 3 << 30 | 1 << 16 | ord("g") << 8 | 0x22
"""linux/usb/g_printer.h: GADGET_SET_PRINTER_STATUS."""
GOOD, PAPER_OUT = 0x18, 0x30
QUERY, ANSWER = b"\x10\x04\x01\x10\x04\x02\x10\x04\x03\x10\x04\x04", b"\x12" * 4
"""ESC/POS: how are you? All is well."""


class Gadget:
    """A printer. got : the bytes it has read. reading : clear it, and it reads no more."""

    def __init__(self) -> None:
        self.got = bytearray()
        self.reading = threading.Event()
        self.reading.set()
        self._descriptor = -1
        self._stop = False
        self._thread: threading.Thread | None = None
        language, use = FOLDER / "strings/0x409", FOLDER / "configs/c.1"
        function = FOLDER / "functions/printer.0"
        for folder in (language, function, use):
            folder.mkdir(parents=True)
        for name, text in (("idVendor", "0x04b8"), ("idProduct", "0x0202")):
            (FOLDER / name).write_text(text)
        for name, text in (("manufacturer", "EPSON"), ("product", "TM-T20"), ("serialnumber", "SN1")):
            (language / name).write_text(text)
        (function / "pnp_string").write_text(ID + "\n")  # the kernel drops the last byte
        (use / "printer.0").symlink_to(function)

    def plug(self) -> None:
        """Returns when the host's usblp has it."""
        (FOLDER / "UDC").write_text("dummy_udc.0")
        until(self._open, "the gadget to be configured by its host")
        self.say(GOOD)
        self.got.clear()
        self.reading.set()
        self._stop = False
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()
        until(NODE.exists, "usblp's node")

    def unplug(self) -> None:
        self._stop = True
        if self._thread is not None:
            self._thread.join()
        os.close(self._descriptor)
        self._descriptor = -1
        (FOLDER / "UDC").write_text("\n")

    def renew(self) -> None:
        """As just plugged in; plugged in again only if it holds bytes that it has not read."""
        if self._descriptor >= 0 and self.reading.is_set():
            self.say(GOOD)
            self.got.clear()
            until(NODE.exists, "usblp's node")
        else:
            if self._descriptor >= 0:
                self.unplug()
            until(lambda: not NODE.exists(), "usblp's node to go")
            self.plug()

    def say(self, status: int) -> None:
        """What it answers to GET_PORT_STATUS from now on."""
        fcntl.ioctl(self._descriptor, SET_STATUS, status)

    def has(self, data: bytes) -> None:
        """Raises AssertionError unless it reads just *data* within a while."""
        until(lambda: len(self.got) >= len(data), f"{len(data)} bytes; there are {len(self.got)}")
        assert bytes(self.got) == data, f"got {len(self.got)} bytes and not the {len(data)} sent"

    def _open(self) -> bool:
        try:
            self._descriptor = os.open("/dev/g_printer0", os.O_RDWR | os.O_NONBLOCK)
        except OSError:
            return False
        return True

    def _read(self) -> None:
        poll = select.poll()
        poll.register(self._descriptor, select.POLLIN)
        while not self._stop:
            if not self.reading.wait(0.02) or not poll.poll(20):
                continue
            try:
                data = os.read(self._descriptor, 1 << 16)
            except BlockingIOError:
                continue
            self.got += data
            if data.endswith(QUERY):
                os.write(self._descriptor, ANSWER)


def until(done: Callable[[], bool], what: str, timeout: float = 20.0) -> None:
    """Wait for something. Raises AssertionError after *timeout* seconds."""
    end = time.monotonic() + timeout
    while not done():
        assert time.monotonic() < end, f"waited in vain for {what}"
        time.sleep(0.01)
