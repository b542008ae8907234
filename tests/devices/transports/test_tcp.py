"""socket://: nothing lost, nothing twice, and a name for every failure."""

from __future__ import annotations

import ctypes
import socket
import struct
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from devices.errors import DisconnectedError
from devices.transports import open_transport, tcp
from devices.transports.base import Transport, Uri
from devices.transports.tcp import TcpTransport
from halftone.errors import DeviceNotFoundError, UsageError

DATA = bytes(range(256)) * 4096
SOON, LATE = 0.05, 20.0
SO_ATTACH_FILTER = 26


@contextmanager
def printer(act: Callable[[socket.socket], None], room: int = 0) -> Iterator[str]:
    """A URI behind which *act* does what it likes with the connection."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        if room:
            server.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, room)

        def serve() -> None:
            connection, _ = server.accept()
            with connection:
                act(connection)

        thread = threading.Thread(target=serve)
        thread.start()
        yield f"socket://127.0.0.1:{server.getsockname()[1]}"
        thread.join()


def give(transport: Transport, data: bytes, timeout: float = LATE) -> int:
    """All of *data*, or as much as is taken before a write takes nothing; how much."""
    done = 0
    while done < len(data):
        taken = transport.write(memoryview(data)[done : done + transport.chunk], timeout)
        if not taken:
            break
        done += taken
    return done


def keep_giving(transport: Transport) -> None:
    for _ in range(200):
        give(transport, DATA, 0.1)


def everything(connection: socket.socket) -> bytes:
    got = bytearray()
    while piece := connection.recv(1 << 16):
        got += piece
    return bytes(got)


def test_all_bytes_arrive_once() -> None:
    got: list[bytes] = []
    with (
        printer(lambda c: got.append(everything(c))) as uri,
        open_transport(Uri.parse(uri)) as transport,
    ):
        assert give(transport, DATA) == len(DATA)
        assert transport.flush(LATE)
    assert got == [DATA]


def test_a_reader_that_stops_and_goes_on() -> None:
    go, got = threading.Event(), list[bytes]()

    def act(connection: socket.socket) -> None:
        go.wait()
        got.append(everything(connection))

    with printer(act, 4096) as uri, open_transport(Uri.parse(uri)) as transport:
        done = give(transport, DATA, SOON)
        assert 0 < done < len(DATA)
        start = time.monotonic()
        assert transport.write(memoryview(DATA)[done:], SOON) == 0
        assert time.monotonic() - start >= SOON
        assert not transport.flush(SOON)
        go.set()
        assert give(transport, DATA[done:]) == len(DATA) - done
        assert transport.flush(LATE)
    assert got == [DATA]


def test_little_is_held_where_nobody_reads() -> None:
    """What the kernel holds counts as accepted, so it must not be megabytes."""
    go = threading.Event()

    def act(connection: socket.socket) -> None:
        go.wait()
        everything(connection)

    with printer(act, 4096) as uri, open_transport(Uri.parse(uri)) as transport:
        assert give(transport, DATA, SOON) < 1 << 19
        go.set()


def test_answers_are_read() -> None:
    def act(connection: socket.socket) -> None:
        connection.sendall(b"\x12")
        everything(connection)

    with printer(act) as uri, open_transport(Uri.parse(uri)) as transport:
        assert transport.read(16, LATE) == b"\x12"
        assert transport.read(16, SOON) == b""
        assert transport.read(16, 0) == b""


def test_unread_answers_lose_no_byte_at_close() -> None:
    """To close with unread input would reset the connection, and drop what is on its way."""
    got, answered = list[bytes](), threading.Event()

    def act(connection: socket.socket) -> None:
        connection.sendall(b"status" * 100)
        answered.set()
        time.sleep(SOON)
        connection.sendall(b"more")
        got.append(everything(connection))

    with printer(act, 4096) as uri:
        transport = open_transport(Uri.parse(uri))
        assert answered.wait(LATE)
        done = give(transport, DATA[:60_000])
        transport.close()
        transport.close()
    assert got == [DATA[:done]]


def test_close_waits_for_the_printer_to_close_first() -> None:
    seen = list[bytes]()

    def act(connection: socket.socket) -> None:
        everything(connection)
        time.sleep(SOON)
        connection.sendall(b"late")  # a reset would be an error here, or in the next line
        seen.append(connection.recv(1))

    with printer(act) as uri:
        open_transport(Uri.parse(uri)).close()
    assert seen == [b""]


def test_without_waiteof_it_does_not_wait() -> None:
    go = threading.Event()
    with printer(lambda c: (go.wait(), None)[1]) as uri:
        transport = TcpTransport.open(Uri.parse(uri + "?waiteof=false"))
        assert transport.linger == 0
        transport.close()  # would hang for its time: the printer waits for go
        go.set()


def reset(connection: socket.socket) -> None:
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))


@pytest.mark.parametrize("how", [reset, lambda connection: None], ids=["reset", "closed"])
def test_a_printer_that_goes_away(how: Callable[[socket.socket], None]) -> None:
    def act(connection: socket.socket) -> None:
        connection.recv(1000, socket.MSG_WAITALL)
        how(connection)

    with printer(act) as uri, open_transport(Uri.parse(uri)) as transport:
        with pytest.raises(DisconnectedError, match="127.0.0.1"):
            give(transport, DATA * 100)
        transport.close()


def test_nothing_is_taken_once_the_printer_has_closed() -> None:
    """The kernel would take it, and throw it away; the count of accepted bytes would be wrong."""
    with printer(lambda c: None) as uri:
        transport = open_transport(Uri.parse(uri))
        with pytest.raises(DisconnectedError, match="closed"):
            transport.read(1, LATE)
        with pytest.raises(DisconnectedError):
            transport.write(memoryview(b"abc"), LATE)
        transport.close()


def test_flush_hears_of_a_reset() -> None:
    go = threading.Event()

    def act(connection: socket.socket) -> None:
        go.wait()
        reset(connection)

    with printer(act, 4096) as uri, open_transport(Uri.parse(uri)) as transport:
        give(transport, DATA, SOON)
        go.set()
        with pytest.raises(DisconnectedError):
            transport.flush(LATE)


def test_refused() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    with pytest.raises(DeviceNotFoundError, match=f"refuses port {port}.*raw printing"):
        open_transport(Uri.parse(f"socket://127.0.0.1:{port}"))


def test_no_answer_in_time() -> None:
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen(0)
        filler = [socket.socket() for _ in range(4)]
        for one in filler:  # a full queue of a server that accepts nobody: further attempts hear nothing
            one.setblocking(False)
            one.connect_ex(server.getsockname())
        with pytest.raises(DeviceNotFoundError, match="did not answer within"):
            open_transport(Uri.parse(f"socket://127.0.0.1:{server.getsockname()[1]}"), 0.2)
        for one in filler:
            one.close()


def test_unknown_host() -> None:
    with pytest.raises(DeviceNotFoundError, match=r"no host is called 'printer\.invalid'"):
        open_transport(Uri.parse("socket://printer.invalid"), 5)


def test_a_resolver_that_hangs(monkeypatch: pytest.MonkeyPatch) -> None:
    go = threading.Event()
    monkeypatch.setattr(socket, "getaddrinfo", lambda *a, **k: [go.wait()][:0])
    with pytest.raises(DeviceNotFoundError, match="no answer in"):
        open_transport(Uri.parse("socket://printer.example"), SOON)
    go.set()


def test_the_second_address_is_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.create_server(("127.0.0.1", 0)) as closed:
        dead = closed.getsockname()
    got = list[bytes]()
    with printer(lambda c: got.append(everything(c))) as uri:
        port = Uri.parse(uri).port
        kind = (socket.AF_INET, socket.SOCK_STREAM, 6, "")
        monkeypatch.setattr(
            socket, "getaddrinfo", lambda *a, **k: [(*kind, dead), (*kind, ("127.0.0.1", port))]
        )
        with open_transport(Uri.parse(f"socket://two.example:{port}")) as transport:
            give(transport, b"x")
    assert got == [b"x"]


def vanish(connection: socket.socket) -> None:
    """Nothing reaches it any more, and nothing is acknowledged: a filter that keeps 0 bytes of all."""
    program = struct.pack("=HBBI", 0x06, 0, 0, 0)  # BPF_RET
    held = ctypes.create_string_buffer(program)
    pointer = struct.pack("@HP", 1, ctypes.addressof(held))  # struct sock_fprog
    connection.setsockopt(socket.SOL_SOCKET, SO_ATTACH_FILTER, pointer)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="socket filters are Linux's")
def test_a_host_that_vanishes_is_noticed_and_one_that_waits_is_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(tcp, "UNANSWERED", 2)
    monkeypatch.setattr(tcp, "SILENT", 300)
    full, gone, end = threading.Event(), threading.Event(), threading.Event()

    def act(connection: socket.socket) -> None:
        full.wait()
        connection.recv(1 << 20, socket.MSG_WAITALL)
        vanish(connection)
        gone.set()
        end.wait()
        reset(connection)

    with printer(act, 4096) as uri:
        transport = open_transport(Uri.parse(uri))
        done = give(transport, DATA, SOON)
        for _ in range(10):  # without paper it acknowledges, and is waited for
            assert transport.write(memoryview(DATA), 0.1) == 0
        full.set()
        give(transport, DATA[: (1 << 20) - done])
        assert gone.wait(LATE)
        with pytest.raises(DisconnectedError, match="has not answered for"):
            keep_giving(transport)
        transport.close()
        end.set()


@pytest.mark.parametrize(
    ("retransmits", "probes", "silent", "gone"),
    [(0, 0, 60_000, False), (4, 0, 12_000, True), (0, 4, 12_000, True), (9, 0, 9_000, False)],
)
def test_a_host_that_vanished(
    monkeypatch: pytest.MonkeyPatch, retransmits: int, probes: int, silent: int, gone: bool
) -> None:
    """Without paper a printer acknowledges, and is waited for; one that is switched off does not."""
    info = struct.pack("=8B12I48x", 1, 0, retransmits, probes, *4 * [0], *12 * [0])
    info = info[:56] + struct.pack("=I", silent) + info[60:]

    class Connection(socket.socket):
        def getsockopt(self, level: int, name: int, size: int = 0) -> int | bytes:  # type: ignore[override]
            return info if size else super().getsockopt(level, name)

    ours, theirs = socket.socketpair()
    with theirs, Connection(fileno=ours.detach()) as connection:
        connection.setblocking(False)
        transport = TcpTransport(connection, "far", 0)
        if gone:
            with pytest.raises(DisconnectedError, match="far has not answered for 12 s"):
                give(transport, DATA, 0)
        else:
            assert 0 < give(transport, DATA, 0) < len(DATA)
        transport.close()


@pytest.mark.parametrize("text", ["socket://", "socket://h/queue", "socket:h", "socket://h?baud=1"])
def test_uris_that_are_refused(text: str) -> None:
    with pytest.raises(UsageError):
        open_transport(Uri.parse(text))


def test_waiteof_is_checked() -> None:
    with pytest.raises(UsageError, match="allowed: true, false"):
        open_transport(Uri.parse("socket://h?waiteof=maybe"))
