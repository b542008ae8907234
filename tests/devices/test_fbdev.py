"""A Linux frame buffer, with a driver of our own in place of the kernel's."""

from __future__ import annotations

import ctypes
import errno
import mmap
import os
import struct
import sys
from pathlib import Path

import numpy as np
import pytest

from devices import fbdev, fbscreen
from devices.errors import DeviceBusyError, DevicePermissionError
from devices.fbdev import LinuxFrameBuffer, show
from devices.fbnode import Kernel
from devices.fbscreen import (
    DIRECTCOLOR,
    FIX,
    MONO01,
    MONO10,
    PSEUDOCOLOR,
    STATIC_PSEUDOCOLOR,
    TRUECOLOR,
    VAR,
    Field,
)
from halftone.errors import DeviceFaultError, DeviceNotFoundError, InputError, UsageError
from halftone.frame import Frame
from halftone.tone.levels import Levels
from halftone.tone.lut import gamma_table, hardware_table

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="frame buffers are Linux's")

NONE, EIGHT = (0, 0, 0), (0, 8, 0)
RGB565 = ((11, 5, 0), (5, 6, 0), (0, 5, 0), NONE)
BGR565 = ((0, 5, 0), (5, 6, 0), (11, 5, 0), NONE)
XRGB = ((16, 8, 0), (8, 8, 0), (0, 8, 0), NONE)
ARGB = ((16, 8, 0), (8, 8, 0), (0, 8, 0), (24, 8, 0))
NUMBERS = (EIGHT, EIGHT, EIGHT, NONE)
PLACES = {"lines": 3, "left": 4, "top": 5, "grayscale": 7, "nonstd": 20, "vmode": 33}
"""Of the numbers of fb_var_screeninfo."""


class Driver(Kernel):
    """A screen whose picture memory is a file; what it says of itself is what a test wants."""

    def __init__(self, path: Path, visual=MONO10, bits=1, fields=NUMBERS, width=16, height=4, **changes):
        self.path, self.opened, self.mapped = path, [], []
        self.calls = []
        self.fail = {}
        self.modes = {bits}
        self.entries = 256
        self.colours = np.arange(3 * 256, dtype=np.uint16).reshape(3, 256)
        self.var = [width, height, width, height, 0, 0, bits, 0]
        self.var += [number for field in fields for number in field] + [0] * 20
        self.start, self.kind, self.visual = 4096 * 7, 0, visual
        self.stride = (width * bits + 31) // 32 * 4
        for name, value in changes.items():
            if name in ("stride", "start", "kind"):
                setattr(self, name, value)
            else:
                place = PLACES[name]
                self.var[place] = value
        self.size = self.stride * self.var[3]
        path.write_bytes(b"\x5a" * (self.start % mmap.PAGESIZE + max(self.size, 4096)))

    def open(self, path):
        self.step("open")
        self.opened.append(super().open(str(self.path)))
        return self.opened[-1]

    def map(self, file, length):
        self.step("map")
        self.mapped.append(super().map(file, length))
        return self.mapped[-1]

    def step(self, what):
        self.calls.append(what)
        if what in self.fail:
            raise OSError(self.fail[what], os.strerror(self.fail[what]))

    def ioctl(self, file, request, argument):
        self.step(request)
        if request == 0x4600:
            argument[:] = VAR.pack(*self.var)
        elif request == 0x4601:
            self.set_var(list(VAR.unpack(argument)))
        elif request == 0x4602:
            lengths = (self.size, self.kind, 0, self.visual, 1, 1, 0, self.stride)
            argument[:] = FIX.pack(b"Fake FB", self.start, *lengths, 0, 0, 0, 0, 0, 0)
        else:
            start, count, *places, alpha = struct.unpack("@IIPPPP", argument)
            assert (start, alpha) == (0, 0)
            assert count <= self.entries
            for colours, place in zip(self.colours, places, strict=True):
                entries = (ctypes.c_uint16 * count).from_address(place)
                if request == 0x4604:
                    entries[:] = colours[:count].tolist()
                else:
                    colours[:count] = entries[:]

    def set_var(self, var):
        if var[6] not in self.modes:
            raise OSError(errno.EINVAL, "no")
        self.var = var
        self.stride = (var[2] * var[6] + 31) // 32 * 4

    @property
    def memory(self) -> bytes:
        return self.path.read_bytes()[self.start % mmap.PAGESIZE :]

    def nothing_is_open(self) -> bool:
        return all(file.closed for file in self.opened) and all(each.closed for each in self.mapped)


@pytest.fixture
def driver(tmp_path):
    made = []

    def make(*given, **changes):
        made.append(Driver(tmp_path / f"fb{len(made)}", *given, **changes))
        return made[-1]

    yield make
    assert all(each.nothing_is_open() for each in made)


