"""Pixel formats: against a twin that sets bit by bit, against drivers' own layouts, and mistakes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from devices.pixels import FORMATS, Field, Fields, Indexed, Planes, pixel_format
from halftone.errors import UsageError
from halftone.packing import Packing
from tests.oracle.framebuffer import bit_field_bytes, plane_bytes
from tests.oracle.packing import pack_row

RGB = sorted(name for name, form in FORMATS.items() if form.channels == 3)


def _codes(form: Fields | Planes, rows: int, width: int, seed: int) -> np.ndarray:
    random = np.random.default_rng(seed)
    tops = [1 << bits for bits in form.bits_per_channel]
    shape = (rows, width, 3) if form.channels == 3 else (rows, width)
    kind = np.uint8 if max(tops) <= 256 else np.uint16
    return random.integers(0, tops if form.channels == 3 else tops[0], shape).astype(kind)


@st.composite
def fields(draw: st.DrawFn) -> Fields:
    """Any three bit fields that fit, in any order, with gaps."""
    bits = draw(st.sampled_from([8, 16, 24, 32]))
    cuts = draw(st.lists(st.integers(0, bits), min_size=6, max_size=6, unique=True).map(sorted))
    made = [
        Field(low, min(high - low, 16), draw(st.booleans()))
        for low, high in zip(cuts[::2], cuts[1::2], strict=True)
    ]
    order = draw(st.permutations(made))
    return Fields(bits, *order, big_endian=draw(st.booleans()))


@given(form=fields(), seed=st.integers(0, 1000), rows=st.integers(1, 3), width=st.integers(1, 9))
def test_bit_fields_equal_the_twin_and_come_back(form: Fields, seed: int, rows: int, width: int) -> None:
    codes = _codes(form, rows, width, seed)
    packed = form.pack(codes)
    assert packed.shape == form.packed_shape(rows, width)
    places = [(f.offset, f.length, f.msb_right) for f in (form.red, form.green, form.blue)]
    for y in range(rows):
        twin = [
            byte
            for pixel in codes[y].tolist()
            for byte in bit_field_bytes(pixel, form.bits, places, form.big_endian)
        ]
        assert packed[y].tolist() == twin
    back = form.unpack(packed, width)
    assert back.dtype == codes.dtype or max(form.bits_per_channel) > 8
    assert back.tolist() == codes.tolist()


@given(
    count=st.integers(1, 16), seed=st.integers(0, 1000), rows=st.integers(1, 3), width=st.integers(1, 20)
)
def test_planes_equal_the_twin_and_come_back(count: int, seed: int, rows: int, width: int) -> None:
    form = Planes(count)
    codes = _codes(form, rows, width, seed)
    packed = form.pack(codes)
    for k in range(count):
        assert packed[k].tolist() == [plane_bytes(row, count - 1 - k) for row in codes.tolist()]
    assert form.unpack(packed, width).tolist() == codes.tolist()
    low_first = Planes(count, high_first=False)
    assert low_first.pack(codes).tolist() == packed[::-1].tolist()
    assert low_first.unpack(low_first.pack(codes), width).tolist() == codes.tolist()


@pytest.mark.parametrize("name", sorted(n for n in FORMATS if n not in RGB))
def test_indexed_formats_equal_the_twin(name: str) -> None:
    form = pixel_format(name)
    assert isinstance(form, Indexed)
    packing = form.packing
    row = np.random.default_rng(1).integers(0, 1 << packing.bits, 13).astype(np.uint8)
    packed = form.pack(row[None])
    assert packed[0].tolist() == pack_row(row.tolist(), packing.bits, packing.order, packing.codes)
    assert form.unpack(packed, 13)[0].tolist() == row.tolist()


def test_layouts_of_drivers() -> None:
    """What drivers and linux/fb.h say, byte by byte."""
    one = np.array([[[31, 0, 0], [0, 63, 0], [0, 0, 31]]], np.uint8)
    assert pixel_format("rgb565").pack(one).tolist() == [[0x00, 0xF8, 0xE0, 0x07, 0x1F, 0x00]]
    assert pixel_format("rgb565-be").pack(one).tolist() == [[0xF8, 0x00, 0x07, 0xE0, 0x00, 0x1F]]
    vfb = Fields(16, Field(0, 5), Field(5, 6), Field(11, 5))  # red lowest
    assert vfb.pack(one).tolist() == pixel_format("bgr565").pack(one).tolist()
    assert vfb.pack(one).tolist() == [[0x1F, 0x00, 0xE0, 0x07, 0x00, 0xF8]]
    true = np.array([[[1, 2, 3]]], np.uint8)
    assert pixel_format("xrgb8888").pack(true).tolist() == [[3, 2, 1, 0]]
    assert pixel_format("bgr888").pack(true).tolist() == [[1, 2, 3]]
    ink = np.array([[0, 1, 1, 1, 1, 1, 1, 0]], np.uint8)  # levels: black at both ends
    assert pixel_format("mono01").pack(ink).tolist() == [[0b10000001]]
    assert pixel_format("mono10").pack(ink).tolist() == [[0b01111110]]
    # Waveshare 7in3e: high nibble first, codes with a hole; epdiy: even x in the low nibble.
    spectra = Indexed(Packing(4, "msb", (0, 1, 2, 3, 5, 6)))
    assert spectra.pack(np.array([[0, 1, 4, 5]], np.uint8)).tolist() == [[0x01, 0x56]]
    assert pixel_format("index4-lsb").pack(np.array([[1, 2, 3]], np.uint8)).tolist() == [[0x21, 0x03]]
    # 4 grays in 2 planes, the high bits first.
    assert pixel_format("planes2").pack(np.array([[0, 1, 2, 3]], np.uint8)).tolist() == [
        [[0b00110000]],
        [[0b01010000]],
    ]


@pytest.mark.parametrize(
    ("name", "word"),
    [
        ("rgb656", "Did you mean rgb565"),
        ("index3", "index"),
        ("planes0", "planes=0"),
        ("planes17", "1 … 16"),
        ("index4-be", "unknown pixel format"),
        ("", "unknown pixel format"),
    ],
)
def test_unknown_names(name: str, word: str) -> None:
    with pytest.raises(UsageError, match=word):
        pixel_format(name)


def test_wrong_fields() -> None:
    with pytest.raises(UsageError, match="green overlaps"):
        Fields(16, Field(0, 5), Field(4, 6), Field(11, 5))
    with pytest.raises(UsageError, match="blue lies at bits 12 … 16 of a pixel of 16"):
        Fields(16, Field(0, 5), Field(5, 6), Field(12, 5))
    with pytest.raises(UsageError, match="12 bits"):
        Fields(12, Field(0, 4), Field(4, 4), Field(8, 4))
    with pytest.raises(UsageError, match="length of a bit field=0"):
        Field(0, 0)
    with pytest.raises(UsageError, match="bit order"):
        Planes(2, "left")


@pytest.mark.parametrize("name", ["rgb565", "planes3", "index4"])
def test_a_wrong_number_of_bytes_is_refused(name: str) -> None:
    form = pixel_format(name)
    good = np.zeros(form.packed_shape(2, 5), np.uint8)
    assert form.unpack(good, 5).shape[:2] == (2, 5)
    for bad in (good[..., :-1], good.astype(np.int16), good.ravel()):
        with pytest.raises(UsageError, match="packed pixels|rows of"):
            form.unpack(bad, 5)


@pytest.mark.parametrize(
    ("name", "mode", "raw", "top"),
    [
        ("mono10", "1", "1", 255),
        ("index1-lsb", "1", "1;R", 255),
        ("mono01", "1", "1;I", 255),
        ("index2", "L", "L;2", 85),
        ("index4", "L", "L;4", 17),
        ("index8", "L", "L", 1),
    ],
)
def test_pillow_reads_indexed_pixels(name: str, mode: str, raw: str, top: int) -> None:
    from PIL import Image

    form = pixel_format(name)
    levels = (
        np.random.default_rng(4).integers(0, 1 << form.bits_per_channel[0], (5, 13)).astype(np.uint8)
    )
    read = Image.frombytes(mode, (13, 5), form.pack(levels).tobytes(), "raw", raw)
    assert (np.asarray(read.convert("L")) == levels * top).all()


@pytest.mark.parametrize(
    ("name", "raw"),
    [("rgb565", "BGR;16"), ("rgb555", "BGR;15"), ("rgb888", "BGR"), ("bgr888", "RGB"),
     ("xrgb8888", "BGRX"), ("xbgr8888", "RGBX"), ("xbgr8888-be", "XRGB")],
)  # fmt: skip
def test_pillow_reads_bit_fields(name: str, raw: str) -> None:
    from PIL import Image

    form = pixel_format(name)
    assert isinstance(form, Fields)
    codes = _codes(form, 5, 13, 3)
    if raw == "XRGB":
        codes = codes[..., ::-1]  # big-endian xbgr: blue comes after the empty byte
    read = np.asarray(Image.frombytes("RGB", (13, 5), form.pack(codes).tobytes(), "raw", raw))
    tops = (1 << np.array(form.bits_per_channel)) - 1
    seen = codes[..., ::-1] if raw == "XRGB" else codes
    assert (read == seen.astype(int) * 255 // tops).all()
