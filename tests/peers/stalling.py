"""A USB printer that only listens and can refuse: usb_f_printer never stalls, so this one is of our own,
by FunctionFS (https://docs.kernel.org/usb/functionfs.html).
"""

from __future__ import annotations

import os
import struct
import subprocess
import threading
from contextlib import suppress
from pathlib import Path

from tests.peers.gadget import ID, NODE, until

__all__ = ["StallingPrinter"]

GADGETS = Path("/sys/kernel/config/usb_gadget")
INTERFACE = bytes([9, 4, 0, 0, 1, 7, 1, 1, 1])
"""One endpoint, class 7, subclass 1, protocol 1."""
SETUP = 4
"""FUNCTIONFS_SETUP."""


class StallingPrinter:
    """Takes *most* bytes and then stalls. got : the bytes. name : of its own among gadgets."""

    def __init__(self, name: str, most: int) -> None:
        self.got, self.most = bytearray(), most
        self._gadget, self._mount = GADGETS / name, Path("/tmp", name)
        language, use = self._gadget / "strings/0x409", self._gadget / "configs/c.1"
        function = self._gadget / f"functions/ffs.{name}"
        for folder in (language, function, use, self._mount):
            folder.mkdir(parents=True)
        for key, text in (("idVendor", "0x04b8"), ("idProduct", "0x0202")):
            (self._gadget / key).write_text(text)
        for key, text in (("manufacturer", "EPSON"), ("product", "TM-T20"), ("serialnumber", "SN1")):
            (language / key).write_text(text)
        (use / "function").symlink_to(function)
        subprocess.run(["mount", "-t", "functionfs", name, self._mount], check=True)
        self._control = os.open(self._mount / "ep0", os.O_RDWR)
        speeds = [INTERFACE + bytes([7, 5, 1, 2]) + struct.pack("<HB", size, 0) for size in (64, 512)]
        body = struct.pack("<II", 2, 2) + b"".join(speeds)
        os.write(self._control, struct.pack("<III", 3, 12 + len(body), 1 | 2) + body)
        words = struct.pack("<H", 0x409) + b"printer\0"
        os.write(self._control, struct.pack("<IIII", 2, 16 + len(words), 1, 1) + words)
        threading.Thread(target=self._answer, daemon=True).start()
        (self._gadget / "UDC").write_text("dummy_udc.0")
        until(NODE.exists, "usblp's node")
        threading.Thread(target=self._read, daemon=True).start()

    def unplug(self) -> None:
        (self._gadget / "UDC").write_text("\n")
        until(lambda: not NODE.exists(), "usblp's node to go")

    def _answer(self) -> None:
        """The questions of the printer class, on the control pipe."""
        with suppress(OSError):
            while event := os.read(self._control, 12):
                kind, request = event[:2]
                if event[8] != SETUP:
                    continue
                if not kind & 0x80:
                    os.read(self._control, 0)
                elif request == 0:
                    os.write(self._control, struct.pack(">H", len(ID) + 2) + ID.encode())
                else:
                    os.write(self._control, b"\x18")

    def _read(self) -> None:
        with suppress(OSError):
            end = os.open(self._mount / "ep1", os.O_RDWR)
            while len(self.got) < self.most:
                self.got += os.read(end, 8192)
            os.write(end, b"x")  # the wrong way: this is how it is told to stall
