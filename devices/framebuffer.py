"""A simulated frame buffer: takes what a panel takes, and shows the light that the panel would show.

What is written lies in the memory as level indices, palette indices or R, G, B codes. From there a code
goes through the look-up table to a voltage and by the panel's response to light, or, on a panel without
such a table, it has its measured luminance. Black level, ambient light, the shape of pixels, and what
partial refreshes leave behind are those of :class:`devices.glass.Glass`.

Source of the three paths of look-up tables: Hearn & Baker, gamma correction and video look-up tables
(:mod:`halftone.tone.lut` makes them).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from devices.differences import MOST, Box, boxes
from devices.eye import at_distance
from devices.glass import Glass
from devices.paper import FINEST, Paper
from devices.pixels import Indexed, PixelFormat
from devices.profile import DeviceProfile
from halftone._arrays import whole
from halftone.errors import InputError, UsageError
from halftone.packing import Packing
from halftone.tone.dotgain import DotModel
from halftone.tone.levels import Levels

__all__ = ["Box", "FrameBuffer"]

LARGEST = 1 << 28
"""Pixels of a frame buffer, or samples of a view."""

Light = NDArray[np.float32]
Codes = NDArray[Any]


class FrameBuffer:
    """A panel, white (the lightest level) at first.

    what : a device profile, or the shape (M, N). levels : as in :class:`halftone.tone.levels.Levels`;
    a profile has its own. shape : for a profile whose width or height is open. packing : bits, order
    and codes of its memory; None takes the fewest bits that hold a level. glass : the rest, also as a
    mapping of its keys. dot : the printed dot for ``pixel="dot"``. dpi : across and down.
    """

    def __init__(
        self,
        what: DeviceProfile | tuple[int, int],
        levels: Any = None,
        *,
        shape: tuple[int, int] | None = None,
        packing: Packing | None = None,
        glass: Glass | Mapping[str, Any] | None = None,
        dot: DotModel | None = None,
        dpi: tuple[float, float] | None = None,
    ) -> None:
        if glass is not None and not isinstance(glass, Glass):
            glass = Glass.of(glass)
        if isinstance(what, DeviceProfile):
            if levels is not None:
                raise UsageError(f"levels were given, and the profile '{what.name}' has its own")
            levels, packing, dpi = what.levels, packing or what.packing, dpi or what.dpi
            dot, shape = dot or what.dot, shape or _size(what)
            if glass is None:
                glass = Glass.of(what.glass)
                if dot is not None and "pixel" not in what.glass:
                    glass = replace(glass, pixel="dot")
        else:
            shape = what
        self.glass = glass or Glass()
        self.levels = self.glass.ladder(2 if levels is None else levels)
        self.shape = _checked_shape(shape)
        self.dot, self.dpi = dot, dpi
        self.palette = self.glass.colours
        self.format = self._format(packing)
        self._lut: tuple[NDArray[np.float64], ...] | None = None
        self._paper = self._printed(what.measured if isinstance(what, DeviceProfile) else None)
        self.memory = np.full((*self.shape, *self._channels), self._limits, self._kind)
        if self.palette is not None:
            self.memory[...] = self.palette.paper
        self._seen: Light | None = self._light() if self.glass.needs_refresh else None

    def _format(self, packing: Packing | None) -> PixelFormat:
        if self.glass.pixels is not None:
            return self.glass.pixels
        if self.palette is None:
            return Indexed(packing or Packing(self.levels.bits))
        bits = packing.bits if packing else Levels.of(max(2, max(self.palette.codes) + 1)).bits
        return Indexed(Packing(bits, packing.order if packing else "msb", self.palette.codes))

    def _printed(self, measured: Sequence[tuple[float, float]] | None) -> Paper | None:
        """For dots: the paper they lie on."""
        if self.glass.pixel != "dot":
            return None
        if self.dot is None or self._colour or len(self.levels) != 2:
            raise UsageError(
                "pixel = 'dot' needs two levels and the diameter of the dot (dot_x and dot_y of the "
                "profile, or dot=); allowed without: box, led"
            )
        return Paper(self.levels, self.dot, measured)

    # --- what lies in its memory

    @property
    def _colour(self) -> bool:
        return self.palette is not None or self.format.channels == 3

    @property
    def _channels(self) -> tuple[int, ...]:
        return () if self.format.channels == 1 else (3,)

    @property
    def _limits(self) -> NDArray[np.int64]:
        """The highest value of each channel."""
        if self.format.channels == 3:
            return np.array([(1 << bits) - 1 for bits in self.format.bits_per_channel])
        return np.array([len(self.levels if self.palette is None else self.palette) - 1])

    @property
    def _kind(self) -> type[np.unsignedinteger[Any]]:
        return np.uint16 if self._limits.max() > 255 else np.uint8

    def write(self, pixels: Any, at: tuple[int, int] = (0, 0)) -> None:
        """Put *pixels* with their upper left corner at (y, x): level indices (or a frame), palette
        indices, or R, G, B codes (m, n, 3); a panel of R, G, B shows level indices as neutral grays."""
        codes = self._codes(pixels)
        if not codes.size:
            raise InputError("the picture has no pixels")
        self.memory[self._place(at, codes.shape[:2])] = codes

    def write_bytes(self, packed: Any, at: tuple[int, int] = (0, 0), width: int | None = None) -> None:
        """Put packed pixels in the format of the panel at (y, x).

        packed : bytes or uint8, whole rows (of every plane). width : pixels in a row; None is the
        panel's.
        """
        data = np.frombuffer(packed, np.uint8) if isinstance(packed, bytes | bytearray) else packed
        data = np.asarray(data)
        width = self.shape[1] if width is None else whole("width", width, 1, self.shape[1])
        one = int(np.prod(self.format.packed_shape(1, width)))
        rows, left = divmod(data.size, one)
        if data.dtype != np.uint8 or left or not rows:
            raise InputError(
                f"{data.size} values of type {data.dtype}; allowed: bytes of whole rows, "
                f"{one} for a row of {width} pixels"
            )
        shaped = data.reshape(self.format.packed_shape(rows, width))
        self.write(self.format.unpack(shaped, width), at)

    def read_bytes(self) -> NDArray[np.uint8]:
        """The whole memory in the format of the panel."""
        return self.format.pack(self.memory)

    def difference(self, new: Any, most: int = MOST) -> list[Box]:
        """Boxes (top, left, height, width) in which *new*, a picture as large as the panel, differs
        from the memory; they start and end at whole bytes of a row, but for its end."""
        if np.shape(new)[:2] != self.shape:
            raise InputError(f"a picture of shape {np.shape(new)}; allowed: {self._form}, all of it")
        differ = self.memory != self._codes(new)
        differ = differ.any(axis=2) if differ.ndim == 3 else differ
        bits = self.format.packed_shape(1, 8)[-1]  # bytes of eight pixels are bits of one
        return boxes(differ, max(1, 8 // bits), whole("most", most, 1, 1 << 20))

    # --- what is seen

    @property
    def lut(self) -> tuple[NDArray[np.float64], ...] | None:
        """The look-up table: voltages 0 … 1 by code, one table a channel; None: codes go straight."""
        return self._lut

    @lut.setter
    def lut(self, table: ArrayLike | Sequence[ArrayLike] | None) -> None:
        if table is None:
            self._lut = None
            return
        if self.glass.response is None or self.palette is not None:
            raise UsageError(
                "this panel has no look-up table: its levels are measured as they are. Give its glass "
                "a response, as gamma:2.2"
            )
        sizes = [1 << bits for bits in self.format.bits_per_channel]
        parts: Any = table
        if len(sizes) == 1 or (isinstance(table, np.ndarray) and table.ndim == 1):
            parts = [table] * len(sizes)
        elif isinstance(table, np.ndarray):
            parts = list(table.T)
        if len(parts) != len(sizes):
            raise UsageError(f"{len(parts)} look-up tables; allowed: {len(sizes)}, one a channel")
        self._lut = tuple(_checked_table(part, size) for part, size in zip(parts, sizes, strict=True))

    def refresh(self, full: bool = True, box: Box | tuple[int, int, int, int] | None = None) -> None:
        """Bring the memory onto the glass of a panel that needs it.

        full : whether ghosts are cleared; a partial refresh leaves (1 − g)·target + g·previous.
        box : (top, left, height, width) for a partial refresh of that part; None is all.
        """
        if self._seen is None:
            return
        if box is None:
            box = Box(0, 0, *self.shape)
        elif full:
            raise UsageError("a full refresh is of the whole panel; leave the box out, or full=False")
        top, left, *size = box
        place = self._place((top, left), tuple(size))
        kept = 0.0 if full else self.glass.ghosting
        mixed = (1 - kept) * self._light()[place] + kept * self._seen[place]
        self._seen[place] = mixed.astype(np.float32)

    def snapshot(self, absolute: bool = False) -> Light:
        """Mean light of every pixel, float32 (M, N), or (M, N, 3) linear R, G, B of BT.709.

        1 is the panel's white; absolute : a perfect white is 1, and the panel's what was measured.
        """
        light = self._light() if self._seen is None else self._seen
        return self._finished(light, absolute)

    def view(
        self,
        scale: int = 1,
        distance: float | None = None,
        dpi: float | tuple[float, float] | None = None,
        absolute: bool = False,
    ) -> Light:
        """The pixels as shapes, scale × scale samples each: float32 (M·scale, N·scale[, 3]).

        distance : as the eye sees them from so many inches away: a low-pass in linear light. dpi :
        pixels an inch, or across and down; None is the panel's.
        """
        scale = whole("scale", scale, 1, FINEST)
        if self.memory.size * scale**2 > LARGEST:
            raise UsageError(f"a view of {self.shape} at scale {scale} is too large; take a lower scale")
        if self._paper is not None and self._seen is None:
            light = np.concatenate(list(self._paper.drawn(self.memory, scale)))
            light = self.glass.shown(light).astype(np.float32)
        else:
            light = self._light() if self._seen is None else self._seen
            light = light.repeat(scale, axis=0).repeat(scale, axis=1)
            if self.glass.pixel == "led":
                tiled = np.tile(self.glass.emitter(scale), self.shape)
                light *= tiled if light.ndim == 2 else tiled[..., None]
        light = self._finished(light, absolute)
        if distance is None:
            return light
        across, down = self._dots(dpi)
        fine = (across * scale, down * scale)
        if light.ndim == 2:
            return at_distance(light, fine, distance)
        return np.stack([at_distance(light[..., c], fine, distance) for c in range(3)], axis=-1)

    def _dots(self, dpi: float | tuple[float, float] | None) -> tuple[float, float]:
        given = self.dpi if dpi is None else dpi
        if given is None:
            raise UsageError("a view at a distance needs the pixels of an inch; give dpi=")
        return (given, given) if isinstance(given, int | float) else given

    def _finished(self, light: Light, absolute: bool) -> Light:
        white = self.glass.white if self.palette is None else self.palette.white
        seen = light + np.float32(self.glass.ambient)
        return np.asarray(seen * np.float32(white) if absolute else seen, np.float32)

    def _light(self) -> Light:
        """What the memory would show, without ambient light."""
        if self._paper is not None:
            return self.glass.shown(self._paper.seen(self.memory)).astype(np.float32)
        if self.palette is not None:
            return np.asarray(self.glass.shown(self.palette.relative).astype(np.float32)[self.memory])
        tables = [self.glass.shown(part).astype(np.float32) for part in self._tables()]
        if len(tables) == 1:
            return np.asarray(tables[0][self.memory])
        return np.stack([part[self.memory[..., c]] for c, part in enumerate(tables)], axis=-1)

    def _tables(self) -> list[NDArray[Any]]:
        """Light by level index, or by the codes of each channel."""
        if self.format.channels == 3:
            tables = self._lut or tuple(np.arange(top + 1) / top for top in self._limits)
            return [self.glass.light(volts) for volts in tables]
        if self._lut is None:
            return [self.levels.luminance]
        packing = self.format.packing if isinstance(self.format, Indexed) else None
        codes = packing.codes if packing and packing.codes else range(len(self.levels))
        return [self.glass.light(self._lut[0])[list(codes)]]

    # --- checks

    def _codes(self, pixels: Any) -> Codes:
        """*pixels*, checked, as they lie in the memory."""
        given = np.asarray(pixels)
        if given.dtype.kind not in "iu" and given.dtype != np.bool_:
            raise InputError(
                f"pixels are {given.dtype}; allowed: level indices or codes, which are whole numbers. "
                "halftone.dither makes them from light"
            )
        grays = self.format.channels == 3 and given.ndim == 2
        if given.ndim != (3 if self._channels and not grays else 2) or given.shape[2:] not in ((), (3,)):
            raise InputError(f"pixels of shape {given.shape}; allowed: {self._form}")
        limits = np.array([len(self.levels) - 1]) if grays else self._limits
        if given.size and (given.min() < 0 or (given.max(axis=(0, 1)) > limits).any()):
            raise InputError(
                f"pixels hold {given.min()} … {given.max()}; allowed: 0 … "
                + ", ".join(str(v) for v in limits)
            )
        if grays:
            steps = np.arange(len(self.levels))[:, None] / (len(self.levels) - 1)
            given = np.rint(steps * self._limits).astype(self._kind)[given]
        return given.astype(self._kind, copy=False)

    @property
    def _form(self) -> str:
        """The shape that pictures have, in words."""
        if self.format.channels == 3:
            return f"{self.shape} level indices, or {(*self.shape, 3)} codes"
        return f"{self.shape} {'palette' if self.palette else 'level'} indices"

    def _place(self, at: tuple[int, int], size: tuple[int, ...]) -> tuple[slice, slice]:
        """Slices of a box inside the panel."""
        try:
            (top, left), (rows, columns) = (int(v) for v in at), size
        except (TypeError, ValueError):
            raise UsageError(
                f"place {at!r} and size {size!r}; allowed: (y, x), (rows, columns)"
            ) from None
        inside = top >= 0 and left >= 0 and rows >= 0 and columns >= 0
        if not inside or top + rows > self.shape[0] or left + columns > self.shape[1]:
            raise UsageError(
                f"{rows} × {columns} pixels at y = {top}, x = {left} reach beyond the panel's "
                f"{self.shape[0]} × {self.shape[1]}"
            )
        return slice(top, top + rows), slice(left, left + columns)


def _size(profile: DeviceProfile) -> tuple[int, int]:
    if profile.width is None or profile.height is None:
        raise UsageError(
            f"the profile '{profile.name}' leaves its size open; give shape=(rows, columns)"
        )
    return profile.height, profile.width


def _checked_shape(shape: Any) -> tuple[int, int]:
    if not isinstance(shape, tuple | list) or len(shape) != 2:
        raise UsageError(f"shape {shape!r}; allowed: (rows, columns)")
    rows, columns = (
        whole(name, v, 1, LARGEST) for name, v in zip(("rows", "columns"), shape, strict=True)
    )
    if rows * columns > LARGEST:
        raise UsageError(f"a frame buffer of {rows} × {columns} pixels; allowed: {LARGEST:,} in all")
    return rows, columns


def _checked_table(table: Any, size: int) -> NDArray[np.float64]:
    try:
        volts = np.array(table, np.float64)
    except (TypeError, ValueError):
        volts = np.array([])
    if volts.shape != (size,):
        raise UsageError(
            f"a look-up table of shape {volts.shape}; allowed: ({size},), a voltage for every code"
        )
    if not ((volts >= 0) & (volts <= 1)).all():
        raise UsageError(
            "a look-up table holds NaN or voltages outside of 0 … 1; codes of a converter are divided "
            "by its highest"
        )
    volts.flags.writeable = False
    return volts
