"""PWG raster, CUPS raster, URF and PNG against libcups, Ghostscript, the filters of CUPS, pngcheck and
Pillow: their files through our reader, ours through theirs."""

from __future__ import annotations

import os
import subprocess
from io import BytesIO

import numpy as np
import pytest

from devices.languages import language
from devices.languages.base import page_of
from devices.languages.raster_stream import pages
from halftone.frame import Frame
from halftone.packing import pack
from halftone.tone.levels import Levels
from tests.peers import libcups, places

pytestmark = pytest.mark.peer

RNG = np.random.default_rng(7)
LANGUAGES = {
    "pwg": language("pwg", quality=4, media="labels", page_size="om_x_30x30mm"),
    "2, low byte first": language("cups-raster", version=2, order="little"),
    "2, high byte first": language("cups-raster", version=2, order="big"),
    "3, low byte first": language("cups-raster", version=3, order="little"),
    "3, high byte first": language("cups-raster", version=3, order="big"),
    "urf": language("urf", quality=5),
}
MODES = {
    "pwg": libcups.WRITE_PWG,
    "2, low byte first": libcups.WRITE_COMPRESSED,
    "3, low byte first": libcups.WRITE,
    "urf": libcups.WRITE_APPLE,
}


def pictures(levels):
    """Noise, runs, blank lines, more than 256 equal lines, widths that are no multiple of 8."""
    noise = RNG.integers(0, levels, (40, 203)).astype(np.uint8)
    runs = np.repeat(RNG.integers(0, levels, (30, 40)), RNG.integers(1, 200, 40), axis=1)
    tall = np.repeat(RNG.integers(0, levels, (4, 77)), [1, 300, 600, 2], axis=0)
    blank = np.full((700, 576), levels - 1)
    return [np.ascontiguousarray(p, np.uint8) for p in (noise, runs, tall, blank)]


def ours(kind, levels, copies=1):
    """Our file of these pictures, the packed rows, and the headers we wrote."""
    made, frames = (
        LANGUAGES[kind],
        [Frame(p, Levels.of(levels), dpi=(300, 300)) for p in pictures(levels)],
    )
    packing = made.packing(Levels.of(levels))
    data = b"".join(
        piece.data for piece in made.encode(page_of(made, frame, copies=copies) for frame in frames)
    )
    return data, [pack(frame.indices, packing) for frame in frames]


@pytest.mark.parametrize("levels", [2, 256])
@pytest.mark.parametrize("kind", LANGUAGES)
def test_libcups_reads_ours(kind, levels, tmp_path):
    data, rows = ours(kind, levels, copies=1 if kind == "urf" else 3)
    path = tmp_path / "ours"
    path.write_bytes(data)
    theirs = libcups.read(path)
    assert len(theirs) == len(rows)
    for (header, got), wanted, page in zip(theirs, rows, pages(BytesIO(data).read), strict=True):
        np.testing.assert_array_equal(got, wanted)
        mine = dict(page.header)
        if kind == "urf":
            mine |= {"MediaType": "auto", "cupsPageSize": header["cupsPageSize"]}
            blank = {name: value for name, value in header.items() if name not in mine}
            assert not any(np.any(np.array(value, object)) for value in blank.values())
        for name, value in mine.items():
            assert header[name] == value, name


