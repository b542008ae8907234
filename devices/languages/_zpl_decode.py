"""Reading ZPL strictly: labels of graphics, as our encoder, CUPS, LPrint and others write them."""

from __future__ import annotations

import base64
import binascii
import re
import zlib

import numpy as np

from devices.languages.label import Image, Rows, compose, fewest
from devices.languages.reader import Reader
from halftone.frame import Frame

__all__ = ["Decoder"]

MOST_DOTS = 32_000
PREFIX = re.compile(rb"[\^~]")
GRAPHIC = re.compile(rb"A,(\d{1,9}),(\d{1,9}),(\d{1,5}),")
NAME = rb"(?:([A-Z]):)?([A-Z0-9_]{1,16})\.GRF"
DOWNLOAD = re.compile(NAME + rb",(\d{1,9}),(\d{1,5}),")
STORED = re.compile(NAME + rb"(?:,1,1)?")
PLACE = re.compile(rb"(\d{1,5}),(\d{1,5})(?:,[012])?")
QUANTITY = re.compile(rb"(\d{1,8})(?:,\d{0,8}(?:,\d{0,8}(?:,[NY]?(?:,[NY]?)?)?)?)?")
LENGTH = re.compile(rb"(\d{1,5})(?:,[NY])?")
ENCODED = re.compile(rb":([BZ])64:([A-Za-z0-9+/=]*):([0-9A-Fa-f]{4})")
TOKEN = re.compile(rb"[ \t\r\n]+|([G-Yg-z]*)([0-9A-Fa-f])|([,!:])")
DIGITS = re.compile(rb"[0-9A-Fa-f]+")
TIMES = {ord("F") + i: i for i in range(1, 20)} | {ord("f") + i: 20 * i for i in range(1, 21)}


def _setting(key: str, pattern: bytes) -> tuple[str, re.Pattern[bytes]]:
    return key, re.compile(pattern)


_SPEED = rb"(?:[1-9]|1[0-4]|[A-E])"
SETTINGS = {
    b"~SD": _setting("density", rb"([012]?\d|30)"),
    b"^MD": _setting("darkness", rb"(-?(?:[012]?\d|30))"),
    b"~MD": _setting("darkness", rb"(-?(?:[012]?\d|30))"),  # so written by LPrint 1.1
    b"^PR": _setting("speed", rb"(%s)(?:,%s){0,2}" % (_SPEED, _SPEED)),
    b"^PO": _setting("orientation", rb"([NI])"),
    b"^MN": _setting("media", rb"([NYWMAV])"),
    b"^MT": _setting("method", rb"([TD])"),
    b"^MM": _setting("mode", rb"([TPRACDFKLSU])(?:,[YN])?"),
    b"^LT": _setting("top", rb"(-?(?:\d{1,2}|1[01]\d|120))"),
    b"^LS": _setting("left", rb"(-?\d{1,4})"),
    b"~TA": _setting("tear", rb"(-?\d{1,3})"),
    b"^JZ": _setting("", rb"[YN]"),
    b"^CI": _setting("", rb"\d{1,2}"),
    b"^CF": _setting("", rb"[A-Z0-9](?:,\d{1,5}){0,2}"),
    b"^CN": _setting("", rb"[01]"),
    b"~HQ": _setting("", rb"[A-Z]{2}"),
    b"~HS": _setting("", rb""),
    b"~HI": _setting("", rb""),
}
"""Commands that lay nothing: what their value is called in a frame's report, and their parameters."""


