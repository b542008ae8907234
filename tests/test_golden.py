"""Golden images, compared exactly; and again with other processor features."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

from tests.golden import streams
from tests.golden.make import CASES, FOLDER, frame, path


@pytest.mark.parametrize("case", CASES, ids=str)
def test_golden(case):
    from PIL import Image

    made = frame(*case)
    with Image.open(path(*case)) as image:
        image.load()
        shown = np.asarray(image.convert("L"))
    np.testing.assert_array_equal(made.preview(), shown)


def test_every_golden_file_has_a_case():
    assert {path(*case) for case in CASES} == set(FOLDER.glob("*.png"))


@pytest.mark.parametrize(
    "features",
    [
        {"NPY_DISABLE_CPU_FEATURES": "X86_V4", "NUMBA_CPU_NAME": "generic"},
        {"NUMBA_DISABLE_JIT": "1"},
    ],
    ids=str,
)
def test_golden_on_other_processors(features, tmp_path):
    """Older vector units, no compiler at all: the same bytes."""
    if "NPY_DISABLE_CPU_FEATURES" in features and not _has_v4():
        features = {"NUMBA_CPU_NAME": "generic"}
    environment = os.environ | features
    code = (
        "from tests.golden.make import *\n"
        "import io, numpy as np\nfrom PIL import Image\n"
        "bad = [c for c in CASES if not np.array_equal(frame(*c).preview(),"
        " np.asarray(Image.open(path(*c)).convert('L')))]\n"
        "print(len(CASES), 'compared;', bad)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=FOLDER.parent.parent,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.strip() == f"{len(CASES)} compared; []", done.stderr


def _has_v4() -> bool:
    from numpy._core._multiarray_umath import __cpu_features__

    return bool(__cpu_features__.get("X86_V4"))


@pytest.mark.parametrize("case", streams.CASES, ids=str)
def test_golden_streams(case):
    """The bytes of a printer language do not change silently either."""
    assert streams.line(*case) in streams.FILE.read_text().splitlines()


def test_every_golden_stream_has_a_case():
    assert len(streams.FILE.read_text().splitlines()) == len(streams.CASES)
