"""PCL that other programs write, read by our decoder: netpbm, Ghostscript, CUPS's filter and command.

No program of a package registry draws PCL, so what we write is read back by this same decoder alone.
"""

from __future__ import annotations

import os
import subprocess

import numpy as np
import pytest

from devices.errors import ProtocolError
from devices.languages.pcl import Pcl
from tests.peers.places import file, program

pytestmark = pytest.mark.peer

GHOSTSCRIPT = ("-q", "-dNOPAUSE", "-dBATCH", "-dSAFER", "-r300")
BARE = ("-c", "<</HWMargins [0 0 0 0] /Margins [0 0]>> setpagedevice", "-f")
"""Settings by which the printers' devices of Ghostscript draw the whole page, as a file device does."""
PAGES = """%!
<< /PageSize [300 252] >> setpagedevice
/Times-Roman findfont 40 scalefont setfont 80 140 moveto (PCL 5) show
0.5 setgray 90 80 120 30 rectfill showpage
80 80 moveto 220 90 lineto stroke 100 170 3 3 rectfill showpage
"""


def run(*command: str, data: bytes = b"", **environment: str) -> bytes:
    done = subprocess.run(
        command, input=data, capture_output=True, check=False, env=os.environ | environment
    )
    assert done.returncode == 0, done.stderr.decode()
    return done.stdout


def pbm(picture: np.ndarray) -> bytes:
    height, width = picture.shape
    return f"P4\n{width} {height}\n".encode() + np.packbits(1 - picture, axis=1).tobytes()


def pbms(data: bytes) -> list[np.ndarray]:
    """The pictures of a stream of P4 files, 0 = ink."""
    made = []
    while data:
        end = 0
        lines: list[bytes] = []
        while len(lines) < 2:
            start, end = end, data.index(b"\n", end) + 1
            if not data[start:end].startswith(b"#"):
                lines.append(data[start:end])
        width, height = map(int, lines[1].split())
        size = (width + 7) // 8 * height
        bits = np.frombuffer(data[end : end + size], np.uint8).reshape(height, -1)
        made.append(1 - np.unpackbits(bits, axis=1, count=width))
        data = data[end + size :]
    return made


def same_ink(got: np.ndarray, wanted: np.ndarray) -> None:
    """Pictures whose dots are equal; either may have paper beyond the other's edges."""
    height, width = np.maximum(got.shape, wanted.shape)
    paper = [np.ones((height, width), np.uint8) for _ in range(2)]
    for sheet, picture in zip(paper, (got, wanted), strict=True):
        sheet[: picture.shape[0], : picture.shape[1]] = picture
    assert (paper[1] == 0).any()
    np.testing.assert_array_equal(*paper)


def drawn(tmp_path) -> list[np.ndarray]:
    """The pages as Ghostscript draws them into a picture."""
    (tmp_path / "pages.ps").write_text(PAGES)
    source = str(tmp_path / "pages.ps")
    return pbms(
        run(program("gs"), *GHOSTSCRIPT, "-sDEVICE=pbmraw", "-sOutputFile=%stdout", "-q", source)
    )


@pytest.mark.parametrize("options", ["", "-packbits", "-delta", "-compress", "-delta -float"])
@pytest.mark.parametrize("share", [0.02, 0.5, 0.98])
def test_pbmtolj(options, share):
    rng = np.random.default_rng(5)
    picture = (rng.random((300, 407)) < share).astype(np.uint8)
    picture[:40] = 1
    picture[50:90, 1:] = 1
    picture[100:200] = np.repeat(picture[100:200:10], 10, axis=0)
    picture[:, 300:] = np.repeat(picture[:, 300:301], 107, axis=1)
    picture[40:, 0] = picture[-1, 406] = 0
    made = run(
        program("pbmtolj"), *options.split(), "-resolution", "150", "-copies", "3", data=pbm(picture)
    )
    (frame,) = Pcl.decode(made)
    same_ink(frame.indices, picture)
    assert frame.dpi == (150.0, 150.0)
    assert frame.report["copies"] == 3


def test_pbmtolj_repeats_a_row_where_a_blank_one_is_meant():
    """In mode 3 it sends blank rows as ``ESC * b 0 W``, which repeats the row before (HP's manual)."""
    picture = np.zeros((3, 80), np.uint8)
    picture[2] = 1
    (frame,) = Pcl.decode(run(program("pbmtolj"), "-delta", data=pbm(picture)))
    assert frame.indices.max() == 0


