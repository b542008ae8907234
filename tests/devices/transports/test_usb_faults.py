"""Random faults on the USB: what is reported as taken is what the printer has, in order and once."""

from __future__ import annotations

import errno

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip("usb", reason="pyusb is not installed (pip install pyusb)")

from devices.errors import DisconnectedError, StalledError
from devices.transports.base import Uri
from devices.transports.usb import UsbTransport
from tests.bench.usb_faults import random_scripts
from tests.devices.simulated_usb import Clock, SimBackend
from tests.devices.simulated_usb_printer import Fail, Printer, Stall, Take, Timeout, Unplug

PATIENCE = 60.0
"""Seconds without a byte after which the writer below gives up."""

counts = st.integers(0, 9000)
outcomes = (
    st.builds(Take, st.integers(1, 9000))
    | st.builds(Timeout, counts | st.just(0))
    | st.builds(Stall, counts)
    | st.builds(Unplug, counts, st.sampled_from([errno.ENODEV, errno.EIO, errno.ESHUTDOWN]))
    | st.builds(Fail, st.sampled_from([errno.EIO, errno.EPROTO, errno.EOVERFLOW]), counts)
)
harmless = st.builds(Take, st.integers(1, 9000)) | st.builds(Timeout, counts)
printers = st.builds(
    Printer,
    script=st.lists(harmless, max_size=30) | st.lists(harmless | outcomes, max_size=12),
    drivers=st.sampled_from([{}, {0: "usblp"}]),
    says=st.binary(min_size=1, max_size=80),
    asks_every=st.sampled_from([0, 0, 700, 5000]),
    queue_limit=st.integers(1, 300),
    in_stalls=st.integers(0, 1),
)


def push(transport: UsbTransport, data: bytes, clock: Clock) -> tuple[int, str]:
    """Resume until all is taken, or it fails: how many bytes were taken, and how it ended."""
    done, moved = 0, clock()
    view = memoryview(data)
    try:
        while done < len(view):
            before = clock()
            count = transport.write(view[done:], 0.5)
            assert 0 <= count <= transport.chunk
            if count == 0:
                assert clock() - before >= 0.5 - 1e-9, "0 is returned only after the time"
            done += count
            moved = clock() if count else moved
            if clock() - moved > PATIENCE:
                return done, "timeout"
            transport.read(4096, 0)
    except DisconnectedError:
        return done, "gone"
    except StalledError:
        return done, "stalled"
    return done, "done"


@settings(max_examples=300)
@given(printers, st.binary(min_size=1, max_size=64), st.integers(1, 400))
def test_what_is_reported_is_what_it_has(printer, seed, times):
    data, clock = bytes(k ^ n & 255 for n in range(times) for k in seed), Clock()
    transport = UsbTransport.open(Uri.parse("usb:"), 10.0, SimBackend(printer, clock=clock))
    driver = dict(printer.removed)
    done, end = push(transport, data, clock)
    transport.close()
    assert data.startswith(bytes(printer.received)), "in order and never twice"
    if end == "done":
        assert printer.received == data
    unknown = 0 if end in ("done", "timeout") else transport.chunk
    assert 0 <= len(printer.received) - done <= unknown
    assert clock() <= 0.6 * (len(data) + 100) + PATIENCE + 5
    assert printer.open_handles == 0
    assert not [call for call in printer.calls if call[0] == "reset_device"]
    if printer.plugged:
        assert printer.drivers == driver
        assert not printer.halted & {0x02}


def test_a_whole_job_through_the_device():
    """As above, with its waiting, its looking at the status and its report."""
    ended = random_scripts(200)
    assert set(ended) == {
        "printed",
        "DisconnectedError",
        "StalledError",
        "DeviceTimeoutError",
        "DeviceStateError",
    }
