"""What is tried inside the virtual machine, each on a printer that is as just plugged in.

``python -m tests.peers.vm_scenes`` there runs them all and writes a line of JSON for each: its name, and
what went wrong or nothing. They are plain functions, as pytest would take longer to load than they run.
"""

from __future__ import annotations

import json
import os
import random
import signal
import threading
import time
import traceback
from collections.abc import Callable
from importlib import import_module

from devices.errors import DeviceBusyError, DisconnectedError, StalledError
from devices.status import Status
from devices.transports import open_transport
from devices.transports.base import Transport, Uri
from tests.peers.gadget import NODE, PAPER_OUT, Gadget, until
from tests.peers.stalling import StallingPrinter

__all__ = ["SCENES"]

BY_USB, BY_USBLP = "usb://EPSON/TM-T20?serial=SN1", f"file:{NODE}"
DATA = random.Random(1).randbytes(200_001)
LATE, SOON = 20.0, 0.2

Scene = Callable[[Gadget], None]


def forget_the_bus() -> None:
    """No udevd runs here to tell libusb what was plugged in since it first looked."""
    import usb.backend.libusb1

    usb.backend.libusb1._lib_object = None


def opened(uri: str) -> Transport:
    forget_the_bus()
    return open_transport(Uri.parse(uri))


def give(transport: Transport, data: bytes, timeout: float = LATE) -> int:
    """All of *data*, or as much as is taken before a write takes nothing; how much."""
    done = 0
    while done < len(data):
        taken = transport.write(memoryview(data)[done : done + transport.chunk], timeout)
        if not taken:
            break
        done += taken
    return done


def prints(gadget: Gadget, uri: str) -> None:
    """All bytes arrive once, and usblp has the printer afterwards as before."""
    with opened(uri) as transport:
        assert transport.device_id.model == "TM-T20"  # type: ignore[attr-defined]
        assert give(transport, DATA) == len(DATA)
        assert transport.flush(LATE)
    gadget.has(DATA)
    until(NODE.exists, "usblp's node, again")
    with NODE.open("wb", 0) as node:
        node.write(b"after")
        gadget.has(DATA + b"after")


def says_no_paper(gadget: Gadget, uri: str) -> None:
    with opened(uri) as transport:
        assert transport.port_status() == Status()
        gadget.say(PAPER_OUT)
        assert transport.port_status() == Status.of("media-empty-error")


def answers(gadget: Gadget, uri: str) -> None:
    """What the printer sends is read; nothing comes without a question."""
    with opened(uri) as transport:
        assert transport.reads
        assert transport.read(64, SOON) == b""
        give(transport, b"\x10\x04\x01\x10\x04\x02\x10\x04\x03\x10\x04\x04")
        assert transport.read(64, LATE) == b"\x12" * 4


def stops_reading_and_goes_on(gadget: Gadget, uri: str) -> None:
    """0 after the timeout and not before; then nothing is lost and nothing comes twice."""
    gadget.reading.clear()
    with opened(uri) as transport:
        done = give(transport, DATA, SOON)
        assert 0 < done < len(DATA), done
        start = time.monotonic()
        assert transport.write(memoryview(DATA)[done : done + transport.chunk], SOON) == 0
        assert time.monotonic() - start >= SOON * 0.9
        gadget.reading.set()
        assert give(transport, DATA[done:]) == len(DATA) - done
        assert transport.flush(LATE)
        gadget.has(DATA)


def is_unplugged(gadget: Gadget, uri: str) -> None:
    """During a write that waits."""
    gadget.reading.clear()
    transport = opened(uri)
    give(transport, DATA, SOON)
    pulling = threading.Timer(SOON, gadget.unplug)
    pulling.start()
    try:
        give(transport, DATA, LATE)
    except DisconnectedError:
        pass
    else:
        raise AssertionError("the write said nothing")
    finally:
        transport.close()
        pulling.join()
    until(lambda: not NODE.exists(), "usblp's node to go")
    gadget.plug()
    prints(gadget, uri)


def closes_at_once(gadget: Gadget) -> None:
    """usblp throws away what is on its way when it is closed: close() waits for that."""
    gadget.reading.clear()
    transport = opened(BY_USBLP)
    done = give(transport, DATA, 0.1)
    assert not transport.flush(0.1)
    threading.Timer(SOON, gadget.reading.set).start()
    transport.close()
    gadget.has(DATA[:done])


