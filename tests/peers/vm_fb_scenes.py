"""What is tried in the virtual machine on its frame buffer: vfb, Linux's driver of a screen in memory.

What is expected comes from here alone: plain loops over vfb's layouts (drivers/video/fbdev/vfb.c), and
the bytes as a second descriptor reads them. As in vm_scenes, one line of JSON is written for each scene.
"""

from __future__ import annotations

import ctypes
import fcntl
import json
import mmap
import os
import struct
import time
import traceback
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from devices.errors import DevicePermissionError
from devices.fbdev import LinuxFrameBuffer, show
from halftone.errors import DeviceNotFoundError, UsageError
from halftone.frame import Frame
from halftone.tone.levels import Levels
from halftone.tone.lut import gamma_table

__all__ = ["SCENES"]

NODE = "/dev/fb0"
WIDTH, HEIGHT = 75, 21
AT = (3, 10)
GRAYS = (0.0, 0.01, 0.1, 0.3, 0.6, 1.0)
CODES = (0.0, 0.09985, 0.34919, 0.58383, 0.79774, 1.0)
"""The sRGB codes of GRAYS (IEC 61966-2-1), to five digits."""
PICTURE = [[(x * 7 + y * 5 + x * y) % 6 for x in range(50)] for y in range(11)]
COLOURS = [[((x * 5) % 256, (y * 23) % 256, (x * y * 3) % 256) for x in range(50)] for y in range(11)]
FIELDS = {16: ((0, 5), (5, 6), (11, 5)), 24: ((0, 8), (8, 8), (16, 8)), 32: ((0, 8), (8, 8), (16, 8))}
OPAQUE = {16: 0, 24: 0, 32: 0xFF << 24}

Scene = Callable[[], None]


def var() -> bytearray:
    """fb_var_screeninfo, asked without us."""
    answer = bytearray(160)
    with open(NODE, "rb", buffering=0) as node:
        fcntl.ioctl(node, 0x4600, answer)
    return answer


def put_var(changes: dict[int, int]) -> None:
    numbers = list(struct.unpack("40I", var()))
    for k, value in changes.items():
        numbers[k] = value
    with open(NODE, "r+b", buffering=0) as node:
        fcntl.ioctl(node, 0x4601, bytearray(struct.pack("40I", *numbers)))


def colour_map(entries: int = 256) -> list[tuple[int, int, int]]:
    channels = [(ctypes.c_uint16 * entries)() for _ in range(3)]
    told = struct.pack("@IIPPPP", 0, entries, *map(ctypes.addressof, channels), 0)
    with open(NODE, "rb", buffering=0) as node:
        fcntl.ioctl(node, 0x4604, bytearray(told))
    return list(zip(*channels, strict=True))


def memory(size: int) -> bytes:
    """Of the screen, by read(2); another mapping must say the same."""
    with open(NODE, "r+b", buffering=0) as node:
        with mmap.mmap(node.fileno(), size) as mapped:
            by_map = mapped[:]
        got = b""
        while len(got) < size:
            got += node.read(size - len(got))
    assert got == by_map
    return got


def fill(byte: bytes, size: int) -> None:
    with open(NODE, "r+b", buffering=0) as node:
        assert node.write(byte * size) == size


def stride(width: int, bits: int) -> int:
    return (width * bits + 31) // 32 * 4


def laid_out(
    pixels: Sequence[Sequence[int]], bits: int, black: int, width: int = WIDTH, height: int = HEIGHT
) -> bytes:
    """Pixel values at AT, on black, as one number for each line, whose lowest bits are its left end."""
    lines = []
    for y in range(height):
        line = 0
        for x in range(width):
            row, column = y - AT[0], x - AT[1]
            inside = 0 <= row < len(pixels) and 0 <= column < len(pixels[0])
            line |= (pixels[row][column] if inside else black) << (x * bits)
        lines.append(line.to_bytes(stride(width, bits), "little"))
    return b"".join(lines)


def gray(code: float, bits: int) -> int:
    return sum(round(code * (2**n - 1)) << at for at, n in FIELDS[bits]) | OPAQUE[bits]


def colour(rgb: tuple[int, int, int], bits: int) -> int:
    parts = zip(rgb, FIELDS[bits], strict=True)
    return sum(round(c / 255 * (2**n - 1)) << at for c, (at, n) in parts) | OPAQUE[bits]