def opened(driver, **options):
    return LinuxFrameBuffer(kernel=driver, **options)


def checkers(rows, columns):
    return (np.add.outer(np.arange(rows), np.arange(columns)) % 2).astype(np.uint8)


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


def test_a_look_up_table(driver):
    """Of colour numbers: write leaves it alone; of the three channels, which may differ in size."""
    fake = driver(PSEUDOCOLOR, 8)
    before = fake.colours.copy()
    with opened(fake) as screen:
        table = gamma_table(256, 2.2)
        screen.set_lut(table, blue=hardware_table(np.arange(256) / 255))
        assert np.array_equal(fake.colours[0], np.rint(table * 65535))
        assert np.array_equal(fake.colours[1], fake.colours[0])
        assert np.array_equal(fake.colours[2], np.arange(256) * 257)
        loaded = fake.colours.copy()
        screen.write(checkers(4, 4), 2)
        assert np.array_equal(fake.colours, loaded)
        assert np.array_equal(screen.colour_map(), loaded)
        for bad in (table[:255], table + 0.1, table - 0.1, table * np.nan):
            with pytest.raises(UsageError, match="256 voltages from 0 to 1"):
                screen.set_lut(bad)
    assert np.array_equal(fake.colours, before)


def test_direct_colour(driver):
    """Straight lines are loaded, unless set_lut gave something else."""
    fake = driver(DIRECTCOLOR, 16, RGB565)
    before = fake.colours.copy()
    with opened(fake) as screen:
        screen.write(np.full((1, 1, 3), 255, np.uint8))
        assert np.array_equal(fake.colours[0, :32], np.rint(np.arange(32) / 31 * 65535))
        assert np.array_equal(fake.colours[1, :64], np.rint(np.arange(64) / 63 * 65535))
        screen.set_lut(gamma_table(32, 2) / 3, gamma_table(64, 2))
        assert np.array_equal(fake.colours[2, :32], np.rint(np.sqrt(np.arange(32) / 31) * 21845))
        assert (fake.colours[2, 32:64] == 21845).all()
        with pytest.raises(UsageError, match="a green table of shape .32.*64 voltages"):
            screen.set_lut(gamma_table(32, 2))
    assert np.array_equal(fake.colours, before)


def test_no_look_up_table(driver):
    for visual, bits, fields in ((TRUECOLOR, 32, XRGB), (MONO01, 1, NUMBERS)):
        with (
            opened(driver(visual, bits, fields)) as screen,
            pytest.raises(UsageError, match="without a look-up table that can be written.*set_mode"),
        ):
            screen.set_lut(gamma_table(256, 2.2))


def test_a_mode_and_back(driver):
    """The colours of the first mode are put back in it, and the mode at close."""
    fake = driver(PSEUDOCOLOR, 8, width=16, height=4)
    fake.modes = {8, 16}
    before, colours = list(fake.var), fake.colours.copy()
    with opened(fake) as screen:
        screen.write(checkers(2, 2), 2)
        assert not np.array_equal(fake.colours, colours)
        screen.set_mode(8, 3, 16)
        assert np.array_equal(fake.colours, colours)
        assert (screen.screen.width, screen.screen.height, screen.screen.stride) == (8, 3, 16)
        assert fake.var[:7] == [8, 3, 8, 3, 0, 0, 16]
        screen.set_mode(9, 3, 8)
    assert fake.var == before
    assert fake.calls.count(0x4601) == 3


def test_what_a_mode_asks_for(driver):
    """No layout of the mode before it: the driver is to say what it has."""
    fake = driver(TRUECOLOR, 32, ARGB, left=2, top=1, lines=9, grayscale=0x36314752, nonstd=2)
    fake.modes = {16, 32}
    with opened(fake) as screen:
        screen.set_mode(8, 3, 16)
        assert fake.var == [8, 3, 8, 3, 0, 0, 16, *[0] * 33]
        fake.var[fbscreen.GRAYSCALE] = 1
        screen.set_mode(8, 2, 16)
        assert fake.var[fbscreen.GRAYSCALE] == 1


