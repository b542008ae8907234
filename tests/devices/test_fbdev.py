"""Pixels on a Linux frame buffer, with a driver of our own in place of the kernel's."""

from __future__ import annotations

import struct
import sys

import numpy as np
import pytest

from devices import fbdev
from devices.fbscreen import (
    FIX,
    MONO01,
    MONO10,
    PSEUDOCOLOR,
    STATIC_PSEUDOCOLOR,
    TRUECOLOR,
    VAR,
    Field,
)
from halftone.errors import UsageError
from tests.devices.simulated_screen import (
    ARGB,
    BGR565,
    EIGHT,
    NONE,
    NUMBERS,
    RGB565,
    XRGB,
    checkers,
    opened,
)

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="frame buffers are Linux's")


def test_the_structures_are_the_kernel_s():
    """Sizes and places as a C compiler gives them for linux/fb.h on a 64-bit machine."""
    assert VAR.size == 160
    if struct.calcsize("P") == 8:
        assert FIX.size == 80
        assert (
            fbdev.Screen.parse(
                struct.pack("=16sQ4I3H2xI28x", b"x", 0, 9, 0, 0, 2, 1, 1, 1, 77), bytes(160)
            ).stride
            == 77
        )


@pytest.mark.parametrize(("visual", "black"), [(MONO01, 1), (MONO10, 0)])
@pytest.mark.parametrize(
    ("order", "big"), [(None, sys.byteorder == "big"), ("lsb", False), ("msb", True)]
)
def test_monochrome(driver, visual, black, order, big):
    """1 is black or white, the leftmost pixel where Linux has it or where it is said to be."""
    fake = driver(visual, 1, width=13, height=3)
    with opened(fake, order=order) as screen:
        assert screen.write(checkers(1, 5), 2, at=(1, 3)) == (1, 3)
        expected = np.zeros((3, 13), np.uint8)
        expected[1, 3:8] = [0, 1, 0, 1, 0]
        assert np.array_equal(screen.snapshot(), expected)
    packed = np.packbits(expected ^ black, axis=1, bitorder="big" if big else "little")
    rows = np.frombuffer(fake.memory, np.uint8)[: 3 * fake.stride].reshape(3, -1)
    mask = np.packbits(np.ones((1, 13), np.uint8), axis=1, bitorder="big" if big else "little")
    assert np.array_equal(rows[:, :2] & mask, packed)
    assert np.array_equal(rows[:, :2] & ~mask, np.full((3, 2), 0x5A) & ~mask)
    assert (rows[:, 2:] == 0x5A).all()


def test_pixels_in_a_byte_reversed(driver):
    """FB_NONSTD_REV_PIX_IN_B."""
    fake = driver(MONO10, 1, width=8, height=1, nonstd=2)
    with opened(fake) as screen:
        screen.write(np.array([[1, 0, 0, 0, 0, 0, 0, 0]], np.uint8), 2)
    assert fake.memory[0] == (0x80 if sys.byteorder == "little" else 0x01)


@pytest.mark.parametrize("bits", [2, 4, 8])
def test_a_colour_map_of_grays(driver, bits):
    """It is loaded with the sRGB codes of the levels, and what was there comes back."""
    field = (0, bits, 0)
    fake = driver(PSEUDOCOLOR, bits, (field, field, field, NONE), width=11, height=2)
    before = fake.colours.copy()
    picture = np.arange(8, dtype=np.uint8).reshape(2, 4) % 4
    light = np.array([0.0, 0.0031308, 0.21404114, 1.0])
    with opened(fake) as screen:
        assert screen.write(picture, light, at=(0, 5)) == (0, 5)
        grays = np.array([0, 0.04045, 0.5, 1]) * 65535
        assert np.abs(fake.colours[:, :4] - grays).max() <= 1
        assert (fake.colours[:, 4 : 1 << bits] == 0).all()
        assert np.array_equal(fake.colours[:, 1 << bits :], before[:, 1 << bits :])
        assert np.array_equal(screen.snapshot()[:, 5:9], picture)
        assert (screen.snapshot()[:, :5] == 0).all()
        screen.write(picture, light, response="linear")
        assert np.array_equal(fake.colours[0, :4], np.rint(light * 65535))
        with pytest.raises(UsageError, match="not for RGB"):
            screen.write(np.zeros((2, 2, 3), np.uint8))
    assert np.array_equal(fake.colours, before)