def same(got: bytes, expected: bytes) -> None:
    wrong = [k for k in range(len(expected)) if got[k] != expected[k]]
    assert not wrong, f"{len(wrong)} of {len(expected)} bytes, first {wrong[0]}"


def shown(bits: int, picture: object, levels: object) -> tuple[bytes, np.ndarray]:
    with LinuxFrameBuffer(NODE) as screen:
        screen.set_mode(WIDTH, HEIGHT, bits)
        fill(b"\0", HEIGHT * stride(WIDTH, bits))  # also what no picture covers
        assert screen.write(picture, levels, at=AT) == AT
        return memory(HEIGHT * stride(WIDTH, bits)), screen.snapshot()


def reads_back_1_bit() -> None:
    """MONO01: 1 is black. Bits after the last pixel keep what they were."""
    two = [[p % 2 for p in line] for line in PICTURE]
    with LinuxFrameBuffer(NODE) as screen:
        screen.set_mode(WIDTH, HEIGHT, 1)
        size = HEIGHT * stride(WIDTH, 1)
        fill(b"\0", size)
        screen.write(np.array(two, np.uint8), 2, at=AT)
        same(memory(size), laid_out([[1 - p for p in line] for line in two], 1, 1))
        expected = np.zeros((HEIGHT, WIDTH), np.uint8)
        expected[AT[0] : AT[0] + 11, AT[1] : AT[1] + 50] = two
        assert np.array_equal(screen.snapshot(), expected)


def reads_back_8_bits() -> None:
    got, seen = shown(8, np.array(PICTURE, np.uint8), GRAYS)
    same(got, laid_out(PICTURE, 8, 0))
    assert np.array_equal(seen[AT[0] : AT[0] + 11, AT[1] : AT[1] + 50], PICTURE)


def reads_back_true_colour() -> None:
    for bits in (16, 24, 32):
        got, _ = shown(bits, Frame(np.array(PICTURE, np.uint8), Levels.of(GRAYS)), None)
        pixels = [[gray(CODES[p], bits) for p in line] for line in PICTURE]
        same(got, laid_out(pixels, bits, OPAQUE[bits]))
        got, seen = shown(bits, np.array(COLOURS, np.uint8), None)
        pixels = [[colour(c, bits) for c in line] for line in COLOURS]
        same(got, laid_out(pixels, bits, OPAQUE[bits]))
        away = np.abs(seen[AT[0] : AT[0] + 11, AT[1] : AT[1] + 50].astype(int) - np.array(COLOURS))
        assert away.max() <= (4 if bits == 16 else 0), away.max()


def is_panned() -> None:
    """A larger picture memory of which a part is in view, beginning within a byte; the rest stays."""
    before = bytes(var())
    for bits in (1, 8, 24):
        put_var({0: WIDTH, 1: HEIGHT, 2: 128, 3: 64, 4: 0, 5: 0, 6: bits})
        size = 64 * stride(128, bits)
        fill(b"\xa5", size)
        put_var({4: 13, 5: 17})
        whole = [int.from_bytes(b"\xa5" * stride(128, bits), "little")] * 64
        two = [[(x + y) % 2 for x in range(WIDTH)] for y in range(HEIGHT)]
        for y, line in enumerate(two):
            for x, p in enumerate(line):
                at, ones = (13 + x) * bits, 2**bits - 1
                value = {1: 1 - p, 8: p, 24: p * 0xFFFFFF}[bits]
                whole[17 + y] = whole[17 + y] & ~(ones << at) | value << at
        with LinuxFrameBuffer(NODE) as screen:
            screen.write(np.array(two, np.uint8), 2)
        same(memory(size), b"".join(n.to_bytes(stride(128, bits), "little") for n in whole))
    put_var(dict(enumerate(struct.unpack("40I", before))))


def loads_and_restores_the_colour_map() -> None:
    first = colour_map()
    with LinuxFrameBuffer(NODE) as screen:
        assert screen.screen.bits == 8
        screen.write(np.array(PICTURE, np.uint8), GRAYS)
        got = colour_map()
        for entry, code in zip(got, CODES, strict=False):
            assert max(abs(value - code * 65535) for value in entry) < 1, (entry, code)
        assert set(got[6:]) == {(0, 0, 0)}
        table = gamma_table(256, 2.2)
        screen.set_lut(table, table[::-1])
        got = colour_map()
        assert [e[0] for e in got] == [round((k / 255) ** (1 / 2.2) * 65535) for k in range(256)]
        assert [e[1] for e in got] == [e[0] for e in reversed(got)]
        screen.write(np.array(PICTURE, np.uint8), GRAYS)
        assert colour_map() == got, "write changed the table of set_lut"
        assert screen.colour_map().T.tolist() == [list(entry) for entry in got]
        screen.set_mode(WIDTH, HEIGHT, 32)
        assert colour_map(16) == first[:16], "the text console's colours"
    assert colour_map() == first
    show(np.array(PICTURE, np.uint8), NODE, GRAYS)
    assert colour_map()[5] == (65535,) * 3
    assert colour_map() != first


