"""Ctrl-C, and the progress bar: what a person at a terminal sees of a long run."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
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
