"""Vectors of lanes: what they compile to does what they do in plain Python, and kernels as a whole."""

from __future__ import annotations

import inspect
import os
import re
import subprocess
import sys

import numpy as np
import pytest

from halftone import _lanes
from halftone._jit import kernel, part
from halftone._lanes import (
    acquire,
    added,
    as_bytes,
    as_floats,
    as_places,
    copy,
    gather,
    load,
    release,
    select,
    shifted,
    splat,
    store,
    transpose,
    widened,
)

LANES = 32


@part
def doubled(vector):
    return vector + vector


@kernel("u1[:]; i2[:]; i4[:]; f4[:]; u1[:]; i2[:]; i4[:]; f4[:]; i8[:]; f4; i8", lanes=True)
def everything(u1, i2, i4, f4, bytes_out, shorts, ints, floats, shared, scalar, number):
    a = load(i2, 3, LANES)
    b = load(i2, 40, LANES)
    store(shorts, 0, ((a >> 2) - (b << 1)) + 3 * a)
    store(shorts, 32, added(a, b))
    store(shorts, 64, shifted(a, i2[0]))
    store(shorts, 96, select(a >= b, a, b) - select(a < number, b, np.int16(7)))
    store(shorts, 128, widened(load(u1, 1, LANES)) * b)
    store(bytes_out, 0, select((a >= b) & (a < 100), u1[0], u1[1]))
    store(bytes_out, 32, as_bytes(a >= 0))
    store(bytes_out, 64, as_bytes(load(i4, 0, LANES)))
    transpose(u1, 2, 19, bytes_out, 100, 17)
    x = load(f4, 0, LANES)
    y = load(f4, 32, LANES)
    store(floats, 0, (x * scalar - y) * y + splat(scalar, LANES))
    store(floats, 32, select(x >= y, x - scalar, np.float32(0.5) * y))
    store(floats, 64, shifted(doubled(x), scalar))
    places = as_places(select(x < np.float32(0), np.float32(0), x))
    store(ints, 0, places + 1)
    store(floats, 96, gather(f4, places))
    store(floats, 128, as_floats(load(i4, 1, LANES)))
    copy(f4, 5, floats, 160, 20)
    release(shared, 0, number)
    shared[1] = acquire(shared, 0)


def inputs(seed: int) -> list[np.ndarray]:
    random = np.random.default_rng(seed)
    return [
        random.integers(0, 256, 400).astype(np.uint8),
        random.integers(-32768, 32768, 100).astype(np.int16),
        random.integers(-(2**31), 2**31, 100).astype(np.int32),
        np.exp(random.normal(0, 1, 100)).astype(np.float32) * random.choice([-1, 1], 100).astype("f4"),
    ]


def outputs(call, given: list[np.ndarray]) -> list[np.ndarray]:
    out = [np.zeros(400, array.dtype) for array in given] + [np.zeros(2, np.int64)]
    call(*given, *out, np.float32(1.37), 1234)
    return out


@pytest.mark.parametrize("seed", range(5))
def test_compiled_equals_plain_python(seed):
    with np.errstate(over="ignore"):
        plain = outputs(everything.python, inputs(seed))
    for compiled, expected in zip(outputs(everything, inputs(seed)), plain, strict=True):
        assert (expected != 0).any()
        np.testing.assert_array_equal(compiled, expected)


def test_vectors_need_nothing_but_the_processor():
    """They become object code that other processes load, as all kernels do."""
    assert everything.prepare() in ("compiled", "cache")


def test_public_names():
    made = [name for name, value in vars(_lanes).items() if inspect.isfunction(value)]
    assert sorted(_lanes.__all__) == sorted(made)


RUN = """
import sys, numpy as np, hashlib, halftone
codes = np.arange(60 * 90, dtype=np.uint16).reshape(60, 90).astype(np.uint8)
total = hashlib.sha256()
for method in ("fs:raster", "stucki:raster:right"):
    for levels in (2, 5, "uniform-linear:40"):
        total.update(halftone.dither(codes, method, levels=levels, encoding="linear").indices.tobytes())
print(total.hexdigest())
"""


@pytest.mark.parametrize(
    "environment",
    [
        {"NUMBA_DISABLE_JIT": "1"},
        {"NUMBA_CPU_NAME": "generic"},
        {"NUMBA_CPU_NAME": "nehalem", "NUMBA_CPU_FEATURES": ""},
        {"NUMBA_CPU_NAME": "haswell", "NUMBA_CPU_FEATURES": ""},
    ],
    ids=str,
)
def test_same_bytes_on_any_processor(environment, tmp_path):
    """Without a compiler, with SSE2, SSE4.2 and AVX2 (on x86-64), and as this machine is."""

    def run(**more: str) -> str:
        return subprocess.run(
            [sys.executable, "-c", RUN],
            env=os.environ | more,
            capture_output=True,
            text=True,
            check=True,
        ).stdout

    assert run(**environment, HALFTONE_CACHE_DIR=str(tmp_path)) == run()


def test_wavefronts_become_neon_code_on_aarch64(monkeypatch):
    """Not run here: nothing in a kernel's LLVM code may belong to one processor."""
    llvm = pytest.importorskip("llvmlite.binding")
    from halftone import _objects
    from halftone.dithering import _wave_kernels

    codes: list[str] = []
    monkeypatch.setattr(_objects, "build", lambda kernel, ir: codes.append(ir))
    _objects._llvm()
    _wave_kernels.wave_codes.compile()
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    triple = "aarch64-unknown-linux-gnu"
    machine = llvm.Target.from_triple(triple).create_target_machine(cpu="generic", opt=3)
    module = llvm.parse_assembly(re.sub(r'target (triple|datalayout) = .*|"target-[^ ]*', "", codes[0]))
    module.triple, module.data_layout = triple, str(machine.target_data)
    assert len(re.findall(r"\bv\d+\.8h", machine.emit_assembly(module))) > 100
