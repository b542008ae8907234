"""PWG raster as a language."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from devices.languages.pwg import Pwg
from devices.languages.raster_header import PAGE
from halftone.errors import UsageError
from halftone.tone.levels import Levels
from tests.devices.languages import contract, rasters

START = 4
PICTURE = (np.arange(600).reshape(20, 30) % 7 > 2).astype(np.uint8)


def header(data):
    return PAGE.read(data[START : START + PAGE.size], ">")


@given(contract.pictures(), st.lists(st.integers(0, 40)))
def test_round_trip(picture, split):
    contract.check_round_trip(Pwg(), picture, split)
    contract.check_rows_are_counted(Pwg(), picture)


@given(st.data(), st.sampled_from(rasters.GRAY), st.lists(st.integers(0, 40)))
def test_gray(data, levels, split):
    rasters.check_gray(Pwg(), data.draw(contract.pictures(levels=levels)), levels, split)


@given(contract.pictures(), st.floats(0, 1))
def test_abort(picture, at):
    contract.check_abort(Pwg(), picture, at)


@given(contract.pictures(levels=16), st.floats(0, 1))
def test_abort_of_gray(picture, at):
    rasters.check_gray_abort(Pwg(), picture, 16, at)


@settings(max_examples=20)
@given(contract.pictures(), st.integers(0, 2**32 - 1), st.sampled_from([2, 256]))
def test_damaged(picture, seed, levels):
    rng = np.random.default_rng(seed)
    data = contract.stream(Pwg(), picture, levels=levels)
    for _ in range(100):
        contract.check_damaged(Pwg(), data, rng)


def test_every_end():
    rasters.check_every_end(Pwg(), contract.stream(Pwg(), PICTURE))


def test_header():
    language = Pwg(media="labels", page_size="om_x_10x20mm", quality=5, optimize="photo")
    data = contract.stream(language, PICTURE, dpi=(300.0, 150.0), copies=3, cut=True)
    said = {name: value for name, value in header(data).items() if np.any(np.array(value, object))}
    assert said == {
        "MediaClass": "PwgRaster",
        "MediaType": "labels",
        "OutputType": "photo",
        "CutMedia": 4,
        "HWResolution": (300, 150),
        "NumCopies": 3,
        "PageSize": (7, 10),
        "cupsWidth": 30,
        "cupsHeight": 20,
        "cupsBitsPerColor": 1,
        "cupsBitsPerPixel": 1,
        "cupsBytesPerLine": 4,
        "cupsColorSpace": 3,
        "cupsNumColors": 1,
        "cupsInteger": (0, 1, 1, 0, 0, 0, 0, 0xFFFFFF, 5, 0, 0, 0, 0, 0, 0, 0),
        "cupsPageSizeName": "om_x_10x20mm",
    }
    (frame,) = Pwg.decode(data)
    assert frame.dpi == (300.0, 150.0)
    assert frame.report["copies"] == 3
    assert frame.report["cut"] is True
    assert frame.report["header"] == said


def test_header_of_gray():
    got = header(contract.stream(Pwg(), PICTURE, levels=16))
    assert (got["cupsColorSpace"], got["cupsBitsPerColor"], got["cupsBytesPerLine"]) == (18, 8, 30)


def test_pages_follow_each_other():
    pictures = [PICTURE, 1 - PICTURE[:5], PICTURE[:, :9]]
    data = contract.stream(Pwg(), *pictures)
    assert data.count(b"RaS2") == 1
    for got, wanted in zip(Pwg.decode(data), pictures, strict=True):
        np.testing.assert_array_equal(got.indices, wanted)


def test_equal_lines_are_one_over_pieces():
    """600 blank rows of 30 kB are three groups, though a band holds one row."""
    blank = np.full((600, 30_000), 255, np.uint8)
    made = contract.pieces(Pwg(), blank, levels=256)
    assert sum(len(piece.data) for piece in made) == 4 + 1796 + 3 * (1 + 2 * 235)


def test_pieces_are_small():
    noise = np.random.default_rng(0).integers(0, 256, (300, 5000)).astype(np.uint8)
    made = contract.pieces(Pwg(), noise, levels=256)
    assert max(len(piece.data) for piece in made) < 1 << 16
    assert len(made) > 20


def test_rows_are_read_as_pieces_are_asked_for():
    read = []

    def rows():
        for number in range(100):
            read.append(number)
            yield np.random.default_rng(number).integers(0, 256, (10, 1000)).astype(np.uint8)

    page = contract.page(Pwg(), np.zeros((1000, 1000), np.uint8), levels=256)
    made = Pwg().encode([type(page)(1000, 1000, rows(), page.levels, page.dpi)])
    next(made)
    assert len(read) < 12


@pytest.mark.parametrize(
    ("name", "value", "index"),
    [
        ("HWResolution", 0, 1),
        ("AdvanceDistance", 1, 0),
        ("cupsRowStep", 7, 0),
        ("CutMedia", 5, 0),
        ("Duplex", 2, 0),
        ("Orientation", 4, 0),
        ("cupsWidth", 0, 0),
        ("cupsWidth", 1 << 24, 0),
        ("cupsHeight", 0, 0),
        ("cupsBitsPerColor", 2, 0),
        ("cupsBitsPerColor", 16, 0),
        ("cupsBitsPerPixel", 8, 0),
        ("cupsBytesPerLine", 5, 0),
        ("cupsColorOrder", 1, 0),
        ("cupsColorSpace", 6, 0),
        ("cupsNumColors", 3, 0),
        ("cupsInteger", 2, 1),
        ("cupsInteger", 2, 8),
        ("cupsInteger", 1, 9),
        ("cupsInteger", 1089, 15),
    ],
)
def test_the_field_that_is_wrong_is_named(name, value, index):
    data, place = rasters.changed(contract.stream(Pwg(), PICTURE), name, value, index)
    rasters.check_refused(Pwg(), data, place)


def test_vendor_data_may_be_anything():
    data, _ = rasters.changed(contract.stream(Pwg(), PICTURE), "cupsReal", 77)
    np.testing.assert_array_equal(Pwg.decode(data)[0].indices, PICTURE)


@pytest.mark.parametrize(("start", "offset"), [(b"", 0), (b"RaS3", 3), (b"RaS2Pwg", 7), (b"2SaR", 0)])
def test_other_streams(start, offset):
    rasters.check_refused(Pwg(), start, offset)


def test_wrong_pixels():
    data = contract.stream(Pwg(), np.ones((5, 30), np.uint8))  # one group: 04 03 00
    body = 4 + 1796
    assert data[body:] == b"\4\3\0"
    rasters.check_refused(Pwg(), data[:body] + b"\5\3\0", body)  # six lines of five
    rasters.check_refused(Pwg(), data[:body] + b"\4\4\0", body + 1)  # five bytes of four
    rasters.check_refused(Pwg(), data[:body] + b"\3\3\0", len(data))  # four lines of five
    rasters.check_refused(Pwg(), data + b"\0", len(data) + 1)  # no header
    (frame,) = Pwg.decode(data[:body] + b"\4\x80")  # the rest is blank
    assert (frame.indices == 1).all()


def test_a_count_of_pages_is_held():
    data, _ = rasters.changed(contract.stream(Pwg(), PICTURE), "cupsInteger", 2)
    rasters.check_refused(Pwg(), data, len(data))


def test_no_more_pixels_than_allowed():
    data = contract.stream(Pwg(), PICTURE, PICTURE)
    assert len(Pwg.decode(data, limit=1200)) == 2
    with pytest.raises(ValueError, match="more pixels than allowed"):
        Pwg.decode(data, limit=1199)


@pytest.mark.parametrize(
    "option",
    [{"media": "x" * 64}, {"media_color": "weiß"}, {"page_size": "a\nb"}, {"quality": 2}],
)
def test_options_that_are_not_allowed(option):
    with pytest.raises(UsageError, match=next(iter(option))):
        Pwg(**option)


def test_pages_that_cannot_be_expressed():
    with pytest.raises(UsageError, match="dpi"):
        contract.stream(Pwg(), PICTURE, dpi=None)
    with pytest.raises(UsageError, match="dpi"):
        contract.stream(Pwg(), PICTURE, dpi=(0.2, 100.0))
    with pytest.raises(UsageError, match="density"):
        contract.stream(Pwg(), PICTURE, density=3)
    with pytest.raises(UsageError, match="Leave one"):
        Pwg().packing(Levels.of([0, 0.5, 0.5001, 1]))


def test_gray_of_a_measured_ladder():
    ladder = Levels.of([0.03, 0.2, 0.5, 0.9])
    packing = Pwg().packing(ladder)
    assert packing.codes == tuple(ladder.srgb())
    assert packing.bits == 8
