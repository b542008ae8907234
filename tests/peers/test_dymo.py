"""DYMO LabelWriter streams of CUPS's filter through our decoder."""

from __future__ import annotations

import os
import subprocess

import pytest

from devices.errors import ProtocolError
from devices.languages.dymo import Dymo
from tests.peers.places import file, program
from tests.peers.test_pcl import PAGES, PPD, drawn, same_ink

pytestmark = pytest.mark.peer


def rastertolabel(tmp_path, darkness: int) -> bytes:
    """Its stream of the two pages; darkness : 0 … 3, light to dark."""
    (tmp_path / "label.ps").write_text(PAGES)
    raster, ppd = tmp_path / "label.ras", tmp_path / "label.ppd"
    ppd.write_text(PPD + "*cupsModelNumber: 0\n")
    settings = ["-q", "-dNOPAUSE", "-dBATCH", "-dSAFER", "-r300", "-sDEVICE=cups"]
    settings += ["-dcupsBitsPerColor=1", "-dcupsColorSpace=3", f"-dcupsCompression={darkness}"]
    subprocess.run(
        [program("gs"), *settings, f"-sOutputFile={raster}", str(tmp_path / "label.ps")], check=True
    )
    done = subprocess.run(
        [file("/usr/lib/cups/filter/rastertolabel"), "1", "user", "title", "1", "", str(raster)],
        capture_output=True, check=True, env=os.environ | {"PPD": str(ppd)},
    )  # fmt: skip
    return done.stdout


@pytest.mark.parametrize("darkness", [0, 1, 2])
def test_rastertolabel(darkness, tmp_path):
    wanted = drawn(tmp_path)
    made = rastertolabel(tmp_path, darkness)
    frames = Dymo.decode(made)
    assert len(frames) == len(wanted) == 2
    for frame, picture in zip(frames, wanted, strict=True):
        same_ink(frame.indices, picture)
        assert frame.report["density"] == darkness + 1
    assert Dymo.sniff(made[:1024])


def test_rastertolabel_sends_no_command_for_the_darkest(tmp_path):
    """It counts on from c, d, e to ESC f, which skips rows and takes the next commands for numbers."""
    with pytest.raises(ProtocolError) as caught:
        Dymo.decode(rastertolabel(tmp_path, 3))
    assert caught.value.offset == 111