@pytest.mark.parametrize(
    "device",
    [
        "ljet4",
        "ljet4d",
        "ljet3",
        "ljet3d",
        "ljet2p",
        "ljetplus",
        "laserjet",
        "lp2563",
        "deskjet",
        "djet500",
    ],
)
def test_ghostscript(device, tmp_path):
    wanted = drawn(tmp_path)
    made = run(
        program("gs"), *GHOSTSCRIPT, f"-sDEVICE={device}", "-sOutputFile=%stdout", *BARE,
        str(tmp_path / "pages.ps"),
    )  # fmt: skip
    frames = Pcl.decode(made)
    assert len(frames) == len(wanted) == 2
    for frame, picture in zip(frames, wanted, strict=True):
        same_ink(frame.indices, picture)


@pytest.mark.parametrize("compression", ["", "1", "2"])
def test_rastertohp(compression, tmp_path):
    """Modes 0, 1 and 2; asked for mode 3 it sets that mode and sends plain rows."""
    wanted = drawn(tmp_path)
    raster = str(tmp_path / "pages.ras")
    settings = ["-sDEVICE=cups", "-dcupsBitsPerColor=1", "-dcupsColorSpace=3"]
    settings += [f"-dcupsCompression={compression}"] if compression else []
    run(program("gs"), *GHOSTSCRIPT, *settings, f"-sOutputFile={raster}", str(tmp_path / "pages.ps"))
    ppd = tmp_path / "pcl.ppd"
    ppd.write_text(PPD)
    made = run(
        file("/usr/lib/cups/filter/rastertohp"), "1", "user", "title", "1", "", raster, PPD=str(ppd)
    )
    frames = Pcl.decode(made)
    assert len(frames) == len(wanted) == 2
    for frame, picture in zip(frames, wanted, strict=True):
        assert frame.shape == picture.shape
        same_ink(frame.indices, picture)


PPD = """*PPD-Adobe: "4.3"
*FormatVersion: "4.3"
*FileVersion: "1.0"
*LanguageVersion: English
*LanguageEncoding: ISOLatin1
*PCFileName: "PCL.PPD"
*Product: "(PCL)"
*Manufacturer: "HP"
*ModelName: "PCL"
*ShortNickName: "PCL"
*NickName: "PCL"
*PSVersion: "(3010.000) 0"
*LanguageLevel: "3"
*ColorDevice: False
*DefaultColorSpace: Gray
*FileSystem: False
*OpenUI *PageSize/Media Size: PickOne
*DefaultPageSize: Own
*PageSize Own: "<</PageSize[300 252]>>setpagedevice"
*CloseUI: *PageSize
*OpenUI *PageRegion/Media Size: PickOne
*DefaultPageRegion: Own
*PageRegion Own: "<</PageSize[300 252]>>setpagedevice"
*CloseUI: *PageRegion
*DefaultImageableArea: Own
*ImageableArea Own: "0 0 300 252"
*DefaultPaperDimension: Own
*PaperDimension Own: "300 252"
"""


def ippevepcl(tmp_path, source: str) -> bytes:
    """Its PCL for a page at 300 dpi, of which it prints what lies within ¼ and ⅙ inch of the edges."""
    (tmp_path / "page.ps").write_text(source)
    raster = str(tmp_path / "page.pwg")
    settings = ["-sDEVICE=pwgraster", "-dcupsBitsPerColor=1", "-dcupsColorSpace=3"]
    run(program("gs"), *GHOSTSCRIPT, *settings, f"-sOutputFile={raster}", str(tmp_path / "page.ps"))
    return run(program("ippevepcl"), raster, CONTENT_TYPE="image/pwg-raster")


def test_ippevepcl(tmp_path):
    wanted = drawn(tmp_path)
    frames = Pcl.decode(ippevepcl(tmp_path, PAGES))
    assert len(frames) == 2
    for frame, picture in zip(frames, wanted, strict=True):
        assert frame.shape == (1000, 1100)
        same_ink(frame.indices[50:], picture[:, 72:])  # it cuts rows at a whole byte


def test_ippevepcl_counts_blank_rows_of_its_margin(tmp_path):
    """It sends more rows than it has stated if a page begins blank; a printer drops the last ones."""
    made = ippevepcl(tmp_path, "%!\n<</PageSize [300 252]>> setpagedevice 50 1 90 60 rectfill showpage")
    with pytest.raises(ProtocolError, match="more rows than the 950 of the raster"):
        Pcl.decode(made)
