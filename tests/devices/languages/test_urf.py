"""URF as a language."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from devices.languages.base import encoded
from devices.languages.raster_header import URF
from devices.languages.urf import Urf
from halftone.errors import UsageError
from tests.devices.languages import contract, rasters

PICTURE = (np.arange(600).reshape(20, 30) % 7 > 2).astype(np.uint8)


@given(contract.pictures(), st.lists(st.integers(0, 40)))
def test_round_trip(picture, split):
    contract.check_round_trip(Urf(), picture, split)
    contract.check_rows_are_counted(Urf(), picture)


@given(st.data(), st.sampled_from(rasters.GRAY), st.lists(st.integers(0, 40)))
def test_gray(data, levels, split):
    rasters.check_gray(Urf(), data.draw(contract.pictures(levels=levels)), levels, split)


@given(contract.pictures(), st.floats(0, 1))
def test_abort(picture, at):
    contract.check_abort(Urf(), picture, at)


@given(contract.pictures(levels=16), st.floats(0, 1))
def test_abort_of_gray(picture, at):
    rasters.check_gray_abort(Urf(), picture, 16, at)


@settings(max_examples=20)
@given(contract.pictures(), st.integers(0, 2**32 - 1), st.sampled_from([2, 256]))
def test_damaged(picture, seed, levels):
    rng = np.random.default_rng(seed)
    data = contract.stream(Urf(), picture, levels=levels)
    for _ in range(100):
        contract.check_damaged(Urf(), data, rng)


def test_every_end():
    rasters.check_every_end(Urf(), contract.stream(Urf(), PICTURE))


def test_header():
    data = contract.stream(Urf(quality=4), PICTURE, dpi=(300.0, 300.0))
    assert data[:12] == b"UNIRAST\0\0\0\0\0"
    assert data[12:44] == bytes.fromhex("08000104 00000000 00000000 0000001e 00000014 0000012c") + bytes(
        8
    )
    (frame,) = Urf.decode(data)
    assert frame.dpi == (300.0, 300.0)
    assert frame.report["header"]["PageSize"] == (7, 4)


def test_the_count_of_pages():
    """A single page is counted; of several, a break-off could leave fewer."""
    frame = contract.frame_of(PICTURE)
    assert contract.stream(Urf(), PICTURE)[8:12] == bytes(4)
    page = contract.page(Urf(), PICTURE)
    data = b"".join(piece.data for piece in Urf().encode([page]))
    assert data[8:12] == b"\0\0\0\1"
    assert len(Urf.decode(data)) == 1
    assert len(Urf.decode(encoded(Urf(), frame, frame))) == 2
    rasters.check_refused(Urf(), data + data[12:], 2 * len(data) - 12)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("BitsPerPixel", 1),
        ("BitsPerPixel", 24),
        ("ColorSpace", 2),
        ("Duplex", 4),
        ("Quality", 1),
        ("MediaType", 14),
        ("Zeros", 1),
        ("Rest", 1),
        ("Width", 0),
        ("Height", 1 << 24),
        ("Resolution", 0),
    ],
)
def test_the_field_that_is_wrong_is_named(name, value):
    data, place = rasters.changed(contract.stream(Urf(), PICTURE), name, value, start=12)
    rasters.check_refused(Urf(), data, place)


def test_other_streams():
    rasters.check_refused(Urf(), b"UNIRASTER", 7)
    rasters.check_refused(Urf(), b"UNIRAST\0\0\0\0\1", 12)
    assert URF.size == 32


def test_pages_that_cannot_be_expressed():
    with pytest.raises(UsageError, match="dpi"):
        contract.stream(Urf(), PICTURE, dpi=None)
    with pytest.raises(UsageError, match="300 × 150"):
        contract.stream(Urf(), PICTURE, dpi=(300.0, 150.0))
    with pytest.raises(UsageError, match="copies"):
        contract.stream(Urf(), PICTURE, copies=2)
    with pytest.raises(UsageError, match="quality"):
        Urf(quality=1)
