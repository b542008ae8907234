"""Page headers as tables."""

from __future__ import annotations

import pytest

from devices.languages.raster_header import OLD, PAGE, PWG, PWG_UNUSED, URF


def test_sizes():
    assert (OLD.size, PAGE.size, URF.size) == (420, 1796, 32)


@pytest.mark.parametrize(
    ("name", "place"),
    [  # spec-raster.html of CUPS, tables 1 and 2
        ("MediaColor", 64),
        ("OutputType", 192),
        ("AdvanceDistance", 256),
        ("CutMedia", 268),
        ("HWResolution", 276),
        ("ImagingBoundingBox", 284),
        ("Margins", 312),
        ("NumCopies", 340),
        ("PageSize", 352),
        ("Tumble", 368),
        ("cupsWidth", 372),
        ("cupsBitsPerPixel", 388),
        ("cupsColorSpace", 400),
        ("cupsRowStep", 416),
        ("cupsNumColors", 420),
        ("cupsPageSize", 428),
        ("cupsInteger", 452),
        ("cupsReal", 516),
        ("cupsString", 580),
        ("cupsMarkerType", 1604),
        ("cupsRenderingIntent", 1668),
        ("cupsPageSizeName", 1732),
    ],
)
def test_places(name, place):
    assert PAGE.place(name) == place
    assert name not in OLD.fields or OLD.place(name) == place


def test_places_of_pwg():
    assert PAGE.place("cupsInteger", PWG["AlternatePrimary"]) == 480  # PWG 5102.4, table 1
    assert PAGE.place("cupsInteger", PWG["VendorLength"]) == 512
    assert set(PWG_UNUSED) < set(PAGE.fields)


def test_places_of_urf():
    places = {name: URF.place(name) for name in URF.fields}
    assert places == {
        "BitsPerPixel": 0,
        "ColorSpace": 1,
        "Duplex": 2,
        "Quality": 3,
        "MediaType": 4,
        "MediaPosition": 5,
        "Zeros": 6,
        "Width": 12,
        "Height": 16,
        "Resolution": 20,
        "Rest": 24,
    }


@pytest.mark.parametrize("order", ["<", ">"])
def test_all_that_is_written_is_read(order):
    values = {}
    for number, field in enumerate(PAGE.fields.values()):
        kinds = {"64s": f"text {number}", "I": 1000 + number, "f": number + 0.5}
        one = kinds[field.kind]
        values[field.name] = (one,) * field.count if field.count > 1 else one
    data = PAGE.write(values, order)
    assert PAGE.read(data, order) == values
    assert OLD.read(data[: OLD.size], order) == {name: values[name] for name in OLD.fields}
    assert PAGE.read(data, "<>"[order == "<"])["cupsWidth"] != values["cupsWidth"]


def test_nothing_is_zeros():
    assert PAGE.write({}, ">") == bytes(1796)


def test_a_text_ends_at_its_first_nul():
    data = bytearray(PAGE.write({"MediaType": "labels"}, ">"))
    data[128 + 7 : 128 + 12] = b"noise"
    assert PAGE.read(bytes(data), ">")["MediaType"] == "labels"
