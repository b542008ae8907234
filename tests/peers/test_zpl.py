"""ZPL against real programs: two renderers read ours, four encoders are read by ours, LPrint asks our
simulated printer."""

from __future__ import annotations

import binascii
import json
import os
import re
import signal
import socket
import struct
import subprocess
import threading
import time
from contextlib import contextmanager

import numpy as np
import pytest
from PIL import Image

from devices.languages.zpl import COMPRESSIONS, Zpl
from devices.status import Status
from halftone import dither
from tests.devices.languages import contract
from tests.devices.simulated_zpl import SimulatedZpl
from tests.peers.places import file, npm, program

pytestmark = pytest.mark.peer

DPMM = 8


def halftone_of(method: str, width: int = 576, height: int = 240) -> np.ndarray:
    """A ramp within margins of paper and a bar of ink, as level indices."""
    y, x = np.mgrid[0:height, 0:width]
    light = (0.7 * x / width + 0.3 * y / height).astype(np.float32)
    light[:, :37] = light[:, -21:] = light[:30] = 1
    light[60:80, 100:] = 0
    return np.ascontiguousarray(dither(light, method).indices)


def awkward() -> np.ndarray:
    """Noise 203 wide (no multiple of 8) with repeated rows, blank and full rows, long runs."""
    picture = np.random.default_rng(3).integers(0, 2, (120, 203)).astype(np.uint8)
    picture[20:30] = 1
    picture[40:50] = picture[40]
    picture[60:70] = 0
    picture[:, 150:] = 1
    picture[80:90, 100:] = 0
    return picture


PICTURES = {"fs": halftone_of("fs"), "bayer8": halftone_of("bayer8"), "awkward": awkward()}
cases = pytest.mark.parametrize("name", PICTURES)


