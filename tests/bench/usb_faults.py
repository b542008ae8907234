"""Faults on the USB, and what becomes of the bytes: ours, python-escpos and brother_ql on the same
simulated printers. ``python -m tests.bench.usb_faults`` prints a table in Markdown; with ``--scripts
10000``, so many random scripts of faults are run through our Device.
"""

from __future__ import annotations

import argparse
import logging
import random
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from devices.device import Device, PrintReport
from devices.errors import DisconnectedError, PrintError, StalledError
from devices.languages import language
from devices.profile import load
from devices.sending import Patience
from devices.transports.base import Uri
from devices.transports.usb import UsbTransport
from halftone.frame import Frame
from tests.bench.table import markdown
from tests.devices.simulated_usb import Forever, SimBackend
from tests.devices.simulated_usb_printer import (
    Fail,
    Outcome,
    Printer,
    Rest,
    Setting,
    Stall,
    Take,
    Timeout,
    Unplug,
)

__all__ = ["CASES", "DRIVERS", "Ended", "random_scripts", "run", "table"]

ENDS = (Setting(ends=((0x01, 2, 64), (0x82, 2, 64))),)
"""The endpoints that python-escpos takes for granted; all cases but one have them."""
NEVER = float("inf")


CASES: dict[str, Callable[[], Printer]] = {
    "no fault": lambda: Printer(ENDS),
    "takes 12,000 bytes, and says so": lambda: Printer(ENDS, at=(12000, Take(0))),
    "out of paper for 30 s after 12,000 bytes": lambda: Printer(ENDS, at=(12000, Rest(0, 30))),
    "takes nothing any more after 12,000 bytes": lambda: Printer(ENDS, at=(12000, Rest(0, NEVER))),
    "halts the pipe (stall) after 12,000 bytes": lambda: Printer(ENDS, at=(12000, Stall())),
    "unplugged after 12,000 bytes": lambda: Printer(ENDS, at=(12000, Unplug())),
    "takes nothing while 12 bytes of status wait to be read": lambda: Printer(
        ENDS, says=b"\x14\x00\x00\x0f", asks_every=1000, queue_limit=12
    ),
    "endpoints 0x02 and 0x81": lambda: Printer(),
    "interface 1, beside a scanner": lambda: Printer(
        (Setting(kind=255, ends=((0x03, 2, 64),)), Setting(1, ends=ENDS[0].ends)), drivers={1: "usblp"}
    ),
    "`usblp` has it": lambda: Printer(ENDS, drivers={0: "usblp"}),
    "another program has it": lambda: Printer(ENDS, holders={0: "ipp-usb"}),
}


@dataclass(frozen=True)
class Ended:
    """What became of a job. said : the error that the caller got, empty if none; told : the bytes that
    the driver reported as taken, None if it does not report any."""

    payload: bytes
    printer: Printer
    said: str
    told: int | None
    driver: dict[int, str]

    @property
    def whole(self) -> bool:
        return bytes(self.printer.received) == self.payload

    def __str__(self) -> str:
        got = len(self.printer.received)
        parts = ["all bytes" if self.whole else f"{got:,} of {len(self.payload):,} bytes"]
        if self.said:
            parts.append(self.said)
        elif not self.whole:
            parts = [f"**{len(self.payload) - got:,} bytes lost, and says nothing**"]
        if self.told is not None and not self.whole:
            parts.append(f"reports {self.told:,}")
        if self.driver and self.printer.plugged and self.printer.drivers != self.driver:
            parts.append("**`usblp` not attached again**")
        if any(call[0] == "reset_device" for call in self.printer.calls):
            parts.append("reset")
        return "; ".join(parts)


def picture(rows: int = 400, width: int = 576) -> Frame:
    dots = np.random.default_rng(7).integers(0, 2, (rows, width), dtype=np.uint8)
    return Frame(dots, load("receipt-80mm").levels)


def payload(frame: Frame) -> bytes:
    """What is to be printed: the bytes that a transport without faults is given."""
    from devices.transports.memory import MemoryTransport

    transport = MemoryTransport()
    Device(transport, language("pbm"), load("receipt-80mm")).print(frame)
    return transport.data


def ours(backend: SimBackend, frame: Frame, data: bytes) -> int:
    transport = UsbTransport.open(Uri.parse("usb:"), 10.0, backend)
    clock = backend.clock
    with Device(
        transport, language("pbm"), load("receipt-80mm"), clock=clock, asleep=clock.sleep
    ) as device:
        try:
            return device.print(frame).bytes_accepted
        except PrintError as error:
            told.append((error.report or PrintReport()).bytes_accepted)
            raise


def python_escpos(backend: SimBackend, data: bytes, timeout: int) -> None:
    """timeout : in milliseconds, 0 for ever, which is its default."""
    from escpos.printer import Usb

    printer = Usb(0x04B8, 0x0202, usb_args={"backend": backend}, timeout=timeout)
    try:
        printer._raw(data)
    finally:
        printer.close()


