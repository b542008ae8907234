"""How fast paper is simulated, and what memory it takes: a receipt of 2 m, its dots drawn 8 × 8.

``python -m tests.bench.paper [--md]``. The receipt is a photograph in Floyd–Steinberg's dots, 576 wide,
again and again to 16,000 rows, in bands of 64. Every line is a process of its own, whose peak of
resident memory is that of all of it: Python, NumPy, the halftoning, and what is measured.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator

import numpy as np

import halftone
from devices.paper import Paper
from halftone.cli.demo import PHOTOGRAPH
from halftone.frame import Bands
from halftone.tone.dotgain import DotModel

WIDTH, ROWS, BAND, SCALE = 576, 16_000, 64, 8
MEASURED = ((0.0, 0.05), (0.5, 0.35), (1.0, 0.85))
DOT = DotModel(1.5, 1.4)


def receipt() -> Bands:
    """The photograph, one after the other, band by band."""
    photograph = halftone.convert(PHOTOGRAPH, width=WIDTH)

    def bands() -> Iterator[np.ndarray]:
        for top in range(0, ROWS, BAND):
            rows = np.arange(top, min(top + BAND, ROWS)) % photograph.shape[0]
            yield photograph.indices[rows]

    return Bands((ROWS, WIDTH), bands(), photograph.levels, dpi=(203.2, 203.2))


def counted(parts: Iterable[np.ndarray]) -> int:
    """Samples of all bands, none of which is kept."""
    return sum(part.size for part in parts)


def saved(distance: float | None) -> int:
    Paper(2, DOT).save(os.devnull, receipt(), SCALE, distance)
    return ROWS * WIDTH * SCALE**2


WORK: dict[str, Callable[[], int]] = {
    "seen": lambda: counted(Paper(2, DOT).seen(receipt())),
    "seen, measured": lambda: counted(Paper(2, DOT, MEASURED).seen(receipt())),
    "drawn": lambda: counted(Paper(2, DOT).drawn(receipt(), SCALE)),
    "drawn, measured": lambda: counted(Paper(2, DOT, MEASURED).drawn(receipt(), SCALE)),
    "drawn, as PNG": lambda: saved(None),
    "drawn, as PNG, from 12 inches": lambda: saved(12),
}


def measure(name: str) -> dict[str, object]:
    """One line of the table, in this process."""
    start = time.perf_counter()
    samples = WORK[name]()
    seconds = time.perf_counter() - start
    return {
        "work": name,
        "s": round(seconds, 2),
        "million samples/s": round(samples / seconds / 1e6, 1),
        "peak MB": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--md", action="store_true", help="as a Markdown table")
    parser.add_argument("--only", help="lines whose name begins so")
    parser.add_argument("--one", choices=WORK, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measure(options.one)))
        return
    for place, name in enumerate(n for n in WORK if n.startswith(options.only or "")):
        command = [sys.executable, "-m", "tests.bench.paper", "--one", name]
        line = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
        if options.md and place == 0:
            print("| " + " | ".join(line) + " |\n|" + "---|" * len(line))
        print("| " + " | ".join(map(str, line.values())) + " |" if options.md else line)


if __name__ == "__main__":
    main()
