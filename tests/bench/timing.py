"""Timing side by side: the candidates take turns, so that a drift of the machine hits all alike."""

from __future__ import annotations

import os
import platform
import statistics
import subprocess
import sys
import time
from collections.abc import Callable

__all__ = ["compare", "machine", "process"]


def compare(work: dict[str, Callable[[], object]], runs: int = 9) -> dict[str, list[float]]:
    """Seconds of each run of each candidate, in turns, after one run that is not counted."""
    times: dict[str, list[float]] = {name: [] for name in work}
    for turn in range(runs + 1):
        for name, call in work.items():
            start = time.perf_counter()
            call()
            if turn:
                times[name].append(time.perf_counter() - start)
    return times


def process(*command: str, **environment: str) -> Callable[[], object]:
    """A whole process, from start to exit."""
    # A user's installation has its bytecode compiled.
    inherited = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    return lambda: subprocess.run(
        command, check=True, stdout=subprocess.DEVNULL, env=inherited | environment
    )


def machine() -> str:
    """One line on what this was measured on."""
    name = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo") as file:
            name = next(line.split(":")[1].strip() for line in file if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    start = time.perf_counter()
    total = 0
    for i in range(3_000_000):
        total += i
    loop = time.perf_counter() - start
    return (
        f"{name}, {len(os.sched_getaffinity(0))} processors, Python {sys.version.split()[0]}; "
        f"3 million turns of an empty Python loop: {loop * 1e3:.0f} ms"
    )


def best_and_median(times: list[float]) -> tuple[float, float]:
    return min(times), statistics.median(times)
