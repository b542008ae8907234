"""Other people's readers on the files we write: netpbm, libtiff, pngcheck, ImageMagick."""

from __future__ import annotations

import shutil
import subprocess

import numpy as np
import pytest

import halftone

pytestmark = pytest.mark.peer

LEVELS = [2, 3, 4, 16, 256, "log:0.02:4", "lstar:11"]


def run(program: str, *arguments: str, **options) -> bytes:
    if shutil.which(program) is None:
        pytest.skip(f"{program} is not installed (tests/peers/install.sh installs it)")
    done = subprocess.run([program, *arguments], capture_output=True, check=False, **options)
    assert done.returncode == 0, done.stderr.decode()
    assert b"arning" not in done.stderr, done.stderr.decode()
    return done.stdout


def frame(levels, width: int = 61) -> halftone.Frame:
    ramp = np.tile(np.linspace(0, 1, width, dtype=np.float32), (23, 1))
    return halftone.dither(ramp, "stucki", levels=levels)


def pnm(data: bytes) -> np.ndarray:
    """A P4 or P5 file as gray codes 0 … 255."""
    kind, rest = data.split(b"\n", 1)
    width, height = (int(v) for v in rest.split(b"\n", 1)[0].split())
    body = rest.split(b"\n", 1)[1]
    if kind == b"P4":
        rows = np.frombuffer(body, np.uint8).reshape(height, -1)
        return (1 - np.unpackbits(rows, axis=1, count=width)) * np.uint8(255)
    top, body = body.split(b"\n", 1)
    codes = np.frombuffer(body, np.uint8).reshape(height, width)
    return np.rint(codes * 255.0 / int(top)).astype(np.uint8)


@pytest.mark.parametrize("levels", LEVELS, ids=str)
def test_netpbm_reads_our_png(levels, tmp_path):
    made = frame(levels)
    made.save(tmp_path / "a.png")
    gray = run("ppmtopgm", input=run("pngtopam", str(tmp_path / "a.png")))
    assert np.abs(pnm(gray).astype(int) - made.preview()).max() <= 1  # ppmtopgm weighs R, G, B


@pytest.mark.parametrize("levels", LEVELS, ids=str)
def test_pngcheck_accepts_our_png(levels, tmp_path):
    frame(levels).save(tmp_path / "a.png")
    assert run("pngcheck", str(tmp_path / "a.png")).startswith(b"OK")


@pytest.mark.parametrize("levels", LEVELS, ids=str)
def test_libtiff_reads_our_tiff(levels, tmp_path):
    made = frame(levels)
    made.save(tmp_path / "a.tiff")
    said = run("tiffinfo", str(tmp_path / "a.tiff")).decode()
    assert f"Bits/Sample: {made.levels.bits}" in said
    assert "Image Width: 61 Image Length: 23" in said
    run("tiff2rgba", str(tmp_path / "a.tiff"), str(tmp_path / "b.tiff"))
    light = halftone.read(tmp_path / "b.tiff")
    np.testing.assert_allclose(
        light[:, :, 0], halftone.read(tmp_path / "a.tiff").reshape(23, 61, -1)[:, :, 0], atol=1e-6
    )


@pytest.mark.parametrize("format", ["pbm", "pgm"])
def test_netpbm_reads_our_pnm(format, tmp_path):
    made = frame(2)
    made.save(tmp_path / f"a.{format}")
    said = run("pamfile", str(tmp_path / f"a.{format}")).decode()
    assert "61 by 23" in said
    flipped = run("pamflip", "-lr", str(tmp_path / f"a.{format}"))
    np.testing.assert_array_equal(pnm(flipped)[:, ::-1], made.preview())


@pytest.mark.parametrize("levels", LEVELS, ids=str)
@pytest.mark.parametrize("format", ["png", "tiff", "pgm"])
def test_imagemagick_shows_the_same_codes(levels, format, tmp_path):
    made = frame(levels)
    made.save(tmp_path / f"a.{format}")
    name = str(tmp_path / f"a.{format}")
    program = "magick" if shutil.which("magick") else "convert"
    if shutil.which("identify") is None:
        pytest.skip("imagemagick is not installed (tests/peers/install.sh installs it)")
    gray = run(program, name, "-depth", "8", "gray:-")
    shown = np.frombuffer(gray, np.uint8).reshape(23, 61).astype(int)
    # A PGM of n levels holds k/(n−1), whose half codes are rounded one way or the other.
    half = format == "pgm" and 255 % (len(made.levels) - 1)
    assert np.abs(shown - made.preview()).max() <= (1 if half else 0)


def test_floyd_steinberg_agrees_with_netpbm_in_tone(tmp_path):
    """pamditherbw -fs works in BT.709 light; both must keep the mean light of a flat patch."""
    for code in (30, 90, 160, 220):
        data = b"P5\n256 256\n255\n" + bytes([code]) * 65536
        theirs = pnm(run("pamtopnm", input=run("pamditherbw", "-fs", "-randomseed=1", input=data)))
        codes = np.full((256, 256), code, np.uint8)
        ours = halftone.dither(codes, "fs", encoding="bt709")
        assert abs(ours.indices.mean() - (theirs > 0).mean()) < 0.006
