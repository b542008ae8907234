"""What is imported when: nothing that a job does not need."""

from __future__ import annotations

import subprocess
import sys

import pytest

import halftone

HEAVY = {"numba", "llvmlite", "scipy", "colour", "OpenImageIO", "PIL", "skimage", "matplotlib"}


def loaded(code: str) -> set[str]:
    """Top-level modules in sys.modules after *code* in a fresh interpreter."""
    done = subprocess.run(
        [
            sys.executable,
            "-c",
            code + "\nimport sys; print(*{m.split('.')[0] for m in sys.modules})",
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    return set(done.stdout.split())


def test_import_halftone_loads_nothing():
    assert not loaded("import halftone, devices") & (HEAVY | {"numpy"})


def test_help_needs_no_numpy():
    code = (
        "import contextlib, io\nfrom halftone.cli import main\n"
        "with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):\n"
        "    main(['--help'])"
    )
    assert not loaded(code) & (HEAVY | {"numpy"})


@pytest.mark.parametrize("method", ["none", "threshold", "otsu", "random", "bayer8"])
def test_point_methods_do_not_load_a_compiler(method):
    code = f"import halftone, numpy\nhalftone.dither(numpy.zeros((9, 9)), '{method}')"
    assert not loaded(code) & HEAVY


def test_warm_error_diffusion_does_not_load_numba(photograph):
    code = "import halftone, numpy\nhalftone.dither(numpy.zeros((9, 9)), 'fs')"
    loaded(code)  # the first run may compile
    assert loaded(code) & HEAVY == {"llvmlite"}


def test_a_conversion_loads_only_its_reader(photograph):
    code = f"import halftone\nhalftone.convert({str(photograph)!r}, method='bayer8')"
    assert loaded(code) & HEAVY == {"OpenImageIO"}
    code = f"import halftone\nhalftone.convert({str(photograph)!r}, method='bayer8', width=99)"
    assert loaded(code) & HEAVY == {"OpenImageIO", "PIL"}


def test_public_names():
    for name in halftone.__all__:
        assert getattr(halftone, name) is not None
    assert set(halftone.__all__) <= set(dir(halftone))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = halftone.nothing


def test_the_stub_names_what_is_public():
    from pathlib import Path

    stub = Path(halftone.__file__).with_suffix(".pyi").read_text()
    for name in halftone.__all__:
        assert f"{name} as {name}" in stub or f"{name}:" in stub, name
