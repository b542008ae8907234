"""The terminal, and what stands around a command."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

__all__ = ["our_devices", "quiet_libraries"]


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
