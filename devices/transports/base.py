"""What every transport is: a way for bytes to a device, and back where there is one."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from types import TracebackType
from typing import ClassVar, Self
from urllib.parse import parse_qsl, unquote, urlsplit

from devices.status import Status
from halftone.errors import UsageError

__all__ = ["Found", "Transport", "Uri"]


@dataclass(frozen=True)
class Uri:
    """Where a device is, as CUPS writes it: ``socket://192.168.1.9:9100``,
    ``usb://EPSON/TM-T20?serial=SN1``, ``usb://04b8:0202``, ``file:/dev/usb/lp0``,
    ``serial:/dev/ttyS0?baud=115200``, ``mem:``; with a language in front, ``escpos+usb://…``.
    """

    text: str
    scheme: str
    host: str = ""
    port: int | None = None
    path: str = ""
    query: dict[str, str] = field(default_factory=dict)
    language: str | None = None

    @classmethod
    def parse(cls, text: str) -> Uri:
        """Raises UsageError for what is no such URI."""
        scheme, colon, _ = text.partition(":")
        if not colon or not scheme:
            raise UsageError(f"'{text}' is not a device URI; allowed: usb://…, socket://…, file:…, mem:")
        language, plus, scheme = scheme.rpartition("+")
        try:
            parts = urlsplit(text[len(language) + len(plus) :])
            port = None if parts.scheme == "usb" else parts.port  # usb://04b8:0202 is vendor:product
            asked = parts.query.replace("+", "%2B")  # no web form: a plus in a serial number is a plus
            given = parse_qsl(asked, keep_blank_values=True, strict_parsing=bool(asked))
        except ValueError as error:
            raise UsageError(f"device URI '{text}': {error}") from None
        if parts.fragment:
            raise UsageError(f"device URI '{text}': write # as %23")
        host = parts.netloc.rpartition("@")[2]
        if port is not None:
            host = host.rpartition(":")[0]
        query = dict(given)
        return cls(
            text,
            parts.scheme,
            unquote(host.strip("[]")),
            port,
            unquote(parts.path),
            query,
            language or None,
        )

    def number(self, key: str, default: float, least: float, most: float) -> float:
        """The number called *key* in the query."""
        if key not in self.query:
            return default
        try:
            value = float(self.query[key])
        except ValueError:
            value = float("nan")
        if not least <= value <= most:
            raise UsageError(f"{self.text}: {key}={self.query[key]}; allowed: {least:g} … {most:g}")
        return value

    def check_query(self, *allowed: str) -> None:
        """Refuse keys that the transport does not know: an option is never ignored."""
        for key in self.query:
            if key not in allowed:
                names = ", ".join(allowed) or "none"
                raise UsageError(f"{self.text}: unknown option '{key}'; allowed: {names}")


@dataclass(frozen=True)
class Found:
    """A device that is there. uri : what opens it. title : make and model, as far as it says.
    languages : what it says it understands (``CMD:`` of its IEEE 1284 device ID).
    problem : why it cannot be opened, and what to do; empty if it can.
    """

    uri: str
    title: str
    languages: tuple[str, ...] = ()
    problem: str = ""


class Transport(ABC):
    """An open way to a device. It moves bytes and knows nothing of what they mean.

    After an exception nothing may be written any more.
    """

    scheme: ClassVar[str]
    reads: bool = False
    """Whether the device can answer."""
    chunk: int = 1 << 16
    """Bytes worth handing over in one call."""

    @classmethod
    @abstractmethod
    def open(cls, uri: Uri, timeout: float = 10.0) -> Self:
        """Open it within *timeout* seconds.

        Raises UsageError for an option it does not know, DeviceNotFoundError and its kin
        (:mod:`devices.errors`) if there is no such device, or it is not permitted, or held.
        """

    @abstractmethod
    def write(self, data: memoryview, timeout: float) -> int:
        """Hand over *data*; the number of bytes that were taken, often fewer than given.

        0 says that none were taken within *timeout* seconds, and is returned only after that time.
        Bytes that were taken are never handed over twice. Raises DisconnectedError or StalledError.
        """

    def read(self, size: int, timeout: float) -> bytes:
        """Up to *size* bytes that came from the device; empty if none came within *timeout* seconds.

        Raises DisconnectedError.
        """
        return b""

    def port_status(self) -> Status | None:
        """What the port itself says (USB printer class), or None where it says nothing."""
        return None

    def flush(self, timeout: float) -> bool:
        """Wait until what was taken has left this machine; whether it has within *timeout* seconds."""
        return True

    def spoil(self) -> None:  # noqa: B027 (most have nothing to do)
        """What was written is no whole job: a file is not kept."""

    @abstractmethod
    def close(self) -> None:
        """Give the device back as it was found. A second call does nothing."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
