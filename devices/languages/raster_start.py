"""What a raster stream begins with, and what its page headers may say."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from devices.languages.raster_header import OLD, PAGE, PWG, PWG_ALLOWED, PWG_UNUSED, URF, Table
from devices.languages.raster_source import Source

__all__ = ["MOST", "SPACES", "Opened", "Space", "is_pwg", "opened", "page_header"]

MOST = 0xFFFFFF
"""Dots across and down that libcups allows."""
MOST_BYTES = 1 << 24
"""Bytes of a row that libcups allows."""
SYNC = {
    b"RaSt": (">", 1),
    b"tSaR": ("<", 1),
    b"RaS2": (">", 2),
    b"2SaR": ("<", 2),
    b"RaS3": (">", 3),
    b"3SaR": ("<", 3),
}
"""Byte order and version of CUPS raster."""
URF_START = b"UNIRAST\0"
PWG_CLASS = b"PwgRaster\0"


class Space(NamedTuple):
    """A colour space. paper : the byte that is blank, 255 where 0 is dark and 0 where it is ink."""

    name: str
    colours: int
    paper: int


SPACES = {
    0: Space("W", 1, 255),
    1: Space("RGB", 3, 255),
    3: Space("K", 1, 0),
    18: Space("SW", 1, 255),
    19: Space("sRGB", 3, 255),
}
"""The values of cupsColorSpace that are read. W and SW are sRGB's gray, K is black ink."""
URF_SPACES = {0: 18, 1: 19, 4: 0, 5: 1}
"""URF's numbers of them."""
URF_MEDIA = 14
"""Types of media that URF numbers."""
BITS = {1: (1, 8), 3: (8,)}
"""Bits a colour that are read, by the number of colours."""
QUALITIES = (0, 3, 4, 5)
"""Of IPP: not said, draft, normal, high."""


@dataclass
class Opened:
    """A stream after its first bytes. total : pages that it says it has, 0 if it does not."""

    source: Source
    table: Table
    order: str
    compressed: bool
    total: int = 0

    @property
    def pwg(self) -> bool:
        return self.source.language == "pwg"


class Picture(NamedTuple):
    space: Space
    bits: int
    width: int
    height: int
    dpi: tuple[float, float] | None


@dataclass
class PageHeader:
    """The fields of a header by name, and where it lies."""

    values: dict[str, Any]
    table: Table
    source: Source
    start: int

    def where(self, name: str, index: int = 0) -> int:
        """Offset of a field, called as in CUPS."""
        urf = {"cupsWidth": "Width", "cupsHeight": "Height", "cupsBytesPerLine": "Width"}
        if self.table is URF:
            name = urf.get(name, name)
        return self.start + self.table.place(name, index)

    def check(self, good: bool, name: str, allowed: str, index: int = 0) -> None:
        """Refuse the field *name* unless it is *good*."""
        if not good:
            value = self.values[name]
            got = value[index] if isinstance(value, tuple) else value
            self.source.fail(f"{name} = {got!r}; allowed: {allowed}", self.where(name, index))

    @property
    def picture(self) -> Picture:
        """What it says of the pixels; refused if it is not read."""
        v = self.values
        space = SPACES[v["cupsColorSpace"]]
        x, y = (float(d) for d in v["HWResolution"])
        dpi = (x, y) if x and y else None
        return Picture(space, v["cupsBitsPerPixel"], v["cupsWidth"], v["cupsHeight"], dpi)


def is_pwg(head: bytes) -> bool:
    """Whether a stream with this beginning is PWG raster, and not CUPS raster of version 2."""
    return head[:4] == b"RaS2" and head[4:14] == PWG_CLASS


def opened(read: Callable[[int], bytes], language: str | None) -> Opened:
    """Which of the three it is. language : the only one that is allowed, or None."""
    source = Source(language or "cups-raster", read)
    head = bytes(source.peek(14)[:14])
    if head[:8] == URF_START and language in (None, "urf"):
        source.language = "urf"
        source.take(8, "UNIRAST")
        return Opened(source, URF, ">", True, int.from_bytes(source.take(4, "page count"), "big"))
    if is_pwg(head) and language in (None, "pwg"):
        source.language = "pwg"
    elif is_pwg(head):
        source.fail("this is PWG raster", 4)
    elif language == "pwg":
        start = b"RaS2" + PWG_CLASS
        source.fail("RaS2 and PwgRaster expected", _same(head, start))
    elif language == "urf":
        source.fail("UNIRAST expected", _same(head, URF_START))
    elif head[:4] not in SYNC:
        source.fail("RaSt, RaS2 or RaS3, or one of them backwards, expected")
    order, version = SYNC[bytes(source.take(4, "sync word"))]
    return Opened(source, OLD if version == 1 else PAGE, order, version == 2)


def _same(head: bytes, wanted: bytes) -> int:
    """How many bytes at the start are alike."""
    same = (a == b for a, b in zip(head, wanted, strict=False))
    return next((i for i, alike in enumerate(same) if not alike), min(len(head), len(wanted)))


def page_header(stream: Opened, seen: int) -> PageHeader:
    """The header of the next page, after *seen* of them, checked."""
    source, table = stream.source, stream.table
    start = source.place
    values = table.read(bytes(source.take(table.size, "page header")), stream.order)
    header = PageHeader(values, table, source, start)
    if table is URF:
        _check_urf(header)
        header.values = _as_cups(values, stream.total)
    if stream.pwg:
        _check_pwg(header, first=not seen)
        if not seen and values["NumCopies"] <= 1:
            stream.total = values["cupsInteger"][0]
    _check_picture(header)
    return header


