"""PCL 5: what is written is read back, and every mode is read; wrong streams are named by offset."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from devices.errors import ProtocolError
from devices.languages.base import Page
from devices.languages.pcl import MODES, UEL, Pcl
from halftone.errors import UsageError
from halftone.tone.levels import Levels
from tests.devices.languages import contract

DPI = (300.0, 300.0)
coders = st.builds(Pcl, mode=st.sampled_from(MODES), pjl=st.booleans())


@given(coders, contract.pictures(), st.lists(st.integers(0, 40)))
def test_round_trip(language, picture, split):
    contract.check_round_trip(language, picture, split, dpi=DPI)
    contract.check_rows_are_counted(language, picture, dpi=DPI)


@given(coders, contract.pictures(), st.floats(0, 1))
def test_abort(language, picture, at):
    contract.check_abort(language, picture, at, dpi=DPI)


@settings(max_examples=20)
@given(coders, contract.pictures(), st.integers(0, 2**32 - 1))
def test_damaged(language, picture, seed):
    rng = np.random.default_rng(seed)
    data = contract.stream(language, picture, dpi=DPI)
    for _ in range(100):
        contract.check_damaged(language, data, rng)


@settings(max_examples=8)
@given(coders, st.integers(2000, 9000), st.integers(1, 60), st.integers(0, 2**32 - 1))
def test_wide_pages_come_in_many_pieces(language, width, height, seed):
    rng = np.random.default_rng(seed)
    picture = (rng.random((height, width)) < rng.random((height, 1))).astype(np.uint8)
    split = rng.integers(1, 60, 5).tolist()
    contract.check_round_trip(language, picture, split, dpi=(1200.0, 1200.0))
    made = contract.pieces(language, picture, dpi=(1200.0, 1200.0))
    assert max(len(piece.data) for piece in made) < 1 << 16
    assert len(made) >= height * width // 8 // (1 << 15)


@given(contract.pictures(), st.floats(0, 1))
def test_abort_among_many_pieces(picture, at):
    contract.check_abort(Pcl(), np.tile(picture, (3, 60)), at, dpi=DPI)


def test_a_job_of_several_pages():
    rng = np.random.default_rng(1)
    pictures = [rng.integers(0, 2, shape).astype(np.uint8) for shape in [(9, 20), (3, 70), (30, 8)]]
    data = contract.stream(Pcl(), *pictures, dpi=(600.0, 600.0), copies=3)
    frames = Pcl.decode(data)
    for frame, picture in zip(frames, pictures, strict=True):
        np.testing.assert_array_equal(frame.indices, picture)
        assert frame.dpi == (600.0, 600.0)
        assert frame.report["copies"] == 3


def test_best_is_never_longer_than_the_best_single_mode():
    rng = np.random.default_rng(2)
    smooth = (rng.random((300, 576)) < np.linspace(0, 1, 300)[:, None] ** 2).astype(np.uint8)
    ruled = np.ones((300, 576), np.uint8)
    ruled[::7, 40:500] = ruled[50:250, 60:62] = 0
    for picture in (smooth, ruled, np.concatenate([smooth, ruled])):
        best, *single = (len(contract.stream(Pcl(mode), picture, dpi=DPI)) for mode in MODES)
        assert best <= min(single) + 2 * 2  # the mode may be set once more at either end


def test_the_bytes_of_a_small_page():
    picture = np.ones((5, 17), np.uint8)
    picture[1] = picture[2] = 0
    data = contract.stream(Pcl("3", pjl=True), picture, dpi=(150.0, 150.0), copies=2)
    assert data == (
        UEL + b"@PJL ENTER LANGUAGE=PCL\r\n\x1bE\x1b&l2x0l0E\x1b*p0x0Y\x1b*t150R"
        b"\x1b*r0f17s5T\x1b*r1A\x1b*b1Y\x1b*b3m4W\x40\xff\xff\x80\x1b*b0W\x1b*b2Y\x1b*rC\x0c\x1bE" + UEL
    )


@pytest.mark.parametrize(
    "options", [{"dpi": (203.0, 203.0)}, {"dpi": (300.0, 600.0)}, {"density": 3}, {"cut": True}]
)
def test_what_pcl_cannot_express_is_refused(options):
    picture = np.ones((1, 8), np.uint8)
    with pytest.raises(UsageError):
        contract.stream(Pcl(), picture, **{"dpi": DPI, **options})


def test_what_is_no_option_is_refused():
    for options in ({"mode": "5"}, {"dpi": 180}):
        with pytest.raises(UsageError, match="allowed"):
            Pcl(**options)
    with pytest.raises(UsageError, match="32767"):
        contract.stream(Pcl(), np.ones((32_768, 1), np.uint8), dpi=DPI)


def rows(data: bytes) -> list[str]:
    (frame,) = Pcl.decode(data)
    return ["".join(".#"[1 - dot] for dot in row) for row in frame.indices]


HEAD = b"\x1bE\x1b*t300R"
TAIL = b"\x1b*rB\x0c\x1bE"


@pytest.mark.parametrize(
    ("body", "shown"),
    [
        (b"\x1b*r1A\x1b*b1W\xf0\x1b*bW\x1b*b0M\x1b*b1W\x0f", ["####....", "........", "....####"]),
        (b"\x1b*r1A\x1b*b1m4W\x00\xf0\x01\x0f", ["####........####....####"]),
        (b"\x1b*r1A\x1b*b2m5W\x80\xff\x0f\x00\xf0", ["....####....########...."]),
        (
            b"\x1b*r1A\x1b*b1W\xf0\x1b*b3m0W\x1b*b2W\x01\xff",
            ["####............"] * 2 + ["####....########"],
        ),
        (b"\x1b*r1A\x1b*b1W\xf0\x1b*b2Y\x1b*b3m0W", ["####...."] + ["........"] * 3),
        (b"\x1b*r4s2T\x1b*r1A\x1b*b1W\x90", ["#..#", "...."]),
        (b"\x1b*r4S\x1b*r1A\x1b*b3W\x90\x00\x00\x1b*b3m0W", ["#..#", "#..#"]),
        (b"\x1b*p3x+2Y\x1b*r1A\x1b*b1W\xf0", ["." * 11] * 2 + ["...####...."]),
        (b"\x1b&u600D\x1b*p4Y\x1b*p-2Y\x1b*r0A\x1b*b1W\xf0", ["........", "####...."]),
        (b"\x1b&a4.0v0H\x1b*t75R\x1b*t300R\x1b*r1A\x1b*b1W\xf0", ["........", "####...."]),
        (b"\x1b*r1A\x1b*b1W\xf0\x1b*p+1Y\x1b*b1W\x0f", ["####....", "........", "....####"]),
        (b"\x1b*r1A\x1b*b1W\xf0\x1b*rC\x1b*p0Y\x1b*r1A\x1b*b1W\x0f", ["########"]),
        (b"\x1b&l1o0l26a2X\x1b&k2G\x1b*r1A\x1b*b1W\xf0", ["####...."]),
        (
            UEL + b"@PJL SET X=1\r\n@PJL ENTER LANGUAGE = PCL\n\x1b*t75R\x1b*r1A\x1b*b1W\xf0",
            ["####...."],
        ),
    ],
)
def test_what_a_printer_draws(body, shown):
    assert rows(HEAD + body + TAIL) == shown


@pytest.mark.parametrize(
    "marked",
    [
        b"|",
        b"\x1b|",
        b"|A",
        b"|\x1b9",
        b"\x1b*t|301R",
        b"\x1b*t300|",
        b"\x1b*t|3.5R",
        b"\x1b*t3|\x01R",
        b"\x1b*c|5P",
        b"\x1b(|8U",
        b"\x1b%|0B",
        b"\x1b&u|7D",
        b"\x1b*p|-1X",
        b"\x1b*r|3U",
        b"\x1b*r|2A",
        b"\x1b*r1A\x1b*b|5M",
        b"\x1b*r1A\x1b*b|3V\x01\x02\x03",
        b"\x1b*r1A\x1b*r|8S",
        b"\x1b*r8S\x1b*r1A\x1b*b|2W\x00\x01",
        b"\x1b*r7S\x1b*r1A\x1b*b|1W\x01\x1b*rC\x0c",
        b"\x1b*r1T\x1b*r1A\x1b*b|2Y",
        b"\x1b*r1A\x1b*b9W\x00|",
        b"\x1b*r1A\x1b*b1m3W\x00\x00|\x00",
        b"\x1b*r1A\x1b*b3m1W|\x00",
        b"\x1b*r1A\x1b*b3m2W|\x1f\xff",
        b"\x1b*r1A\x1b*b1W\x00\x1b*rC|",
        b"\x1b*r1A\x1b*b1W\x00\x1b&l|0O",
        b"\x1b*r1A\x1b*b1W\xff\x1b*rC\x1b*t300R\x1b*r1A\x1b*b1W\xff|\x0c",
        b"\x1bE|\x0c",
        b"\x1b%-12345X|@PJL ENTER LANGUAGE=PS\n",
        b"\x1b%-12345X@PJL |\xff\n",
        b"\x1b%-12345X|@PJL",
    ],
)
def test_the_offset_of_what_is_wrong(marked):
    with pytest.raises(ProtocolError) as caught:
        Pcl.decode(marked.replace(b"|", b""))
    assert caught.value.offset == marked.index(b"|")


@pytest.mark.parametrize(
    "body",
    [
        b"\x1b*r65535s65535T\x1b*r1A",
        b"\x1b*r1A\x1b*b1W\xff" + b"\x1b*b65535Y" * 9,
        b"\x1b*p65535Y\x1b*r1A" + b"\x1b*b3m2W\x00\xff" * 30,
        b"\x1b*r1A\x1b*b1m1000W" + b"\xff\x00" * 500,
        b"\x1b*r1A\x1b*b3m9003W\x1f" + b"\xff" * 9000 + b"\x00\x01",
    ],
)
def test_a_page_beyond_the_limit_is_refused_before_it_is_made(body):
    with pytest.raises(ProtocolError, match="more than"):
        Pcl.decode(HEAD + body + TAIL, 1 << 18)


def test_a4_at_1200_dpi_takes_the_memory_of_a_band():
    width, height, band = 9921, 14031, 16
    taken = 0

    def bands():
        nonlocal taken
        row = np.random.default_rng(4).integers(0, 256, (band, (width + 7) // 8)).astype(np.uint8)
        row[:, -1] &= 0x80
        while taken < height:
            some = row[: height - taken]
            taken += len(some)
            yield some

    page = Page(width, height, bands(), Levels.of(2), (1200.0, 1200.0))
    contract.stream(Pcl(), np.eye(9, dtype=np.uint8), dpi=(1200.0, 1200.0))  # the kernels are loaded now
    tracemalloc.start()
    try:
        sent = 0
        for piece in Pcl().encode([page]):
            sent += piece.rows
            assert sent <= taken <= sent + 2 * band
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert sent == height
    assert peak < 1 << 20
