"""What must be known of a file before or beside OpenImageIO: sizes, and the maxval of a PNM."""

from __future__ import annotations

import re
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

__all__ = ["declared_size", "exact_pnm", "progressive_size"]


def declared_size(head: bytes) -> tuple[int, int] | None:
    """(width, height) that a GIF or JPEG 2000 file declares in its first 4 KiB, else None.

    OpenImageIO decodes these when it opens them, before their size can be asked for.
    """
    if head[:4] == b"GIF8" and len(head) >= 10:
        return int.from_bytes(head[6:8], "little"), int.from_bytes(head[8:10], "little")
    if head[:4] == b"\xff\x4f\xff\x51" and len(head) >= 16:  # a bare codestream: SOC, SIZ
        return int.from_bytes(head[8:12], "big"), int.from_bytes(head[12:16], "big")
    place = head.find(b"ihdr")
    if head[4:8] == b"jP  " and 0 < place <= len(head) - 12:
        height, width = head[place + 4 : place + 8], head[place + 8 : place + 12]
        return int.from_bytes(width, "big"), int.from_bytes(height, "big")
    return None


def progressive_size(file: BinaryIO) -> tuple[int, int] | None:
    """(width, height) of a progressive JPEG (ITU-T T.81, B.2), None for any other file.

    Its coefficients are read as a whole when it is opened.
    """
    file.seek(0)
    if file.read(2) != b"\xff\xd8":
        return None
    while len(marker := file.read(4)) == 4 and marker[0] == 0xFF:
        while marker[1] == 0xFF and (more := file.read(1)):  # fill bytes (B.1.1.2)
            marker = marker[1:] + more
        kind, length = marker[1], int.from_bytes(marker[2:], "big")
        if kind in (0xC2, 0xC6, 0xCA, 0xCE):  # SOF of a progressive scan
            size = file.read(5)
            return int.from_bytes(size[3:5], "big"), int.from_bytes(size[1:3], "big")
        if 0xC0 <= kind <= 0xCF and kind not in (0xC4, 0xC8, 0xCC):
            return None
        file.seek(length - 2, 1)
    return None


def exact_pnm(pixels: NDArray[Any], place: str) -> NDArray[Any]:
    """Pixels of a plain PGM or PPM as they are, where OpenImageIO rounded them down.

    It gives ⌊v·full/maxval⌋ for the value v, from which v follows; it is returned as a 16-bit code.
    """
    with open(place, "rb") as file:
        head = re.sub(rb"#[^\n]*", b"", file.read(4096)).split(maxsplit=4)
    if pixels.dtype.kind != "u" or len(head) < 4 or head[0] not in (b"P2", b"P3", b"P5", b"P6"):
        return pixels
    maxval, full = int(head[3]), np.iinfo(pixels.dtype).max
    if full % maxval == 0:
        return pixels
    value = np.ceil(pixels * (maxval / full) - 1e-9)
    return np.rint(value * (65535 / maxval)).astype(np.uint16)
