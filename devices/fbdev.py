"""A picture on a real screen: a Linux frame buffer, as ``/dev/fb0``.

What the driver says of its memory is read, never assumed (:mod:`devices.fbscreen`). A text console on
the same screen goes on writing there, and its cursor blinks; ``setterm --cursor off`` on that terminal
stills it.
"""

from __future__ import annotations

import struct
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from devices.fbnode import FrameBufferNode, Kernel
from devices.fbscreen import (
    ACTIVATE,
    BITS,
    DIRECTCOLOR,
    FIELDS,
    GRAYSCALE,
    MONO01,
    PSEUDOCOLOR,
    STATIC_PSEUDOCOLOR,
    VAR,
    Screen,
    Words,
)
from halftone._arrays import whole
from halftone.errors import InputError, UsageError
from halftone.frame import Frame
from halftone.tone.levels import Levels
from halftone.tone.lut import to_dac
from halftone.tone.transfer import Encoding, encoding

__all__ = ["LinuxFrameBuffer", "show"]

Codes = NDArray[np.uint8]
Tables = NDArray[np.uint16]


class LinuxFrameBuffer:
    """An open frame buffer; best in a ``with``, as close() puts back the mode and the colour map.

    screen : what the driver says of it.
    order : ``msb`` or ``lsb``, which bits of a byte hold its leftmost pixel where several share it,
    for drivers that differ from Linux's own drawing; None is as that.
    restore : False leaves the screen as it is at close().
    Raises DeviceNotFoundError, DevicePermissionError, DeviceBusyError.
    """

    def __init__(
        self,
        path: str = "/dev/fb0",
        *,
        order: str | None = None,
        restore: bool = True,
        kernel: Kernel | None = None,
    ) -> None:
        if order not in (None, "msb", "lsb"):
            raise UsageError(f"bit order '{order}'; allowed: msb, lsb")
        self.path, self._order, self._restore = path, order, restore
        self._old_var: bytes | None = None
        self._old_map: Tables | None = None
        self._own_table = False
        self._node = FrameBufferNode(path, kernel or Kernel())
        try:
            self._look()
        except BaseException:
            self._node.close()
            raise

    def set_mode(self, width: int, height: int, bits: int) -> None:
        """Ask the driver for a mode; the old one comes back at close().

        Raises UsageError, with all as it was, if the driver refuses it or gives another one.
        """
        wanted = f"{width} × {height} pixels of {bits} bits"
        old = self._node.var()
        new = list(VAR.unpack(old))
        new[:BITS] = [width, height, width, height, 0, 0]
        new[BITS] = bits
        new[GRAYSCALE] = int(new[GRAYSCALE] == 1)
        new[FIELDS:ACTIVATE] = [0] * (ACTIVATE - FIELDS)  # vfb: an old alpha would make 565 into 5551
        try:
            asked = VAR.pack(*new)
        except struct.error:
            raise UsageError(f"a mode of {wanted}; allowed: whole numbers above 0") from None
        own, table = self._own_table, None if self._old_map is None else self.colour_map()
        self._put_back_map()
        try:
            self._change_mode(old, asked, wanted)
        except BaseException:
            if table is not None:
                self._put_map(table)
                self._own_table = own
            raise

    def _change_mode(self, old: bytes, asked: bytes, wanted: str) -> None:
        try:
            self._node.put_var(asked)
        except UsageError as error:
            raise UsageError(f"{self.path}: the driver has no mode of {wanted} ({error})") from error
        self._old_var = self._old_var or old
        self._look()
        got = self.screen.width, self.screen.height, self.screen.bits
        nearest = f"{got[0]} × {got[1]} pixels of {got[2]} bits"
        if nearest != wanted:
            self._node.put_var(old)
            self._look()
            raise UsageError(f"{self.path}: the driver has no mode of {wanted}; nearest: {nearest}")

    def write(
        self,
        picture: Any,
        levels: Any = None,
        *,
        at: tuple[int, int] | None = None,
        response: str | Encoding = "srgb",
    ) -> tuple[int, int]:
        """Show a picture, on black; returns the row and column of its first pixel in view.

        picture : a Frame, uint8 (M, N) level indices, or uint8 (M, N, 3) RGB codes.
        levels : what the indices mean, as ``Levels.of`` takes it; a Frame has its own.
        at : (row, column), or None for the middle.
        response : the encoding by which the screen turns its codes into light.

        A screen with a colour map gets a gray one, unless set_lut gave it another; in true colour every
        code becomes the nearest that its bits hold. Raises UsageError if the screen cannot show the
        picture: nothing is cropped or dithered here. InputError for an array that is no picture.
        """
        self.screen.check()
        code = encoding(response)
        pixels, meaning = _checked(picture, levels)
        row, column = _place(pixels.shape[:2], self.screen, at)
        if meaning is None:
            words, black = self._from_rgb(pixels), np.uint32(0)
        else:
            # The light of white is the most that a screen gives.
            wanted = code.encode(np.minimum(meaning.luminance.astype(np.float64), 1))
            table = self._table(wanted)
            words = table[pixels]
            black = table[0] if self.screen.mono or self.screen.mapped else np.uint32(0)
        every = np.full((self.screen.height, self.screen.width), black, np.uint32)
        every[row : row + words.shape[0], column : column + words.shape[1]] = words
        if not (self.screen.mono or self.screen.mapped):
            every |= self.screen.fields[3].put(1.0)  # opaque
        self.screen.store(self._node.memory, every, self._in_byte())
        self._node.flush()
        return row, column

    def snapshot(self) -> Codes:
        """What is in view, from the mapped memory.

        uint8 (height, width) on a monochrome screen, 0 black and 1 white; on one with a colour map,
        the numbers of the colours; else uint8 (height, width, 3), RGB codes, the nearest in 8 bits.
        """
        screen = self.screen
        screen.check()
        words = screen.load(self._node.memory, self._in_byte())
        if screen.mono:
            return (words ^ np.uint32(screen.visual == MONO01)).astype(np.uint8)
        if screen.mapped:
            return (words >> np.uint32(screen.fields[0].offset)).astype(np.uint8)
        return np.stack([field.seen(words) for field in screen.fields[:3]], axis=2)

    def set_lut(
        self, red: ArrayLike, green: ArrayLike | None = None, blue: ArrayLike | None = None
    ) -> None:
        """Load a look-up table: the voltages 0 … 1 of the pixel values, as :mod:`halftone.tone.lut`
        makes them. What was there comes back at close().

        red, green, blue : one for every value the channel has; None is as red. Raises UsageError for
        other sizes, and on a screen whose table cannot be written.
        """
        screen = self.screen
        screen.check()
        if screen.visual not in (PSEUDOCOLOR, DIRECTCOLOR):
            raise UsageError(
                f"{self.path} is {screen.visual_name}, without a look-up table that can be written; "
                "allowed: PSEUDOCOLOR, DIRECTCOLOR. Apply the table to the picture instead, or set_mode"
            )
        tables = np.empty((3, screen.entries), np.uint16)
        for k, given in enumerate((red, red if green is None else green, red if blue is None else blue)):
            size = screen.entries if screen.mapped else 1 << screen.fields[k].length
            values = np.asarray(given, np.float64)
            if values.shape != (size,) or not ((values >= 0) & (values <= 1)).all():
                name = ("red", "green", "blue")[k]
                raise UsageError(
                    f"a {name} table of shape {values.shape}; allowed: {size} voltages from 0 to 1"
                )
            tables[k, :size] = to_dac(values, 16)
            tables[k, size:] = tables[k, size - 1]
        self._put_map(tables)
        self._own_table = True

    def colour_map(self) -> Tables:
        """The colour map: uint16 (3, entries), of red, green, blue; 65535 is full."""
        return self._node.colours(self.screen.entries)

    def close(self) -> None:
        """Put back what was changed, and let go. A second time does nothing."""
        if self._node.closed:
            return
        try:
            if self._restore:
                self._put_back()
        finally:
            self._node.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _from_rgb(self, pixels: Codes) -> Words:
        screen = self.screen
        if screen.mono or screen.mapped or screen.grayscale:
            raise UsageError(
                f"{self.path} is {screen.visual_name} of {screen.bits} bits, not for RGB codes; "
                "allowed: level indices. Dither the picture, or set_mode to 16, 24 or 32 bits"
            )
        self._load_gray(None)
        codes = np.arange(256) / 255
        red, green, blue = (
            field.put(codes)[pixels[:, :, k]] for k, field in enumerate(screen.fields[:3])
        )
        return red | green | blue

    def _table(self, wanted: NDArray[np.float64]) -> Words:
        """The pixel of every level, whose code of 0 … 1 is *wanted*; the colour map is made to suit."""
        screen, n = self.screen, len(wanted)
        if screen.mono:
            if n != 2:
                raise UsageError(f"{n} levels on {self.path}, which has 2; dither with levels=2")
            return np.array([0, 1], np.uint32) ^ np.uint32(screen.visual == MONO01)
        if not screen.mapped:
            self._load_gray(None)
            red, green, blue = (field.put(wanted) for field in screen.fields[:3])
            return red | green | blue
        if n > screen.entries:
            raise UsageError(f"{n} levels on {self.path}; allowed: up to {screen.entries} (its colours)")
        if screen.visual == STATIC_PSEUDOCOLOR:
            numbers = self._nearest_colours(wanted)
        else:
            numbers = np.arange(n)
            self._load_gray(wanted)
        return numbers.astype(np.uint32) << np.uint32(screen.fields[0].offset)

    def _nearest_colours(self, wanted: NDArray[np.float64]) -> NDArray[np.int64]:
        """Of a colour map that cannot be changed: the numbers of its colours nearest to the grays."""
        colours = self.colour_map().astype(np.float64) / 65535
        away = ((colours[:, :, None] - wanted) ** 2).sum(axis=0)
        numbers: NDArray[np.int64] = away.argmin(axis=0)
        if np.unique(numbers).size < np.unique(wanted).size:
            raise UsageError(
                f"{self.path}: its fixed colours have no {len(wanted)} grays as these; use fewer levels"
            )
        return numbers

    def _load_gray(self, wanted: NDArray[np.float64] | None) -> None:
        """Grays for the colour numbers 0 … n−1, the rest black; None: for DIRECTCOLOR, a straight
        line for each channel. Nothing where there is no such map, or set_lut was called."""
        screen = self.screen
        if self._own_table or screen.visual not in (PSEUDOCOLOR, DIRECTCOLOR):
            return
        tables = np.zeros((3, screen.entries), np.uint16)
        if wanted is not None:
            tables[:, : len(wanted)] = to_dac(wanted, 16)
        else:
            for k, field in enumerate(screen.fields[:3]):
                tables[k] = to_dac(np.arange(screen.entries) / max(field.top, 1), 16)
        self._put_map(tables)

    def _put_back(self) -> None:
        """The mode comes back even if the colour map does not."""
        try:
            self._put_back_map()
        finally:
            if self._old_var is not None:
                self._node.put_var(self._old_var)

    def _put_map(self, tables: Tables) -> None:
        if self._old_map is None:
            self._old_map = self.colour_map()
        self._node.put_colours(tables)

    def _put_back_map(self) -> None:
        """The colour map as this mode had it."""
        old, self._old_map, self._own_table = self._old_map, None, False
        if old is not None:
            self._node.put_colours(old)

    def _look(self) -> None:
        """What the driver says now; its memory is mapped anew."""
        self.screen = Screen.parse(self._node.fix(), self._node.var())
        self._node.map(self.screen.memory)

    def _in_byte(self) -> str:
        """Which bits of a byte hold the leftmost of the pixels that share it."""
        return self._order or self.screen.order


