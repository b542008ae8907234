"""A driver of our own in place of the kernel's, for a Linux frame buffer whose memory is a file."""

from __future__ import annotations

import ctypes
import errno
import mmap
import os
import struct
from pathlib import Path

import numpy as np

from devices.fbdev import LinuxFrameBuffer
from devices.fbnode import Kernel
from devices.fbscreen import (
    FIX,
    MONO10,
    VAR,
)

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


def opened(driver, **options):
    return LinuxFrameBuffer(kernel=driver, **options)


def checkers(rows, columns):
    return (np.add.outer(np.arange(rows), np.arange(columns)) % 2).astype(np.uint8)