class Decoder:
    """The labels of a stream.

    ^PW, ^LL, ^LH and settings hold until they are set anew, as in a printer. A label without ^PW or
    ^LL is as wide and high as its images need. ^POI, ^LT and ^LS are reported, not carried out: the
    frame is the label as its fields lay it. Labels without an image print nothing.

    *limit* holds for the pixels of all labels, for those of all images that are loaded, and for those
    of all images that are laid; memory is a few bytes for each.
    """

    def __init__(self, language: str, data: bytes, limit: int) -> None:
        self.reader = Reader(language, data)
        self.limit = self.left = limit
        self.loaded = self.drawn = 0
        self.width = self.height = 0  # not set
        self.home = (0, 0)
        self.settings: dict[str, object] = {}
        self.store: dict[bytes, Rows] = {}
        self.made: list[Frame] = []
        self.start: int | None = None  # of the open label
        self._clear()

    def _clear(self) -> None:
        self.copies = 1
        self.fields = 0
        self.origin: tuple[int, int] | None = None
        self.filled = False
        self.laid: list[Image] = []

    def frames(self) -> list[Frame]:
        reader = self.reader
        if not reader.data.strip(b" \t\r\n"):
            reader.fail("a ZPL command expected")
        while self._skip():
            place = reader.place
            name = reader.take(3, "a command")
            if name in SETTINGS:
                self._set(*SETTINGS[name], name)
            elif name == b"^FX":
                self._text()
            elif name == b"~DG":
                self._download()
            elif name == b"^XA":
                if self.start is not None:
                    reader.fail("^XA within a label", place)
                self.start = place
                self._nothing()
            elif name in LABEL:
                if self.start is None:
                    reader.fail(f"{name.decode()} outside of a label", place)
                LABEL[name](self, place)
            else:
                reader.fail(f"unknown command {name!r}", place)
        if self.start is not None:
            reader.fail("the label is not ended by ^XZ")
        return self.made

    # --- reading -------------------------------------------------------------------------------

    def _skip(self) -> bool:
        """Over white space; whether a command follows."""
        data, place = self.reader.data, self.reader.place
        found = PREFIX.search(data, place)
        end = found.start() if found else len(data)
        rest = data[place:end].lstrip(b" \t\r\n")
        if rest:
            self.reader.fail("a command expected", end - len(rest))
        self.reader.place = end
        return found is not None

    def _text(self) -> bytes:
        """The parameters of a command: all before the next."""
        found = PREFIX.search(self.reader.data, self.reader.place)
        end = found.start() if found else len(self.reader.data)
        return self.reader.take(end - self.reader.place, "parameters")

    def _match(self, pattern: re.Pattern[bytes], what: str) -> re.Match[bytes]:
        """Parameters of the form of *pattern*; white space within them is allowed."""
        place = self.reader.place
        found = pattern.fullmatch(re.sub(rb"[ \t\r\n]+", b"", self._text()))
        if not found:
            self.reader.fail(f"parameters of {what}", place)
        return found

    def _nothing(self) -> None:
        place = self.reader.place
        if self._text().strip(b" \t\r\n"):
            self.reader.fail("a command expected", place)

    def _dots(self, text: bytes, least: int, place: int) -> int:
        if not least <= int(text) <= MOST_DOTS:
            self.reader.fail(f"{int(text)} dots; allowed: {least} … {MOST_DOTS}", place)
        return int(text)

    # --- commands ------------------------------------------------------------------------------

    def _set(self, key: str, pattern: re.Pattern[bytes], name: bytes) -> None:
        found = self._match(pattern, name.decode())
        if key:
            text = found[1].decode()
            self.settings[key] = text if text.isalpha() else int(text)

    def _before_fields(self, place: int) -> None:
        if self.fields:
            self.reader.fail("after the label's first ^FS it would hold for the next label", place)

    def _set_width(self, place: int) -> None:
        self._before_fields(place)
        self.width = self._dots(self._match(LENGTH, "^PW")[1], 1, place)

    def _set_height(self, place: int) -> None:
        self._before_fields(place)
        self.height = self._dots(self._match(LENGTH, "^LL")[1], 1, place)

    def _set_home(self, place: int) -> None:
        self._before_fields(place)
        found = self._match(PLACE, "^LH")
        self.home = self._dots(found[1], 0, place), self._dots(found[2], 0, place)

    def _quantity(self, place: int) -> None:
        self.copies = int(self._match(QUANTITY, "^PQ")[1])
        if not self.copies:
            self.reader.fail("0 copies", place)

    def _open_field(self, place: int) -> None:
        if self.origin is not None:
            self.reader.fail("the field before is not ended by ^FS", place)
        found = self._match(PLACE, "^FO")
        x, y = self._dots(found[1], 0, place), self._dots(found[2], 0, place)
        self.origin = self.home[0] + x, self.home[1] + y

    def _end_field(self, place: int) -> None:
        self._nothing()
        if self.origin is not None and not self.filled:
            self.reader.fail("a field without an image", place)
        self.origin, self.filled = None, False
        self.fields += 1

    def _field(self, place: int) -> None:
        found = GRAPHIC.match(self.reader.data, self.reader.place)
        if not found:
            self.reader.fail("^GFA with three numbers expected")
        if found[1] != found[2] and int(found[1]) != int(found[2]):
            self.reader.fail(
                f"{int(found[1])} bytes of data for {int(found[2])} of image", found.start(1)
            )
        self._lay(self._image(found, int(found[2]), int(found[3])), place)

    def _download(self) -> None:
        found = DOWNLOAD.match(self.reader.data, self.reader.place)
        if not found:
            self.reader.fail("~DG with a name and two numbers expected")
        image = self._image(found, int(found[3]), int(found[4]))
        self.store[(found[1] or b"R") + found[2]] = image

    def _recall(self, place: int) -> None:
        found = self._match(STORED, "^XG (a name, not magnified)")
        key = (found[1] or b"R") + found[2]
        if key not in self.store:
            self.reader.fail("an image that was not downloaded", place)
        self._lay(self.store[key], place)

    def _delete(self, place: int) -> None:
        found = self._match(STORED, "^ID")
        self.store.pop((found[1] or b"R") + found[2], None)

    def _lay(self, image: Rows, place: int) -> None:
        if self.origin is None or self.filled:
            self.reader.fail("an image without its own ^FO", place)
        self.drawn += fewest(*image.shape)
        if self.drawn > self.limit:
            self.reader.fail(f"images of more than {self.limit} pixels", place)
        self.laid.append(Image(*self.origin, place, image))
        self.filled = True

    def _end_label(self, place: int) -> None:
        self._nothing()
        if self.origin is not None:
            self.reader.fail("the field is not ended by ^FS", place)
        if self.laid:
            size = self.width, self.height
            sheet = compose(self.reader, self.laid, size, self.left, self.start)
            self.left -= sheet.width * sheet.height
            self.made.append(sheet.frame(None, copies=self.copies, **self.settings))
        self.start = None
        self._clear()

    # --- images --------------------------------------------------------------------------------

    def _image(self, header: re.Match[bytes], total: int, size: int) -> Rows:
        reader = self.reader
        if not total or not size or total % size:
            reader.fail(f"{total} bytes are not whole rows of {size}", header.start())
        self.loaded += fewest(total // size, size)
        if self.loaded > self.limit:
            reader.fail(f"images of more than {self.limit} pixels", header.start())
        reader.place = header.end()
        encoded = reader.peek(1) == b":"
        data = _encoded(reader, total) if encoded else _rows(reader, total, size)
        self._nothing()
        return np.frombuffer(data, np.uint8).reshape(-1, size)


LABEL = {
    b"^XZ": Decoder._end_label,
    b"^PW": Decoder._set_width,
    b"^LL": Decoder._set_height,
    b"^LH": Decoder._set_home,
    b"^PQ": Decoder._quantity,
    b"^FO": Decoder._open_field,
    b"^FS": Decoder._end_field,
    b"^GF": Decoder._field,
    b"^XG": Decoder._recall,
    b"^ID": Decoder._delete,
}
"""Commands of a label; each is called with the offset where it begins."""


def _rows(reader: Reader, total: int, size: int) -> bytes:
    """*total* bytes in hexadecimal digits, with the abbreviations of the alternative compression."""
    data, place = reader.data, reader.place
    need, row = 2 * total, 2 * size
    text = bytearray()
    while len(text) < need:
        plain = DIGITS.match(data, place)
        if plain:
            taken = plain[0][: need - len(text)]
            text += taken
            place += len(taken)
            continue
        found = TOKEN.match(data, place)
        if not found:
            reader.fail(
                f"a hexadecimal digit or count expected, {len(text) // 2} of {total} bytes read", place
            )
        if found[2]:
            run = sum(TIMES[letter] for letter in found[1])
            if run > need - len(text):
                reader.fail("a run longer than the image", place)
            text += found[2] * run
        elif found[3] == b":":
            if not text or len(text) % row:
                reader.fail("':' repeats a row, and stands only between rows", place)
            text += text[-row:]
        elif found[3] == b"!":
            reader.fail("'!', which some printers take as ink and others as digits 1,", place)
        elif found[3]:
            text += b"0" * (row - len(text) % row)
        place = found.end()
    reader.place = place
    return bytes.fromhex(text.decode())


def _encoded(reader: Reader, total: int) -> bytes:
    """*total* bytes in base64, compressed or not, with their CRC."""
    start = reader.place
    found = ENCODED.match(reader.data, start)
    if not found:
        reader.fail("':Z64:' or ':B64:', base64 and a CRC of four digits expected")
    text = found[2]
    if int(found[3], 16) != binascii.crc_hqx(text, 0):
        reader.fail(
            f"CRC {found[3].decode()}, but the data have {binascii.crc_hqx(text, 0):04X}", found.start(3)
        )
    try:
        data = base64.b64decode(text, validate=True)
        if found[1] == b"Z":
            unpacker = zlib.decompressobj()
            data = unpacker.decompress(data, total + 1)
            if len(data) <= total and (not unpacker.eof or unpacker.unused_data):
                reader.fail("compressed data that are cut off or go on", found.start(2))
    except (binascii.Error, zlib.error) as error:
        reader.fail(str(error).lower(), found.start(2))
    if len(data) != total:
        reader.fail(
            f"{total} bytes of image declared, {'more' if len(data) > total else len(data)} given",
            found.start(2),
        )
    reader.place = found.end()
    return data
