"""CUPS raster as a language."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from devices.languages.cups_raster import CupsRaster
from devices.languages.pwg import Pwg
from devices.languages.raster_header import OLD, PAGE
from halftone.errors import UsageError
from tests.devices.languages import contract, rasters

PICTURE = (np.arange(600).reshape(20, 30) % 7 > 2).astype(np.uint8)
KINDS = [CupsRaster(version, order) for version in (2, 3) for order in ("little", "big")]
kinds = st.sampled_from(KINDS)


@given(kinds, contract.pictures(), st.lists(st.integers(0, 40)))
def test_round_trip(language, picture, split):
    contract.check_round_trip(language, picture, split)
    contract.check_rows_are_counted(language, picture)


@given(kinds, st.data(), st.sampled_from(rasters.GRAY), st.lists(st.integers(0, 40)))
def test_gray(language, data, levels, split):
    rasters.check_gray(language, data.draw(contract.pictures(levels=levels)), levels, split)


@given(kinds, contract.pictures(), st.floats(0, 1))
def test_abort(language, picture, at):
    contract.check_abort(language, picture, at)


@given(kinds, contract.pictures(levels=16), st.floats(0, 1))
def test_abort_of_gray(language, picture, at):
    rasters.check_gray_abort(language, picture, 16, at)


@settings(max_examples=20)
@given(kinds, contract.pictures(), st.integers(0, 2**32 - 1), st.sampled_from([2, 256]))
def test_damaged(language, picture, seed, levels):
    rng = np.random.default_rng(seed)
    data = contract.stream(language, picture, levels=levels)
    for _ in range(100):
        contract.check_damaged(language, data, rng)


@pytest.mark.parametrize("language", KINDS)
def test_every_end(language):
    rasters.check_every_end(language, contract.stream(language, PICTURE))


@pytest.mark.parametrize(
    ("language", "sync"), list(zip(KINDS, [b"2SaR", b"RaS2", b"3SaR", b"RaS3"], strict=True))
)
def test_header(language, sync):
    data = contract.stream(language, PICTURE, dpi=(300.0, 150.0), copies=3, cut=True)
    assert data[:4] == sync
    order = "<" if language.order == "little" else ">"
    header = PAGE.read(data[4:1800], order)
    said = {name: value for name, value in header.items() if np.any(np.array(value, object))}
    assert said == {
        "CutMedia": 4,
        "HWResolution": (300, 150),
        "ImagingBoundingBox": (0, 0, 7, 10),
        "NumCopies": 3,
        "PageSize": (7, 10),
        "cupsWidth": 30,
        "cupsHeight": 20,
        "cupsBitsPerColor": 1,
        "cupsBitsPerPixel": 1,
        "cupsBytesPerLine": 4,
        "cupsColorSpace": 3,
        "cupsNumColors": 1,
        "cupsBorderlessScalingFactor": 1.0,
        "cupsPageSize": (7.0, 10.0),
        "cupsImagingBBox": (0.0, 0.0, 7.0, 10.0),
    }


def test_rows_of_version_3_lie_as_they_are():
    """So that a break-off counts them one by one."""
    (piece,) = contract.pieces(CupsRaster(3), PICTURE)
    assert (piece.head, piece.stride) == (1800, 4)
    assert piece.accepted(1800 + 4 * 7 + 3) == 7
    assert len(piece.data) == 1800 + 20 * 4


@pytest.mark.parametrize("order", ["<", ">"])
def test_version_1_is_read(order):
    values = {"cupsWidth": 9, "cupsHeight": 2, "cupsBitsPerColor": 1, "cupsBitsPerPixel": 1}
    values |= {"cupsBytesPerLine": 2, "cupsColorSpace": 3, "HWResolution": (0, 0)}
    sync = b"RaSt" if order == ">" else b"tSaR"
    data = sync + OLD.write(values, order) + b"\x80\x00\xff\x80"
    (frame,) = CupsRaster.decode(data)
    assert frame.indices.tolist() == [[0] + [1] * 8, [0] * 9]
    assert frame.dpi is None
    rasters.check_refused(CupsRaster, data[:-1], len(data) - 1)


@pytest.mark.parametrize(
    ("space", "bits", "pixels", "codes"),
    [
        (0, 1, b"\x50", [0, 255, 0, 255, 0, 0, 0, 0]),  # W: 1 is white
        (18, 1, b"\x50", [0, 255, 0, 255, 0, 0, 0, 0]),
        (3, 1, b"\xaf", [0, 255, 0, 255, 0, 0, 0, 0]),  # K: 1 is ink
        (0, 8, b"\x00\x01\x80\xfe\xff\x00\x00\x00", [0, 1, 128, 254, 255, 0, 0, 0]),
        (3, 8, b"\x00\x01\x80\xfe\xff\x00\x00\x00", [255, 254, 127, 1, 0, 255, 255, 255]),
    ],
)
def test_what_pixels_look_like(space, bits, pixels, codes):
    values = {"cupsWidth": 8, "cupsHeight": 1, "cupsBitsPerColor": bits, "cupsBitsPerPixel": bits}
    values |= {"cupsBytesPerLine": bits, "cupsColorSpace": space}
    (frame,) = CupsRaster.decode(b"RaS3" + PAGE.write(values, ">") + pixels)
    assert frame.preview()[0].tolist() == codes


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("cupsColorSpace", 6),
        ("cupsBitsPerColor", 4),
        ("cupsColorOrder", 3),
        ("cupsBytesPerLine", 8),
        ("cupsHeight", 0),
    ],
)
@pytest.mark.parametrize("language", KINDS)
def test_the_field_that_is_wrong_is_named(language, name, value):
    order = "<" if language.order == "little" else ">"
    data, place = rasters.changed(contract.stream(language, PICTURE), name, value, order=order)
    rasters.check_refused(language, data, place)


def test_colour_pages_are_no_frames():
    values = {"cupsWidth": 1, "cupsHeight": 1, "cupsBitsPerColor": 8, "cupsBitsPerPixel": 24}
    values |= {"cupsBytesPerLine": 3, "cupsColorSpace": 19}
    rasters.check_refused(CupsRaster, b"RaS3" + PAGE.write(values, ">") + b"abc", 4)


def test_pwg_is_not_taken_for_it():
    data = contract.stream(Pwg(), PICTURE)
    assert not CupsRaster.sniff(data[:1024])
    assert Pwg.sniff(data[:1024])
    rasters.check_refused(CupsRaster, data, 4)
    for language in KINDS:
        data = contract.stream(language, PICTURE)
        assert CupsRaster.sniff(data[:1024])
        assert not Pwg.sniff(data[:1024])


@pytest.mark.parametrize("option", [{"version": 1}, {"order": "middle"}])
def test_options_that_are_not_allowed(option):
    with pytest.raises(UsageError, match=next(iter(option))):
        CupsRaster(**option)
