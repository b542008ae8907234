"""What the figures were measured on."""

from __future__ import annotations

import os
import platform
import sys
import time
from importlib.metadata import version

import numpy as np

__all__ = ["clock", "described"]

TURNS = 20_000_000


def clock() -> float:
    """GHz that a chain of dependent additions runs at: best of five.

    Every turn is an exclusive or and an addition, each of one cycle, that wait for each other and
    that no compiler can shorten.
    """
    from numba import njit

    @njit
    def chain(value: int, flip: int, step: int, turns: int) -> int:
        for _ in range(turns):
            value = (value ^ flip) + step
        return value

    arguments = np.int64(1), np.int64(0x5DEECE66D), np.int64(11)
    chain(*arguments, 1)
    best = float("inf")
    for _ in range(5):
        start = time.perf_counter()
        chain(*arguments, TURNS)
        best = min(best, time.perf_counter() - start)
    return 2 * TURNS / best / 1e9


def described() -> str:
    """Processor, how many this process may use, and the versions of what ours runs on."""
    from llvmlite.binding import llvm_version_info

    name = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo") as file:
            name = next(line.split(":")[1].strip() for line in file if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    return (
        f"{name}, {len(os.sched_getaffinity(0))} processors, {platform.system()}; "
        f"Python {sys.version.split()[0]}, NumPy {version('numpy')}, numba {version('numba')}, "
        f"LLVM {'.'.join(map(str, llvm_version_info))}, halftone-kit {version('halftone-kit')}"
    )