def closes_though_nothing_is_taken(gadget: Gadget) -> None:
    """The driver is made to drop what is on its way, and the node can be opened again."""
    gadget.reading.clear()
    transport = opened(BY_USBLP)
    give(transport, DATA, SOON)
    transport.failed = True  # type: ignore[attr-defined]  # so that it does not wait first
    transport.close()
    opened(BY_USBLP).close()


def is_interrupted_by_signals(gadget: Gadget) -> None:
    """usblp's blocking write fails at a signal, and its bytes arrive all the same."""
    signal.signal(signal.SIGALRM, lambda number, frame: None)
    signal.setitimer(signal.ITIMER_REAL, 0.005, 0.005)
    for k, act in enumerate([gadget.reading.clear, gadget.reading.set] * 4):
        threading.Timer(k * 0.05, act).start()
    try:
        with opened(BY_USBLP) as transport:
            assert give(transport, DATA) == len(DATA)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
    gadget.has(DATA)


def stalls(gadget: Gadget, uri: str) -> None:
    """It takes five pieces and refuses the sixth; usblp without blocking would not say so."""
    gadget.unplug()
    printer = StallingPrinter(f"stalling-{uri[:3]}", 5 * 8192)
    try:
        with opened(uri) as transport:
            try:
                done = give(transport, DATA)
            except StalledError:
                pass
            else:
                raise AssertionError(f"it took {done} bytes")
        assert DATA.startswith(printer.got), "what it got is not what was sent"
        assert len(printer.got) == printer.most
    finally:
        printer.unplug()
        gadget.plug()


def is_open_elsewhere(gadget: Gadget) -> None:
    with opened(BY_USBLP):
        try:
            opened(BY_USBLP)
        except DeviceBusyError:
            return
    raise AssertionError("it was opened twice")


def is_listed_and_examined(gadget: Gadget) -> None:
    from devices.discovery import found
    from devices.doctor import examine

    listed = found()
    assert [each.uri for each in listed if "tty" not in each.uri] == [BY_USB, BY_USBLP], listed
    assert all(each.title == "EPSON TM-T20" and each.languages == ("ESC/POS",) for each in listed[:2])
    findings = examine(BY_USB)
    assert all(finding.ok for finding in findings), findings
    assert any("usblp" in finding.what for finding in findings), findings
    with opened(BY_USB):
        (held,) = [each for each in found() if each.uri.startswith("usb:")]
        assert "another program" in held.problem, held
        until(lambda: not NODE.exists(), "usblp to let go")


def prints_a_picture(gadget: Gadget) -> None:
    """The whole way: profile, language, status query with its answer, report."""
    import numpy as np

    from devices import decode, open_device
    from halftone.frame import Frame

    forget_the_bus()
    with open_device(BY_USB, "receipt-80mm") as device:
        levels = device.profile.levels
        across, down = np.arange(576), np.arange(300)[:, None]
        picture = ((across * 7 + down * 3) % 13 < 5).astype(np.uint8)
        sent = bytearray()
        device.record = sent.extend
        report = device.print(Frame(picture, levels))
        status = device.status()
    assert report.completed, report
    assert report.rows_accepted == 300, report
    assert status == Status(), status
    until(lambda: sent in gadget.got, "the picture")
    (frame,) = decode(bytes(sent), "escpos")
    assert np.array_equal(frame.indices, picture)


BOTH = (stalls, prints, says_no_paper, answers, stops_reading_and_goes_on, is_unplugged)
SCENES: dict[str, Scene] = {
    f"{scene.__name__} by {way}": lambda gadget, scene=scene, uri=uri: scene(gadget, uri)
    for scene in BOTH
    for way, uri in (("libusb", BY_USB), ("usblp", BY_USBLP))
} | {
    scene.__name__: scene
    for scene in (
        closes_at_once,
        closes_though_nothing_is_taken,
        is_interrupted_by_signals,
        is_open_elsewhere,
        is_listed_and_examined,
        prints_a_picture,
    )
}
"""What is tried, by name."""


def main() -> None:
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    threading.Thread(target=import_module, args=("numpy",)).start()  # seconds here, needed last
    gadget = Gadget()
    for name, scene in SCENES.items():
        start, wrong = time.monotonic(), ""
        try:
            gadget.renew()
            scene(gadget)
        except Exception:
            wrong = traceback.format_exc()
        seconds = round(time.monotonic() - start, 2)
        print(json.dumps({"name": name, "wrong": wrong, "seconds": seconds}), flush=True)


if __name__ == "__main__":
    main()
