"""Files that cannot be written: exit code 1, one line, and never half a file."""

from __future__ import annotations

import os
import resource
from pathlib import Path

import pytest

from tests.cli.command import names_in, run

LIMIT = 1000


def _small_disk() -> None:
    """Files of at most 1000 bytes, as on a disk that is nearly full."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (LIMIT, LIMIT))


def test_no_overwrite(gray: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.png"
    assert run("convert", gray, out, "--no-overwrite").code == 0
    written = out.read_bytes()
    line = run("convert", gray, out, "--no-overwrite", "-l", "4").complaint(1)
    assert str(out) in line
    assert out.read_bytes() == written
    assert names_in(tmp_path) == ["out.png"]
    assert run("convert", gray, out, "-l", "4").code == 0
    assert out.read_bytes() != written


def test_no_overwrite_within_a_folder(gray: Path, colour: Path, tmp_path: Path) -> None:
    (tmp_path / "gray.png").write_bytes(b"kept")
    line = run("convert", gray, colour, tmp_path, "--no-overwrite").complaint(1)
    assert "gray.png" in line
    assert (tmp_path / "gray.png").read_bytes() == b"kept"
    assert names_in(tmp_path) == ["colour.png", "gray.png"]


@pytest.mark.parametrize("name", ["nowhere/out.png", "file/out.png", "file/"])
def test_no_such_folder(name: str, gray: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"kept")
    line = run("convert", gray, f"{tmp_path}/{name}").complaint(1)
    assert name in line
    assert names_in(tmp_path) == ["file"]


@pytest.mark.parametrize("out", ["/proc/out.png", "/proc/new/folder/"])
def test_where_nobody_can_write(out: str, gray: Path) -> None:
    assert out in run("convert", gray, out).complaint(1)


def test_a_folder_that_is_read_only(gray: Path, tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    folder.chmod(0o500)
    if os.access(folder, os.W_OK):
        pytest.skip("this user may write everywhere")
    assert str(folder) in run("convert", gray, folder / "out.png").complaint(1)


@pytest.mark.parametrize("length", [251, 300])
def test_long_names(length: int, gray: Path, tmp_path: Path) -> None:
    """251 + 4 characters are allowed by most file systems, 304 by none."""
    out = tmp_path / ("x" * length + ".png")
    result = run("convert", gray, out)
    if length == 251:
        assert (result.code, result.err) == (0, "")
        assert names_in(tmp_path) == [out.name]
    else:
        result.complaint(1)


def test_a_long_name_of_wide_characters(gray: Path, tmp_path: Path) -> None:
    """83 characters of 3 bytes each are as long as the 251 above."""
    out = tmp_path / ("日" * 83 + ".png")
    result = run("convert", gray, out)
    assert (result.code, result.err) == (0, "")
    assert names_in(tmp_path) == [out.name]


@pytest.mark.parametrize("before", [b"", b"what was there"])
def test_a_full_disk(before: bytes, gray: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.raw"
    if before:
        out.write_bytes(before)
    args = ("convert", gray, out, "-l", "256", "--upscale", "4")
    line = run(*args, preexec_fn=_small_disk).complaint(1)
    assert str(out) in line
    assert names_in(tmp_path) == (["out.raw"] if before else [])
    if before:
        assert out.read_bytes() == before


def test_a_full_disk_for_one_of_two(gray: Path, colour: Path, tmp_path: Path) -> None:
    """Neither fits, both are named, and nothing is left."""
    args = ("convert", gray, colour, tmp_path, "--format", "raw", "-l", "256", "--upscale", "4")
    result = run(*args, preexec_fn=_small_disk)
    assert result.code == 1
    assert [line.count("gray.raw") for line in result.err.splitlines()] == [1, 0]
    assert names_in(tmp_path) == []


def test_a_full_device_as_out(gray: Path) -> None:
    line = run("convert", gray, "/dev/full", "--format", "png").complaint(1)
    assert "/dev/full" in line
    assert Path("/dev/full").is_char_device()


def test_a_device_takes_the_bytes(gray: Path) -> None:
    result = run("convert", gray, "/dev/stdout", "--format", "pbm")
    assert (result.code, result.err) == (0, "")
    assert result.out == run("convert", gray, "-", "--format", "pbm").out


@pytest.mark.parametrize(
    "args",
    [
        ("convert", "{gray}", "-"),
        ("convert", "{gray}", "{out}", "--json"),
        ("list", "methods"),
        ("list", "levels", "--json"),
        ("cache", "info"),
    ],
)
def test_stdout_is_full(args: tuple[str, ...], gray: Path, tmp_path: Path) -> None:
    filled = [a.format(gray=gray, out=tmp_path / "out.png") for a in args]
    with open("/dev/full", "wb") as full:
        line = run(*filled, stdout=full).complaint(1)
    assert "stdout" in line or "No space left" in line


def test_a_link_is_kept_and_its_target_replaced(gray: Path, tmp_path: Path) -> None:
    (tmp_path / "target").write_bytes(b"kept")
    (tmp_path / "out.png").symlink_to("target")
    assert run("convert", gray, tmp_path / "out.png").code == 0
    assert (tmp_path / "out.png").is_symlink()
    assert (tmp_path / "target").read_bytes().startswith(b"\x89PNG")


def test_the_mode_of_a_file_that_is_replaced_stays(gray: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.png"
    out.write_bytes(b"")
    out.chmod(0o600)
    assert run("convert", gray, out).code == 0
    assert out.stat().st_mode & 0o777 == 0o600
