"""Picture files of every kind, made without the product, and the light they stand for."""

from __future__ import annotations

import io
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

__all__ = [
    "GRAY",
    "RGB",
    "chunk",
    "codes_of",
    "decoded",
    "header_of",
    "light_of",
    "png_of",
    "shown",
    "write_gray_png",
    "write_oiio",
]

_Y, _X = np.mgrid[0:24, 0:41]
GRAY = (_X * 6 + _Y // 3).astype(np.uint8)
"""24 rows of 41 pixels: 8-bit sRGB codes 0 … 247, brighter to the right."""

RGB = np.dstack([GRAY, GRAY[::-1, ::-1], (_Y * 10).astype(np.uint8)])
"""The same size, with three different channels."""

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def light_of(codes: Any) -> np.ndarray:
    """Light of 8-bit sRGB codes by IEC 61966-2-1; of RGB codes (M, N, 3), the luminance."""
    v = np.asarray(codes, np.float64) / 255
    light = np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)
    return light @ _LUMINANCE if light.ndim == 3 else light


def codes_of(light: Any) -> np.ndarray:
    """8-bit sRGB codes, as floats that are not rounded, of light."""
    v = np.asarray(light, np.float64)
    return 255 * np.where(v <= 0.0031308, v * 12.92, 1.055 * np.maximum(v, 0) ** (1 / 2.4) - 0.055)


def shown(data: bytes | Path) -> np.ndarray:
    """8-bit gray codes (M, N) that Pillow shows of a file."""
    with Image.open(io.BytesIO(data) if isinstance(data, bytes) else data) as picture:
        return np.asarray(picture.convert("RGB"))[:, :, 0]


def decoded(data: bytes | Path) -> np.ndarray:
    """Light (M, N) that a file shows."""
    return light_of(shown(data))


def chunk(kind: bytes, data: bytes) -> bytes:
    """A PNG chunk with its length and CRC."""
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def header_of(png: bytes) -> tuple[int, int, int, int]:
    """Width, height, bit depth and colour type of a PNG, by its IHDR chunk."""
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    assert png[8:16] == b"\0\0\0\x0dIHDR"
    width, height, depth, colour, *rest = struct.unpack(">IIBBBBB", png[16:29])
    assert rest == [0, 0, 0]
    return width, height, depth, colour


def png_of(width: int, height: int, depth: int, colour: int, rows: bytes, *more: bytes) -> bytes:
    """A PNG with the header given and *rows*, filter bytes included; *more* chunks before IDAT."""
    header = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    pixels = chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + b"".join(more) + pixels


def write_gray_png(path: Path, values: np.ndarray, depth: int, *more: bytes) -> None:
    """*values* (M, N) below 2^depth as a gray PNG of 1, 2, 4, 8 or 16 bits."""
    rows = b""
    for row in values.tolist():
        bits = "".join(format(v, f"0{depth}b") for v in row)
        bits += "0" * (-len(bits) % 8)
        rows += b"\0" + int(bits, 2).to_bytes(len(bits) // 8, "big")
    path.write_bytes(png_of(values.shape[1], values.shape[0], depth, 0, rows, *more))


def write_oiio(
    path: Path, pixels: np.ndarray, kind: str, names: tuple[str, ...] = (), **attributes: Any
) -> None:
    """*pixels* (M, N) or (M, N, C) by OpenImageIO; in *attributes*, ``__`` stands for ``:``."""
    import OpenImageIO as oiio

    cube = np.ascontiguousarray(pixels.reshape(*pixels.shape[:2], -1))
    spec = oiio.ImageSpec(cube.shape[1], cube.shape[0], cube.shape[2], kind)
    if names:
        spec.channelnames = names
    for name, value in attributes.items():
        spec.attribute(name.replace("__", ":"), value)
    file = oiio.ImageOutput.create(str(path))
    assert file is not None, oiio.geterror()
    assert file.open(str(path), spec), file.geterror()
    assert file.write_image(cube), file.geterror()
    file.close()