def brother_ql(backend: SimBackend, data: bytes) -> None:
    import usb.core
    from brother_ql.backends.pyusb import BrotherQLBackendPyUSB

    printer = BrotherQLBackendPyUSB(usb.core.find(backend=backend))
    try:
        printer.write(data)
    finally:
        printer.dispose()


Driver = Callable[[SimBackend, Frame, bytes], int | None]
DRIVERS: dict[str, Driver] = {
    "ours": ours,
    "python-escpos": lambda backend, frame, data: python_escpos(backend, data, 0),
    "python-escpos, `timeout=5000`": lambda backend, frame, data: python_escpos(backend, data, 5000),
    "brother_ql": lambda backend, frame, data: brother_ql(backend, data),
}
told: list[int] = []
"""What a driver reported before it raised."""


def run(case: str, driver: str, frame: Frame, data: bytes) -> Ended:
    """One job on one printer, by one driver."""
    printer = CASES[case]()
    had, said, count = dict(printer.drivers), "", None
    told.clear()
    backend = SimBackend(printer)
    try:
        count = DRIVERS[driver](backend, frame, data)
    except Forever:
        said = "**waits for ever**"
    except Exception as error:
        inner = error.__cause__ or error
        said = f"`{type(error).__name__}`"
        if driver != "ours" and isinstance(inner, OSError) and inner is not error:
            said += f" ({inner.strerror})"
        count = told[0] if told else None
    return Ended(data, printer, said, count, had)


def table() -> str:
    frame = picture()
    data = payload(frame)
    logging.disable(logging.CRITICAL)
    rows = [[case, *(str(run(case, driver, frame, data)) for driver in DRIVERS)] for case in CASES]
    return markdown(["the printer", *DRIVERS], rows)


def random_outcome(chance: random.Random, gentle: bool) -> Outcome:
    most = chance.choice([0, 1, 63, 64, 4096, 9000])
    count = chance.randint(0, most)
    kinds: list[Callable[[], Outcome]] = [
        lambda: Take(max(1, count)),
        lambda: Timeout(count),
        lambda: Rest(count, chance.choice([0.1, 3.0, 45.0])),
    ]
    if not gentle:
        kinds += [
            lambda: Stall(count),
            lambda: Unplug(count, chance.choice([5, 19, 108])),
            lambda: Fail(chance.choice([5, 71]), count),
            lambda: Rest(count, NEVER),
        ]
    return chance.choice(kinds)()


def random_scripts(number: int, seed: int = 1) -> dict[str, int]:
    """Run random faults through our Device: how each job ended. Raises AssertionError for a byte that
    was lost or sent twice, or a job that ended later than its deadline."""
    chance, ended = random.Random(seed), dict[str, int]()
    frame, profile = picture(300), load("receipt-80mm")
    data = payload(frame)
    patience = Patience(stall=60, fault=100, answer=3, finish=10)
    for _ in range(number):
        gentle = chance.random() < 0.5
        printer = Printer(
            script=[random_outcome(chance, gentle) for _ in range(chance.randint(0, 12))],
            drivers=chance.choice([{}, {0: "usblp"}]),
            says=bytes(chance.randint(1, 70)),
            asks_every=chance.choice([0, 0, 500, 4000]),
            queue_limit=chance.randint(1, 200),
            replies=deque(chance.choice([[], [b"noise"], [b"x" * 64]])),
            status=chance.choice([b"\x18", b"\x18", b"\x00", None, b"\x30"]),
        )
        script = list(printer.script)
        had, backend = dict(printer.drivers), SimBackend(printer)
        clock = backend.clock
        transport = UsbTransport.open(Uri.parse("usb:"), 10.0, backend)
        device = Device(
            transport,
            language("pbm"),
            profile,
            patience=patience,
            clock=clock,
            asleep=clock.sleep,
        )
        with device:
            try:
                report, end = device.print(frame), "printed"
                assert report.completed, script
            except PrintError as error:
                report, end = error.report or PrintReport(), type(error).__name__
        got, count = bytes(printer.received), report.bytes_accepted
        assert data.startswith(got), f"not in order, or twice: {script}"
        if end == "printed":
            assert got == data, f"lost: {script}"
        unknown = transport.chunk if end in (DisconnectedError.__name__, StalledError.__name__) else 0
        assert count <= len(got) <= count + unknown, f"{end}, {len(got)} and not {count}: {script}"
        assert printer.open_handles == 0, script
        assert not printer.plugged or printer.drivers == had, script
        assert clock() < 110 * (len(script) + 2), script
        ended[end] = ended.get(end, 0) + 1
    return ended


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scripts", type=int, help="run so many random scripts instead")
    options = parser.parse_args()
    if options.scripts is None:
        print(table())
        return
    start = time.perf_counter()
    ended = random_scripts(options.scripts)
    kinds = ", ".join(f"{count:,} {kind}" for kind, count in sorted(ended.items()))
    print(f"{options.scripts:,} scripts, no byte lost or sent twice: {kinds}")
    print(f"{time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