def node(source: str, package: str, *arguments: str) -> str:
    """What a script prints, run where node finds *package*."""
    folder = npm(package)
    done = subprocess.run(
        [program("node"), "-e", source, *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr[:500]
    return done.stdout


def same_dots(path, picture: np.ndarray) -> None:
    """A rendering is the picture; renderers may make it a dot wider or higher than asked."""
    shown = (np.array(Image.open(path).convert("L")) > 127).astype(np.uint8)
    height, width = picture.shape
    assert height <= shown.shape[0] <= height + 1
    assert width <= shown.shape[1] <= width + 1
    np.testing.assert_array_equal(shown[:height, :width], picture)
    assert shown[height:].all()
    assert shown[:, width:].all()


# --- renderers read ours -----------------------------------------------------------------------


@cases
@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_labelize_shows_our_dots(name, compression, tmp_path):
    picture = PICTURES[name]
    source, shown = tmp_path / "ours.zpl", tmp_path / "shown.png"
    source.write_bytes(contract.stream(Zpl(compression, 4000), picture))
    size = [str(n / DPMM) for n in reversed(picture.shape)]
    convert = [program("labelize"), "convert", source, "-o", shown, "--dpmm", str(DPMM)]
    subprocess.run([*convert, "--width", size[0], "--height", size[1]], check=True, timeout=60)
    same_dots(shown, picture)


RENDER = """
const fs = require('fs');
require('zpl-renderer-js').ready.then(async ({api}) => {
  for (const [from, to, width, height] of JSON.parse(process.argv[1])) {
    const shown = await api.zplToBase64Async(fs.readFileSync(from, 'latin1'), width, height, 8);
    fs.writeFileSync(to, Buffer.from(shown, 'base64'));
  }
  process.exit(0);
}).catch(error => { console.error(String(error).slice(0, 400)); process.exit(1); });
"""


def test_zpl_renderer_js_shows_our_dots(tmp_path):
    jobs = []
    for name, picture in PICTURES.items():
        for compression in COMPRESSIONS:
            source = tmp_path / f"{name}-{compression}.zpl"
            source.write_bytes(contract.stream(Zpl(compression, 4000), picture))
            height, width = picture.shape
            jobs.append((f"{source}", f"{source}.png", width / DPMM, height / DPMM))
    node(RENDER, "zpl-renderer-js", json.dumps(jobs))
    for (_, shown, _, _), picture in zip(
        jobs, np.repeat(list(PICTURES), len(COMPRESSIONS)), strict=True
    ):
        same_dots(shown, PICTURES[picture])


def test_labelize_shows_a_job_that_was_broken_off(tmp_path):
    """Rows that were not begun are paper there too."""
    picture = PICTURES["awkward"]
    for compression in ("acs", "hex"):
        made = contract.pieces(Zpl(compression), picture)
        part = len(made[1].data) // 2
        source, shown = tmp_path / "ours.zpl", tmp_path / f"{compression}.png"
        source.write_bytes(made[0].data + made[1].data[:part] + made[1].abort(part))
        size = [str(n / DPMM) for n in reversed(picture.shape)]
        convert = [program("labelize"), "convert", source, "-o", shown, "--dpmm", str(DPMM)]
        subprocess.run([*convert, "--width", size[0], "--height", size[1]], check=True, timeout=60)
        expected = picture.copy()
        expected[made[1].accepted(part) + 1 :] = 1
        same_dots(shown, expected)


# --- ours reads encoders -----------------------------------------------------------------------


ENCODE = """
const zpl = require('zpl-image'), fs = require('fs');
const [path, width] = [process.argv[1], Number(process.argv[2])];
const rgba = fs.readFileSync(path);
const a = zpl.rgbaToACS(rgba, width, {notrim: true}), z = zpl.rgbaToZ64(rgba, width, {notrim: true});
console.log(JSON.stringify({total: a.length, size: a.rowlen, acs: a.acs, z64: z.z64}));
"""


def zpl_image(picture: np.ndarray, folder) -> dict[str, str]:
    gray = np.repeat((picture * 255)[:, :, None], 4, axis=2)
    gray[:, :, 3] = 255
    path = folder / "rgba"
    path.write_bytes(gray.tobytes())
    return json.loads(node(ENCODE, "zpl-image", str(path), str(picture.shape[1])))


def data_of(compression: str, picture: np.ndarray) -> bytes:
    """Our data of a picture as one field."""
    (piece,) = contract.pieces(Zpl(compression, 99_999), picture)[1:-1]
    return piece.data[piece.head : -len(b"^FS\n")]


@cases
def test_zpl_image_is_read(name, tmp_path):
    """Its counts go on from row to row, which ours do not: that may save it two characters a row."""
    picture = PICTURES[name]
    theirs = zpl_image(picture, tmp_path)
    height, width = picture.shape
    for compression in ("acs", "z64"):
        label = (
            f"^XA^PW{width}^LL{height}^FO0,0^GFA,{theirs['total']},{theirs['total']},{theirs['size']},"
        )
        (frame,) = Zpl.decode(f"{label}{theirs[compression]}^FS^XZ".encode())
        np.testing.assert_array_equal(frame.indices, picture)
    assert len(data_of("acs", picture)) <= len(theirs["acs"]) + 2 * height
    text, crc = theirs["z64"][5:-5], theirs["z64"][-4:].upper()
    assert f"{binascii.crc_hqx(text.encode(), 0):04X}" == crc


@cases
def test_zplgrf_is_read_and_reads_ours(name):
    grf = pytest.importorskip("zplgrf", reason="zplgrf is not installed (tests/peers/install.sh)")
    picture = PICTURES[name]
    rows = np.packbits(picture == 0, axis=1)
    width = picture.shape[1]
    theirs = grf.GRF("PICTURE", grf.GRFData(rows.shape[1], bytes=rows.tobytes()))
    for compression in (1, 2, 3):
        label = theirs.to_zpl(compression=compression, quantity=2)
        (frame,) = Zpl.decode(label.replace("^XA", f"^XA^PW{width}", 1).encode())
        np.testing.assert_array_equal(frame.indices, picture)
        assert frame.report["copies"] == 2
    assert len(data_of("acs", picture)) <= len(theirs.to_zpl_line(compression=2).split(",", 3)[3])
    for compression in ("hex", "z64"):
        ours = data_of(compression, picture).decode()
        read = grf.GRF.from_zpl_line(f"~DGR:OURS.GRF,{rows.size},{rows.shape[1]},{ours}")
        assert read.data.bytes == rows.tobytes()
        if compression == "z64":
            assert theirs._calc_crc(ours[5:-5].encode()) == ours[-4:]


@cases
def test_labelize_encode_is_read(name, tmp_path):
    picture = PICTURES[name]
    source, made = tmp_path / "p.png", tmp_path / "p.zpl"
    Image.fromarray(picture * np.uint8(255)).save(source)
    subprocess.run([program("labelize"), "encode", source, "-o", made], check=True, timeout=60)
    stream = made.read_bytes()
    (frame,) = Zpl.decode(stream.replace(b"^XA", b"^XA^PW%d" % picture.shape[1]))
    np.testing.assert_array_equal(frame.indices, picture)
    assert len(data_of("acs", picture)) < len(re.sub(rb"\s", b"", stream))


def raster(pictures: list[np.ndarray], pwg: bool = False, copies: int = 1, density: int = 0) -> bytes:
    """A CUPS raster stream, not compressed, or a PWG raster stream (PWG 5102.4): 1 bit, 1 = black."""
    stream = b"RaS2" if pwg else b"RaS3"
    for picture in pictures:
        rows = np.packbits(picture == 0, axis=1)
        height, width = picture.shape
        words = [0] * 42
        words[5] = words[6] = 203
        words[21], words[24], words[25] = copies, round(width * 72 / 203), round(height * 72 / 203)
        words[29], words[30], words[32], words[33], words[34] = width, height, 1, 1, rows.shape[1]
        words[36], words[37] = 3, density
        if pwg:
            words[41] = 1  # colours
        else:
            words[0], words[40] = 1000, 200  # tear-off and label top as they are set
        head = (b"PwgRaster" if pwg else b"").ljust(256, b"\0") + struct.pack(">42I", *words)
        stream += head.ljust(1796, b"\0")
        for row in rows:
            stream += row.tobytes() if not pwg else b"\0" + literals(row.tobytes())
    return stream


def literals(row: bytes) -> bytes:
    """A row for PWG raster, not compressed."""
    cut = [row[i : i + 128] for i in range(0, len(row), 128)]
    return b"".join((bytes([257 - len(c)]) if len(c) > 1 else b"\0") + c for c in cut)


def test_cups_rastertolabel_is_read(tmp_path):
    label = file("/usr/lib/cups/filter/rastertolabel")
    drivers = file("/usr/share/cups/drv/sample.drv")
    subprocess.run([program("ppdc"), "-d", tmp_path, drivers], check=True, capture_output=True)
    pictures = [PICTURES["awkward"], PICTURES["fs"]]
    path = tmp_path / "job.ras"
    path.write_bytes(raster(pictures, copies=3, density=50))
    for options, report in (
        ("zeMediaTracking=Continuous zePrintRate=4", {"media": "N", "speed": 4}),
        ("zeMediaTracking=Web zePrintMode=Cutter zeErrorReprint=Always", {"media": "Y", "mode": "C"}),
    ):
        environment = {**os.environ, "PPD": str(tmp_path / "zebra.ppd")}
        command = [label, "1", "user", "title", "1", options, path]
        done = subprocess.run(command, env=environment, capture_output=True, check=True, timeout=60)
        frames = Zpl.decode(done.stdout)
        assert Zpl.sniff(done.stdout)
        sent = re.findall(rb"~DG[^,]*,\d+,\d+,\n([^^]*)", done.stdout)
        for frame, picture, data in zip(frames, pictures, sent, strict=True):
            assert len(data_of("acs", picture)) <= len(data)
            np.testing.assert_array_equal(frame.indices, picture)
            assert frame.report.items() >= (report | {"copies": 3, "density": 15}).items()


# --- LPrint ------------------------------------------------------------------------------------


@contextmanager
def listening(printer: SimulatedZpl):
    """The printer on a port of this machine; gives the port."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def talk(connection: socket.socket) -> None:
            with connection:
                while data := connection.recv(1 << 16):
                    connection.sendall(printer(data))

        def serve() -> None:
            while True:
                try:
                    connection, _ = server.accept()
                except OSError:
                    return
                threading.Thread(target=talk, args=(connection,), daemon=True).start()

        threading.Thread(target=serve, daemon=True).start()
        try:
            yield server.getsockname()[1]
        finally:
            server.shutdown(socket.SHUT_RDWR)


@contextmanager
def lprint_server(folder):
    """LPrint's server on a free port with a bus and folders of its own; gives a function that runs
    ``lprint`` with it."""
    program("lprint")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    environment = {
        **os.environ,
        "HOME": str(folder),
        "TMPDIR": str(folder),
        "XDG_CONFIG_HOME": str(folder),
    }
    serve = (
        "DBUS_SYSTEM_BUS_ADDRESS=$DBUS_SESSION_BUS_ADDRESS exec lprint server"
        f" -o server-port={port} -o listen-hostname=localhost -o log-file={folder}/log"
    )
    server = subprocess.Popen(
        [program("dbus-run-session"), "--", "sh", "-c", serve],
        env=environment,
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )

    def run(command: str, *arguments: str, path: str = "") -> subprocess.CompletedProcess[str]:
        address = f"ipp://localhost:{port}/{path}"
        return subprocess.run(
            [program("lprint"), command, "-u", address, *arguments],
            env=environment,
            capture_output=True,
            text=True,
            timeout=20,
        )

    try:
        until(lambda: run("status").returncode == 0, "LPrint's server to start")
        yield run
    finally:
        os.killpg(server.pid, signal.SIGTERM)
        server.wait(20)


def until(done, what: str, seconds: float = 20) -> None:
    """Wait for *done*."""
    end = time.monotonic() + seconds
    while not done():
        assert time.monotonic() < end, f"waited {seconds} s for {what}"
        time.sleep(0.1)


def test_lprint_is_read_and_asks_our_simulated_printer(tmp_path):
    """LPrint passes bilevel pages on as they are, laid at the top left of the medium."""
    program("dbus-run-session")
    picture = PICTURES["awkward"]
    page = tmp_path / "page.pwg"
    page.write_bytes(raster([picture], pwg=True))
    printer = SimulatedZpl({"media_low"})
    with listening(printer) as port, lprint_server(tmp_path) as lprint:
        device = f"socket://127.0.0.1:{port}"
        added = lprint("add", "-d", "zpl", "-v", device, "-m", "zpl_4inch-203dpi-dt")
        assert added.returncode == 0, added.stderr
        options = ["-o", "document-format=image/pwg-raster"]
        sent = lprint("submit", *options, str(page), path="ipp/print/zpl")
        assert sent.returncode == 0, sent.stderr
        until(lambda: printer.received.endswith(b"^IDR:LPRINT.GRF^FS\n^XZ\n"), "the page")
        stream = bytes(printer.received)
    assert printer.asked[0] == "~HQES"
    assert Zpl.sniff(stream)
    (frame,) = Zpl.decode(stream)
    height, width = picture.shape
    np.testing.assert_array_equal(frame.indices[:height, :width], picture)
    assert frame.indices[height:].all()
    assert frame.indices[:, width:].all()
    assert frame.report.items() >= {"density": 15, "copies": 1, "orientation": "I"}.items()
    assert Zpl().parse_status(printer.errors()) == Status.of("media-low-warning")
