"""Device URIs, as CUPS writes them."""

from __future__ import annotations

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from devices.transports import open_transport, transport_type
from devices.transports.base import Uri
from halftone.errors import UsageError


@pytest.mark.parametrize(
    ("text", "language", "scheme", "host", "port", "path", "query"),
    [
        ("mem:", None, "mem", "", None, "", {}),
        ("escpos+mem:", "escpos", "mem", "", None, "", {}),
        ("socket://192.168.1.9:9100", None, "socket", "192.168.1.9", 9100, "", {}),
        ("zpl+socket://[::1]:6101", "zpl", "socket", "::1", 6101, "", {}),
        ("socket://printer.local", None, "socket", "printer.local", None, "", {}),
        ("file:/dev/usb/lp0", None, "file", "", None, "/dev/usb/lp0", {}),
        ("file:///tmp/a%20b", None, "file", "", None, "/tmp/a b", {}),
        ("serial:/dev/ttyS0?baud=9600", None, "serial", "", None, "/dev/ttyS0", {"baud": "9600"}),
        ("cups-raster+file:out", "cups-raster", "file", "", None, "out", {}),
        (
            "usb://EPSON/TM-T20%20II?serial=S1",
            None,
            "usb",
            "EPSON",
            None,
            "/TM-T20 II",
            {"serial": "S1"},
        ),
    ],
)
def test_parts(text, language, scheme, host, port, path, query):
    uri = Uri.parse(text)
    assert (uri.language, uri.scheme, uri.host, uri.port) == (language, scheme, host, port)
    assert (uri.path, uri.query) == (path, query)


@pytest.mark.parametrize("text", ["", "photo.png", ":x", "socket://h:port", "socket://[::1", "mem:?a"])
def test_what_is_none(text):
    with pytest.raises(UsageError):
        Uri.parse(text)


@given(st.text())
def test_any_text_is_a_uri_or_a_usage_error(text):
    with suppress(UsageError):
        assert Uri.parse(text).text == text


@pytest.mark.parametrize("text", ["usb://04b8:0202", "escpos+usb://04b8:0202", "usb://0a5f:00a3"])
def test_vendor_and_product(text):
    assert Uri.parse(text).scheme == "usb"


def test_numbers_and_options_of_a_query():
    uri = Uri.parse("serial:/dev/ttyS0?baud=9600&x=nan")
    assert uri.number("baud", 1, 50, 4e6) == 9600
    assert uri.number("none", 7, 0, 9) == 7
    with pytest.raises(UsageError, match="allowed: 0 … 1"):
        uri.number("baud", 1, 0, 1)
    with pytest.raises(UsageError, match="allowed"):
        uri.number("x", 1, 0, 1)
    with pytest.raises(UsageError, match="unknown option 'x'; allowed: baud"):
        uri.check_query("baud")


def test_schemes():
    with open_transport(Uri.parse("mem:")) as transport:
        assert transport.write(memoryview(b"abc"), 1) == 3
    with pytest.raises(UsageError, match="Did you mean socket"):
        transport_type("sokcet")
