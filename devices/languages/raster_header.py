"""The page headers of PWG raster, CUPS raster and URF, as tables of their fields.

Names are those of CUPS (cups/raster.h); PWG 5102.4 has other names for some, and for elements of
``cupsInteger``: see PWG. Sources: spec-raster.html of CUPS, tables 1 and 2; PWG 5102.4-2012, table
1; for URF, which Apple has not published, cups/raster-stream.c.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

__all__ = ["OLD", "PAGE", "PWG", "PWG_ALLOWED", "PWG_UNUSED", "URF", "Table"]


@dataclass(frozen=True)
class Field:
    """*count* values of struct's *kind* from byte *place* on; texts are NUL-terminated."""

    name: str
    place: int
    kind: str
    count: int


class Table:
    """Fields that follow each other without gaps."""

    def __init__(self, text: str) -> None:
        self.fields: dict[str, Field] = {}
        self.size = 0
        form = ""
        for word in text.split():
            name, kind, count = word.split(":")
            self.fields[name] = Field(name, self.size, kind, int(count))
            self.size += struct.calcsize(">" + kind) * int(count)
            form += kind * int(count)
        self.form = form

    def place(self, name: str, index: int = 0) -> int:
        """Where the field lies, or one of its values."""
        field = self.fields[name]
        return field.place + index * struct.calcsize(">" + field.kind)

    def read(self, data: bytes, order: str) -> dict[str, Any]:
        """Values by name: numbers, texts without what follows their NUL (Latin-1), tuples of them.

        order : ``<`` or ``>``, the low or the high byte first.
        """
        values = iter(struct.unpack(order + self.form, data))
        read: dict[str, Any] = {}
        for field in self.fields.values():
            got = tuple(next(values) for _ in range(field.count))
            if field.kind.endswith("s"):
                got = tuple(text.partition(b"\0")[0].decode("latin-1") for text in got)
            read[field.name] = got if field.count > 1 else got[0]
        return read

    def write(self, values: Mapping[str, Any], order: str) -> bytes:
        """The inverse; what is not among *values* is 0."""
        flat: list[Any] = []
        for field in self.fields.values():
            nothing: Any = "" if field.kind.endswith("s") else 0
            given = values.get(field.name, (nothing,) * field.count if field.count > 1 else nothing)
            several = given if field.count > 1 else (given,)
            flat += [v.encode("latin-1") if isinstance(v, str) else v for v in several]
        return struct.pack(order + self.form, *flat)


_OLD = """
MediaClass:64s:1 MediaColor:64s:1 MediaType:64s:1 OutputType:64s:1
AdvanceDistance:I:1 AdvanceMedia:I:1 Collate:I:1 CutMedia:I:1 Duplex:I:1 HWResolution:I:2
ImagingBoundingBox:I:4 InsertSheet:I:1 Jog:I:1 LeadingEdge:I:1 Margins:I:2 ManualFeed:I:1
MediaPosition:I:1 MediaWeight:I:1 MirrorPrint:I:1 NegativePrint:I:1 NumCopies:I:1 Orientation:I:1
OutputFaceUp:I:1 PageSize:I:2 Separations:I:1 TraySwitch:I:1 Tumble:I:1
cupsWidth:I:1 cupsHeight:I:1 cupsMediaType:I:1 cupsBitsPerColor:I:1 cupsBitsPerPixel:I:1
cupsBytesPerLine:I:1 cupsColorOrder:I:1 cupsColorSpace:I:1 cupsCompression:I:1 cupsRowCount:I:1
cupsRowFeed:I:1 cupsRowStep:I:1
"""

OLD = Table(_OLD)
"""420 bytes: version 1 of CUPS raster."""

PAGE = Table(
    _OLD
    + """
cupsNumColors:I:1 cupsBorderlessScalingFactor:f:1 cupsPageSize:f:2 cupsImagingBBox:f:4
cupsInteger:I:16 cupsReal:f:16 cupsString:64s:16 cupsMarkerType:64s:1 cupsRenderingIntent:64s:1
cupsPageSizeName:64s:1
"""
)
"""1796 bytes: versions 2 and 3 of CUPS raster, and PWG raster (high byte first)."""

URF = Table(
    "BitsPerPixel:B:1 ColorSpace:B:1 Duplex:B:1 Quality:B:1 MediaType:B:1 MediaPosition:B:1 Zeros:B:6 "
    "Width:I:1 Height:I:1 Resolution:I:1 Rest:B:8"
)
"""32 bytes, high byte first."""

PWG = {
    "TotalPageCount": 0,
    "CrossFeedTransform": 1,
    "FeedTransform": 2,
    "ImageBoxLeft": 3,
    "ImageBoxTop": 4,
    "ImageBoxRight": 5,
    "ImageBoxBottom": 6,
    "AlternatePrimary": 7,
    "PrintQuality": 8,
    "VendorIdentifier": 14,
    "VendorLength": 15,
}
"""What PWG raster calls the elements of cupsInteger; 9 … 13 are not used."""

PWG_UNUSED = (
    *("AdvanceDistance", "AdvanceMedia", "Collate", "Margins", "MirrorPrint", "NegativePrint"),
    *("OutputFaceUp", "Separations", "TraySwitch", "cupsMediaType", "cupsCompression", "cupsRowCount"),
    *("cupsRowFeed", "cupsRowStep", "cupsBorderlessScalingFactor", "cupsPageSize", "cupsImagingBBox"),
    "cupsMarkerType",
)
"""Fields that are 0 in PWG raster; so should ImagingBoundingBox and ManualFeed, which libcups fills."""

PWG_ALLOWED = {
    "CutMedia": range(5),
    "Duplex": range(2),
    "InsertSheet": range(2),
    "Jog": range(5),
    "LeadingEdge": range(4),
    "ManualFeed": range(2),
    "Orientation": range(4),
    "Tumble": range(2),
}
"""Values of PWG raster's enumerations."""
