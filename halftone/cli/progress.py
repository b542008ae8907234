"""A progress bar on a terminal, for work that takes more than a second."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from types import TracebackType

__all__ = ["Bar"]

PATIENCE = 1.0
REDRAW = 0.1
WIDTH = 30


class Bar:
    """Progress over several files; silent where stderr is no terminal."""

    def __init__(self, files: int, *, shown: bool = True) -> None:
        self.files = files
        self.shown = shown and sys.stderr.isatty()
        self.shares: dict[str, float] = {}
        self.finished = 0
        self.start = self.last = time.monotonic()
        self.drawn = False
        self.lock = threading.Lock()
        self.stopped = False

    def __enter__(self) -> Bar:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self.drawn:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()

    def stop(self) -> None:
        """End the work on every file at its next band: Ctrl-C reaches the main thread only."""
        self.stopped = True

    def file(self, name: str) -> Callable[[float], None]:
        """What the work on one file calls with its share done."""
        if self.stopped:
            raise KeyboardInterrupt

        def tell(share: float) -> None:
            if self.stopped:
                raise KeyboardInterrupt
            self.shares[name] = share
            if self.shown:
                self._draw(name)

        return tell

    def done(self, name: str) -> None:
        """One file is finished."""
        with self.lock:
            self.shares.pop(name, None)
            self.finished += 1
        if self.shown:
            self._draw(name)

    def _draw(self, name: str) -> None:
        now = time.monotonic()
        if now - self.start < PATIENCE or now - self.last < REDRAW:
            return
        with self.lock:
            self.last = now
            self.drawn = True
            share = min(1.0, (self.finished + sum(self.shares.values())) / self.files)
            full = round(share * WIDTH)
            count = f" {self.finished}/{self.files}" if self.files > 1 else ""
            marks = "█░" if "utf" in (sys.stderr.encoding or "").lower() else "#-"
            bar = marks[0] * full + marks[1] * (WIDTH - full)
            sys.stderr.write(f"\r\x1b[K{bar} {share:4.0%}{count} {name[-40:]}")
            sys.stderr.flush()