@pytest.mark.parametrize(
    ("kind", "space", "bits"),
    [
        (kind, space, bits)
        for kind in MODES
        for space, bits in ((3, 1), (0, 1), (3, 8), (0, 8), (18, 8), (19, 24), (1, 24))
        if kind != "urf" or (bits > 1 and space != 3)
    ],
)
def test_we_read_what_libcups_writes(kind, space, bits, tmp_path):
    given = []
    for width, height in ((203, 40), (64, 700), (1, 3)):
        size = (width * bits + 7) // 8
        rows = RNG.integers(0, 2, (height, size)).astype(np.uint8) * 255
        rows[height // 3 :] = rows[height // 3]
        if bits == 24:
            rows[:, 30:90] = 17
        header = {
            "cupsWidth": width,
            "cupsHeight": height,
            "cupsBitsPerColor": min(bits, 8),
            "cupsBitsPerPixel": bits,
            "cupsBytesPerLine": size,
            "cupsColorSpace": space,
            "cupsNumColors": 3 if bits == 24 else 1,
            "HWResolution": (300, 300),
            "PageSize": (width * 72 // 300, height * 72 // 300),
            "NumCopies": 5,
            "MediaType": "labels",
            "cupsInteger": (3, 1, 1, *[0] * 13),
        }
        if kind not in ("pwg", "urf"):
            header |= {"cupsReal": tuple(k / 2 for k in range(16)), "cupsString": ("text",) * 16}
            header |= {"cupsCompression": 7, "cupsRowCount": 24, "MediaClass": "class"}
        given.append((header, rows))
    data = libcups.write(tmp_path / "theirs", MODES[kind], given)
    count = 0
    for page, (header, rows) in zip(pages(BytesIO(data).read), given, strict=True):
        np.testing.assert_array_equal(np.concatenate(list(page.bands())), rows)
        for name, value in header.items():
            if kind == "urf" and name in ("NumCopies", "MediaType"):
                continue
            got = page.header[name]
            if name == "cupsInteger":
                got, value = got[:3], value[:3]
                if kind == "urf":
                    got, value = got[0], value[0]
            assert got == value, name
        count += 1
    assert count == len(given)


def test_libcups_blanks_the_rest_of_a_line_as_we_do(tmp_path):
    """Packet 128, which nobody here writes."""
    for kind, levels in (("pwg", 2), ("pwg", 256), ("urf", 256)):
        made = LANGUAGES[kind]
        frame = Frame(np.zeros((2, 80), np.uint8), Levels.of(levels), dpi=(300, 300))
        (piece,) = made.encode([page_of(made, frame)])
        head = piece.data[: 44 if kind == "urf" else 1800]
        path = tmp_path / "blank"
        path.write_bytes(head + b"\1\2\x11\x80")
        ((_, rows),) = libcups.read(path)
        (page,) = [np.concatenate(list(p.bands())) for p in pages(BytesIO(path.read_bytes()).read)]
        np.testing.assert_array_equal(page, rows)
        assert set(rows.ravel()) == {0x11, 0 if levels == 2 else 255}


def test_libcups_reads_a_broken_off_job(tmp_path):
    """A page that was broken off in its second piece has all its rows, the rest blank."""
    for kind in LANGUAGES:
        made = LANGUAGES[kind]
        picture = RNG.integers(0, 256, (3000, 203)).astype(np.uint8)
        frame = Frame(picture, Levels.of(256), dpi=(300, 300))
        first, second, *_ = made.encode([page_of(made, frame)])
        path = tmp_path / "broken"
        path.write_bytes(first.data + second.data[:1000] + second.abort(1000))
        ((_, rows),) = libcups.read(path)
        done = first.rows + second.rows
        np.testing.assert_array_equal(rows[:done], picture[:done])
        assert len(rows) == 3000
        assert (rows[done:] == 255).all()


PICTURES = """%!PS
<< /PageSize [101 80] >> setpagedevice
/Helvetica findfont 20 scalefont setfont 10 20 moveto (Hello) show 0 0 50 10 rectfill
.5 setgray 60 30 30 30 rectfill showpage
0 setgray 10 40 moveto (two) show showpage
"""


def ghostscript(path, device, *options):
    command = [places.program("gs"), "-q", "-dNOPAUSE", "-dBATCH", "-dSAFER", "-r144"]
    subprocess.run(
        [*command, f"-sDEVICE={device}", *options, f"-sOutputFile={path}", "-"],
        input=PICTURES.encode(),
        check=True,
        capture_output=True,
        timeout=60,
    )


@pytest.mark.parametrize(
    ("device", "bits", "space"),
    [
        (device, bits, space)
        for device in ("pwgraster", "cups", "urf")
        for bits, space in ((8, 0), (8, 18), (8, 19), (1, 3))
        if (device, bits) != ("urf", 1)
    ],
)
def test_pages_of_ghostscript(device, bits, space, tmp_path):
    """The same page as Ghostscript's own plain picture."""
    path, plain = tmp_path / "raster", tmp_path / "plain"
    ghostscript(path, device, f"-dcupsColorSpace={space}", f"-dcupsBitsPerColor={bits}")
    plain_device = "pbmraw" if bits == 1 else "ppmraw" if space == 19 else "pgmraw"
    ghostscript(f"{plain}%d", plain_device)
    from PIL import Image

    seen = []
    with open(path, "rb") as file:
        for page in pages(file.read):
            rows = np.concatenate(list(page.bands()))
            assert page.dpi == (144.0, 144.0)
            with Image.open(f"{plain}{len(seen) + 1}") as image:
                wanted = np.array(image.convert("L") if bits == 1 else image)
            if bits == 1:
                rows = 255 * (1 - np.unpackbits(rows, axis=1)[:, : page.width])
            np.testing.assert_array_equal(rows.reshape(wanted.shape), wanted)
            seen.append(wanted)
    assert len(seen) == 2
    assert (seen[0] != seen[1]).any()


def test_cups_makes_a_pdf_of_our_pwg_raster(tmp_path):
    """rastertopdf of cups-filters: what it takes, drawn by Ghostscript, is our page."""
    program = places.file("/usr/lib/cups/filter/rastertopdf")
    places.program("gs")
    picture = RNG.integers(0, 2, (150, 128)).astype(np.uint8)
    frame = Frame(picture, Levels.of(2), dpi=(72, 72))
    path, drawn = tmp_path / "ours.pwg", tmp_path / "drawn.pgm"
    path.write_bytes(b"".join(p.data for p in language("pwg").encode([page_of(language("pwg"), frame)])))
    environment = {
        **os.environ,
        "CONTENT_TYPE": "image/pwg-raster",
        "FINAL_CONTENT_TYPE": "application/pdf",
    }
    ran = subprocess.run(
        [program, "1", "user", "title", "1", "", str(path)],
        capture_output=True,
        timeout=60,
        env=environment,
    )
    assert ran.stdout.startswith(b"%PDF"), ran.stderr[-500:]
    (tmp_path / "page.pdf").write_bytes(ran.stdout)
    command = [places.program("gs"), "-q", "-dNOPAUSE", "-dBATCH", "-dSAFER", "-sDEVICE=pgmraw", "-r72"]
    subprocess.run(
        [*command, f"-sOutputFile={drawn}", str(tmp_path / "page.pdf")], check=True, timeout=60
    )
    from PIL import Image

    with Image.open(drawn) as image:
        np.testing.assert_array_equal(np.array(image) // 255, picture)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("levels", [2, 256])
def test_cups_makes_pwg_raster_of_our_cups_raster(levels, version, tmp_path):
    """rastertopwg of CUPS, there and back."""
    program = places.file("/usr/lib/cups/filter/rastertopwg")
    made = language("cups-raster", version=version)
    picture = RNG.integers(0, levels, (792, 612)).astype(np.uint8)
    frame = Frame(picture, Levels.of(levels), dpi=(72, 72))
    path = tmp_path / "ours"
    path.write_bytes(b"".join(piece.data for piece in made.encode([page_of(made, frame)])))
    environment = {**os.environ, "FINAL_CONTENT_TYPE": "image/pwg-raster"}
    ran = subprocess.run(
        [program, "1", "user", "title", "1", "", str(path)],
        capture_output=True,
        timeout=60,
        env=environment,
        check=True,
    )
    (got,) = language("pwg").decode(ran.stdout)
    np.testing.assert_array_equal(got.indices, picture)
    assert got.dpi == (72.0, 72.0)


@pytest.mark.parametrize("levels", [2, 3, 16, 200, 256])
def test_png(levels, tmp_path):
    """pngcheck finds nothing, and Pillow sees what the levels show; also when it was broken off."""
    from PIL import Image

    made = language("png")
    picture = RNG.integers(0, levels, (1000, 701)).astype(np.uint8)
    frame = Frame(picture, Levels.of(levels), dpi=(203, 300))
    parts = list(made.encode([page_of(made, frame)]))
    first = parts[0]
    whole = b"".join(piece.data for piece in parts)
    broken = first.data[:500] + first.abort(500)
    for data, rows in ((whole, 1000), (broken, first.rows)):
        path = tmp_path / "ours.png"
        path.write_bytes(data)
        checked = subprocess.run(
            [places.program("pngcheck"), "-q", path], capture_output=True, text=True
        )
        assert (checked.returncode, checked.stdout) == (0, "")
        with Image.open(path) as image:
            got = np.array(image.convert("L"))
            assert image.info["dpi"] == pytest.approx((203, 300), abs=0.01)
        np.testing.assert_array_equal(got[:rows], frame.preview()[:rows])
        assert (got[rows:] == 255).all()
        assert got.shape == picture.shape


def test_png_of_pillow(tmp_path):
    """Filters of all kinds, as libpng chooses them."""
    from PIL import Image

    slope = np.add.outer(np.arange(300), np.arange(400)) // 3 % 256
    gray = (slope + RNG.integers(0, 3, slope.shape)).clip(0, 255).astype(np.uint8)
    path = tmp_path / "theirs.png"
    Image.fromarray(gray).save(path, dpi=(300, 300))
    (frame,) = language("png").decode(path.read_bytes())
    np.testing.assert_array_equal(frame.indices, gray)
    assert frame.dpi == (300.0, 300.0)
    Image.fromarray(gray > 99).save(path)
    (frame,) = language("png").decode(path.read_bytes())
    np.testing.assert_array_equal(frame.indices, gray > 99)
