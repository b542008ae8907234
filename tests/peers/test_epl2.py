"""EPL2 against CUPS and LPrint, whose streams ours reads. labelize shows GW inverted, so it is no judge
of it: both real encoders say that 0 burns a dot."""

from __future__ import annotations

import os
import subprocess

import numpy as np
import pytest
from PIL import Image

from devices.languages.epl2 import Epl2
from tests.devices.languages import contract
from tests.devices.simulated_zpl import SimulatedZpl
from tests.peers.places import file, program
from tests.peers.test_zpl import awkward, listening, lprint_server, raster, until

pytestmark = pytest.mark.peer


def test_cups_rastertolabel_is_read(tmp_path):
    label = file("/usr/lib/cups/filter/rastertolabel")
    drivers = file("/usr/share/cups/drv/sample.drv")
    subprocess.run([program("ppdc"), "-d", tmp_path, drivers], check=True, capture_output=True)
    pictures = [awkward(), awkward()[60:]]
    path = tmp_path / "job.ras"
    path.write_bytes(raster(pictures, density=50))
    environment = {**os.environ, "PPD": str(tmp_path / "zebraep2.ppd")}
    command = [label, "1", "user", "title", "1", "zePrintRate=4", path]
    done = subprocess.run(command, env=environment, capture_output=True, check=True, timeout=60)
    assert Epl2.sniff(done.stdout)
    for frame, picture in zip(Epl2.decode(done.stdout), pictures, strict=True):
        width = picture.shape[1]
        np.testing.assert_array_equal(frame.indices[:, :width], picture)
        assert frame.indices[:, width:].all()
        assert frame.report.items() >= {"density": 7, "speed": 4}.items()


def test_lprint_is_read(tmp_path):
    program("dbus-run-session")
    picture = awkward()
    page = tmp_path / "page.pwg"
    page.write_bytes(raster([picture], pwg=True))
    printer = SimulatedZpl()  # takes the bytes; nothing is asked
    with listening(printer) as port, lprint_server(tmp_path) as lprint:
        device = f"socket://127.0.0.1:{port}"
        added = lprint("add", "-d", "epl", "-v", device, "-m", "epl2_4inch-203dpi-dt")
        assert added.returncode == 0, added.stderr
        sent = lprint(
            "submit", "-o", "document-format=image/pwg-raster", str(page), path="ipp/print/epl"
        )
        assert sent.returncode == 0, sent.stderr
        until(lambda: printer.received.endswith(b"\nP1\n"), "the page")
        stream = bytes(printer.received)
    assert Epl2.sniff(stream)
    (frame,) = Epl2.decode(stream)
    height, width = picture.shape
    np.testing.assert_array_equal(frame.indices[:height, :width], picture)
    assert frame.indices[:, width:].all()


def test_labelize_shows_our_dots_inverted(tmp_path):
    """A known fault of labelize 1.10 (see above): a fixed labelize will show them as they are."""
    picture = awkward()
    source, shown = tmp_path / "ours.epl", tmp_path / "shown.png"
    source.write_bytes(contract.stream(Epl2(), picture))
    size = [str(n / 8) for n in reversed(picture.shape)]
    convert = [program("labelize"), "convert", source, "-o", shown, "--dpmm", "8"]
    subprocess.run([*convert, "--width", size[0], "--height", size[1]], check=True, timeout=60)
    dots = (np.array(Image.open(shown).convert("L")) > 127).astype(np.uint8)
    dots = dots[: picture.shape[0], : picture.shape[1]]
    assert np.array_equal(dots, picture) or np.array_equal(dots, 1 - picture)
