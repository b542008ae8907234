"""Raster error diffusion by a wavefront: fast, in several threads, with the bytes of the serial loop.

A band's blocks of 32 rows are shared out among the threads in turn. Each block leaves the next what it
sends down, column by column, and one that has caught up with the block above it waits.
"""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halftone._arrays import Source
from halftone._parallel import side_by_side
from halftone.dithering.base import Job
from halftone.dithering.filters import ErrorFilter
from halftone.tone.levels import Levels

__all__ = ["WaveCodes", "WaveLight", "few_rounds"]

LANES, CHUNK, SCANNED = 32, 128, 16
"""As in _wave_kernels, which is not imported before it is needed; a test compares them."""

LINE = 64
"""Bytes of a cache line."""

MOST_ROUNDS = 8
"""Levels that share a bucket with so many others are left to the serial kernel."""

BAND_PIXELS = 1 << 24
"""Of a band of codes in memory: to begin a band costs more than most of its pixels."""
READ_PIXELS = 1 << 21
"""Of a band that is read or made light first."""
MOST_ROWS = 256
"""Of a band that is read from a file, of which a few rows are held."""

YIELDS = 200
PAUSE = 1e-3
"""Seconds of sleep after so many looks at a block above that is far behind."""


class _Wave:
    """Bands of one picture. Each kind says what its kernel works on."""

    parallel = False  # bands come one after the other, and each is shared out among threads

    def __init__(self, job: Job, from_right: bool, skew: int) -> None:
        self.job = job
        self.from_right = from_right
        self.width = job.source.shape[1]
        self.skew = skew
        pitch = self.width + 2 * (CHUNK + skew * LANES)
        # Rows apart by an odd number of cache lines do not fall into the same few places.
        self.pitch = -(-pitch // 512) * 512 + 64 + skew
        self.places = np.arange(LANES) * skew
        self.band_rows = self._suited(job.source)
        self.threads = min(job.workers, -(-min(job.source.shape[0], self.band_rows) // LANES))
        self.slots = self.threads + 2  # blocks at work, the one above them, and one to begin
        self.reach = np.zeros(self.slots, np.int64)
        self.reach[0] = self.width  # above the picture: nothing comes down, at once
        self.state = [np.zeros(2, np.int64) for _ in range(self.threads)]
        self.work = [self._work() for _ in range(self.threads)]
        self.blocks = 0  # above the next band
        self.stopped = False

    def _suited(self, source: Source) -> int:
        """The height of bands: whole blocks, and two at least, for there may be two threads."""
        held = isinstance(source.pixels, np.ndarray)
        pixels = BAND_PIXELS if held and source.codes() is not None else READ_PIXELS
        rows = max(2 * LANES, pixels // self.width // LANES * LANES)
        return rows if held else min(rows, MOST_ROWS)

    def stop(self) -> None:
        """Threads that wait give up."""
        self.stopped = True

    def band(self, start: int, stop: int, out: NDArray[np.uint8]) -> None:
        rows = self._rows(start, stop)
        shown = np.empty_like(out) if self.from_right else out
        given = (rows, shown.reshape(-1), stop - start)
        blocks = -(-(stop - start) // LANES)
        threads = min(self.threads, blocks)
        side_by_side(lambda first: self._blocks(first, threads, *given), threads, self.stop)
        self.blocks += blocks
        if self.from_right:
            out[:] = shown[:, ::-1]

    def _blocks(self, first: int, threads: int, rows: Any, out: NDArray[np.uint8], count: int) -> None:
        """Every *threads*-th block of a band, from the first-th on."""
        state = self.state[first]
        state[:] = first, 0
        waits = 0
        while True:
            self._go(rows, out, count, threads, state, self.work[first])
            if state[0] * LANES >= count:
                return
            if self.stopped:
                raise InterruptedError("the rows above did not come")
            # Of two threads that sleep and wake, the scheduler may leave a processor idle.
            waits += 1
            if waits % YIELDS:
                os.sched_yield()
            else:
                time.sleep(PAUSE)

    def _turned(self, rows: NDArray[Any]) -> NDArray[Any]:
        return np.ascontiguousarray(rows[:, ::-1] if self.from_right else rows)

    def _bytes(self) -> list[NDArray[np.uint8]]:
        """Rows of codes and of indices, and both step by step."""
        sizes = (self.pitch * LANES, self.pitch * LANES, CHUNK * LANES, CHUNK * LANES)
        return _aligned(sizes, np.uint8)

    def _work(self) -> list[NDArray[Any]]:
        raise NotImplementedError

    def _rows(self, start: int, stop: int) -> Any:
        raise NotImplementedError

    def _go(
        self,
        rows: Any,
        out: NDArray[np.uint8],
        count: int,
        threads: int,
        state: NDArray[np.int64],
        work: Sequence[NDArray[Any]],
    ) -> None:
        raise NotImplementedError


class WaveCodes(_Wave):
    """Floyd–Steinberg on linear 8-bit codes, two levels, in integers."""

    def __init__(self, job: Job, from_right: bool) -> None:
        super().__init__(job, from_right, 3)
        room = self.width + 2 * (CHUNK + self.skew * LANES)
        self.history = np.zeros(self.slots * room, np.int16)
        self.places = self.places.astype(np.int16)

    def _work(self) -> list[NDArray[Any]]:
        return _aligned((5 * LANES, CHUNK * LANES), np.int16) + self._bytes()

    def _rows(self, start: int, stop: int) -> Any:
        return self._turned(self.job.source.pixels[start:stop]).reshape(-1)

    def _go(self, rows: Any, out: Any, count: int, threads: int, state: Any, work: Any) -> None:
        from halftone.dithering._wave_kernels import wave_codes

        kept, carries, *rest = work
        wave_codes(
            rows, out, count, self.width, self.job.levels.index, self.blocks, threads,
            self.history, self.reach, state, kept, self.places, carries, *rest,
        )  # fmt: skip


class WaveLight(_Wave):
    """Any error filter and any levels, in float32 light."""

    def __init__(self, job: Job, filter: ErrorFilter, strength: float, from_right: bool) -> None:
        taps = filter.taps
        share = {t[:2]: np.float32(t[2] * strength / filter.divisor) for t in taps}
        self.left = [float(share.pop((0, dx), 0)) for dx in (1, 2)]
        # Rows from the top, taps in table order. Without taps below, one of weight 0.
        below = sorted(share.items(), key=lambda tap: -tap[0][0]) or [((1, 0), np.float32(0))]
        skew = filter.reach + 4
        late = [skew * dy + dx for (dy, dx), _ in below]  # steps since the sender's own
        self.weight = np.array([w for _, w in below], np.float32)
        self.depth = max(1, filter.depth)
        # Each step keeps its errors as they are, then one row further down, then two …
        self.place = np.array(
            [
                (dy - (self.depth + 1) * steps) * LANES
                for steps, ((dy, _), _) in zip(late, below, strict=True)
            ],
            np.int64,
        )
        self.before = max(late)
        super().__init__(job, from_right, skew)
        size = self.width + 2 * (self.before + CHUNK + skew * LANES)
        self.history = np.zeros(self.slots * self.depth * size, np.float32)
        self.places = self.places.astype(np.int32)
        coded = job.source.codes()
        self.codes = None if coded is None or coded[0].dtype != np.uint8 else coded[0]
        levels = job.levels
        distinct = levels.distinct
        self.table = np.zeros(0, np.float32)
        if coded is not None and self.codes is not None:
            self.table = np.clip(coded[1], distinct[0], distinct[-1]).astype(np.float32)
        linear = np.arange(256, dtype=np.float32) / np.float32(255)
        self.white = 255.0 if np.array_equal(self.table, linear) else 0.0
        bucket, scale = levels.buckets()
        middle = levels.middles()
        self.levels = (
            distinct, middle, np.append(middle, np.float32(np.inf)), levels.index,
            bucket.astype(np.int32), levels.index.astype(np.int32), scale,
            _rounds(bucket, distinct.size), _evenly(levels),
        )  # fmt: skip

    def _work(self) -> list[NDArray[Any]]:
        sizes = (2 * LANES, (self.before + CHUNK) * (self.depth + 1) * LANES, CHUNK * LANES)
        return _aligned(sizes, np.float32) + self._bytes()

    def _rows(self, start: int, stop: int) -> Any:
        if self.codes is not None:
            return _NO_LIGHT, self._turned(self.codes[start:stop]).reshape(-1)
        return self._turned(self.job.source.band(start, stop)).reshape(-1), _NO_CODES

    def _go(self, rows: Any, out: Any, count: int, threads: int, state: Any, work: Any) -> None:
        from halftone.dithering._wave_kernels import wave_light

        kept, errors, lit, *rest = work
        wave_light(
            *rows, self.table, self.white, out, count, self.width, *self.levels,
            self.place, self.weight, *self.left, self.skew, self.depth, self.blocks, threads,
            self.history, self.reach, state, kept, self.places, errors, lit, *rest,
        )  # fmt: skip


def _aligned(sizes: Sequence[int], dtype: Any) -> list[NDArray[Any]]:
    """Zeros that start with a cache line: a vector across two lines is slow to come back."""
    item = np.dtype(dtype).itemsize
    starts = np.cumsum([0, *(-(-size * item // LINE) * LINE for size in sizes)]).tolist()
    room = np.zeros(starts[-1] + LINE, np.uint8)
    first = -room.ctypes.data % LINE
    return [
        room[first + start : first + start + size * item].view(dtype)
        for start, size in zip(starts, sizes, strict=False)
    ]


_NO_LIGHT = np.zeros(0, np.float32)
_NO_CODES = np.zeros(0, np.uint8)


def _evenly(levels: Levels) -> float:
    """n − 1 if level k of n has the luminance k/(n − 1) and the index k, else 0."""
    n = levels.distinct.size
    even = np.arange(n, dtype=np.float32) / np.float32(n - 1)
    same = np.array_equal(levels.distinct, even) and np.array_equal(levels.index, np.arange(n))
    return n - 1.0 if same else 0.0


def few_rounds(levels: Levels) -> bool:
    """Whether :class:`WaveLight` takes these levels: no more than a few lie close together."""
    return (
        levels.distinct.size <= SCANNED
        or _rounds(levels.buckets()[0], levels.distinct.size) <= MOST_ROUNDS
    )


def _rounds(bucket: NDArray[np.uint8], count: int) -> int:
    """How often the level that a bucket of :meth:`Levels.buckets` names may have to be raised.

    A bucket's entry is that of one bucket before, and rounding may reach one further: the value lies
    below the middles that the entry of three buckets on has passed.
    """
    upper = np.append(bucket[3:], [count - 1] * 3).astype(np.int64)
    return int((upper - bucket).max())
