"""Real-time commands of ESC/POS: those that arise by chance in a picture, and those that ask how it is.

An ESC/POS printer looks for ``DLE EOT``, ``DLE ENQ`` and ``DLE DC4`` in everything it receives, even
within the data of a picture (TM-L90 specification p. 300, Citizen CBM1000 p. 50, Custom P80C p. 59),
and then answers, empties its buffers, opens the drawer or switches itself off. Which third bytes count
differs: after EOT 1 – 4 everywhere, 5 on the TM-H5000, 1 – 17 on the SMICE; after ENQ 2 on the TM-U220,
1 – 3 on the TM-H5000; after DC4 1 on the TM-U220, 2 on the TP80K, 8 on Citizen's. So here every third
byte counts: no stream has one of the three pairs at all. It does not matter who made the printer, and
no job that is broken off between two bytes is completed to such a command by what follows.

The first byte, 0x10, is one dot with paper to its left and right. Moved to the left by one place it
is 0x20, which is in none of the pairs: the tone stays, and no new pair can arise. Where a header ends
with 0x10 it is the lowest dot of the next byte that moves: 04 → 08, 05 → 06, 14 → 18.

What the answers mean: the tables of DLE EOT in the manuals of SRP-350, TM-L60II and iDP-3221; packets
that printers send unasked: GS a in Epson's ESC/POS reference.
"""

from __future__ import annotations

import re

from devices.status import Status

__all__ = ["DLE", "PAIR", "QUERY", "harmless", "parsed", "unsolicited"]

DLE = 0x10
PAIR = re.compile(rb"\x10[\x04\x05\x14]")
"""What begins every real-time command."""
MOVED = {0x04: 0x08, 0x05: 0x06, 0x14: 0x18}


def harmless(header: bytes, data: bytes) -> bytes:
    """The *data* of a command that begins with *header*, without the beginning of any real-time
    command; as many bytes with as many dots. One dot is moved for each of them, by one place."""
    for second in MOVED:
        data = data.replace(bytes((DLE, second)), bytes((DLE << 1, second)))
    if header[-1] == DLE and data[0] in MOVED:
        data = bytes((MOVED[data[0]],)) + data[1:]
    return data


QUERY = b"\x10\x04\x01\x10\x04\x02\x10\x04\x03\x10\x04\x04"
"""DLE EOT 1 … 4: printer, cause of being off-line, error, paper; a byte each in answer."""


def parsed(reply: bytes) -> Status | None:
    """The status in the four answers to QUERY, the last four if there are more."""
    answers = [byte for byte in reply if byte & 0x93 == 0x12]  # no byte of a packet of GS a is so
    if len(answers) < 4:
        return None
    printer, cause, error, paper = answers[-4:]
    return _status(
        offline=bool(printer & 0x08),
        cover=bool(cause & 0x04),
        button=bool(cause & 0x08),
        empty=bool(cause & 0x20 or paper & 0x60),
        low=bool(paper & 0x0C),
        cutter=bool(error & 0x08),
        passing=bool(error & 0x40),
        # the general bit counts where the particular ones say nothing
        other=bool(error & 0x24 or (cause & 0x40 and not error & 0x48)),
    )


def unsolicited(received: bytes) -> Status | None:
    """The status in the last whole packet of GS a among bytes of any kind."""
    found, place = None, 0
    while place + 4 <= len(received):
        first, *others = received[place : place + 4]
        if first & 0x93 == 0x10 and not any(byte & 0x90 for byte in others):
            found, place = (first, *others), place + 4
        else:
            place += 1
    if found is None:
        return None
    printer, error, paper, _ = found
    return _status(
        offline=bool(printer & 0x08),
        cover=bool(printer & 0x20),
        button=bool(printer & 0x40 or error & 0x02),
        empty=bool(paper & 0x0C),
        low=bool(paper & 0x03),
        cutter=bool(error & 0x08),
        passing=bool(error & 0x40),
        other=bool(error & 0x24),
    )


def _status(
    *,
    offline: bool,
    cover: bool,
    button: bool,
    empty: bool,
    low: bool,
    cutter: bool,
    passing: bool,
    other: bool,
) -> Status:
    """IPP's words. A cut-off that passes by itself (a hot head) and paper fed by the button are no
    errors; being off-line is one only where nothing else explains it."""
    reasons = set()
    if cover:
        reasons.add("cover-open-error")
    if empty:
        reasons.add("media-empty-error")
    elif low:
        reasons.add("media-low-warning")
    if cutter:
        reasons.add("marker-failure-error")
    if other:
        reasons.add("other-error")
    if passing:
        reasons.add("other-warning")
    if button:
        reasons.add("paused-report")
    if offline:
        explained = passing or button or any(reason.endswith("-error") for reason in reasons)
        reasons.add("offline-report" if explained else "offline-error")
    return Status(frozenset(reasons))
