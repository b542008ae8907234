"""The terminal, and what stands around a command."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType, ModuleType
from typing import Any, TypeVar

__all__ = ["Flag", "interrupted", "interruptible", "listen", "our_devices", "profile", "quiet_libraries"]

T = TypeVar("T")

PATIENCE = 0.06
"""Seconds that work may take to end by itself after Ctrl-C."""


class Flag:
    """Raised once and for all. A signal's handler may raise it at any moment: an Event's lock may just
    be held by the code that the signal interrupts, or by the same handler of a signal before."""

    def __init__(self) -> None:
        self.raised = False

    def set(self) -> None:
        self.raised = True

    def is_set(self) -> bool:
        return self.raised


_heard = Flag()
_ending = Flag()


def listen() -> None:
    """Remember Ctrl-C: KeyboardInterrupt is lost, or turned into another error, within some imports."""

    def hear(number: int, frame: FrameType | None) -> None:
        _heard.set()
        if not _ending.is_set():  # a second Ctrl-C must not keep what is half done from being taken away
            raise KeyboardInterrupt

    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, hear)


def interrupted() -> bool:
    """Whether Ctrl-C was heard."""
    return _heard.is_set()


def interruptible(work: Callable[[], T], stop: Callable[[], None]) -> T:
    """work(), with Ctrl-C heard at once, be it in the middle of a library's call.

    Python hears of it between two steps of its main thread only, so *work* has a thread of its own.
    *stop* asks it to end at its next band. What it has written so far is taken away; if it goes on,
    it ends with the process.
    """
    done: list[T] = []
    failed: list[BaseException] = []

    def run() -> None:
        try:
            done.append(work())
        except BaseException as error:
            failed.append(error)
        finally:
            ended.set()

    ended = threading.Event()
    try:
        threading.Thread(target=run, daemon=True).start()
        while not ended.wait(PATIENCE / 4):  # the signal may reach another thread, and not wake this
            if interrupted():
                raise KeyboardInterrupt
    except KeyboardInterrupt:
        _ending.set()
        from halftone.images.output import discard_unfinished

        stop()
        ended.wait(PATIENCE)
        discard_unfinished()
        raise
    if failed:
        raise failed[0]
    return done[0]


@contextmanager
def quiet_libraries() -> Iterator[None]:
    """Keep C libraries from printing on stderr: libpng does, beside the error it reports.

    Python's own sys.stderr goes on to the terminal.
    """
    try:
        number = sys.stderr.fileno()
        kept = os.dup(number)
    except (OSError, ValueError, AttributeError):  # no real stderr: nothing to keep quiet
        yield
        return
    ours = os.fdopen(kept, "w", buffering=1, encoding=sys.stderr.encoding, errors="replace")
    shown, sys.stderr = sys.stderr, ours
    shown.flush()
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, number)
    os.close(null)
    try:
        yield
    finally:
        ours.flush()
        os.dup2(kept, number)
        sys.stderr = shown
        ours.close()


def our_devices() -> ModuleType:
    """The module devices.profile of this project; another ``devices`` package is a clear error."""
    from halftone.errors import HalftoneError

    try:
        import devices
    except ImportError as error:
        raise HalftoneError(f"the package 'devices' cannot be imported: {error}") from None
    if not getattr(devices, "__halftone__", False):
        raise HalftoneError(
            f"the package 'devices' at {getattr(devices, '__file__', '?')} is not halftone-kit's; "
            "take it off the Python path, or run halftone in an environment of its own"
        )
    from devices import profile

    return profile


def profile(name: str | None) -> Any:
    """The profile that ``--device`` names, or None."""
    return None if name is None else our_devices().load(name)
