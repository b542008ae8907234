"""The kernel cache: cold and warm, damaged, read-only, foreign; and the kernel without it."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

from halftone import _objects
from halftone._jit import kernels
from halftone.dithering import _diffusion_kernels

RUN = (
    "import numpy as np, halftone, sys\n"
    "from halftone.dithering._diffusion_kernels import diffuse_codes as k\n"
    "f = halftone.dither(np.arange(64 * 64, dtype=np.uint16).reshape(64, 64).astype(np.uint8),"
    " 'fs', encoding='linear')\n"
    "print(k.origin, int(f.indices.sum()), 'numba' in sys.modules)"
)


def run(folder, **environment) -> list[str]:
    done = subprocess.run(
        [sys.executable, "-c", RUN],
        env=os.environ | {"HALFTONE_CACHE_DIR": str(folder)} | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return done.stdout.split()


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    """A folder with the kernel, and what it gave."""
    folder = tmp_path_factory.mktemp("cache") / "made" / "when needed"
    first = run(folder)
    assert first[0] == "compiled"
    return folder, first[1]


def test_a_second_process_runs_the_cached_kernel_without_numba(cache):
    folder, total = cache
    assert run(folder) == ["cache", total, "False"]


@pytest.mark.parametrize("damage", ["empty", "cut", "flipped", "garbage", "other magic"])
def test_a_damaged_file_is_compiled_anew(cache, tmp_path, damage):
    folder, total = cache
    (source,) = folder.glob("*.kernel")
    blob = source.read_bytes()
    flipped = bytearray(blob)
    flipped[len(blob) // 2] ^= 1
    broken = {
        "empty": b"",
        "cut": blob[: len(blob) // 2],
        "flipped": bytes(flipped),
        "garbage": b"\0" * 4096,
        "other magic": b"halftone-kernel-0\n" + blob[18:],
    }[damage]
    (tmp_path / source.name).write_bytes(broken)
    assert run(tmp_path)[:2] == ["compiled", total]
    assert run(tmp_path)[:2] == ["cache", total]


def test_a_cache_that_cannot_be_written(cache, tmp_path):
    _, total = cache
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    assert run(blocked / "below")[:2] == ["compiled", total]
    assert run("/proc/nowhere")[:2] == ["compiled", total]


def test_a_read_only_cache_still_serves(cache, tmp_path):
    folder, total = cache
    (source,) = folder.glob("*.kernel")
    (tmp_path / source.name).write_bytes(source.read_bytes())
    tmp_path.chmod(0o500)
    try:
        assert run(tmp_path)[:2] == ["cache", total]
    finally:
        tmp_path.chmod(0o700)


def test_no_home_folder(cache):
    _, total = cache
    environment = {"HALFTONE_CACHE_DIR": "", "XDG_CACHE_HOME": "", "HOME": "/proc/nowhere"}
    assert run("", **environment)[1] == total


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give a file to another user")
def test_a_file_of_another_user_is_not_executed(cache, tmp_path):
    folder, total = cache
    (source,) = folder.glob("*.kernel")
    copy = tmp_path / source.name
    copy.write_bytes(source.read_bytes())
    os.chown(copy, 12345, 12345)
    assert run(tmp_path)[:2] == ["compiled", total]


def test_without_a_compiler(cache, tmp_path):
    _, total = cache
    assert run(tmp_path, NUMBA_DISABLE_JIT="1") == ["python", total, "False"]


def test_another_processor_has_its_own_file(cache, tmp_path):
    _, total = cache
    assert run(tmp_path, NUMBA_CPU_NAME="generic")[:2] == ["compiled", total]
    assert run(tmp_path)[:2] == ["compiled", total]
    assert len(list(tmp_path.glob("*.kernel"))) == 2


def test_every_kernel_becomes_object_code():
    """None falls back to numba's dispatcher, which would cost every process its start-up."""
    for made in kernels():
        dispatcher, object_code = made.compile()
        assert object_code is not None, made.__name__
        assert callable(dispatcher)


def test_a_kernel_that_needs_the_runtime_falls_back(monkeypatch):
    monkeypatch.setattr(_objects, "build", lambda kernel, ir: None)
    made = _diffusion_kernels.diffuse_codes
    dispatcher, object_code = made.compile()
    assert object_code is None
    codes = np.full((4, 8), 100, np.uint8)
    arguments = [np.zeros(8, np.int32), np.zeros(10, np.int32), np.array([0, 1], np.uint8), 0, 1, 0]
    first, second = np.zeros_like(codes), np.zeros_like(codes)
    dispatcher(codes, first, *[np.copy(a) if hasattr(a, "copy") else a for a in arguments])
    made.python(codes, second, *[np.copy(a) if hasattr(a, "copy") else a for a in arguments])
    np.testing.assert_array_equal(first, second)


def test_a_wrong_argument_is_refused_before_the_call():
    made = _diffusion_kernels.diffuse_codes
    codes = np.zeros((4, 8), np.uint8)
    rest = [np.zeros(8, np.int32), np.zeros(10, np.int32), np.array([0, 1], np.uint8), 0, 1, 0]
    with pytest.raises(TypeError, match="u1"):
        made(codes.astype(np.int64), np.zeros_like(codes), *rest)
    with pytest.raises(TypeError, match="u1"):
        made(codes[:, ::2], np.zeros((4, 4), np.uint8), *rest)


def test_numbas_own_dispatcher_serves_where_object_code_cannot(monkeypatch):
    """Read-only arrays are a type of their own to numba: the tables of levels are such."""
    from halftone import dither
    from halftone._jit import Kernel

    picture = np.linspace(0, 1, 35 * 41, dtype=np.float32).reshape(35, 41)
    picture.flags.writeable = False
    expected = dither(picture, "stucki", levels=5)
    monkeypatch.setattr(_objects, "build", lambda kernel, ir: None)
    monkeypatch.setattr(_objects, "read", lambda kernel: None)
    fresh = Kernel(_diffusion_kernels.diffuse_light.python, _diffusion_kernels.diffuse_light.signature)
    monkeypatch.setattr(_diffusion_kernels, "diffuse_light", fresh)
    np.testing.assert_array_equal(dither(picture, "stucki", levels=5), expected)
    assert fresh.origin == "numba"