def test_more_levels_than_colours(driver):
    field = (0, 4, 0)
    with opened(driver(PSEUDOCOLOR, 4, (field, field, field, NONE))) as screen:
        screen.write(checkers(1, 1), 16)
        with pytest.raises(UsageError, match="17 levels on .*; allowed: up to 16"):
            screen.write(checkers(1, 1), 17)


def test_a_colour_number_in_the_upper_bits(driver):
    field = (4, 4, 0)
    fake = driver(PSEUDOCOLOR, 8, (field, field, field, NONE), width=4, height=1)
    with opened(fake) as screen:
        screen.write(np.array([[0, 1, 2, 15]], np.uint8), 16)
        assert screen.snapshot().tolist() == [[0, 1, 2, 15]]
    assert fake.memory[:4] == bytes([0, 16, 32, 240])


def test_fixed_colours(driver):
    """Of a colour map that cannot be changed, the nearest grays; levels it does not have are refused."""
    fake = driver(STATIC_PSEUDOCOLOR, 8, width=3, height=1)
    fake.colours[:] = 0
    fake.colours[:, 7], fake.colours[:, 9], fake.colours[0, 11] = 65535, 32000, 65535
    before = fake.colours.copy()
    with opened(fake) as screen:
        screen.write(np.array([[0, 1, 2]], np.uint8), 3)
        assert fake.memory[:3] == bytes([0, 9, 7])
        with pytest.raises(UsageError, match="no 16 grays"):
            screen.write(np.array([[0, 1, 2]], np.uint8), 16)
        with pytest.raises(UsageError, match="STATIC_PSEUDOCOLOR, without a look-up table"):
            screen.set_lut(np.zeros(256))
    assert np.array_equal(fake.colours, before)
    assert 0x4605 not in fake.calls


