"""The packets of 32 bytes in which Brother's label printers say how they are.

They answer ``ESC i S`` and come by themselves: a page is finished, a fault, a notice, another phase.
Source: Brother, Raster Command Reference of the QL-710W/720NW, chapter 4, tables (1) to (7).
"""

from __future__ import annotations

from devices.status import Status

__all__ = ["packets", "status_of"]

SIZE = 32
HEAD = b"\x80\x20B"

ERRORS = {
    (8, 0): ("media-empty",),
    (8, 1): ("media-empty",),
    (8, 2): ("marker-failure",),  # the cutter is jammed
    (8, 4): ("paused",),  # in use
    (8, 5): ("offline",),
    (9, 0): ("media-needed",),
    (9, 1): ("spool-area-full",),
    (9, 3): ("spool-area-full",),
    (9, 4): ("cover-open",),
    (9, 5): ("paused",),  # its cancel key was pressed
    (9, 6): ("media-jam", "media-empty"),  # it cannot feed, at the end of a roll as well
}
"""Byte and bit of a status packet → IPP keywords; other bits of these bytes are faults without one."""


def packets(received: bytes) -> list[bytes]:
    """The whole status packets among *received*; what is between them is passed over."""
    found, place = [], received.find(HEAD)
    while 0 <= place <= len(received) - SIZE:
        found.append(received[place : place + SIZE])
        place = received.find(HEAD, place + SIZE)
    return found


def status_of(packet: bytes) -> Status:
    """What a packet says. Phases, and that a page is finished, are no fault."""
    reasons: set[str] = set()
    for place in (8, 9):
        for bit in range(8):
            if packet[place] >> bit & 1:
                reasons.update(f"{word}-error" for word in ERRORS.get((place, bit), ("other",)))
    kind, media, notice = packet[18], packet[11], packet[22]
    if kind == 0x00 and media == 0x00 and not reasons:
        reasons.add("media-empty-error")
    if kind == 0x02 and not reasons:
        reasons.add("other-error")
    if kind == 0x04:
        reasons.add("offline-error")
    if kind == 0x05 and notice == 1:
        reasons.add("cover-open-error")
    if kind == 0x05 and notice == 3:
        reasons.add("fuser-over-temp-warning")  # it cools down and goes on
    return Status(frozenset(reasons))
