"""``halftone cache``, and a cache that is damaged or cannot be written: never a wrong picture."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import pytest

from tests.cli.command import names_in, run

ARGS = ("-l", "4", "-m", "stucki")


@pytest.fixture(scope="module")
def expected(gray: Path, tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The picture with the cache of the test run."""
    out = tmp_path_factory.mktemp("expected") / "out.png"
    assert run("convert", gray, out, *ARGS).code == 0
    return out.read_bytes()


@pytest.fixture(scope="module")
def warm(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """A cache filled by ``cache warm``, and what that said."""
    folder = tmp_path_factory.mktemp("cache") / "made" / "by us"
    result = run("cache", "warm", env={"HALFTONE_CACHE_DIR": str(folder)}, timeout=300)
    assert (result.code, result.err) == (0, "")
    return folder, result.text


def test_warm_compiles_and_keeps(warm: tuple[Path, str]) -> None:
    folder, said = warm
    lines = said.splitlines()
    assert lines
    assert all(": compiled, " in line for line in lines)
    assert len(list(folder.glob("*.kernel"))) == len(lines)
    assert folder.stat().st_mode & 0o077 == 0
    again = run("cache", "warm", env={"HALFTONE_CACHE_DIR": str(folder)})
    assert again.code == 0
    assert all(": cache, " in line for line in again.text.splitlines())


def test_info_names_folder_and_kernels(warm: tuple[Path, str], tmp_path: Path) -> None:
    info = run("cache", "info", env={"HALFTONE_CACHE_DIR": str(warm[0])})
    assert (info.code, info.err) == (0, "")
    assert str(warm[0]) in info.text
    for path in warm[0].glob("*.kernel"):
        assert path.name in info.text
    empty = run("cache", "info", env={"HALFTONE_CACHE_DIR": str(tmp_path / "none")})
    assert empty.code == 0
    assert "kernels  0" in empty.text


def test_the_cache_is_where_xdg_says(tmp_path: Path) -> None:
    env = {"HALFTONE_CACHE_DIR": "", "XDG_CACHE_HOME": str(tmp_path)}
    assert str(tmp_path / "halftone") in run("cache", "info", env=env).text


def test_clear_deletes_kernels_only(tmp_path: Path) -> None:
    for name in ("a.kernel", "b.kernel", "mine.txt"):
        (tmp_path / name).write_bytes(b"x")
    env = {"HALFTONE_CACHE_DIR": str(tmp_path)}
    assert "2 kernels" in run("cache", "clear", env=env).text
    assert names_in(tmp_path) == ["mine.txt"]
    assert "0 kernels" in run("cache", "clear", env=env).text


def _copy(source: Path, target: Path, damage: str) -> None:
    target.mkdir()
    for path in source.glob("*.kernel"):
        data = path.read_bytes()
        damaged = {
            "cut": data[: len(data) // 2],
            "garbage": bytes(range(256)) * 20,
            "one bit": data[:-9] + bytes([data[-9] ^ 1]) + data[-8:],
        }[damage]
        (target / path.name).write_bytes(damaged)


@pytest.mark.parametrize("damage", ["cut", "garbage", "one bit"])
def test_a_damaged_cache_is_made_anew(
    damage: str, warm: tuple[Path, str], gray: Path, expected: bytes, tmp_path: Path
) -> None:
    folder = tmp_path / "cache"
    _copy(warm[0], folder, damage)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    env = {"HALFTONE_CACHE_DIR": str(folder)}
    result = run("convert", gray, tmp_path / "out.png", *ARGS, env=env)
    assert (result.code, result.err) == (0, "")
    assert (tmp_path / "out.png").read_bytes() == expected
    after = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert sorted(after) == sorted(before)
    mended = [name for name in after if after[name] != before[name]]
    assert mended
    for name in mended:  # what was used is whole again: a mark, a checksum, the object code
        payload = after[name].partition(b"\n")[2][32:]
        assert hashlib.sha256(payload).digest() == after[name].partition(b"\n")[2][:32]


@pytest.mark.parametrize("kind", ["a file", "read-only"])
def test_a_cache_that_cannot_be_written(kind: str, gray: Path, expected: bytes, tmp_path: Path) -> None:
    folder = tmp_path / "cache"
    if kind == "a file":
        folder.write_bytes(b"kept")
    if kind == "read-only":
        folder.mkdir()
        folder.chmod(0o500)
        if os.access(folder, os.W_OK):
            pytest.skip("this user may write everywhere")
    env = {"HALFTONE_CACHE_DIR": str(folder)}
    result = run("convert", gray, tmp_path / "out.png", *ARGS, env=env)
    assert (result.code, result.err) == (0, "")
    assert (tmp_path / "out.png").read_bytes() == expected
    if kind == "a file":
        assert folder.read_bytes() == b"kept"


def test_warm_says_when_nothing_can_be_kept() -> None:
    result = run("cache", "warm", env={"HALFTONE_CACHE_DIR": "/proc/halftone"})
    assert "HALFTONE_CACHE_DIR" in result.complaint(1)


def test_without_a_home_folder(gray: Path, expected: bytes, tmp_path: Path) -> None:
    """As a service user: the picture is made all the same."""
    (tmp_path / "no folder").touch()
    env = {"HALFTONE_CACHE_DIR": "", "XDG_CACHE_HOME": "", "HOME": str(tmp_path / "no folder")}
    result = run("convert", gray, tmp_path / "out.png", *ARGS, env=env)
    assert (result.code, result.err) == (0, "")
    assert (tmp_path / "out.png").read_bytes() == expected
