"""What a printer says it is: the IEEE 1284 device ID, ``MFG:EPSON;CMD:ESC/POS;MDL:TM-T20;CLS:PRINTER;``.

IEEE 1284-2000 §6.6 asks for MANUFACTURER, MODEL and COMMAND SET, each with its short form, in front of
them a length of two bytes, the high one first, that counts itself. Printers get each of these wrong.
"""

from __future__ import annotations

from dataclasses import dataclass, field

__all__ = ["DeviceId"]

MOST = 1023
"""Bytes of the longest ID that is asked for; the first byte of a length is thus 0 … 3."""

MAKERS = {"hewlett-packard": "HP", "lexmark international": "Lexmark"}
"""Names that CUPS shortens in its URIs."""


@dataclass(frozen=True)
class DeviceId:
    """text : as the printer sent it, without the length. fields : its values by upper-case keys."""

    text: str = ""
    fields: dict[str, str] = field(default_factory=dict)

    @classmethod
    def parse(cls, answer: bytes) -> DeviceId:
        """From the answer to GET_DEVICE_ID. Never raises: what cannot be read is left out."""
        return cls.of(_body(answer).decode("utf-8", "replace"))

    @classmethod
    def of(cls, text: str) -> DeviceId:
        """From the text alone, as Linux shows it in ``ieee1284_id``."""
        fields: dict[str, str] = {}
        for item in text.split(";"):
            key, colon, value = item.partition(":")
            key, value = " ".join(key.split()).upper(), value.strip()
            if colon and key and value:
                fields.setdefault(key, value)
        return cls(text.strip(), fields)

    @property
    def make(self) -> str:
        make = self._first("MANUFACTURER", "MFG")
        return MAKERS.get(make.lower(), make)

    @property
    def model(self) -> str:
        """Without the maker's name in front of it, as CUPS writes it."""
        model = self._first("MODEL", "MDL") or self._first("DESCRIPTION", "DES")
        for maker in (self.make, self._first("MANUFACTURER", "MFG")):
            if maker and model.lower().startswith(maker.lower() + " "):
                return model[len(maker) :].strip()
        return model

    @property
    def serial(self) -> str:
        return self._first("SERIALNUMBER", "SERIAL NUMBER", "SERN", "SN")

    @property
    def languages(self) -> tuple[str, ...]:
        """What it says it understands, in its own words: ``("ESC/POS",)``."""
        named = self._first("COMMAND SET", "CMD").split(",")
        return tuple(name for name in map(str.strip, named) if name)

    def _first(self, *keys: str) -> str:
        return next((self.fields[key] for key in keys if key in self.fields), "")


def _body(answer: bytes) -> bytes:
    """The text without its length. The answer's own length is trusted more than the one it states."""
    if len(answer) >= 2 and (answer[0] <= MOST >> 8 or answer[1] <= MOST >> 8):
        text = answer[2:].partition(b"\0")[0]
        stated = [int.from_bytes(answer[:2], order) for order in ("big", "little")]
        for end in [n - 2 for n in stated] + stated:  # some do not count the length itself
            if 2 < end <= len(text) and text[:end].endswith(b";"):
                return text[:end]
    else:
        text = answer.partition(b"\0")[0]  # no length at all
    return text[: text.rindex(b";") + 1] if _is_padded(text) else text


def _is_padded(text: bytes) -> bool:
    """Whether something that is no text follows the last semicolon."""
    rest = text[text.rfind(b";") + 1 :]
    return b";" in text and any(byte < 0x20 or byte == 0xFF for byte in rest)
