"""Random fault scripts against every language: is a byte ever lost or sent twice?

``python -m tests.bench.faults [--count 10000] [--seed 1]``. Each script is a random print (a language,
one to three pages of random size) to a device that takes a few bytes at a time, pauses, runs out of
paper and gets some, sends bytes of its own and takes nothing until they are read, and at last is
unplugged, stalls, stops for ever, or all goes well; some prints are cancelled on the way. Time is the
simulator's own. Compared is what the device got with what the language makes of the pages.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter

import numpy as np

from devices import Patience, load
from devices.device import Device, PrintReport
from devices.errors import PrintError, ProtocolError
from devices.languages import language
from devices.languages.base import Language, encoded
from devices.profile import DeviceProfile
from halftone.frame import Frame
from tests.bench.printing import VARIANTS, name_of
from tests.devices.languages.contract import frame_of
from tests.devices.simulated import Clock, Gone, Hold, Say, Scripted, Stall, Take

PATIENCE = Patience(stall=20.0, fault=100.0, answer=3.0, finish=10.0)
REASONS = ("media-empty-error", "cover-open-error", "offline-report")


def script_of(rng: np.random.Generator, size: int) -> list[object]:
    """What the device does with a job of about *size* bytes."""
    steps: list[object] = []
    for _ in range(rng.integers(0, 12)):
        kind = rng.integers(6)
        if kind < 3:
            steps.append(Take(int(rng.integers(1, max(2, size // 3))), float(rng.random())))
        elif kind == 3:
            steps.append(Hold(float(rng.random() * 8)))
        elif kind == 4:
            steps.append(Hold(float(rng.random() * 30), (str(rng.choice(REASONS)),)))
        else:
            steps.append(Say(rng.bytes(rng.integers(1, 9))))
    endings: list[object] = [None, None, Gone(), Stall(), Hold(1e9), Hold(1e9, ("media-empty-error",))]
    ending = endings[rng.integers(len(endings))]
    return steps if ending is None else [*steps, ending]


def frames_of(rng: np.random.Generator, name: str) -> list[Frame]:
    pages = 1 if name == "png" else int(rng.integers(1, 4))
    return [
        frame_of(
            (rng.random((rng.integers(1, 200), rng.integers(1, 400))) < 0.6).astype(np.uint8),
            dpi=(300.0, 300.0),
        )
        for _ in range(pages)
    ]


def one(rng: np.random.Generator, made: Language, profile: DeviceProfile) -> tuple[str, float]:
    """How one script ended (``LOST`` if a byte was lost, doubled or miscounted), and when."""
    frames = frames_of(rng, made.name)
    whole = encoded(made, *frames)
    clock = Clock()
    script = script_of(rng, len(whole))
    transport = Scripted(script, clock)
    transport.reads = bool(rng.integers(2))
    recorded = bytearray()
    device = Device(
        transport,
        made,
        profile,
        patience=PATIENCE,
        clock=clock,
        asleep=clock.sleep,
        record=recorded.extend,
    )
    left = int(rng.integers(1, 60)) if rng.random() < 0.2 else 1 << 60

    def cancel() -> bool:
        nonlocal left
        left -= 1
        return left < 0

    try:
        report, outcome = device.print(*frames, cancel=cancel), "completed"
    except PrintError as error:
        report, outcome = error.report or PrintReport(), type(error).__name__
    got, query = bytes(transport.got), made.status_query
    if transport.reads and query:  # the query comes first, in as many pieces as it was taken
        asked = 0
        while got.startswith(query) and not recorded.startswith(got):
            got, asked = got[len(query) :], asked + 1
    if report.bytes_accepted != len(transport.got) or not (got == recorded or query.startswith(got)):
        return "LOST", clock.now
    if report.cancelled:
        if report.completed and not ends_well(made, bytes(recorded)):
            return "LOST", clock.now
        return "cancelled" if report.completed else "cancelled, and it took nothing more", clock.now
    if not whole.startswith(bytes(recorded)) or (outcome == "completed" and recorded != whole):
        return "LOST", clock.now
    return outcome, clock.now


def ends_well(made: Language, got: bytes) -> bool:
    """Whether what a cancelled job left decodes, so that its last command is whole."""
    if not got:
        return True
    try:
        made.decode(got)
    except ProtocolError:
        return False
    return True


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    profile = load("generic-1bit")
    made = [(name_of(n, o), language(n, **o)) for n, o in VARIANTS]
    counts: Counter[str] = Counter()
    latest = 0.0
    for number in range(options.count):
        name, chosen = made[number % len(made)]
        outcome, when = one(rng, chosen, profile)
        counts[outcome] += 1
        latest = max(latest, when)
        if outcome == "LOST":
            print(f"script {number}, {name}: a byte was lost, doubled or miscounted", flush=True)
    print(f"{options.count:,} scripts: " + ", ".join(f"{n:,} {k}" for k, n in counts.most_common()))
    print(f"bytes lost or sent twice: in {counts['LOST']} scripts; the last ended after {latest:.0f} s")
    sys.exit(1 if counts["LOST"] else 0)


if __name__ == "__main__":
    main()
