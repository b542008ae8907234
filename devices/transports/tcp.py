"""``socket://host:9100``: raw printing over TCP (HP's JetDirect, "port 9100", AppSocket)."""

from __future__ import annotations

import errno
import os
import select
import socket
import struct
import threading
import time
from contextlib import suppress
from typing import Any, Self

from devices.errors import DisconnectedError
from devices.transports.base import Uri
from devices.transports.descriptor import CLOSED, PAUSE, DescriptorTransport, queued
from halftone.errors import DeviceNotFoundError, HalftoneError, UsageError

__all__ = ["TcpTransport"]

PORT = 9100
HELD = 1 << 16
"""Bytes asked to be held by the kernel at most: what it holds counts as accepted and is not printed."""
LINGER = 2.0
"""Seconds that close() waits for the printer to close its side."""
KEEPALIVE = {"TCP_KEEPIDLE": 10, "TCP_KEEPINTVL": 5, "TCP_KEEPCNT": 3}
UNANSWERED, SILENT = 4, 10_000
"""Attempts of the kernel in a row, and milliseconds, after which a host counts as gone."""


class TcpTransport(DescriptorTransport):
    """A connection. Option ``waiteof=false``, as in CUPS: do not wait for the printer to close its side.

    A printer without paper stops reading and still acknowledges, for hours if need be; so no
    TCP_USER_TIMEOUT is set, which would end that too, but the kernel's own counts are looked at.
    """

    scheme = "socket"
    reads = True

    def __init__(self, connection: socket.socket, name: str, linger: float = LINGER) -> None:
        super().__init__(connection.fileno(), name)
        self.connection, self.linger = connection, linger

    @classmethod
    def open(cls, uri: Uri, timeout: float = 10.0) -> Self:
        uri.check_query("waiteof")
        waits = uri.query.get("waiteof", "true")
        if waits not in ("true", "false"):
            raise UsageError(f"{uri.text}: waiteof={waits}; allowed: true, false")
        if not uri.host or uri.path not in ("", "/"):
            raise UsageError(
                f"'{uri.text}' is not of the form socket://host:port (port 9100 if left out)"
            )
        port = PORT if uri.port is None else uri.port
        end = time.monotonic() + timeout
        places = _resolve(uri.host, port, timeout)
        for left, place in zip(range(len(places), 0, -1), places, strict=True):
            try:  # a share of the time each: one address may lead nowhere
                connection = _connect(place, max(0.05, (end - time.monotonic()) / left))
            except OSError as error:
                refused = error
                continue
            return cls(connection, f"{uri.host} port {port}", LINGER if waits == "true" else 0.0)
        raise DeviceNotFoundError(_why(refused, uri.host, port, timeout)) from refused

    def flush(self, timeout: float) -> bool:
        end = time.monotonic() + timeout
        while held := queued(self.descriptor):
            self._check()
            if (left := end - time.monotonic()) <= 0:
                self._nothing_taken()
                return False
            time.sleep(min(PAUSE, left))
        self._check()
        return not held

    def close(self) -> None:
        """Say that nothing more comes, and read until the printer has closed its side too.

        Closing with unread answers would reset the connection, and with it what is on its way.
        """
        if self.descriptor < 0:
            return
        self.descriptor = -1
        with self.connection, suppress(OSError):
            if self.failed:
                return
            self.connection.shutdown(socket.SHUT_WR)
            end = time.monotonic() + self.linger
            while (left := end - time.monotonic()) > 0:
                self.connection.settimeout(left)
                if not self.connection.recv(1 << 16):
                    return

    def _put(self, data: memoryview) -> int:
        poll = select.poll()
        poll.register(self.descriptor, getattr(select, "POLLRDHUP", 0))
        if poll.poll(0):  # what is sent now would be thrown away, and the kernel would take it
            self._check()
            raise OSError(errno.EPIPE, CLOSED)
        return os.write(self.descriptor, data)

    def _check(self) -> None:
        code = self.connection.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        if code:
            raise self._lost(OSError(code, os.strerror(code)))

    def _nothing_taken(self) -> None:
        """Has the host gone? Then nobody acknowledges; the kernel itself gives up after 15 minutes."""
        info = b""
        with suppress(OSError, AttributeError):
            info = self.connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, 104)
        if len(info) < 60:
            return
        attempts = info[2] + info[3]  # retransmits, probes (struct tcp_info of linux/tcp.h)
        silent = struct.unpack_from("=I", info, 56)[0]  # last_ack_recv
        if attempts >= UNANSWERED and silent >= SILENT:
            self.failed = True
            raise DisconnectedError(
                f"{self.name} has not answered for {silent / 1000:.0f} s: "
                "is it switched on and connected?"
            )

    def _lost(self, error: OSError) -> HalftoneError:
        if error.errno in (errno.ETIMEDOUT, errno.EHOSTUNREACH, errno.ENETUNREACH):
            self.failed = True
            return DisconnectedError(f"{self.name} no longer answers: is it switched on and connected?")
        return super()._lost(error)


def _resolve(host: str, port: int, timeout: float) -> list[tuple[Any, ...]]:
    """The addresses of *host*. The resolver of the system knows no timeout, so a thread waits for it."""
    found: list[tuple[Any, ...]] = []
    failures: list[OSError] = []

    def ask() -> None:
        try:
            found.extend(socket.getaddrinfo(host, port, type=socket.SOCK_STREAM))
        except (OSError, UnicodeError) as error:
            failures.append(error if isinstance(error, OSError) else OSError(str(error)))

    asking = threading.Thread(target=ask, daemon=True)
    asking.start()
    asking.join(timeout)
    if found:
        return found
    why = failures[0].strerror or failures[0] if failures else f"no answer in {timeout:g} s"
    raise DeviceNotFoundError(
        f"no host is called '{host}' ({why}); check the name, or give the printer's address"
    )


def _connect(place: tuple[Any, ...], timeout: float) -> socket.socket:
    family, kind, protocol, _, address = place
    connection = socket.socket(family, kind, protocol)
    try:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, HELD)
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for option, value in KEEPALIVE.items():
            if hasattr(socket, option):
                connection.setsockopt(socket.IPPROTO_TCP, getattr(socket, option), value)
        connection.settimeout(timeout)
        connection.connect(address)
        connection.setblocking(False)
    except BaseException:
        connection.close()
        raise
    return connection


def _why(error: OSError, host: str, port: int, timeout: float) -> str:
    if isinstance(error, ConnectionRefusedError):
        return (
            f"{host} refuses port {port}: it may be printing for someone else, its raw printing "
            "(port 9100) may be switched off, or it is another host"
        )
    if isinstance(error, TimeoutError):
        return (
            f"{host} port {port} did not answer within {timeout:g} s: is the printer switched on and in "
            "this network, and does no firewall stand between?"
        )
    why = error.strerror or error
    return f"{host} port {port} cannot be reached ({why}): check the address and the network"