def show(
    picture: Any,
    path: str = "/dev/fb0",
    levels: Any = None,
    *,
    at: tuple[int, int] | None = None,
    response: str | Encoding = "srgb",
) -> tuple[int, int]:
    """Put a picture on a screen and leave it there, with its colour map. See
    :meth:`LinuxFrameBuffer.write`."""
    with LinuxFrameBuffer(path, restore=False) as screen:
        return screen.write(picture, levels, at=at, response=response)


def _checked(picture: Any, levels: Any) -> tuple[Codes, Levels | None]:
    """The pixels, and the levels that they mean, or None for RGB codes."""
    if isinstance(picture, Frame):
        if levels is not None:
            raise UsageError("levels with a Frame, which has its own; leave them out")
        picture, levels = picture.indices, picture.levels
    pixels = np.asarray(picture)
    rgb = pixels.ndim == 3 and pixels.shape[2] == 3
    if pixels.dtype != np.uint8 or not (rgb or pixels.ndim == 2) or not pixels.size:
        raise InputError(
            f"a picture of shape {pixels.shape}, {pixels.dtype}; allowed: a Frame, uint8 (M, N) level "
            "indices or uint8 (M, N, 3) RGB codes, of at least one pixel"
        )
    if rgb:
        if levels is not None:
            raise UsageError("levels with an RGB picture; leave them out, or give level indices")
        return pixels, None
    if levels is None:
        raise UsageError("levels are missing: what do the indices mean? As levels=2 or '0.05,0.3,1'")
    meaning = Levels.of(levels)
    if pixels.max() >= len(meaning):
        raise InputError(f"the picture has the level {pixels.max()}; allowed: 0 … {len(meaning) - 1}")
    return pixels, meaning


def _place(shape: tuple[int, ...], screen: Screen, at: tuple[int, int] | None) -> tuple[int, int]:
    """The row and column of a picture's first pixel in view."""
    free = screen.height - shape[0], screen.width - shape[1]
    if min(free) < 0:
        raise UsageError(
            f"a picture of {shape[1]} × {shape[0]} pixels on a screen of {screen.width} × "
            f"{screen.height}; allowed: what fits. Make it smaller: halftone.dither(width=…)"
        )
    if at is None:
        return free[0] // 2, free[1] // 2
    return whole("the row of at", at[0], 0, free[0]), whole("the column of at", at[1], 0, free[1])
