"""``halftone print``, ``decode`` and ``devices`` as whole processes."""

from __future__ import annotations

import json
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Self

import numpy as np
import pytest
from PIL import Image

import halftone
from devices import load
from tests.cli.command import run

LANGUAGES = [
    "escpos",
    "zpl",
    "tspl",
    "epl2",
    "brother-ql",
    "dymo",
    "pcl",
    "pwg",
    "cups-raster",
    "urf",
    "png",
    "pbm",
]


@pytest.fixture(scope="module")
def picture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A ramp, 97 × 64."""
    path = tmp_path_factory.mktemp("picture") / "ramp.png"
    Image.fromarray(np.tile(np.linspace(0, 255, 97), (64, 1)).astype(np.uint8)).save(path)
    return path


def converted(picture: Path, device: str) -> np.ndarray:
    return halftone.convert(picture, profile=load(device)).indices


def same_but_for_moved_dots(got: np.ndarray, wanted: np.ndarray) -> bool:
    """Whether they are the same, with paper to the right; ESC/POS moves a dot in 10,000 by one place,
    where it would say something to the printer."""
    got, more = got[:, : wanted.shape[1]], got[:, wanted.shape[1] :]
    moved = np.count_nonzero(got != wanted)
    return bool(more.all()) and moved <= 0.001 * got.size and got.sum() == wanted.sum()


def shown(path: Path) -> np.ndarray:
    """A bilevel picture as level indices."""
    return np.asarray(Image.open(path).convert("L")) // 255


def test_a_dry_run_shows_what_the_bytes_say(picture, tmp_path):
    result = run("print", picture, "--device", "receipt-80mm", "--dry-run", tmp_path / "out.png")
    assert result.code == 0
    assert "scaled to 576 × 380" in result.err
    assert same_but_for_moved_dots(shown(tmp_path / "out.png"), converted(picture, "receipt-80mm"))


@pytest.mark.parametrize("language", LANGUAGES)
def test_print_dump_and_decode(picture, tmp_path, language):
    """The bytes of a socket, of --dump and of file: are the same; decode finds the language."""
    with Listener() as listener:
        args = ("print", picture, "-d", "brother-ql-29mm", "--no-cut", "-q")
        result = run(
            *args, "--to", f"{language}+socket://127.0.0.1:{listener.port}", "--dump", tmp_path / "a"
        )
        assert (result.code, result.err, result.out) == (0, "", b"")
    assert run(*args, "--to", f"{language}+file:{tmp_path / 'b'}").code == 0
    data = (tmp_path / "a").read_bytes()
    assert data == (tmp_path / "b").read_bytes()
    assert data in listener.data  # around it is what asks for the status
    result = run("decode", tmp_path / "a", tmp_path / "out.png", "--json")
    assert result.code == 0
    said = json.loads(result.out)
    assert said["language"] == language
    assert said["pages"][0]["levels"] == 2
    assert same_but_for_moved_dots(shown(tmp_path / "out.png"), converted(picture, "brother-ql-29mm"))


def test_several_pictures_and_copies(picture, tmp_path):
    args = (
        "print",
        picture,
        picture,
        "-d",
        "receipt-58mm",
        "--dump",
        tmp_path / "x.bin",
        "--copies",
        "2",
    )
    result = run(*args, "--json")
    assert result.code == 0
    said = json.loads(result.out)
    assert (said["pages"], said["pages_accepted"], said["completed"]) == (4, 4, True)
    assert said["rows_accepted"] == said["rows"] == 4 * 253
    assert said["bytes_accepted"] == (tmp_path / "x.bin").stat().st_size


@pytest.mark.parametrize(
    ("args", "code", "word"),
    [
        ([], 2, "which device"),
        (["-d", "receipt-80mm"], 2, "where to"),
        (["-d", "receipt-80mm", "--to", "file:x", "--dry-run", "x.png"], 2, "goes nowhere"),
        (["-d", "receipt-80mm", "--dry-run", "x.xyz"], 2, "xyz"),
        (["-d", "receipt-80mm", "--to", "mem"], 2, "device URI"),
        (["-d", "receipt-80mm", "--to", "sockt://h"], 2, "Did you mean socket"),
        (["-d", "receipt-80mm", "--to", "escpo+mem:"], 2, "Did you mean escpos"),
        (["-d", "receipt-80mm", "--to", "mem:?speed=3"], 2, "speed"),
        (["-d", "receipt-80mm", "--to", "mem:", "-o", "comand=raster"], 2, "Did you mean command"),
        (["-d", "receipt-80mm", "--to", "mem:", "-o", "command=rasta"], 2, "raster"),
        (["-d", "receipt-80mm", "--to", "mem:", "-o", "max_rows=many"], 2, "integer"),
        (["-d", "receipt-80mm", "--to", "mem:", "--density", "99"], 2, "density"),
        (["-d", "label-zpl-203", "--to", "mem:", "--density", "99"], 2, "0 … 30"),
        (["-d", "receipt-80mm", "--to", "mem:", "--copies", "0"], 2, "copies"),
        (["-d", "receipt-80mm", "--to", "mem:", "--width", "577"], 2, "576"),
        (["-d", "epaper-4gray", "--to", "mem:"], 2, "names no language"),
        (["-d", "epaper-4gray", "--to", "escpos+mem:"], 2, "2 levels"),
        (["-d", "receipt-80mm", "--to", "file:/no/such/folder/x.bin"], 1, "/no/such/folder"),
        (["-d", "receipt-80mm", "--to", "file:/dev/usb/lp77"], 4, "/dev/usb/lp77"),
        (["-d", "receipt-80mm", "--to", "socket://127.0.0.1:1"], 4, "127.0.0.1"),
        (["-d", "receipt-99mm", "--to", "mem:"], 4, "Did you mean"),
    ],
)
def test_errors(picture, tmp_path, args, code, word):
    result = run("print", picture, *args, cwd=tmp_path)
    assert (result.code, word in result.err) == (code, True), result.err
    assert len(result.err.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_decode_names_the_offset(picture, tmp_path):
    run("print", picture, "-d", "receipt-58mm", "--dump", tmp_path / "x.bin")
    data = (tmp_path / "x.bin").read_bytes()
    (tmp_path / "cut.bin").write_bytes(data[:1000])
    result = run("decode", tmp_path / "cut.bin", tmp_path / "out.png")
    assert result.code == 3
    assert "at offset 1000" in result.err
    (tmp_path / "what.bin").write_bytes(b"nonsense")
    result = run("decode", tmp_path / "what.bin", tmp_path / "out.png")
    assert result.code == 3
    assert "6e 6f 6e" in result.err
    assert not (tmp_path / "out.png").exists()


def test_info_and_languages():
    result = run("devices", "info", "receipt-58mm", "--json")
    said = json.loads(result.out)
    assert (said["width"], said["options"]["avoid_rows_multiple_of"]) == (384, 48)
    assert b"escpos-printer-db" in run("devices", "info", "receipt-58mm").out
    rows = json.loads(run("devices", "languages", "--json").out)
    assert {row["language"] for row in rows} >= set(LANGUAGES)


def test_status_of_what_cannot_answer():
    result = run("devices", "status", "mem:", "-d", "receipt-80mm")
    assert (result.code, result.out) == (0, b"it says nothing of itself\n")
    assert run("devices", "status", "mem:").code == 2


def test_ctrl_c_completes_the_open_command(tmp_path):
    """The printer takes a little and waits; after Ctrl-C what it got is a whole, shorter job."""
    noise = np.random.default_rng(1).integers(0, 256, (12000, 576)).astype(np.uint8)
    Image.fromarray(noise).save(tmp_path / "long.png")
    with Listener(pause=True) as listener:
        to = f"escpos+socket://127.0.0.1:{listener.port}"
        command = [sys.executable, "-m", "halftone", "print", tmp_path / "long.png", "--to", to]
        child = subprocess.Popen([*command, "-d", "receipt-80mm", "--no-cut"], stderr=subprocess.PIPE)
        assert listener.begun.wait(30)
        time.sleep(0.5)
        child.send_signal(signal.SIGINT)
        time.sleep(0.2)
        listener.go.set()
        _, err = child.communicate(timeout=30)
    assert child.returncode == 130, err
    assert b"cancelled: the device accepted" in err
    from devices.languages.escpos import EscPos

    (frame,) = EscPos.decode(listener.data)
    assert 0 < frame.shape[0] < 12000


def test_inputs_are_not_overwritten(picture, tmp_path):
    own = tmp_path / "in.png"
    own.write_bytes(picture.read_bytes())
    for option, value in (("--dry-run", own), ("--dump", own), ("--to", f"file:{own}")):
        result = run("print", own, "-d", "receipt-80mm", option, value)
        assert (result.code, "is an input itself" in result.err) == (2, True)
    for pair in (("--dump", tmp_path / "x.png", "--dry-run", tmp_path / "x.png"),):
        result = run("print", own, "-d", "receipt-80mm", *pair)
        assert (result.code, "both write" in result.err) == (2, True)
    result = run("decode", own, own)
    assert (result.code, "the input itself" in result.err) == (2, True)
    assert own.read_bytes() == picture.read_bytes()
    assert list(tmp_path.iterdir()) == [own]


def test_a_failure_says_how_far_it_came(picture, tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]

        def vanish() -> None:
            connection, _ = server.accept()
            connection.recv(3000)
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
            connection.close()

        thread = threading.Thread(target=vanish)
        thread.start()
        noise = np.random.default_rng(1).integers(0, 256, (30_000, 576)).astype(np.uint8)
        Image.fromarray(noise).save(tmp_path / "long.png")
        to = f"pbm+socket://127.0.0.1:{port}"
        args = ("print", tmp_path / "long.png", "-d", "receipt-80mm", "--to", to)
        result = run(*args, "--dump", tmp_path / "got", "--json")
        thread.join()
    said = json.loads(result.out)
    assert result.code == 5
    assert "went away" in result.err
    assert 0 < said["rows_accepted"] < said["rows"] == 30_000
    assert (tmp_path / "got").stat().st_size == said["bytes_accepted"]


def test_a_missing_picture_is_said_before_the_first_is_printed(picture, tmp_path):
    result = run("print", picture, "no.png", "-d", "receipt-80mm", "--to", f"file:{tmp_path / 'x'}")
    assert (result.code, "no.png" in result.err) == (3, True)
    assert list(tmp_path.iterdir()) == []


def test_json_and_bytes_do_not_mix(picture):
    result = run("print", picture, "-d", "receipt-80mm", "--to", "file:-", "--json", "-q")
    assert result.out.startswith(b"\x1b@")
    assert json.loads(result.err)["completed"]
    assert b"rows_accepted" not in result.out


def test_a_dry_run_in_another_language(picture, tmp_path):
    args = ("print", picture, "-d", "generic-1bit", "--dry-run", tmp_path / "x.png")
    assert run(*args).code == 2
    assert run(*args, "--to", "pbm+mem:").code == 0
    np.testing.assert_array_equal(shown(tmp_path / "x.png"), converted(picture, "generic-1bit"))


def test_options_before_the_name():
    for args in (("info", "--json", "receipt-80mm"), ("status", "--device", "receipt-80mm", "mem:")):
        assert run("devices", *args).code == 0
    for args in (("info", "a", "b"), ("info",), ("list", "x"), ("doctor", "foo://bar")):
        assert run("devices", *args).code == 2


def test_numbers_that_are_no_times(picture):
    for option in ("--timeout", "--wait"):
        result = run("print", picture, "-d", "receipt-80mm", "--to", "mem:", option, "nan")
        assert (result.code, "seconds" in result.err) == (2, True)


def test_a_profile_with_a_wrong_language(picture, tmp_path):
    for text in ('language = "escpoz"', 'language = "escpos"\n[options]\ncomand = "raster"'):
        (tmp_path / "mine.toml").write_text(f'title = "t"\nprovenance = "p"\nwidth = 8\n{text}\n')
        result = run("print", picture, "-d", tmp_path / "mine.toml", "--to", "mem:")
        assert (result.code, "'mine' with the language" in result.err) == (2, True)
        assert "Did you mean" in result.err


class Listener:
    """A printer on a socket that keeps what it gets; with *pause* only once it may go on."""

    def __init__(self, pause: bool = False) -> None:
        self.server = socket.create_server(("127.0.0.1", 0))
        self.server.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self.port = self.server.getsockname()[1]
        self.data = b""
        self.begun, self.go = threading.Event(), threading.Event()
        if not pause:
            self.go.set()
        self.thread = threading.Thread(target=self._serve, daemon=True)

    def _serve(self) -> None:
        connection, _ = self.server.accept()
        with connection:
            while part := connection.recv(4096):
                if part.startswith(b"\x10\x04"):  # it is asked how it is
                    connection.sendall(b"\x16\x12\x12\x12")
                self.data += part
                if len(self.data) > 4096:
                    self.begun.set()
                    self.go.wait(60)

    def __enter__(self) -> Self:
        self.thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self.thread.join(30)
        self.server.close()