def test_a_mode_that_is_not_had(driver):
    fake = driver(PSEUDOCOLOR, 8)
    before, colours = list(fake.var), fake.colours.copy()
    with opened(fake) as screen:
        screen.set_lut(gamma_table(256, 2))
        own = fake.colours.copy()
        with pytest.raises(UsageError, match="no mode of 8 × 8 pixels of 4 bits"):
            screen.set_mode(8, 8, 4)
        for mode in ((-1, 8, 8), (8, 2.5, 8), (8, 8, 1 << 40)):
            with pytest.raises(UsageError, match="whole numbers"):
                screen.set_mode(*mode)
        rounds = fake.set_var
        fake.set_var = lambda var: rounds([*var[:6], 8, *var[7:]])
        with pytest.raises(
            UsageError, match="no mode of 8 × 3 pixels of 4 bits; nearest: 8 × 3 pixels of 8"
        ):
            screen.set_mode(8, 3, 4)
        assert fake.var == before
        assert np.array_equal(fake.colours, own)
        fake.fail[0x4601] = errno.ENOMEM
        with pytest.raises(UsageError, match="video memory"):
            screen.set_mode(8, 3, 8)
        fake.fail[0x4601] = errno.EBUSY
        with pytest.raises(DeviceBusyError, match="another program"):
            screen.set_mode(8, 3, 8)
        fake.fail.clear()
        assert screen.write(checkers(4, 16), 2) == (0, 0)
        assert np.array_equal(fake.colours, own)
    assert fake.var == before
    assert np.array_equal(fake.colours, colours)


def test_what_does_not_fit_is_refused(driver):
    with opened(driver(MONO10, 1, width=16, height=4)) as screen:
        for shape in ((5, 2), (2, 17)):
            with pytest.raises(UsageError, match="on a screen of 16 × 4; allowed: what fits"):
                screen.write(np.zeros(shape, np.uint8), 2)
        for at, match in (
            ((3, 0), "row of at.*0 … 2"),
            ((-1, 0), "row of at"),
            ((0, 15), "column .*0 … 14"),
        ):
            with pytest.raises(UsageError, match=match):
                screen.write(np.zeros((2, 2), np.uint8), 2, at=at)
        with pytest.raises(UsageError, match="row of at"):
            screen.write(np.zeros((2, 2), np.uint8), 2, at=(0.5, 0))
        assert screen.write(np.zeros((2, 2), np.uint8), 2, at=(2, 14)) == (2, 14)
        with pytest.raises(UsageError, match="3 levels .* has 2; dither with levels=2"):
            screen.write(np.zeros((2, 2), np.uint8), 3)
        with pytest.raises(InputError, match="level 2; allowed: 0 … 1"):
            screen.write(np.full((2, 2), 2, np.uint8), 2)
        with pytest.raises(UsageError, match="levels are missing"):
            screen.write(np.zeros((2, 2), np.uint8))
        with pytest.raises(UsageError, match="which has its own"):
            screen.write(Frame(np.zeros((2, 2), np.uint8), Levels.of(2)), 2)
        with pytest.raises(UsageError, match="levels with an RGB"):
            screen.write(np.zeros((2, 2, 3), np.uint8), 2)
        for bad in (
            np.zeros((2, 2)),
            np.zeros((2, 2, 4), np.uint8),
            np.zeros((0, 2), np.uint8),
            object(),
        ):
            with pytest.raises(InputError, match="allowed: a Frame, uint8"):
                screen.write(bad, 2)
    with pytest.raises(UsageError, match="bit order 'middle'"):
        LinuxFrameBuffer(order="middle")


@pytest.mark.parametrize(
    ("visual", "bits", "changes", "kind", "match"),
    [
        (6, 16, {}, UsageError, "visual FOURCC.*set_mode"),
        (9, 16, {}, UsageError, "visual 9"),
        (MONO01, 2, {}, UsageError, "2 bits a pixel"),
        (PSEUDOCOLOR, 16, {}, UsageError, "16 bits a pixel"),
        (TRUECOLOR, 15, {}, UsageError, "15 bits"),
        (TRUECOLOR, 16, {"grayscale": 0x36314752}, UsageError, "grayscale 909199186"),
        (PSEUDOCOLOR, 4, {"kind": 1}, UsageError, "type 1"),
        (PSEUDOCOLOR, 8, {"stride": 15}, DeviceFaultError, "lines of 15 bytes, of which 16 are used"),
        (PSEUDOCOLOR, 8, {"lines": 3}, DeviceFaultError, "lie in 48 bytes"),
        (PSEUDOCOLOR, 8, {"lines": 0, "vmode": 256}, DeviceFaultError, "0 lines"),
        (PSEUDOCOLOR, 8, {"top": 1}, DeviceFaultError, "5 lines"),
        (TRUECOLOR, 16, {}, DeviceFaultError, "Field.offset=16"),
    ],
)
def test_a_layout_that_is_not_known(driver, visual, bits, changes, kind, match):
    fields = XRGB if visual == TRUECOLOR else NUMBERS
    with opened(driver(visual, bits, fields, **changes)) as screen:
        for call in (
            lambda: screen.write(checkers(1, 1), 2),
            screen.snapshot,
            lambda: screen.set_lut([0]),
        ):
            with pytest.raises(kind, match=match):
                call()


