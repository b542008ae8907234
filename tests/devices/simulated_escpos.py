"""A receipt printer that does what the manuals say real ones do, real-time commands included.

Bytes go into a receive buffer; a receiver looks at each of them as it arrives and carries out DLE
EOT, DLE ENQ and DLE DC4 wherever it finds them, in the middle of a picture too. An interpreter takes
bytes out of the buffer a little later and prints. It shares no code with the decoder of the package.
"""

from __future__ import annotations

import numpy as np

DLE, EOT, ENQ, DC4 = 0x10, 0x04, 0x05, 0x14

CONTROLS = (
    (b"\x1b@", 2, "_reset"),
    (b"\x1b2", 2, "_normal_pitch"),
    (b"\x1b3", 3, "_set_pitch"),
    (b"\x1bJ", 3, "_feed"),
    (b"\n", 1, "_line_feed"),
    (b"\x1dV", 3, "_cut"),
    (b"\x1d(L\x02\x0002", 7, "_print_graphics"),
    (b"\x1da", 3, ""),
    (b"\x1b7", 5, ""),
    (b"\x12#", 3, ""),
    (b"\x1d(K", 7, ""),
    (b"\x10\x04", 3, ""),  # the receiver has carried them out
    (b"\x10\x05", 3, ""),
    (b"\x10\x14", 5, ""),
)
"""Beginning of a command, its bytes in all, and the method that takes the last of them."""
PICTURES = {b"\x1dv0": 8, b"\x12*": 4, b"\x1b*\x21": 5, b"\x1d(L": 15, b"\x1d8L": 17}
"""Beginning of a picture, and the bytes of its header."""


class SimulatedEscPos:
    """Give it bytes with :meth:`write`; ``rows`` is what it printed, as lists of 0 and 1.

    unfinished : what was left of the last command, which never came to its end.
    executed : the real-time commands it carried out, as bytes. replies : what it sent back.
    garbage : bytes that it took for text. states : its answers to DLE EOT 1 … 4.
    lag : bytes that wait in its buffer before it looks at them.
    """

    def __init__(self, lag: int = 4096, states=(0x12, 0x12, 0x12, 0x12)) -> None:
        self.lag, self.states = lag, list(states)
        self.rows: list[list[int]] = []
        self.executed: list[bytes] = []
        self.replies = bytearray()
        self.garbage = bytearray()
        self.fed: list[tuple[int, int]] = []  # after how many rows, and how much
        self.cuts: list[int] = []
        self.off = False
        self._recent = b""
        self._buffer = bytearray()
        self._line: list[list[int]] = []
        self._graphics: list[list[int]] = []
        self._pitch = 30

    def write(self, data: bytes) -> int:
        """Take *data*; the bytes it took."""
        for count, byte in enumerate(data):
            if self.off:
                return count
            self._buffer.append(byte)
            self._receive(byte)
            if len(self._buffer) > 2 * self.lag:
                self._work(self.lag)
        return len(data)

    def finish(self) -> None:
        """Print what still waits in the buffer."""
        if not self.off:
            self._work(0)

    @property
    def unfinished(self) -> bytes:
        return bytes(self._buffer)

    # -- the receiver ---------------------------------------------------------------------------

    def _receive(self, byte: int) -> None:
        self._recent = (self._recent + bytes((byte,)))[-10:]
        for size, begins in ((3, (EOT, ENQ)), (5, (DC4,)), (10, (DC4,))):
            found = self._recent[-size:]
            if len(found) == size and found[0] == DLE and found[1] in begins and self._execute(found):
                self.executed.append(found)
                self._recent = b""

    def _execute(self, found: bytes) -> bool:
        kind, n = found[1], found[2]
        if kind == EOT and 1 <= n <= 4:
            self.replies.append(self.states[n - 1])
        elif kind == ENQ and n <= 2:
            if n == 2:
                self._forget()
        elif kind == DC4 and len(found) == 5 and found[2:] == b"\x02\x01\x08":
            self.off = True
            self._forget()
        elif kind == DC4 and len(found) == 5 and n == 1 and found[3] <= 1 and 1 <= found[4] <= 8:
            pass  # the drawer opens
        elif kind == DC4 and len(found) == 10 and found[2:] == b"\x08\x01\x03\x14\x01\x06\x02\x08":
            self._forget()
        else:
            return False
        return True

    def _forget(self) -> None:
        self._buffer.clear()
        self._line, self._graphics = [], []

    # -- the interpreter ------------------------------------------------------------------------

    def _work(self, leave: int) -> None:
        while len(self._buffer) > leave:
            used = self._command(bytes(self._buffer[:24]))
            if used is None:
                return
            del self._buffer[:used]

    def _command(self, head: bytes) -> int | None:
        """Bytes used by the command at the start of the buffer; None if it is not all there."""
        for command, size, action in CONTROLS:
            if head.startswith(command):
                if len(head) < size:
                    return None
                if action:
                    getattr(self, action)(head[size - 1])
                return size
        for command, size in PICTURES.items():
            if head.startswith(command):
                return self._picture(command, head[:size]) if len(head) >= size else None
        if len(head) < 4:
            return None
        self.garbage.append(head[0])
        return 1

    def _picture(self, command: bytes, header: bytes) -> int | None:
        low, high = header[-2], header[-1]
        if command == b"\x1b*\x21":
            width, height = low + 256 * high, 24
            size = width * 3
        elif command == b"\x12*":
            width, height = high * 8, low
            size = width // 8 * height
        elif command == b"\x1dv0":
            width, height = (header[4] + 256 * header[5]) * 8, low + 256 * high
            size = width // 8 * height
        else:
            width, height = header[-4] + 256 * header[-3], low + 256 * high
            size = (width + 7) // 8 * height
        if len(self._buffer) < len(header) + size:
            return None
        data = np.frombuffer(bytes(self._buffer[len(header) : len(header) + size]), np.uint8)
        if command == b"\x1b*\x21":
            bits = np.unpackbits(data.reshape(width, 3), axis=1).T
            self._line = bits.tolist()
        else:
            bits = np.unpackbits(data.reshape(height, -1), axis=1)[:, :width]
            if header[:1] == b"\x1d" and command != b"\x1dv0":
                self._graphics = bits.tolist()
            else:
                self.rows += bits.tolist()
        return len(header) + size

    def _reset(self, _: int) -> None:
        self._pitch, self._line, self._graphics = 30, [], []

    def _normal_pitch(self, _: int) -> None:
        self._pitch = 30

    def _set_pitch(self, n: int) -> None:
        self._pitch = n

    def _line_feed(self, _: int) -> None:
        self._feed(self._pitch)

    def _feed(self, n: int) -> None:
        gap = max(0, n - len(self._line))
        self.rows += self._line
        self._line = []
        if gap:
            self.fed.append((len(self.rows), gap))

    def _cut(self, mode: int) -> None:
        self.cuts.append(mode)

    def _print_graphics(self, _: int) -> None:
        self.rows += self._graphics
        self._graphics = []
