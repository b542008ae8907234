"""Bands of rows over a thread pool, and threads that work side by side.

The result never depends on the number of workers.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Generator, Iterator
from typing import TypeVar

from halftone._arrays import whole

__all__ = ["bands", "count_workers", "in_order", "side_by_side"]

T = TypeVar("T")

AHEAD = 2
"""Bands that may be done or wait in line, beside those worked on, until they are taken."""


def count_workers(workers: int) -> int:
    """*workers*, with 0 for one per processor this process may use."""
    return whole("workers", workers, 0, 1 << 16) or len(os.sched_getaffinity(0))


def bands(height: int, rows: int) -> Iterator[tuple[int, int]]:
    """(start, stop) of consecutive bands of *rows* rows that cover *height* rows."""
    for start in range(0, height, rows):
        yield start, min(start + rows, height)


def in_order(
    work: Callable[[int, int], T],
    height: int,
    rows: int,
    workers: int = 0,
    stop: Callable[[], None] = lambda: None,
) -> Generator[T]:
    """work(start, stop) of every band, from the top, as they are asked for.

    workers : threads that work ahead, a few bands at most, each started after the one above it; 0 is
    none: the work is done in the calling thread. If a band raises, or nobody asks for more, *stop* is
    called, which tells bands that wait for another to give up, and the bands under way are waited for.
    """
    if workers == 0 or height <= rows:
        for start, end in bands(height, rows):
            yield work(start, end)
        return
    from concurrent.futures import Future, ThreadPoolExecutor

    with ThreadPoolExecutor(workers) as pool:
        under_way: deque[Future[T]] = deque()
        try:
            for start, end in bands(height, rows):
                under_way.append(pool.submit(work, start, end))
                if len(under_way) == workers + AHEAD:
                    yield under_way.popleft().result()
            while under_way:
                yield under_way.popleft().result()
        except BaseException:  # GeneratorExit, too
            stop()
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def side_by_side(
    work: Callable[[int], None], threads: int, stop: Callable[[], None] = lambda: None
) -> None:
    """Run work(0), …, work(threads − 1) at the same time, the first in the calling thread.

    If one raises, *stop* is called, which must make the others end, and the first error is raised.
    """
    if threads == 1:
        work(0)
        return
    import threading

    failed: list[BaseException] = []
    here = _processor()

    def run(number: int) -> None:
        try:
            _move_from(here, number)
            work(number)
        except BaseException as error:  # raised below, in the thread that called
            failed.append(error)
            stop()

    others: list[threading.Thread] = []
    try:
        for number in range(1, threads):
            other = threading.Thread(target=run, args=(number,))
            other.start()
            others.append(other)
        work(0)
    except BaseException:
        stop()
        raise
    finally:
        for other in others:
            other.join()
    if failed:
        raise failed[0]


def _processor() -> int:
    """The processor that the calling thread runs on, or −1."""
    import ctypes

    return int(getattr(ctypes.CDLL(None), "sched_getcpu", lambda: -1)())


def _move_from(other: int, distance: int) -> None:
    """Bring the calling thread to the processor *distance* places after *other*, and leave it free.

    Threads that live for a few milliseconds, or wait for each other every few microseconds, may be
    left on one processor all that time while another is idle.
    """
    allowed = sorted(os.sched_getaffinity(0))
    if other not in allowed or len(allowed) == 1:
        return
    try:
        os.sched_setaffinity(0, {allowed[(allowed.index(other) + distance) % len(allowed)]})
        os.sched_setaffinity(0, allowed)
    except OSError:  # not permitted: it is a hint only
        return
