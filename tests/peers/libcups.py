"""libcups' reader and writer of CUPS raster, PWG raster and URF, called through ctypes."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterable
from ctypes.util import find_library
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from devices.languages.raster_header import PAGE

READ, WRITE, WRITE_COMPRESSED, WRITE_PWG, WRITE_APPLE = range(5)
"""Modes of cupsRasterOpen."""

Rows = NDArray[np.uint8]


def library() -> ctypes.CDLL:
    """libcups; the test skips without it."""
    name = find_library("cups") or "libcups.so.2"
    try:
        cups = ctypes.CDLL(name)
    except OSError:
        pytest.skip("libcups2 is not installed (tests/peers/install.sh installs it)")
    cups.cupsRasterOpen.restype = ctypes.c_void_p
    cups.cupsRasterOpen.argtypes = [ctypes.c_int, ctypes.c_int]
    cups.cupsRasterClose.argtypes = [ctypes.c_void_p]
    cups.cupsRasterErrorString.restype = ctypes.c_char_p
    for name in ("cupsRasterReadHeader2", "cupsRasterWriteHeader2"):
        function = getattr(cups, name)
        function.restype, function.argtypes = ctypes.c_uint, [ctypes.c_void_p, ctypes.c_char_p]
    for name in ("cupsRasterReadPixels", "cupsRasterWritePixels"):
        function = getattr(cups, name)
        function.restype = ctypes.c_uint
        function.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_uint]
    return cups


def write(path: Path, mode: int, pages: Iterable[tuple[dict[str, Any], Rows]]) -> bytes:
    """The file that libcups makes of headers, as :data:`PAGE` has them, and rows (n, bytes a row)."""
    cups = library()
    handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC)
    try:
        raster = cups.cupsRasterOpen(handle, mode)
        assert raster, cups.cupsRasterErrorString()
        for values, rows in pages:
            header = ctypes.create_string_buffer(PAGE.write(values, "="), PAGE.size)
            assert cups.cupsRasterWriteHeader2(raster, header), cups.cupsRasterErrorString()
            for row in rows:
                assert cups.cupsRasterWritePixels(raster, row.tobytes(), row.size) == row.size
        cups.cupsRasterClose(raster)
    finally:
        os.close(handle)
    return path.read_bytes()


def read(path: Path) -> list[tuple[dict[str, Any], Rows]]:
    """Headers and rows as libcups reads them."""
    cups = library()
    found = []
    handle = os.open(path, os.O_RDONLY)
    try:
        raster = cups.cupsRasterOpen(handle, READ)
        assert raster, cups.cupsRasterErrorString()
        header = ctypes.create_string_buffer(PAGE.size)
        while cups.cupsRasterReadHeader2(raster, header):
            values = PAGE.read(header.raw, "=")
            size = values["cupsBytesPerLine"]
            line = ctypes.create_string_buffer(size)
            rows = np.empty((values["cupsHeight"], size), np.uint8)
            for row in rows:
                assert cups.cupsRasterReadPixels(raster, line, size) == size
                row[:] = np.frombuffer(line.raw, np.uint8)
            found.append((values, rows))
        cups.cupsRasterClose(raster)
    finally:
        os.close(handle)
    return found