@pytest.mark.parametrize(
    ("number", "kind", "match"),
    [
        (errno.ENOENT, DeviceNotFoundError, "ls /dev/fb"),
        (errno.ENODEV, DeviceNotFoundError, "modprobe vfb"),
        (errno.EACCES, DevicePermissionError, "usermod -aG video"),
        (errno.EBUSY, DeviceBusyError, "another program"),
    ],
)
def test_it_cannot_be_opened(driver, number, kind, match):
    fake = driver()
    fake.fail["open"] = number
    with pytest.raises(kind, match=match):
        opened(fake)


def test_no_frame_buffer(tmp_path):
    """By the real calls: what is not there, and what is something else."""
    with pytest.raises(DeviceNotFoundError, match="cannot be opened"):
        LinuxFrameBuffer(str(tmp_path / "fb0"))
    (tmp_path / "file").write_bytes(bytes(4096))
    with pytest.raises(DeviceNotFoundError, match="is not a frame buffer"):
        show(checkers(2, 2), str(tmp_path / "file"), 2)
    with pytest.raises(DeviceNotFoundError, match="cannot be opened"):
        LinuxFrameBuffer(str(tmp_path))


@pytest.mark.parametrize("call", ["map", 0x4600, 0x4602])
@pytest.mark.parametrize("number", [errno.EIO, errno.EINVAL, errno.ENOTTY, errno.EPERM])
def test_nothing_stays_open_if_it_fails(driver, call, number):
    fake = driver()
    fake.fail[call] = number
    with pytest.raises((DeviceFaultError, UsageError, DeviceNotFoundError)):
        opened(fake)
    assert len(fake.opened) == 1
    assert fake.nothing_is_open()


def test_close(driver):
    """Twice is as once; afterwards it says so; and it lets go even if it cannot put things back."""
    fake = driver(PSEUDOCOLOR, 8)
    screen = opened(fake)
    screen.write(checkers(2, 2), 2)
    screen.close()
    calls = len(fake.calls)
    screen.close()
    assert len(fake.calls) == calls
    for call in (screen.snapshot, screen.colour_map, lambda: screen.write(checkers(1, 1), 2)):
        with pytest.raises(UsageError, match="was closed"):
            call()
    mode = list(fake.var)
    screen = opened(fake)
    screen.set_mode(8, 2, 8)
    screen.write(checkers(2, 2), 2)
    fake.fail[0x4605] = errno.EIO
    with pytest.raises(DeviceFaultError, match="0x4605"):
        screen.close()
    assert fake.nothing_is_open()
    assert fake.var == mode


def test_left_as_it_is(driver, monkeypatch):
    """restore=False, and so show()."""
    fake = driver(PSEUDOCOLOR, 8)
    monkeypatch.setattr(fbdev, "Kernel", lambda: fake)
    frame = Frame(checkers(4, 16), Levels.of([0, 1]))
    assert show(frame, "fb") == (0, 0)
    assert fake.colours[:, :2].tolist() == [[0, 65535]] * 3
    assert fake.memory[:16] == bytes([0, 1] * 8)
    assert fake.calls.count(0x4605) == 1


@pytest.mark.parametrize(("number", "fails"), [(errno.EINVAL, False), (errno.EIO, True)])
def test_flushing(driver, monkeypatch, number, fails):
    """EINVAL is a kernel that has nothing to flush; else the picture is not on the screen."""

    class Memory(mmap.mmap):
        def flush(self, *given):
            raise OSError(number, os.strerror(number))

    fake = driver(MONO10, 1)
    monkeypatch.setattr("devices.fbnode.mmap.mmap", Memory)
    with opened(fake) as screen:
        if fails:
            with pytest.raises(DeviceFaultError, match="not brought up to date"):
                screen.write(checkers(1, 1), 2)
        else:
            assert screen.write(checkers(1, 1), 2, at=(0, 0)) == (0, 0)


@pytest.mark.parametrize("bits", [16, 24, 32])
def test_the_lowest_bytes_on_either_kind_of_machine(monkeypatch, bits):
    """24 bits of four bytes: the first three or the last three."""
    word = np.array([[0x01020304]], np.uint32).astype("<u4").view(np.uint32)
    monkeypatch.setattr(fbscreen.sys, "byteorder", "little")
    assert fbscreen._as_bytes(word, bits // 8).tobytes() == bytes([4, 3, 2, 1][: bits // 8])
    monkeypatch.setattr(fbscreen.sys, "byteorder", "big")
    swapped = word.byteswap()
    assert fbscreen._as_bytes(swapped, bits // 8).tobytes() == bytes([1, 2, 3, 4][4 - bits // 8 :])