def _check_picture(header: PageHeader) -> None:
    """What decides how pixels lie in the stream."""
    v, check = header.values, header.check
    check(1 <= v["cupsWidth"] <= MOST, "cupsWidth", f"1 … {MOST}")
    check(1 <= v["cupsHeight"] <= MOST, "cupsHeight", f"1 … {MOST}")
    if header.table is not URF:
        names = ", ".join(f"{n} ({s.name})" for n, s in SPACES.items())
        check(v["cupsColorSpace"] in SPACES, "cupsColorSpace", names)
        colours = SPACES[v["cupsColorSpace"]].colours
        bits = v["cupsBitsPerColor"]
        check(bits in BITS[colours], "cupsBitsPerColor", ", ".join(map(str, BITS[colours])))
        check(v.get("cupsNumColors", 0) in (0, colours), "cupsNumColors", f"{colours}")
        check(v["cupsBitsPerPixel"] == bits * colours, "cupsBitsPerPixel", f"{bits * colours}")
        orders = range(3) if colours == 1 else (0,)
        check(v["cupsColorOrder"] in orders, "cupsColorOrder", ", ".join(map(str, orders)))
    size = (v["cupsWidth"] * v["cupsBitsPerPixel"] + 7) // 8
    check(size <= MOST_BYTES, "cupsWidth", f"rows of up to {MOST_BYTES} bytes")
    check(v["cupsBytesPerLine"] == size, "cupsBytesPerLine", f"{size}")


def _check_pwg(header: PageHeader, first: bool) -> None:
    """What PWG raster demands of a header beyond that."""
    v, check = header.values, header.check
    check(v["MediaClass"] == "PwgRaster", "MediaClass", "'PwgRaster'")
    for name in ("MediaColor", "MediaType", "OutputType", "cupsRenderingIntent", "cupsPageSizeName"):
        check(len(v[name]) < 64 and v[name].isascii(), name, "up to 63 ASCII characters")
    for name, allowed in PWG_ALLOWED.items():
        check(v[name] in allowed, name, f"{allowed[0]} … {allowed[-1]}")
    for name in PWG_UNUSED:
        values = v[name] if isinstance(v[name], tuple) else (v[name],)
        for index, value in enumerate(values):
            check(value in (0, ""), name, "nothing", index)
    for index in range(2):
        check(v["HWResolution"][index] > 0, "HWResolution", "1 and more", index)
    check(v["cupsColorOrder"] == 0, "cupsColorOrder", "0")
    numbers = v["cupsInteger"]
    for name in ("CrossFeedTransform", "FeedTransform"):
        at = PWG[name]
        check(numbers[at] in (0, 1, 0xFFFFFFFF), "cupsInteger", f"{name} 1 or -1", at)
    at = PWG["PrintQuality"]
    check(numbers[at] in QUALITIES, "cupsInteger", f"PrintQuality {QUALITIES}", at)
    at = PWG["VendorLength"]
    check(numbers[at] <= 1088, "cupsInteger", "VendorLength 0 … 1088", at)
    for at in range(9, 14):
        check(numbers[at] == 0, "cupsInteger", "nothing", at)


def _check_urf(header: PageHeader) -> None:
    v, check = header.values, header.check
    check(v["ColorSpace"] in URF_SPACES, "ColorSpace", ", ".join(map(str, URF_SPACES)))
    bits = 8 * SPACES[URF_SPACES[v["ColorSpace"]]].colours
    check(v["BitsPerPixel"] == bits, "BitsPerPixel", f"{bits}")
    check(v["Duplex"] <= 3, "Duplex", "0 … 3")
    check(v["Quality"] in QUALITIES, "Quality", ", ".join(map(str, QUALITIES)))
    check(v["MediaType"] < URF_MEDIA, "MediaType", f"0 … {URF_MEDIA - 1}")
    for name in ("Zeros", "Rest"):
        for index, value in enumerate(v[name]):
            check(value == 0, name, "0", index)
    check(v["Resolution"] > 0, "Resolution", "1 and more")


def _as_cups(v: dict[str, Any], total: int) -> dict[str, Any]:
    """URF's header in CUPS's names, as libcups gives it."""
    space = URF_SPACES[v["ColorSpace"]]
    width, height, dpi = v["Width"], v["Height"], v["Resolution"]
    return {
        "MediaClass": "PwgRaster",
        "HWResolution": (dpi, dpi),
        "PageSize": (width * 72 // dpi, height * 72 // dpi),
        "Duplex": int(v["Duplex"] >= 2),
        "Tumble": int(v["Duplex"] == 2),
        "MediaPosition": v["MediaPosition"],
        "NumCopies": 0,
        "cupsWidth": width,
        "cupsHeight": height,
        "cupsBitsPerColor": 8,
        "cupsBitsPerPixel": v["BitsPerPixel"],
        "cupsBytesPerLine": width * v["BitsPerPixel"] // 8,
        "cupsColorOrder": 0,
        "cupsColorSpace": space,
        "cupsNumColors": SPACES[space].colours,
        "cupsInteger": (total, *[0] * 6, 0xFFFFFF, v["Quality"], *[0] * 7),
    }
