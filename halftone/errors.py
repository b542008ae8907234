"""The error tree. Every message says what, got, allowed, and how to mend it.

::

    HalftoneError                 exit 1   anything of ours; catch this one
    ├── UsageError (ValueError)   exit 2   an unknown method, an option that does not apply
    ├── InputError (ValueError)   exit 3   a picture or an array that cannot be used
    │   └── InputFileError        exit 3   … that came from a file: missing, damaged, too large
    ├── OutputError (OSError)     exit 1   a file that cannot be written
    ├── DeviceNotFoundError       exit 4   no such device, or not permitted
    ├── DeviceFaultError          exit 5   the device reports a fault
    └── ThresholdError            exit 6   ``measure --fail-above`` exceeded

``KeyboardInterrupt`` leaves the command with 130.
"""

from __future__ import annotations

from collections.abc import Iterable

__all__ = [
    "DeviceFaultError",
    "DeviceNotFoundError",
    "HalftoneError",
    "InputError",
    "InputFileError",
    "OutputError",
    "ThresholdError",
    "UsageError",
    "near",
]


class HalftoneError(Exception):
    """Base of all errors raised on purpose."""

    exit_code = 1


class UsageError(HalftoneError, ValueError):
    """A name, an option or a value that is not allowed."""

    exit_code = 2


class InputError(HalftoneError, ValueError):
    """A picture that cannot be used: no pixels, NaN, a wrong shape or type."""

    exit_code = 3


class InputFileError(InputError):
    """A file that cannot be used: missing, damaged, or too large for the stated limit."""


class OutputError(HalftoneError, OSError):
    """A file or stream that cannot be written."""

    exit_code = 1


class DeviceNotFoundError(HalftoneError):
    """No such device, or no permission to use it."""

    exit_code = 4


class DeviceFaultError(HalftoneError):
    """The device reports a fault."""

    exit_code = 5


class ThresholdError(HalftoneError):
    """A measured error is above the threshold that was asked for."""

    exit_code = 6


def near(got: str, allowed: Iterable[str], what: str) -> str:
    """One line for an unknown name: what, got, the near matches, all that is allowed."""
    import difflib

    names = sorted(allowed)
    close = difflib.get_close_matches(got, names, n=3, cutoff=0.5)
    hint = f" Did you mean {' or '.join(close)}?" if close else ""
    return f"unknown {what} '{got}'.{hint} Allowed: {', '.join(names)}"
