"""Bands of rows over a thread pool. The result never depends on the number of workers."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator

from halftone._arrays import whole

__all__ = ["bands", "count_workers", "for_each_band"]

Progress = Callable[[float], None]


def count_workers(workers: int) -> int:
    """*workers*, with 0 for one per processor this process may use."""
    return whole("workers", workers, 0, 1 << 16) or len(os.sched_getaffinity(0))


def bands(height: int, rows: int) -> Iterator[tuple[int, int]]:
    """(start, stop) of consecutive bands of *rows* rows that cover *height* rows."""
    for start in range(0, height, rows):
        yield start, min(start + rows, height)


def for_each_band(
    work: Callable[[int, int], None],
    height: int,
    rows: int,
    workers: int = 1,
    progress: Progress | None = None,
) -> None:
    """Run work(start, stop) for every band: in order with one worker, in any order with more.

    *progress* is told the share of rows done, 0 … 1, from the calling thread. An exception or
    Ctrl-C ends the run after the bands under way.
    """
    if workers == 1 or height <= rows:
        for start, stop in bands(height, rows):
            work(start, stop)
            if progress:
                progress(stop / height)
        return
    from concurrent.futures import ThreadPoolExecutor, as_completed

    with ThreadPoolExecutor(workers) as pool:
        futures = {pool.submit(work, a, b): b - a for a, b in bands(height, rows)}
        done = 0
        try:
            for future in as_completed(futures):
                future.result()
                done += futures[future]
                if progress:
                    progress(done / height)
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise
