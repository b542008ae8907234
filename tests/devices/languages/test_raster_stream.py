"""Raster streams as they arrive."""

from __future__ import annotations

import tracemalloc
from io import BytesIO
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from devices.errors import ProtocolError
from devices.languages import language
from devices.languages.raster_header import PAGE
from devices.languages.raster_stream import pages
from tests.devices.languages import contract

LANGUAGES = [
    language("pwg"),
    language("urf"),
    language("cups-raster", version=2),
    language("cups-raster"),
]
PICTURE = (np.arange(600).reshape(20, 30) % 7 > 2).astype(np.uint8)


def reader(data, sizes):
    """A read function that gives so many bytes, in turn."""
    file, turn = BytesIO(data), iter(sizes * (len(data) + 1))
    return lambda most: file.read(min(most, next(turn)))


@given(
    st.sampled_from(LANGUAGES),
    contract.pictures(levels=4),
    st.lists(st.integers(1, 9000), min_size=1, max_size=3),
    st.integers(1, 50),
)
def test_however_it_is_read(language, picture, sizes, rows):
    data = contract.stream(language, picture, picture[::-1].copy(), levels=4)
    whole = [np.concatenate(list(page.bands())) for page in pages(BytesIO(data).read)]
    parts = []
    for page in pages(reader(data, sizes)):
        bands = list(page.bands(rows))
        assert {len(band) for band in bands[:-1]} <= {rows}
        parts.append(np.concatenate(bands))
    assert len(whole) == 2
    for got, wanted in zip(parts, whole, strict=True):
        np.testing.assert_array_equal(got, wanted)


@pytest.mark.parametrize("language", LANGUAGES)
def test_rows_that_are_not_read_are_passed_over(language):
    data = contract.stream(language, PICTURE, PICTURE[:7], PICTURE)
    seen = []
    for page in pages(BytesIO(data).read):
        if page.height == 7:
            next(page.bands(3))
        seen.append((page.width, page.height, page.offset))
    assert [entry[:2] for entry in seen] == [(30, 20), (30, 7), (30, 20)]
    assert seen[0][2] == (12 if language.name == "urf" else 4)


def colour(rows, compressed, space=19, order="<"):
    """A CUPS raster page of pixels (n, width, 3), compressed pixel by pixel as literals and runs."""
    height, width, _ = rows.shape
    values = {"cupsWidth": width, "cupsHeight": height, "cupsBitsPerColor": 8, "cupsBitsPerPixel": 24}
    values |= {"cupsBytesPerLine": 3 * width, "cupsColorSpace": space, "HWResolution": (300, 600)}
    values |= {"cupsInteger": tuple(range(16)), "cupsString": ("a",) * 16, "cupsRowCount": 5}
    sync = (b"2SaR" if compressed else b"3SaR") if order == "<" else b"RaS2" if compressed else b"RaS3"
    head = sync + PAGE.write(values, order)
    if not compressed:
        return head + rows.tobytes()
    body = b""
    for row in rows:
        half = width // 2
        body += b"\0" + b"".join(b"\0" + pixel.tobytes() for pixel in row[:half])
        rest = row[half:]
        body += bytes([257 - len(rest)]) + rest.tobytes() if len(rest) > 1 else b"\0" + rest.tobytes()
    return head + body


@pytest.mark.parametrize("compressed", [True, False])
@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("space", [1, 19])
def test_colour(compressed, order, space):
    rows = np.random.default_rng(0).integers(0, 256, (11, 40, 3)).astype(np.uint8)
    (page,) = list(pages(BytesIO(colour(rows, compressed, space, order)).read))
    assert (page.bits, page.size, page.space.colours, page.dpi) == (24, 120, 3, (300.0, 600.0))
    assert page.header["cupsInteger"] == tuple(range(16))
    assert page.header["cupsRowCount"] == 5
    (page,) = pages(BytesIO(colour(rows, compressed, space, order)).read)
    assert page.height == 11


