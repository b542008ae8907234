"""Timing side by side: the candidates take turns, so that a drift of the machine hits all alike."""

from __future__ import annotations

import os
import statistics
import subprocess
import time
from collections.abc import Callable

__all__ = ["Seconds", "best_and_median", "compare", "process", "rate"]

Seconds = list[float]


def compare(
    work: dict[str, Callable[[], object]], runs: int = 9, budget: float = float("inf")
) -> dict[str, Seconds]:
    """Seconds of each run of each candidate, in turns, after one run that is not counted.

    budget : a candidate that has taken so many seconds in three runs or more sits out the rest.
    """
    times: dict[str, Seconds] = {name: [] for name in work}
    for turn in range(runs + 1):
        for name, call in work.items():
            if len(times[name]) >= 3 and sum(times[name]) > budget:
                continue
            start = time.perf_counter()
            call()
            if turn:
                times[name].append(time.perf_counter() - start)
    return times


def process(*command: str, **environment: str) -> Callable[[], object]:
    """A whole process, from start to exit."""
    # A user's installation has its bytecode compiled.
    inherited = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}

    def call() -> None:
        done = subprocess.run(
            command, capture_output=True, text=True, check=False, env=inherited | environment
        )
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}: exit code {done.returncode}\n{done.stderr}")

    return call


def best_and_median(times: Seconds) -> tuple[float, float]:
    return min(times), statistics.median(times)


def rate(times: Seconds, pixels: int) -> str:
    """Megapixels a second, best / median."""
    best, median = best_and_median(times)
    return f"{pixels / best / 1e6:,.0f} / {pixels / median / 1e6:,.0f}"
