"""brother_ql 0.9.4: its labels through our decoder, and ours through its reader, pixel by pixel."""

from __future__ import annotations

import importlib.util
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

from devices.errors import ProtocolError
from devices.languages.brother_ql import MEDIA, PINS, BrotherQl
from tests.devices.languages import contract

pytestmark = pytest.mark.peer

DPI = (300.0, 300.0)
CREATE = "from brother_ql.brother_ql_create import main; main()"
ANALYSE = "from brother_ql.brother_ql_analyse import main; main()"
CONVERT = """
import sys
from brother_ql.raster import BrotherQLRaster
from brother_ql.conversion import convert
sys.stdout.buffer.write(convert(BrotherQLRaster("QL-820NWB"), sys.argv[1:], "62", compress=True))
"""


def run(code: str, *arguments: str, folder) -> bytes:
    """A command of brother_ql in this Python; its notices of old names are let pass."""
    if importlib.util.find_spec("brother_ql") is None:
        pytest.skip("brother_ql is not installed (tests/peers/install.sh installs it)")
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code, *arguments],
        capture_output=True, check=False, cwd=folder,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr.decode()
    return done.stdout


def drawing(height: int, width: int) -> np.ndarray:
    rng = np.random.default_rng(7)
    picture = (rng.random((height, width)) < np.linspace(0, 1, width)).astype(np.uint8)
    picture[height // 3 : height // 2] = 1
    picture[:, :3] = picture[0] = 0
    return picture


def save(picture: np.ndarray, path) -> str:
    Image.fromarray(picture * np.uint8(255)).save(path)
    return str(path)


@pytest.mark.parametrize("compress", [(), ("--compress",)])
@pytest.mark.parametrize("cut", [(), ("--no-cut",)])
@pytest.mark.parametrize(
    ("model", "media"),
    [("QL-820NWB", (62, 0)), ("QL-580N", (29, 90)), ("QL-710W", (12, 12)), ("QL-1050", (102, 51)),
     ("QL-1060N", (62, 0)), ("QL-720NW", (12, 0))],
)  # fmt: skip
def test_its_labels_are_read(model, media, compress, cut, tmp_path):
    window = MEDIA[media]
    picture = drawing(window.rows or 300, window.dots)
    label = "d12" if media == (12, 12) else f"{media[0]}x{media[1]}" if media[1] else str(media[0])
    source = save(picture, tmp_path / "a.png")
    options = ["-m", model, "-s", label, "-r", "0", *compress, *cut]
    made = run(CREATE, *options, source, folder=tmp_path)
    (frame,) = BrotherQl.decode(made)
    np.testing.assert_array_equal(frame.indices, picture)
    assert frame.dpi == DPI
    assert frame.report["cut"] == (not cut)
    assert BrotherQl.sniff(made[:1024])


def test_models_without_any_option(tmp_path):
    picture = drawing(200, 696)
    source = save(picture, tmp_path / "a.png")
    (frame,) = BrotherQl.decode(run(CREATE, "-m", "QL-500", "--no-cut", source, folder=tmp_path))
    np.testing.assert_array_equal(frame.indices, picture)


def test_its_jobs_of_two_labels_are_read(tmp_path):
    pictures = [drawing(200, 696), drawing(300, 696)[::-1]]
    sources = [save(picture, tmp_path / f"{n}.png") for n, picture in enumerate(pictures)]
    frames = BrotherQl.decode(run(CONVERT, *sources, folder=tmp_path))
    for frame, picture in zip(frames, pictures, strict=True):
        np.testing.assert_array_equal(frame.indices, picture)


def test_its_labels_in_two_colours_are_refused(tmp_path):
    colour = np.repeat(drawing(200, 696)[..., None] * np.uint8(255), 3, axis=2)
    Image.fromarray(colour).save(tmp_path / "a.png")
    made = run(CREATE, "-m", "QL-800", "-s", "62red", "--red", "a.png", folder=tmp_path)
    with pytest.raises(ProtocolError, match="two colours are not read"):
        BrotherQl.decode(made)


@pytest.mark.parametrize("compress", [False, True])
@pytest.mark.parametrize(
    ("media", "pins"), [("62", 720), ("62", 1296), ("29x90", 720), ("102", 1296), ("12x12", 720)]
)
def test_it_reads_our_labels(media, pins, compress, tmp_path):
    width, _, length = media.partition("x")
    window = MEDIA[int(width), int(length or 0)]
    pictures = [drawing(window.rows or 300, window.dots)]
    pictures.append(pictures[0][::-1].copy())
    language = BrotherQl(media, pins, compress=compress)
    (tmp_path / "a.bin").write_bytes(contract.stream(language, pictures[0], dpi=DPI, cut=True))
    run(ANALYSE, "a.bin", folder=tmp_path)
    made = np.asarray(Image.open(tmp_path / "label0001.png").convert("L"))
    stop = pins - window.offset - PINS[pins]
    assert made.shape == (len(pictures[0]), pins)
    np.testing.assert_array_equal(made[:, stop - window.dots : stop], pictures[0] * np.uint8(255))
    made = np.delete(made, slice(stop - window.dots, stop), axis=1)
    assert (made == 255).all()


def test_our_bytes_are_its_bytes(tmp_path):
    """But for the zeros before the job, the mode set before them, and the question for status."""
    picture = drawing(300, 696)
    source = save(picture, tmp_path / "a.png")
    theirs = run(CREATE, "-m", "QL-820NWB", source, folder=tmp_path)
    ours = contract.stream(BrotherQl(invalidate=200), picture, dpi=DPI, cut=True)
    assert b"\x1bia\x01" + ours.replace(b"\x1bia\x01", b"\x1bia\x01\x1biS", 1) == theirs
