"""Our USB transport over the real pyusb and libusb, on a printer that umockdev puts into /dev and /sys.

umockdev answers a transfer only if its bytes are those of the script: what is resumed at the wrong place
matches nothing and fails. Timeouts, kernel drivers and control transfers it cannot play; those are
tried on the kernel itself.
"""

from __future__ import annotations

import errno
import json
import os
import random
import struct
import subprocess
import sys
from pathlib import Path

import pytest

from tests.peers.places import program

pytest.importorskip("usb", reason="pyusb is not installed (tests/peers/install.sh)")

pytestmark = pytest.mark.peer

NODE = "/dev/bus/usb/001/005"
OUT, IN = 0x02, 0x81

WORKER = """
import json, sys
from devices.errors import PrintError
from devices.transports.base import Uri
from devices.transports.usb import UsbTransport
from devices.transports.usb_find import found

steps, said = json.load(open(sys.argv[1])), [[each.uri for each in found()]]
with UsbTransport.open(Uri.parse("usb://04b8:0202"), 5.0) as transport:
    for kind, what in steps:
        try:
            if kind == "read":
                said.append(transport.read(what, 1.0).hex())
            else:
                data, done, counts = memoryview(bytes.fromhex(what)), 0, []
                while done < len(data):
                    counts.append(transport.write(data[done:], 1.0))
                    done += counts[-1]
                said.append(counts)
        except PrintError as error:
            said.append(type(error).__name__)
json.dump(said, open(sys.argv[2], "w"))
"""


def descriptors() -> bytes:
    """A printer of the class 7.1.2 with two bulk endpoints of 512 bytes (USB 2.0 §9.6)."""
    device = struct.pack("<BBHBBBBHHHBBBB", 18, 1, 0x200, 0, 0, 0, 64, 0x04B8, 0x0202, 0x100, 0, 0, 0, 1)
    configuration = struct.pack("<BBHBBBBB", 9, 2, 9 + 9 + 14, 1, 1, 0, 0xC0, 1)
    interface = struct.pack("<BBBBBBBBB", 9, 4, 0, 0, 2, 7, 1, 2, 0)
    ends = (struct.pack("<BBBBHB", 7, 5, address, 2, 512, 0) for address in (OUT, IN))
    return device + configuration + interface + b"".join(ends)


def device() -> str:
    return f"""P: /devices/pci0000:00/0000:00:14.0/usb1/1-2
N: {NODE.removeprefix("/dev/")}
E: BUSNUM=001
E: DEVNAME={NODE}
E: DEVNUM=005
E: DEVTYPE=usb_device
E: MAJOR=189
E: MINOR=4
E: SUBSYSTEM=usb
A: bConfigurationValue=1\\n
A: busnum=1\\n
A: devnum=5\\n
A: speed=480\\n
H: descriptors={descriptors().hex().upper()}
"""


def urb(end: int, data: bytes, actual: int, status: int = 0, size: int | None = None) -> str:
    """A bulk transfer, and what the kernel says of it. libusb asks without waiting (REAPURBNDELAY)."""
    length = len(data) if size is None else size
    return f"USBDEVFS_REAPURBNDELAY 0 3 {end} {-status} 0 {length} {actual} 0 {data.hex().upper()}\n"


def play(folder: Path, urbs: list[str], steps: list[tuple[str, str | int]]) -> list[object]:
    """What the worker said of each step, after the URIs that it found."""
    for name, text in [
        ("printer.umockdev", device()),
        ("script.ioctl", f"@DEV {NODE}\n" + "".join(urbs)),
        ("steps.json", json.dumps(steps)),
    ]:
        (folder / name).write_text(text)
    done = subprocess.run(
        [
            program("umockdev-run"),
            *("-d", folder / "printer.umockdev", "-i", f"{NODE}={folder / 'script.ioctl'}", "--"),
            *(sys.executable, "-c", WORKER, folder / "steps.json", folder / "said.json"),
        ],
        capture_output=True,
        text=True,
        timeout=50,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
    )
    assert done.returncode == 0, done.stderr
    uris, *said = json.loads((folder / "said.json").read_text())
    assert uris == ["usb://04b8:0202"]
    return said


def test_short_writes_are_resumed_where_they_ended(tmp_path):
    data = random.Random(3).randbytes(20000)
    cuts = [(0, 8192, 8192), (8192, 16384, 3), (8195, 16387, 5000), (13195, 20000, 6805)]
    urbs = [urb(OUT, data[start:end], taken) for start, end, taken in cuts]
    assert play(tmp_path, urbs, [("write", data.hex())]) == [[taken for *_, taken in cuts]]


def test_a_byte_out_of_place_would_be_found(tmp_path):
    """The script above is worth something: it refuses other bytes."""
    assert play(tmp_path, [urb(OUT, b"12345", 5)], [("write", b"12346".hex())]) == ["DisconnectedError"]


@pytest.mark.parametrize(
    ("code", "said"),
    [
        (errno.EPIPE, "StalledError"),
        (errno.ENODEV, "DisconnectedError"),
        (errno.ESHUTDOWN, "DisconnectedError"),
    ],
)
def test_errors_of_the_kernel(tmp_path, code, said):
    urbs = [urb(OUT, b"begin", 5), urb(OUT, b"broken", 2, code)]
    steps = [("write", b"begin".hex()), ("write", b"broken".hex())]
    assert play(tmp_path, urbs, steps) == [[5], said]


def test_answers_are_read_in_whole_packets(tmp_path):
    """Asked for 4 bytes, libusb is given a buffer of a packet, and the rest is kept."""
    urbs = [urb(OUT, b"\x10\x04\x01", 3), urb(IN, b"\x12\x00\x55\x66\x77\x88", 6, size=512)]
    steps: list[tuple[str, str | int]] = [("write", "100401"), ("read", 4), ("read", 2)]
    assert play(tmp_path, urbs, steps) == [[3], "12005566", "7788"]


def test_a_stalled_answer_is_no_end(tmp_path):
    urbs = [urb(IN, b"", 0, errno.EPIPE, size=512), urb(OUT, b"more", 4)]
    assert play(tmp_path, urbs, [("read", 4), ("write", b"more".hex())]) == ["", [4]]
