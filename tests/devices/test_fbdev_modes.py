"""Modes, colour maps and failures of a Linux frame buffer, with a driver of our own."""

from __future__ import annotations

import errno
import mmap
import os
import sys

import numpy as np
import pytest

from devices import fbdev, fbscreen
from devices.errors import DeviceBusyError, DevicePermissionError
from devices.fbdev import LinuxFrameBuffer, show
from devices.fbscreen import (
    DIRECTCOLOR,
    MONO01,
    MONO10,
    PSEUDOCOLOR,
    TRUECOLOR,
)
from halftone.errors import DeviceFaultError, DeviceNotFoundError, InputError, UsageError
from halftone.frame import Frame
from halftone.tone.levels import Levels
from halftone.tone.lut import gamma_table, hardware_table
from tests.devices.simulated_screen import (
    ARGB,
    NUMBERS,
    RGB565,
    XRGB,
    checkers,
    opened,
)

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="frame buffers are Linux's")


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
