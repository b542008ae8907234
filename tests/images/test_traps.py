"""Traps of the reader we use: alpha that is not said, PNM rounding, sizes decoded too early."""

from __future__ import annotations

import io
import zlib

import numpy as np
import pytest
from PIL import Image

import halftone
from halftone import InputFileError
from halftone.images.headers import declared_size, exact_pnm
from halftone.tone import encoding


@pytest.mark.parametrize("ending", ["png", "bmp", "dds", "jp2", "tga", "webp", "tif", "ico", "sgi"])
def test_straight_alpha_in_every_format(ending, tmp_path):
    """(200, 100, 50) at alpha 128 over white, in light; lossy formats within a code or two."""
    picture = Image.new("RGBA", (16, 16), (200, 100, 50, 128))
    path = tmp_path / f"a.{ending}"
    picture.save(path, **({"lossless": True} if ending == "webp" else {}))
    light = encoding("srgb").decode(np.array([200, 100, 50]) / 255) * (128 / 255) + 127 / 255
    np.testing.assert_allclose(halftone.read(path)[8, 8], light, atol=0.01)


@pytest.mark.parametrize("maxval", [1, 2, 3, 4, 5, 7, 15, 100, 254, 255, 256, 1000, 4095, 65534, 65535])
@pytest.mark.parametrize("kind", [b"P2", b"P5"])
def test_pgm_of_any_maxval(maxval, kind, tmp_path):
    values = np.unique(np.linspace(0, maxval, 64).astype(int))
    head = kind + b"\n# a comment\n%d 1\n%d\n" % (values.size, maxval)
    if kind == b"P2":
        body = b" ".join(b"%d" % v for v in values) + b"\n"
    else:
        body = values.astype(">u1" if maxval < 256 else ">u2").tobytes()
    (tmp_path / "a.pgm").write_bytes(head + body)
    light = halftone.read(tmp_path / "a.pgm", encoding="linear")
    np.testing.assert_allclose(light[0], values / maxval, atol=0.51 / 65535)


@pytest.mark.parametrize("n", range(2, 40))
def test_our_pgm_comes_back_as_it_was(n, tmp_path):
    indices = np.arange(n, dtype=np.float32)[None].repeat(3, axis=0)
    levels = encoding("srgb").table(n)
    frame = halftone.dither(levels[indices.astype(int)], "none", levels=n)
    frame.save(tmp_path / "a.pgm")
    np.testing.assert_array_equal(halftone.convert(tmp_path / "a.pgm", levels=n, method="fs"), frame)


def test_sizes_that_files_declare():
    def file(kind: str, size: tuple[int, int]) -> bytes:
        data = io.BytesIO()
        Image.new("L", size, 7).save(data, kind)
        return data.getvalue()[:4096]

    assert declared_size(file("GIF", (321, 123))) == (321, 123)
    assert declared_size(file("JPEG2000", (321, 123))) == (321, 123)
    raw = io.BytesIO()
    Image.new("L", (77, 99), 7).save(raw, "JPEG2000", no_jp2=True)
    assert declared_size(raw.getvalue()) == (77, 99)
    assert declared_size(file("PNG", (5, 5))) is None
    assert declared_size(b"") is None


@pytest.mark.parametrize("ending", ["gif", "jp2"])
def test_a_huge_picture_is_refused_before_it_is_decoded(ending, tmp_path):
    Image.new("L", (6000, 6000), 7).save(tmp_path / f"a.{ending}")
    with pytest.raises(InputFileError, match="6000 × 6000"):
        halftone.read(tmp_path / f"a.{ending}", max_memory=50 << 20)


def test_other_formats_are_left_alone(tmp_path):
    (tmp_path / "x").write_bytes(zlib.compress(b"nothing"))
    pixels = np.arange(4, dtype=np.uint8)
    assert exact_pnm(pixels, str(tmp_path / "x")) is pixels
