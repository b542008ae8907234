"""file: to regular files, pipes, stdout and device nodes."""

from __future__ import annotations

import errno
import os
import stat
import struct
import subprocess
import sys
import threading
from pathlib import Path
from types import SimpleNamespace

import pytest

from devices.errors import (
    DeviceBusyError,
    DevicePermissionError,
    DeviceStateError,
    DisconnectedError,
    StalledError,
)
from devices.status import Status
from devices.transports import character, open_transport
from devices.transports.base import Uri
from devices.transports.character import CharacterDevice, open_node
from devices.transports.file import FileTransport, RegularFile
from halftone.errors import DeviceNotFoundError, OutputError, UsageError

DATA = bytes(range(256)) * 1024
SOON, LATE = 0.05, 20.0


def opened(path: object, timeout: float = LATE) -> FileTransport:
    transport = open_transport(Uri.parse(f"file:{path}"), timeout)
    assert isinstance(transport, FileTransport)
    return transport


def give(transport: FileTransport, data: bytes, timeout: float = LATE) -> int:
    done = 0
    while done < len(data):
        taken = transport.write(memoryview(data)[done : done + transport.chunk], timeout)
        if not taken:
            break
        done += taken
    return done


class TestRegularFiles:
    def test_gets_its_name_when_it_is_whole(self, tmp_path: Path) -> None:
        target = tmp_path / "out.bin"
        transport = opened(target)
        assert give(transport, DATA) == len(DATA)
        assert transport.flush(0)
        assert not target.exists()
        transport.close()
        transport.close()
        assert target.read_bytes() == DATA
        assert [each.name for each in tmp_path.iterdir()] == ["out.bin"]

    def test_a_relative_name(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(tmp_path)
        with opened("out.bin") as transport:
            give(transport, b"abc")
            transport.flush(0)
        assert Path("out.bin").read_bytes() == b"abc"

    def test_half_a_job_is_no_file(self, tmp_path: Path) -> None:
        (tmp_path / "out.bin").write_bytes(b"before")
        transport = opened(tmp_path / "out.bin")
        give(transport, b"one job")
        transport.flush(0)
        give(transport, b"half of the next")
        transport.close()
        assert (tmp_path / "out.bin").read_bytes() == b"before"
        assert len(list(tmp_path.iterdir())) == 1

    def test_an_error_in_the_with_block(self, tmp_path: Path) -> None:
        def half(transport: FileTransport) -> None:
            give(transport, b"abc")
            transport.flush(0)
            raise RuntimeError

        with pytest.raises(RuntimeError), opened(tmp_path / "out.bin") as transport:
            half(transport)
        assert not list(tmp_path.iterdir())

    def test_a_broken_off_job_is_not_kept_though_it_is_completed(self, tmp_path: Path) -> None:
        with opened(tmp_path / "out.bin") as transport:
            give(transport, b"abc")
            assert isinstance(transport, RegularFile)
            transport.spoil()
            give(transport, b"what completes it")
            transport.flush(0)
        assert not list(tmp_path.iterdir())

    def test_a_full_disk(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        transport = opened(tmp_path / "out.bin")
        assert isinstance(transport, RegularFile)

        def full(data: object) -> None:
            raise OutputError("'out.bin' cannot be written: No space left on device")

        with monkeypatch.context() as patch:
            patch.setattr(transport._file, "write", full)
            with pytest.raises(OutputError, match="No space left"):
                give(transport, b"abc")
        assert give(transport, b"what completes it") == 17
        transport.flush(0)
        transport.close()
        assert not list(tmp_path.iterdir())

    def test_a_folder_that_is_not_there(self, tmp_path: Path) -> None:
        with pytest.raises(OutputError, match="cannot be written"):
            opened(tmp_path / "no" / "out.bin")


class TestPipes:
    def test_all_bytes_arrive_once_though_the_reader_stops(self, tmp_path: Path) -> None:
        os.mkfifo(tmp_path / "pipe")
        reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
        with opened(tmp_path / "pipe") as transport:
            done = give(transport, DATA, SOON)
            assert 0 < done < len(DATA)
            got = bytearray()

            def read() -> None:
                os.set_blocking(reader, True)
                while piece := os.read(reader, 1 << 16):
                    got.extend(piece)

            thread = threading.Thread(target=read)
            thread.start()
            assert give(transport, DATA[done:]) == len(DATA) - done
        thread.join()
        assert bytes(got) == DATA
        os.close(reader)

    def test_a_reader_that_goes_away(self, tmp_path: Path) -> None:
        os.mkfifo(tmp_path / "pipe")
        reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
        with opened(tmp_path / "pipe") as transport:
            os.close(reader)
            with pytest.raises(DisconnectedError):
                give(transport, b"abc")

    def test_nobody_reads(self, tmp_path: Path) -> None:
        os.mkfifo(tmp_path / "pipe")
        with pytest.raises(DeviceNotFoundError, match="nobody reads the pipe"):
            opened(tmp_path / "pipe", SOON)


SCRIPT = """
import sys
from devices.transports import open_transport
from devices.transports.base import Uri
from halftone.errors import HalftoneError
print("before")
try:
    with open_transport(Uri.parse("file:-")) as out:
        data = memoryview(bytes(range(256)) * 1024)
        while data:
            data = data[out.write(data, 20):]
except HalftoneError as error:
    print(type(error).__name__, file=sys.stderr)
"""


class TestStdout:
    def run(self, **options: object) -> subprocess.CompletedProcess[bytes]:
        return subprocess.run(
            [sys.executable, "-c", SCRIPT],
            stderr=subprocess.PIPE,
            timeout=60,
            check=False,
            **options,  # type: ignore[call-overload]
        )

    def test_into_a_pipe(self) -> None:
        done = self.run(stdout=subprocess.PIPE)
        assert done.stdout == b"before\n" + DATA
        assert done.stderr == b""

    def test_into_a_file(self, tmp_path: Path) -> None:
        with (tmp_path / "out").open("wb") as file:
            self.run(stdout=file)
        assert (tmp_path / "out").read_bytes() == b"before\n" + DATA

    def test_a_full_disk(self) -> None:
        with Path("/dev/full").open("wb") as full:
            script = SCRIPT.replace('print("before")', "")
            done = subprocess.run(
                [sys.executable, "-c", script],
                stdout=full,
                stderr=subprocess.PIPE,
                timeout=60,
                check=False,
            )
        assert done.stderr == b"OutputError\n"

    def test_nobody_reads(self) -> None:
        reader, writer = os.pipe()
        os.close(reader)
        script = SCRIPT.replace('print("before")', "")
        done = subprocess.run(
            [sys.executable, "-c", script],
            stdout=writer,
            stderr=subprocess.PIPE,
            timeout=60,
            check=False,
        )
        os.close(writer)
        assert done.stderr == b"DisconnectedError\n"

    def test_a_terminal_is_refused(self) -> None:
        main, terminal = os.openpty()
        done = self.run(stdout=terminal)
        os.close(terminal)
        os.close(main)
        assert done.stderr == b"UsageError\n"


class TestDeviceNodes:
    def test_null_takes_all(self) -> None:
        with opened("/dev/null") as transport:
            assert give(transport, DATA) == len(DATA)
            assert transport.read(10, SOON) == b""
            assert transport.port_status() is None
            assert transport.flush(LATE)

    def test_full_says_so(self) -> None:
        with opened("/dev/full") as transport, pytest.raises(OutputError, match="No space left"):
            give(transport, b"abc")

    def test_a_terminal_would_change_bytes(self) -> None:
        main, terminal = os.openpty()
        with pytest.raises(UsageError, match="use serial:"):
            opened(os.ttyname(terminal))
        os.close(main)
        os.close(terminal)

    def test_a_node_that_is_not_there_does_not_become_a_file(self) -> None:
        with pytest.raises(DeviceNotFoundError, match="there is no /dev/usb/lp97"):
            opened("/dev/usb/lp97")
        assert not Path("/dev/usb/lp97").exists()

    def test_a_folder(self, tmp_path: Path) -> None:
        with pytest.raises(UsageError, match="neither a character device"):
            opened(tmp_path)

    @pytest.mark.parametrize(
        ("code", "kind", "says"),
        [
            (errno.EBUSY, DeviceBusyError, "doctor"),
            (errno.ENODEV, DeviceNotFoundError, "switched on"),
            (errno.ENXIO, DeviceNotFoundError, "switched on"),
            (errno.EACCES, DevicePermissionError, "usermod -aG"),
        ],
    )
    def test_what_open_refuses(
        self, monkeypatch: pytest.MonkeyPatch, code: int, kind: type[Exception], says: str
    ) -> None:
        def refuse(path: str, flags: int) -> int:
            raise OSError(code, os.strerror(code))

        monkeypatch.setattr(os, "open", refuse)
        with pytest.raises(kind, match=says) as caught:
            open_node("/dev/null")
        assert type(caught.value) is kind

    def test_permission_only_to_write(self, monkeypatch: pytest.MonkeyPatch) -> None:
        really = os.open

        def refuse(path: str, flags: int) -> int:
            if flags & os.O_RDWR:
                raise PermissionError(errno.EACCES, "no")
            return really(path, flags)

        monkeypatch.setattr(os, "open", refuse)
        with opened("/dev/null") as transport:
            assert not transport.reads
            assert give(transport, b"abc") == 3

    @pytest.mark.parametrize(
        ("code", "there", "kind"),
        [
            (errno.EIO, True, StalledError),
            (errno.EIO, False, DisconnectedError),
            (errno.ENODEV, True, DisconnectedError),
            (errno.ENOSPC, True, DeviceStateError),
        ],
    )
    def test_what_usblp_refuses(
        self, monkeypatch: pytest.MonkeyPatch, code: int, there: bool, kind: type[Exception]
    ) -> None:
        transport = opened("/dev/null")
        assert isinstance(transport, CharacterDevice)
        transport.printer = True
        if not there:
            transport.name = "/dev/usb/lp97"
        monkeypatch.setattr(character, "DEPARTURE", SOON)

        def refuse(descriptor: int, data: object) -> int:
            raise OSError(code, os.strerror(code))

        monkeypatch.setattr(os, "write", refuse)
        with pytest.raises(kind):
            give(transport, b"abc")
        transport.close()

    def test_status_by_ioctl(self, monkeypatch: pytest.MonkeyPatch) -> None:
        def answer(descriptor: int, request: int, held: bytearray) -> int:
            assert request == character.LPGETSTATUS
            held[:] = struct.pack("i", 0x38)
            return 0

        monkeypatch.setattr(character, "fcntl", SimpleNamespace(ioctl=answer))
        with opened("/dev/null") as transport:
            assert transport.port_status() == Status.of("media-empty-error")


@pytest.mark.parametrize(
    ("bits", "says"),
    [
        (0x18, set()),
        (0x30, {"media-empty-error"}),
        (0x38, {"media-empty-error"}),
        (0x10, {"other-error"}),
        (0x08, {"offline-error"}),
        (0x28, {"media-empty-error", "offline-error"}),
        (0x00, None),
        (0xFF, None),
        (0x98, set()),
    ],
)
def test_port_reasons(bits: int, says: set[str] | None) -> None:
    status = Status.of_port(bits)
    assert (None if status is None else set(status.reasons)) == says


@pytest.mark.parametrize("text", ["file:", "file://host/path", "file:/dev/null?baud=1"])
def test_uris_that_are_refused(text: str) -> None:
    with pytest.raises(UsageError):
        open_transport(Uri.parse(text))


def test_devfull_is_a_character_device_here() -> None:
    """The tests above rest on it."""
    assert stat.S_ISCHR(Path("/dev/full").stat().st_mode)
