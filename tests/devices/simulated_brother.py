"""A Brother QL in memory: it takes the raster commands, prints, and says how it is."""

from __future__ import annotations

import re

import numpy as np

from devices.languages.brother_ql import BrotherQl

__all__ = ["SimulatedBrother", "packet"]

REPLY, PRINTED, FAULT, NOTICE, PHASE = 0x00, 0x01, 0x02, 0x05, 0x06
COMMAND = re.compile(
    rb"\0|M.|Z|\x0c|\x1a|\x1b@|\x1biS|\x1bi[aAMK!].|\x1bid..|\x1biz.{10}|\x1biUJ.{14}|\x1biUw\x01.{127}",
    re.DOTALL,
)


def packet(kind=REPLY, *, first=0, second=0, phase=0, notice=0, width=62, length=0, media=0x0A) -> bytes:
    """A status packet of 32 bytes. kind : why it is sent. first, second : the bits of its faults."""
    made = bytearray(32)
    made[:8] = b"\x80\x20B490\0\0"
    made[8], made[9], made[10], made[11], made[17] = first, second, width, media, length
    made[18], made[19], made[22] = kind, phase, notice
    return bytes(made)


class SimulatedBrother:
    """Takes bytes in parts of any size and answers between commands, never for bytes within rows.

    faults : bits of the two error bytes; while one is set, it holds what it is given from the print
    command on and takes no more. answers : what it has sent and nobody has read. pages : what was
    printed, as level indices.
    """

    def __init__(self, media=0x0A, width=62, length=0) -> None:
        self.media = {"media": media, "width": width, "length": length}
        self.faults = (0, 0)
        self.answers = bytearray()
        self.pages: list[np.ndarray] = []
        self.waiting = bytearray()  # bytes of a command that is not whole
        self.page = bytearray()  # commands since the last print command
        self.told = False  # whether it has said that it cannot go on

    def say(self, kind: int, **more: int) -> None:
        self.answers += packet(kind, first=self.faults[0], second=self.faults[1], **self.media, **more)

    def write(self, data: bytes) -> int:
        """Take *data*; the number of bytes taken, 0 while a page waits for somebody to help."""
        if self.held:
            return 0
        self.waiting += data
        self.work()
        return len(data)

    def read(self, size: int = 1 << 16) -> bytes:
        answer = bytes(self.answers[:size])
        del self.answers[:size]
        return answer

    def fault(self, first: int = 0, second: int = 0) -> None:
        """Something goes wrong: it says so, as a notice if the cover was opened."""
        self.faults = (first, second)
        if second & 0x10:
            self.say(NOTICE, notice=1)

    def mend(self) -> None:
        """Somebody has helped: what was held is printed."""
        self.faults, self.told = (0, 0), False
        self.say(NOTICE, notice=2)
        self.work()

    @property
    def held(self) -> bool:
        return any(self.faults) and self.waiting[:1] in (b"\x0c", b"\x1a")

    def work(self) -> None:
        while size := self.command():
            if self.held:
                if not self.told:
                    self.say(FAULT)
                self.told = True
                return
            command = bytes(self.waiting[:size])
            del self.waiting[:size]
            if command == b"\x1biS":
                self.say(REPLY)
            elif command == b"\x1b@":
                self.page = bytearray()
            elif command in (b"\x0c", b"\x1a"):
                self.print()
            elif command != b"\0":
                self.page += command

    def command(self) -> int:
        """How long the first command is; 0 while it is not whole."""
        data = bytes(self.waiting[:300])
        if data[:1] == b"g":
            whole = len(data) > 2 and len(data) >= 3 + data[2]
            return 3 + data[2] if whole else 0
        found = COMMAND.match(data)
        assert found is not None or len(data) < 132, f"no command: {data[:8].hex(' ')}"
        return found.end() if found else 0

    def print(self) -> None:
        self.say(PHASE, phase=1)
        self.pages += [frame.indices for frame in BrotherQl.decode(bytes(self.page) + b"\x1a")]
        self.page = bytearray()
        self.say(PRINTED, phase=1)
        self.say(PHASE)
