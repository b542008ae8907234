"""What holds for PWG raster, CUPS raster and URF alike, as functions that their tests call."""

from __future__ import annotations

import numpy as np
import pytest

from devices.errors import ProtocolError
from devices.languages.raster_header import PAGE, URF
from tests.devices.languages import contract

GRAY = (3, 4, 16, 200, 256)
"""Counts of levels that are sent as gray."""


def shown(frame):
    """8-bit sRGB codes of what a frame shows."""
    return frame.preview()


def check_gray(language, picture, levels, split=()):
    """Gray levels come back as what they show, however the rows are cut."""
    data = contract.stream(language, picture, levels=levels)
    assert contract.stream(language, picture, split=split, levels=levels) == data
    (frame,) = language.decode(data)
    np.testing.assert_array_equal(shown(frame), shown(contract.frame_of(picture, levels)))
    assert frame.dpi == (203.0, 203.0)


def check_gray_abort(language, picture, levels, at):
    """Broken off anywhere, the rows that were accepted are there and paper or the picture below."""
    made = contract.pieces(language, picture, levels=levels)
    place = max(1, int(at * sum(len(piece.data) for piece in made)))
    sent, rows = b"", 0
    for piece in made:
        part = min(len(piece.data), place - len(sent))
        sent, rows = sent + piece.data[:part], rows + piece.accepted(part)
        if len(sent) == place:
            sent += piece.abort(part)
            break
    (frame,) = language.decode(sent)
    got, wanted = shown(frame), shown(contract.frame_of(picture, levels))
    assert got.shape == wanted.shape
    np.testing.assert_array_equal(got[:rows], wanted[:rows])
    assert ((got == 255) | (got == wanted)).all()


def changed(data, name, value, index=0, start=4, order=">"):
    """*data* with another value in a field of the first header, and the field's offset."""
    table = URF if data[:3] == b"UNI" else PAGE
    place = start + table.place(name, index)
    size = 1 if table.fields[name].kind == "B" else 4
    number = value.to_bytes(size, "big" if order == ">" else "little")
    return data[:place] + number + data[place + size :], place


def check_refused(language, data, offset):
    """*data* is refused with *offset*."""
    with pytest.raises(ProtocolError) as caught:
        language.decode(data)
    assert caught.value.offset == offset
    assert caught.value.language == language.name


def check_every_end(language, data):
    """Cut anywhere, a stream of one page is refused where it ends, or where its field lies."""
    for end in range(len(data)):
        with pytest.raises(ProtocolError) as caught:
            language.decode(data[:end])
        assert caught.value.offset <= end