def test_pixels_of_colour_in_runs_and_blanks():
    rows = np.zeros((2, 5, 3), np.uint8)
    head = colour(rows, True)[: 4 + 1796]
    body = b"\0\2abc\xffdefghi" + b"\0\0xyz\x80"
    page = next(pages(BytesIO(head + body).read))
    (band,) = page.bands()
    assert band.tobytes() == b"abcabcabcdefghi" + b"xyz" + b"\xff" * 12


@pytest.mark.parametrize("language", LANGUAGES)
def test_memory_is_that_of_a_band(language):
    """A page of 40 MB, of which no more than a band and what is on its way is held."""
    band = np.random.default_rng(0).integers(0, 256, (100, 2000)).astype(np.uint8)
    page = contract.page(language, np.zeros((1, 2000), np.uint8), levels=256)
    rows = (band for _ in range(200))
    page = type(page)(2000, 20_000, rows, page.levels, page.dpi)
    made = (piece.data for piece in language.encode([page]))
    held = b""

    def read(most):
        nonlocal held
        while not held:
            piece = next(made, b"")
            if not piece:
                return b""
            held = piece
        got, held = held[:most], held[most:]
        return got

    tracemalloc.start()
    try:
        count = sum(len(part) for got in pages(read) for part in got.bands())
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert count == 20_000
    assert peak < 3 << 20


def test_long_lines_that_come_slowly_are_not_tried_again_and_again():
    """A line of 4 MB in pieces of 64 KiB: it is tried whenever there is twice as much of it."""
    pixels = np.random.default_rng(0).integers(0, 256, (1_000_000, 3)).astype(np.uint8)
    values = {"cupsWidth": 1_000_000, "cupsHeight": 1, "cupsBitsPerColor": 8, "cupsBitsPerPixel": 24}
    values |= {"cupsBytesPerLine": 3_000_000, "cupsColorSpace": 19}
    body = np.zeros((1_000_000, 4), np.uint8)  # every pixel is a packet
    body[:, 1:] = pixels
    file, asked = BytesIO(b"2SaR" + PAGE.write(values, "<") + b"\0" + body.tobytes()), []

    def read(most):
        asked.append(most)
        return file.read(min(most, 1 << 16))

    (band,) = next(pages(read)).bands()
    assert band.tobytes() == pixels.tobytes()
    tries = 1 + sum(size > before for before, size in pairwise(asked))
    assert 3 <= tries <= 12


@pytest.mark.parametrize(
    ("data", "offset", "name"),
    [
        (b"", 0, "cups-raster"),
        (b"abcd", 0, "cups-raster"),
        (b"UNIRAST\0\0", 9, "urf"),
        (b"RaS2", 4, "cups-raster"),
    ],
)
def test_what_is_no_stream(data, offset, name):
    with pytest.raises(ProtocolError) as caught:
        list(pages(BytesIO(data).read))
    assert (caught.value.offset, caught.value.language) == (offset, name)


def test_a_size_is_not_believed():
    """A page of 2^48 pixels in a stream of 1800 bytes is refused where its rows should be."""
    values = {
        "cupsWidth": 0xFFFFFF,
        "cupsHeight": 0xFFFFFF,
        "cupsBitsPerColor": 1,
        "cupsBitsPerPixel": 1,
    }
    values |= {"cupsBytesPerLine": 1 << 21, "cupsColorSpace": 3}
    for sync in (b"RaS2", b"RaS3"):
        data = sync + PAGE.write(values, ">")
        with pytest.raises(ProtocolError) as caught:
            list(pages(BytesIO(data).read))
        assert caught.value.offset == len(data)
        with pytest.raises(ProtocolError, match="more pixels than allowed") as caught:
            list(pages(BytesIO(data).read, limit=1 << 28))
        assert caught.value.offset == 4 + PAGE.place("cupsHeight")
