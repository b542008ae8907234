"""Screens of ImageMagick and netpbm, from the programs themselves: the same dots for each number."""

from __future__ import annotations

import shutil
import subprocess

import numpy as np
import pytest

from halftone.dithering.screened import screen
from halftone.screens.named import NAMES
from tests.peers.test_files import pnm

pytestmark = pytest.mark.peer


def flats(n: int) -> bytes:
    """A PGM of 256 tiles of n × n pixels, one for each gray."""
    row = np.repeat(np.arange(256, dtype=np.uint8), n)
    return b"P5\n%d %d\n255\n" % (256 * n, n) + np.tile(row, n).tobytes()


def same_dots(ours: np.ndarray, theirs: np.ndarray) -> int:
    """How many different patterns were compared; each must be our lowest thresholds."""
    n = ours.shape[0]
    seen = set()
    for k in range(256):
        tile = theirs[:, k * n : (k + 1) * n] > 0
        count = int(tile.sum())
        order = np.sort(ours.ravel())
        if 0 < count < n * n and order[count - 1] < order[count]:
            np.testing.assert_array_equal(tile, ours <= order[count - 1])
            seen.add(count)
    return len(seen)


@pytest.mark.parametrize("name", [n for n in NAMES if not n.startswith("cluster")])
def test_imagemagick(name):
    program = "magick" if shutil.which("magick") else "convert"
    if shutil.which("identify") is None:
        pytest.skip("imagemagick is not installed (tests/peers/install.sh installs it)")
    ours = screen(name).thresholds
    done = subprocess.run(
        [program, "pgm:-", "-ordered-dither", name, "-depth", "8", "gray:-"],
        input=flats(ours.shape[0]),
        capture_output=True,
        check=True,
    )
    theirs = np.frombuffer(done.stdout, np.uint8).reshape(ours.shape[0], -1)
    assert same_dots(ours, theirs) >= min(np.unique(ours).size - 1, 100)


@pytest.mark.parametrize("name", ["cluster3", "cluster4", "cluster8"])
def test_netpbm(name):
    if shutil.which("pamditherbw") is None:
        pytest.skip("netpbm is not installed (tests/peers/install.sh installs it)")
    ours = screen(name).thresholds
    dithered = subprocess.run(
        ["pamditherbw", f"-{name}"], input=flats(ours.shape[0]), capture_output=True, check=True
    )
    plain = subprocess.run(["pamtopnm"], input=dithered.stdout, capture_output=True, check=True)
    assert same_dots(ours, pnm(plain.stdout)) >= 8
