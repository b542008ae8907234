"""Ctrl-C, and the progress bar: what a person at a terminal sees of a long run."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from PIL import Image

from tests.cli.command import environment, names_in, run, script

SLOW = {"NUMBA_DISABLE_JIT": "1"}
"""Plain Python instead of compiled kernels: seconds on any machine."""

BAR = "░"


@contextmanager
def _terminal(*args: str | Path, env: dict[str, str] | None = None) -> Iterator[tuple]:
    """The command with a terminal as stderr: the process, and what reads on until a test is met."""
    ours, theirs = pty.openpty()
    try:
        with subprocess.Popen(
            [script(), *map(str, args)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=theirs,
            env=environment(env),
        ) as process:
            os.close(theirs)
            seen = b""

            def read(until: Callable[[str], bool] = lambda _: False) -> str:
                nonlocal seen
                while not until(seen.decode(errors="ignore")):
                    try:
                        more = os.read(ours, 4096)
                    except OSError:  # the other end is closed
                        break
                    if not more:
                        break
                    seen += more
                return seen.decode(errors="ignore")

            try:
                yield process, read
            finally:
                process.kill()
    finally:
        os.close(ours)


def test_a_long_run_shows_a_bar_and_takes_it_away(slow: Path, tmp_path: Path) -> None:
    with _terminal("convert", slow, tmp_path / "out.png", env=SLOW) as (process, read):
        seen = read()
        assert process.wait() == 0
    assert BAR in seen
    assert "%" in seen
    assert slow.name in seen
    assert seen.endswith("\r\x1b[K")
    assert "\n" not in seen


def test_large_pictures_show_a_bar(large: Path, tmp_path: Path) -> None:
    """Compiled, four pictures of 24 megapixels: the bar counts the files."""
    inputs = [tmp_path / f"in{k}.pgm" for k in range(4)]
    for path in inputs:
        path.symlink_to(large)
    out = tmp_path / "out"
    with _terminal("convert", *inputs, out, "-m", "jjn", "-l", "16") as (process, read):
        assert "/4 " in read(lambda seen: "/4 " in seen)
        process.send_signal(signal.SIGINT)
        assert "halftone: interrupted" in read()
        assert process.wait() == 130
    assert not list(out.glob(".*"))


def test_a_short_run_shows_nothing(gray: Path, tmp_path: Path) -> None:
    with _terminal("convert", gray, tmp_path / "out.png", "-m", "none") as (process, read):
        assert read() == ""
        assert process.wait() == 0


def test_neither_a_pipe_nor_quiet_shows_a_bar(slow: Path, tmp_path: Path) -> None:
    """Both at once, to spare time."""
    args = ("convert", slow, tmp_path / "quiet.png", "--quiet")
    with _terminal(*args, env=SLOW) as (process, read):
        start = time.monotonic()
        result = run("convert", slow, tmp_path / "pipe.png", env=SLOW)
        assert time.monotonic() - start > 1, "too short a run to show anything"
        assert (result.code, result.err) == (0, "")
        assert read() == ""
        assert process.wait() == 0


@pytest.mark.parametrize("before", [b"", b"what was there"])
def test_ctrl_c_leaves_no_half_file(before: bytes, slow: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.png"
    if before:
        out.write_bytes(before)
    with _terminal("convert", slow, out, env=SLOW) as (process, read):
        read(lambda seen: BAR in seen)  # now it is at work
        process.send_signal(signal.SIGINT)
        seen = read()
        assert process.wait() == 130
    assert "halftone: interrupted" in seen
    assert "Traceback" not in seen
    assert names_in(tmp_path) == (["out.png"] if before else [])
    if before:
        assert out.read_bytes() == before


@pytest.mark.parametrize("pause", [0.0, 0.01, 0.03])
def test_a_second_ctrl_c_leaves_no_half_file_either(pause: float, slow: Path, tmp_path: Path) -> None:
    with _terminal("convert", slow, tmp_path / "out.png", env=SLOW) as (process, read):
        read(lambda seen: BAR in seen)
        process.send_signal(signal.SIGINT)
        time.sleep(pause)
        process.send_signal(signal.SIGINT)
        read()
        assert process.wait() == 130
    assert names_in(tmp_path) == []


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_ctrl_c_keeps_what_is_whole(jobs: str, large: Path, tmp_path: Path) -> None:
    """Of many pictures the first are whole, the others are not there."""
    inputs = [tmp_path / f"in{k}.pgm" for k in range(12)]
    for path in inputs:
        path.symlink_to(large)
    out = tmp_path / "out"
    with subprocess.Popen(
        [script(), "convert", *inputs, out, "-j", jobs],
        stdin=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        env=environment(),
    ) as process:
        assert process.stderr is not None
        while process.poll() is None and not list(out.glob("*.png")):
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        assert process.stderr.read() == b"halftone: interrupted\n"
        assert process.wait() == 130
    names = names_in(out)
    assert 1 <= len(names) < 12
    assert all(name.startswith("in") for name in names)
    for name in names:
        with Image.open(out / name) as picture:
            assert picture.size == (6000, 4000)
            picture.load()


@pytest.fixture(scope="module")
def huge(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A PGM of a gigapixel, of holes: reading it takes time, but no disk."""
    path = tmp_path_factory.mktemp("huge") / "huge.pgm"
    head = b"P5\n32768 32768\n255\n"
    with open(path, "wb") as file:
        file.write(head)
        file.truncate(len(head) + 32768**2)
    yield path
    path.unlink()