def has_its_mode_again() -> None:
    before = bytes(var())
    with LinuxFrameBuffer(NODE) as screen:
        for bits in (1, 32, 16, 8, 24):
            screen.set_mode(WIDTH + bits, HEIGHT, bits)
            numbers = struct.unpack("40I", var())
            assert numbers[6] == bits
            assert numbers[12] == (6 if bits == 16 else 8), "bits of green"
    assert bytes(var()) == before


def fails(kind: type[Exception], word: str, call: Callable[[], object]) -> None:
    said = None
    try:
        call()
    except kind as error:
        said = str(error)
    assert said is not None, f"no {kind.__name__}"
    assert word in said, said


def refuses() -> None:
    before = bytes(var())
    with LinuxFrameBuffer(NODE) as screen:
        for mode, word in (
            ((64, 64, 4), "8 bits"),
            ((4000, 4000, 32), "video memory"),
            ((64, 64, 33), "33"),
        ):
            fails(UsageError, word, partial(screen.set_mode, *mode))
            assert bytes(var()) == before, mode
        screen.set_mode(WIDTH, HEIGHT, 24)
        fails(UsageError, "TRUECOLOR", lambda: screen.set_lut(gamma_table(256, 2.2)))


def is_not_for_everybody() -> None:
    Path(NODE).chmod(0o600)
    os.seteuid(65534)
    try:
        fails(DevicePermissionError, "video", lambda: LinuxFrameBuffer(NODE))
    finally:
        os.seteuid(0)
    fails(DeviceNotFoundError, "is not a frame buffer", lambda: LinuxFrameBuffer("/dev/null"))
    fails(DeviceNotFoundError, "/dev/fb9", lambda: LinuxFrameBuffer("/dev/fb9"))


def reads_what_linux_draws() -> None:
    """A letter of the text console at 8 bits and at 1: which bit of a byte is left is Linux's choice.

    At 1 bit vfb says that colours have 8, so that every black pixel Linux draws is 8 wide to its right:
    of a row of the letter there is what comes before its first black pixel.
    """
    colour, mono = letter(8), letter(1)
    expected = np.logical_and.accumulate(colour, axis=1)
    assert {4, 7} <= set(expected.sum(axis=1)), expected.sum(axis=1)
    assert np.array_equal(mono, expected), (mono.sum(axis=1), expected.sum(axis=1))


def letter(bits: int) -> np.ndarray:
    """Where an F is lit, once it is there and stays."""
    with LinuxFrameBuffer(NODE) as screen:
        screen.set_mode(160, 64, bits)
        Path("/dev/tty1").write_bytes(b"\x1bc\x1b[?25lF")
        last, until = np.zeros((0, 0)), time.monotonic() + 10
        while time.monotonic() < until:
            time.sleep(0.1)
            now = screen.snapshot()[:16] > 0
            if now.any() and not now.all() and np.array_equal(now, last):
                return now
            last = now
    raise AssertionError("nothing was drawn")


SCENES: dict[str, Scene] = {
    scene.__name__: scene
    for scene in (
        reads_what_linux_draws,
        reads_back_1_bit,
        reads_back_8_bits,
        reads_back_true_colour,
        is_panned,
        loads_and_restores_the_colour_map,
        has_its_mode_again,
        refuses,
        is_not_for_everybody,
    )
}
"""What is tried, by name."""


def main() -> None:
    for name, scene in SCENES.items():
        if scene is not reads_what_linux_draws:
            for console in Path("/sys/class/vtconsole").glob("*"):
                if "frame buffer" in (console / "name").read_text():
                    (console / "bind").write_text("0")  # else its cursor would blink in our pictures
        start, wrong = time.monotonic(), ""
        try:
            scene()
        except Exception:
            wrong = traceback.format_exc()
        seconds = round(time.monotonic() - start, 2)
        print(json.dumps({"name": name, "wrong": wrong, "seconds": seconds}), flush=True)


if __name__ == "__main__":
    main()
