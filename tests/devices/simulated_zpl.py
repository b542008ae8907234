"""A simulated ZPL printer: what it received, and what it answers to ``~HQES``, ``~HS`` and ``~HI``.

Call it with the bytes that the host sends; it returns those that the printer sends back. Commands may
be cut anywhere between two calls. Forms of the answers: ZPL II Programming Guide, ~HQ, ~HS, ~HI.
"""

from __future__ import annotations

from dataclasses import dataclass, field

ERRORS = {
    "media_out": 0x1,
    "ribbon_out": 0x2,
    "head_open": 0x4,
    "cutter_fault": 0x8,
    "head_hot": 0x10,
    "paused": 0x10000,
}
WARNINGS = {"media_low": 0x8}


@dataclass
class SimulatedZpl:
    """state : names out of ERRORS and WARNINGS that hold now. script : after so many bytes received,
    (name, whether it holds from then on). strict : answers no ~HS while it has an error, as the guide
    says of newer printers. A printer goes on taking bytes whatever its state."""

    state: set[str] = field(default_factory=set)
    script: dict[int, tuple[str, bool]] = field(default_factory=dict)
    strict: bool = True
    received: bytearray = field(default_factory=bytearray)
    asked: list[str] = field(default_factory=list)

    def __call__(self, data: bytes) -> bytes:
        answer = b""
        for byte in data:
            self.received.append(byte)
            name, holds = self.script.get(len(self.received), ("", False))
            if name:
                (self.state.add if holds else self.state.discard)(name)
            answer += self._answer()
        return answer

    def _answer(self) -> bytes:
        """What the command that has just become complete asks for."""
        for command, reply in (("~HQES", self.errors), ("~HS", self.status), ("~HI", self.identity)):
            if self.received.endswith(command.encode()):
                self.asked.append(command)
                return reply()
        return b""

    def errors(self) -> bytes:
        bits = [sum(v for k, v in table.items() if k in self.state) for table in (ERRORS, WARNINGS)]
        lines = [
            f"{name}: {int(value > 0)} 00000000 {value:08X}"
            for name, value in zip(("ERRORS", "WARNINGS"), bits, strict=True)
        ]
        return "\r\n".join(["\x02", "PRINTER STATUS", *lines, "\x03"]).encode()

    def status(self) -> bytes:
        if self.strict and self.state & (set(ERRORS) - {"paused", "cutter_fault"}):
            return b""
        out, paused, hot, up, ribbon = (
            int(name in self.state)
            for name in ("media_out", "paused", "head_hot", "head_open", "ribbon_out")
        )
        strings = (
            f"030,{out},{paused},1218,000,0,0,0,000,0,0,{hot}",
            f"000,0,{up},{ribbon},0,2,6,0,00000000,1,000",
            "1234,0",
        )
        return "".join(f"\x02{string}\x03\r\n" for string in strings).encode()

    def identity(self) -> bytes:
        return b"\x02SIM420d,V61.17.16Z,8,2104KB\x03\r\n"