@pytest.mark.parametrize("jobs", ["1", "2"])
@pytest.mark.parametrize(
    "options", [("-m", "fs"), ("-m", "dots:knuth"), ("-m", "bayer8"), ("-m", "fs", "--width", "576")]
)
@pytest.mark.parametrize("after", [0.0, 0.5])
def test_ctrl_c_at_any_moment(
    after: float, options: tuple[str, ...], jobs: str, huge: Path, tmp_path: Path
) -> None:
    """A gigapixel, at its start and later: no file is left, and it does not go on to its end."""
    out = tmp_path / "out" / "out.tif"
    out.parent.mkdir()
    with subprocess.Popen(
        [script(), "convert", huge, out, "-j", jobs, *options],
        stdin=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        env=environment({"PYTHONFAULTHANDLER": "1"}),
    ) as process:
        assert process.stderr is not None
        while process.poll() is None and str(huge) not in _opened(process.pid):
            time.sleep(0.002)
        time.sleep(after)  # another moment; the result must be the same
        process.send_signal(signal.SIGINT)
        assert process.stderr.read() == b"halftone: interrupted\n"
        assert process.wait() == 130
    assert names_in(out.parent) == []


def _opened(process: int) -> set[str]:
    """Names of the files that a process has open."""
    names = set()
    with suppress(OSError):  # the process, or a file of it, was closed meanwhile
        for link in Path(f"/proc/{process}/fd").iterdir():
            names.add(str(link.readlink()))
    return names


def test_ctrl_c_in_the_middle_of_a_call(tmp_path: Path) -> None:
    """A step that neither ends nor looks around does not hold up the process."""
    program = (
        "import sys, time; from halftone.cli import main; import halftone.stages as s\n"
        "s.Halftoning.bands = lambda *_: time.sleep(50)\n"
        "main()"
    )
    picture = tmp_path / "in.pgm"
    picture.write_bytes(b"P5\n1 1\n255\n\0")
    out = tmp_path / "out.png"
    with subprocess.Popen(
        [sys.executable, "-c", program, "convert", picture, out],
        stderr=subprocess.PIPE,
        env=environment(),
    ) as process:
        assert process.stderr is not None
        while process.poll() is None and not list(tmp_path.glob("*.part")):
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        assert process.stderr.read() == b"halftone: interrupted\n"
        assert process.wait(20) == 130
    assert names_in(tmp_path) == ["in.pgm"]


def test_ctrl_c_that_was_swallowed_is_not_forgotten() -> None:
    """KeyboardInterrupt within an import may be lost there: the next step ends all the same."""
    program = (
        "import os, signal, time; from halftone.cli import console\n"
        "console.listen()\n"
        "try: os.kill(os.getpid(), signal.SIGINT); time.sleep(9)\n"
        "except KeyboardInterrupt: pass\n"
        "try: console.interruptible(lambda: time.sleep(50), lambda: None)\n"
        "except KeyboardInterrupt: os._exit(7)"
    )
    done = subprocess.run([sys.executable, "-c", program], env=environment(), timeout=30, check=False)
    assert done.returncode == 7
