"""TSPL against labelize, which renders it and writes it."""

from __future__ import annotations

import subprocess

import numpy as np
import pytest
from PIL import Image

from devices.languages.tspl import Tspl
from tests.devices.languages import contract
from tests.peers.places import program

pytestmark = pytest.mark.peer

PICTURE = np.random.default_rng(5).integers(0, 2, (300, 203)).astype(np.uint8)


@pytest.mark.parametrize("unit", ["dot", "mm"])
def test_labelize_shows_our_dots(unit, tmp_path):
    source, shown = tmp_path / "ours.tspl", tmp_path / "shown.png"
    source.write_bytes(contract.stream(Tspl(unit), PICTURE, dpi=(203.2, 203.2)))
    subprocess.run([program("labelize"), "convert", source, "-o", shown], check=True, timeout=60)
    dots = (np.array(Image.open(shown).convert("L")) > 127).astype(np.uint8)
    height, width = PICTURE.shape
    np.testing.assert_array_equal(dots[:height, :width], PICTURE)
    assert dots[height:].all()
    assert dots[:, width:].all()


def test_labelizes_stream_is_read(tmp_path):
    source, made = tmp_path / "p.png", tmp_path / "p.tspl"
    Image.fromarray(PICTURE * np.uint8(255)).save(source)
    subprocess.run([program("labelize"), "encode", source, "-o", made], check=True, timeout=60)
    (frame,) = Tspl.decode(made.read_bytes())
    height, width = PICTURE.shape
    assert frame.shape == (height, -(-width // 8) * 8)
    np.testing.assert_array_equal(frame.indices[:, :width], PICTURE)
    assert frame.indices[:, width:].all()
