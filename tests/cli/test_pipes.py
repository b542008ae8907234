"""``-`` for stdin and stdout."""

from __future__ import annotations

import os
import resource
import subprocess
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.cli.command import environment, run, script
from tests.cli.files import GRAY, RGB, header_of, light_of, shown, write_oiio

FORMATS = ("png", "jpg", "tif", "webp", "bmp", "ppm", "exr", "hdr")


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Pictures of all formats, and what they become."""
    folder, out = tmp_path_factory.mktemp("files"), tmp_path_factory.mktemp("out")
    for kind in FORMATS:
        source = folder / f"{kind}.{kind}"
        if kind in ("exr", "hdr"):
            write_oiio(source, light_of(GRAY).astype(np.float32)[:, :, None].repeat(3, 2), "float")
        else:
            Image.fromarray(RGB).save(source)
    assert run("convert", *folder.iterdir(), out).code == 0
    return folder, out


@pytest.mark.parametrize("kind", FORMATS)
def test_stdin_is_as_good_as_a_file(kind: str, files: tuple[Path, Path]) -> None:
    piped = run("convert", "-", "-", input=(files[0] / f"{kind}.{kind}").read_bytes())
    assert (piped.code, piped.err) == (0, "")
    assert piped.out == (files[1] / f"{kind}.png").read_bytes()


def test_in_and_out_through_a_pipe(gray: Path, tmp_path: Path) -> None:
    piped = run("convert", "-", "-", input=gray.read_bytes())
    assert (piped.code, piped.err) == (0, "")
    assert header_of(piped.out) == (41, 24, 1, 0)
    assert run("convert", gray, tmp_path / "out.png").code == 0
    assert piped.out == (tmp_path / "out.png").read_bytes()


@pytest.mark.parametrize("kind", ["png", "pbm", "pgm", "tiff", "raw"])
def test_every_format_goes_to_stdout(kind: str, gray: Path, tmp_path: Path) -> None:
    piped = run("convert", gray, "-", "--format", kind)
    assert (piped.code, piped.err) == (0, "")
    assert run("convert", gray, tmp_path / f"out.{kind}").code == 0
    assert piped.out == (tmp_path / f"out.{kind}").read_bytes()


def test_stdin_into_a_folder(gray: Path, tmp_path: Path) -> None:
    assert run("convert", "-", f"{tmp_path}/out/", input=gray.read_bytes()).code == 0
    assert [p.name for p in (tmp_path / "out").iterdir()] == ["stdin.png"]


def test_a_preview_goes_to_stdout(gray: Path) -> None:
    piped = run(
        "convert", "-", "-", "--preview", "-l", "0.1,0.9", "--upscale", "1", input=gray.read_bytes()
    )
    assert header_of(piped.out) == (3 * 41 + 8, 24, 8, 0)
    assert set(np.unique(shown(piped.out)[:, 45:86])) == {89, 243}  # sRGB codes of .1 and .9


@pytest.mark.parametrize(
    ("data", "what"),
    [(b"", "empty"), (b"hello\n", "not a picture"), (b"\x89PNG\r\n\x1a\n", "stdin")],
)
def test_stdin_without_a_picture(data: bytes, what: str, tmp_path: Path) -> None:
    line = run("convert", "-", tmp_path / "out.png", input=data).complaint(3)
    assert what in line
    assert "/proc/" not in line
    assert list(tmp_path.iterdir()) == []


def test_stdin_cut_off(gray: Path, tmp_path: Path) -> None:
    data = gray.read_bytes()
    line = run("convert", "-", tmp_path / "out.png", input=data[: len(data) // 2]).complaint(3)
    assert "stdin" in line


def test_stdin_beyond_the_memory_limit(gray: Path, tmp_path: Path) -> None:
    data = gray.read_bytes() + bytes(1 << 20)
    line = run("convert", "-", tmp_path / "o.png", "--max-memory", "1M", input=data).complaint(3)
    assert "max-memory" in line


def test_stdin_under_any_memory_limit(gray: Path, tmp_path: Path) -> None:
    args = ("convert", "-", tmp_path / "o.png", "--max-memory", "99999999999999G")
    assert run(*args, input=gray.read_bytes()).code == 0


def test_stdin_takes_no_more_memory_than_it_holds(gray: Path, tmp_path: Path) -> None:
    """A small picture must go through a pipe where 4 GiB, the limit, cannot be had."""
    size = 3 << 30

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (size, size))

    file = run("convert", gray, tmp_path / "out.png", preexec_fn=limit)
    if file.code:
        pytest.skip("not even a file can be converted within 3 GiB of address space")
    data = gray.read_bytes()
    piped = run("convert", "-", tmp_path / "out.png", input=data, preexec_fn=limit)
    assert (piped.code, piped.err) == (0, "")


def test_a_file_may_be_called_stdin(gray: Path, tmp_path: Path) -> None:
    (tmp_path / "stdin").write_bytes(gray.read_bytes())
    result = run("convert", "stdin", "out.png", cwd=tmp_path)
    assert (result.code, result.err) == (0, "")


def test_a_named_pipe_does_not_hang(gray: Path, tmp_path: Path) -> None:
    """As `halftone convert <(…) OUT`: converted, or refused in one line."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with subprocess.Popen(
        ["sh", "-c", 'cat "$0" > "$1"', gray, pipe], stderr=subprocess.DEVNULL
    ) as writer:
        try:
            result = run("convert", pipe, tmp_path / "out.png", timeout=5)
        finally:
            writer.kill()
    assert result.code in (0, 3)
    if result.code:
        assert "pipe" in result.complaint(3)


@pytest.mark.parametrize("number", [0, 1, 2])
def test_a_closed_stream_is_no_internal_error(number: int, gray: Path, tmp_path: Path) -> None:
    """``<&-``, ``>&-`` and ``2>&-``: without stderr the picture is still converted."""
    args = {
        0: ("-", tmp_path / "out.png"),
        1: (gray, "-"),
        2: (gray, tmp_path / "out.png"),
    }[number]
    result = run("convert", *args, preexec_fn=lambda: os.close(number))
    if number == 2:
        assert result.code == 0
        assert (tmp_path / "out.png").is_file()
    else:
        result.complaint(3 if number == 0 else 1)


@pytest.mark.parametrize("args", [("list", "methods"), ("convert", "{gray}", "-")])
def test_a_reader_that_goes_away(args: tuple[str, ...], gray: Path) -> None:
    """``halftone … | true``: no word, and no success either."""
    command = [script(), *(a.format(gray=gray) for a in args)]
    with subprocess.Popen(
        command, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait() == 1