@pytest.mark.parametrize(
    ("bits", "fields", "expected"),
    [
        (16, RGB565, [0x0000, 0x8410, 0xFFFF]),
        (24, XRGB, [0x000000, 0x808080, 0xFFFFFF]),
        (32, XRGB, [0x000000, 0x808080, 0xFFFFFF]),
        (32, ARGB, [0xFF000000, 0xFF808080, 0xFFFFFFFF]),
        (8, ((5, 3, 0), (2, 3, 0), (0, 2, 0), NONE), [0x00, 0x92, 0xFF]),
    ],
)
def test_levels_in_true_colour(driver, bits, fields, expected):
    """Each field gets the nearest of its own codes: code 0.5 of 3, 7, 31, 63, 255 is 2, 4, 16, 32, 128
    (halves to even), whatever the number of bits."""
    fake = driver(TRUECOLOR, bits, fields, width=3, height=1)
    with opened(fake) as screen:
        screen.write(np.array([[0, 1, 2]], np.uint8), [0, 0.5, 1], response="linear")
    pixels = b"".join(value.to_bytes(bits // 8, sys.byteorder) for value in expected)
    assert fake.memory[: len(pixels)] == pixels


def test_lighter_than_white_is_white(driver):
    fake = driver(TRUECOLOR, 24, XRGB, width=3, height=1)
    with opened(fake) as screen:
        screen.write(np.array([[0, 1, 2]], np.uint8), [0, 1, 3])
        assert screen.snapshot().tolist() == [[[0] * 3, [255] * 3, [255] * 3]]


@pytest.mark.parametrize(("fields", "red"), [(RGB565, 0xF800), (BGR565, 0x001F)])
def test_rgb_codes_by_bitfields(driver, fields, red):
    fake = driver(TRUECOLOR, 16, fields, width=5, height=3)
    with opened(fake) as screen:
        assert screen.write(np.array([[[255, 0, 0]]], np.uint8)) == (1, 2)
        seen = screen.snapshot()
    pixels = np.frombuffer(fake.memory, np.uint16)[: 3 * fake.stride // 2].reshape(3, -1)
    assert pixels[1, 2] == red
    assert np.count_nonzero(pixels[:, :5]) == 1
    assert seen[1, 2].tolist() == [255, 0, 0]
    assert seen.sum() == 255


def test_every_rgb_code_comes_back(driver):
    fake = driver(TRUECOLOR, 24, XRGB, width=32, height=24)
    picture = np.random.default_rng(1).integers(0, 256, (24, 32, 3), np.uint8)
    with opened(fake) as screen:
        screen.write(picture)
        assert np.array_equal(screen.snapshot(), picture)


def test_the_highest_bit_at_the_right(driver):
    fake = driver(TRUECOLOR, 16, ((0, 5, 1), (5, 6, 1), (11, 5, 1), NONE), width=1, height=1)
    with opened(fake) as screen:
        screen.write(np.array([[[8, 4, 132]]], np.uint8))  # 1, 1 and 16 of their fields
        assert screen.snapshot().tolist() == [[[8, 4, 132]]]
    assert np.frombuffer(fake.memory, np.uint16)[0] == 1 << 4 | 1 << 10 | 1 << 11
    assert Field(2, 3, 1).get(Field(2, 3, 1).put(3 / 7)) == 3


@pytest.mark.parametrize(
    ("visual", "field", "expected", "seen"),
    [
        (STATIC_PSEUDOCOLOR, EIGHT, 128, 128),
        (TRUECOLOR, NONE, 128, 128),
        (TRUECOLOR, (4, 4, 0), 8 << 4, 136),
    ],
)
def test_a_gray_screen(driver, visual, field, expected, seen):
    """grayscale = 1: one field, whatever the others say, or all bits if it says nothing."""
    fake = driver(visual, 8, (field, NONE, (1, 1, 0), NONE), width=1, height=1, grayscale=1)
    with opened(fake) as screen:
        screen.write(np.array([[1]], np.uint8), [0, 0.502, 1], response="linear")
        assert fake.memory[0] == expected
        assert screen.snapshot().tolist() == [[[seen] * 3]]
        with pytest.raises(UsageError, match="not for RGB"):
            screen.write(np.zeros((1, 1, 3), np.uint8))


def test_only_what_is_in_view_changes(driver):
    """Longer lines, a panned view that begins within a byte, and memory that begins within a page."""
    for bits, visual in (
        (1, MONO10),
        (4, PSEUDOCOLOR),
        (8, PSEUDOCOLOR),
        (16, TRUECOLOR),
        (24, TRUECOLOR),
    ):
        fields = XRGB if bits == 24 else RGB565 if bits == 16 else NUMBERS
        options = {"left": 3, "top": 2, "lines": 9, "stride": 64, "start": 4096 * 3 + 100}
        fake = driver(visual, bits, fields, width=10, height=4, **options)
        with opened(fake, order="lsb") as screen:
            screen.write(checkers(4, 10), 2)
        for line in range(9):
            row = int.from_bytes(fake.memory[line * 64 : line * 64 + 64], "little")
            untouched = int.from_bytes(b"\x5a" * 64, "little")
            view = ((1 << 10 * bits) - 1) << 3 * bits
            assert row & ~view == untouched & ~view
            if 2 <= line < 6 and sys.byteorder == "little":
                one = 1 if bits in (1, 4, 8) else (1 << bits) - 1
                pixels = [row >> (3 + x) * bits & (1 << bits) - 1 for x in range(10)]
                assert pixels == [one * ((line + x) % 2) for x in range(10)]
            else:
                assert row & view == untouched & view
        assert fake.path.read_bytes()[:100] == b"\x5a" * 100


def test_a_view_that_wraps(driver):
    """FB_VMODE_YWRAP: after the last line comes the first."""
    fake = driver(PSEUDOCOLOR, 8, width=4, height=3, lines=4, top=3, vmode=256, start=4096 + 4090)
    picture = np.arange(12, dtype=np.uint8).reshape(3, 4)
    with opened(fake) as screen:
        screen.write(picture, 16)
        assert np.array_equal(screen.snapshot(), picture)
    rows = np.frombuffer(fake.memory, np.uint8)[:16].reshape(4, 4)
    assert np.array_equal(rows[[3, 0, 1]], picture)
    assert (rows[2] == 0x5A).all()
