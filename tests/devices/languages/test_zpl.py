"""ZPL as a language: what is encoded, and what its strict reader takes and refuses."""

from __future__ import annotations

import base64
import binascii
import tracemalloc
import zlib

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from devices.errors import ProtocolError
from devices.languages import language
from devices.languages._acs_kernels import acs
from devices.languages.zpl import Zpl
from halftone.errors import UsageError
from halftone.packing import pack
from tests.devices.languages import contract
from tests.oracle import acs as oracle

COMPRESSIONS = ["acs", "hex", "z64"]
dialects = st.builds(
    Zpl,
    st.sampled_from(COMPRESSIONS),
    st.sampled_from([1, 20, 200, 32_768]),
    speed=st.integers(0, 14),
    media=st.sampled_from(["", "continuous", "gap", "mark"]),
)


@given(dialects, contract.pictures(), st.lists(st.integers(0, 40)))
def test_round_trip(zpl, picture, split):
    contract.check_round_trip(zpl, picture, split)
    contract.check_rows_are_counted(zpl, picture)


@settings(max_examples=300)
@given(dialects, contract.pictures(), st.floats(0, 1))
def test_abort(zpl, picture, at):
    contract.check_abort(zpl, picture, at)


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_abort_lays_nothing_more_than_the_row_under_way(compression):
    """Rows that were not begun are paper, but in Z64, where only the rest of the field completes it."""
    zpl = Zpl(compression, max_bytes=60)
    picture = np.zeros((40, 24), np.uint8)
    picture[:, 4:9] = 1
    made = contract.pieces(zpl, picture)
    sent = made[0].data + made[1].data
    for place in range(1, len(made[2].data) + 1):
        whole = sent + made[2].data[:place] + made[2].abort(place)
        (frame,) = zpl.decode(whole)
        ink = int((frame.indices == 0).any(axis=1).sum())
        done = 20 + made[2].accepted(place)
        assert ink in ((40,) if compression == "z64" else (done, done + 1))
        assert whole.endswith(b"^FS\n^XZ\n")


def test_a_broken_off_job_prints_one_copy_and_a_setup_alone_prints_nothing():
    picture = np.zeros((8, 8), np.uint8)
    made = contract.pieces(Zpl(), picture, copies=7)
    setup = made[0]
    for place in range(1, len(setup.data) + 1):
        assert Zpl.decode(setup.data[:place] + setup.abort(place)) == []
    (frame,) = Zpl.decode(setup.data + made[1].data + made[1].abort(len(made[1].data)))
    assert frame.report["copies"] == 1


@settings(max_examples=20)
@given(dialects, contract.pictures(), st.integers(0, 2**32 - 1))
def test_damaged(zpl, picture, seed):
    rng = np.random.default_rng(seed)
    data = contract.stream(zpl, picture)
    for _ in range(100):
        contract.check_damaged(zpl, data, rng)


@settings(max_examples=200)
@given(contract.pictures(width=2500, height=6))
@example(np.zeros((3, 8 * 420), np.uint8))
@example(np.ones((3, 8 * 420), np.uint8))
def test_kernel_is_its_twin(picture):
    rows = pack(picture, Zpl().packing(contract.frame_of(picture).levels))
    out, ends = np.empty(2 * rows.size, np.uint8), np.empty(len(rows), np.int64)
    acs(rows, out, ends)
    texts = oracle.encode([row.tobytes() for row in rows])
    assert out[: ends[-1]].tobytes().decode() == "".join(texts)
    np.testing.assert_array_equal(ends, np.cumsum([len(text) for text in texts]))


@given(st.integers(1, 5000))
def test_counts_say_their_number(n):
    letters = oracle.count(n)
    values = [20 * (ord(c) - 102) if c.islower() else ord(c) - 70 for c in letters]
    assert sum(values) == n
    assert len(letters) <= n // 400 + 2


def test_rows_are_coded_as_documented():
    rows = ["0000", "0000", "0FF0", "0FF0", "FFFF", "AAAB", "AA00", "ABFF", "5000"]
    assert oracle.encode([bytes.fromhex(row) for row in rows]) == [
        ",", ",", "0FF0", ":", "JF", "IAB", "AA,", "ABFF", "50,"
    ]  # fmt: skip


def test_the_bytes():
    picture = np.ones((3, 10), np.uint8)
    picture[1] = 0
    zpl = Zpl("hex", x=4, y=2, speed=3, media="continuous")
    data = contract.stream(zpl, picture, copies=2, density=7, cut=True)
    assert data == (
        b"~SD07^XA^PON^LH0,0^PW14^LL5^MNN^PR3^MMC\n^FO4,2^GFA,6,6,2,0000FFC00000^FS\n^PQ2^XZ\n"
    )
    (frame,) = Zpl.decode(data)
    assert frame.shape == (5, 14)
    assert (frame.indices == 0).sum() == 10
    assert (frame.indices[3, 4:] == 0).all()
    kept = {key: frame.report[key] for key in ("copies", "density", "speed", "mode", "media")}
    assert kept == {"copies": 2, "density": 7, "speed": 3, "mode": "C", "media": "N"}


def test_fields_are_within_the_languages_limit():
    rng = np.random.default_rng(1)
    picture = rng.integers(0, 2, (3000, 576)).astype(np.uint8)
    zpl = Zpl("hex", max_bytes=99_999)
    made = contract.pieces(zpl, picture)
    assert [piece.rows for piece in made] == [0, 1388, 1388, 224, 0]
    assert all(len(piece.data) < 1 << 16 + 8 for piece in contract.pieces(Zpl("hex"), picture))
    (frame,) = zpl.decode(b"".join(piece.data for piece in made))
    np.testing.assert_array_equal(frame.indices, picture)


def test_the_cutter_is_set_only_when_asked():
    picture = np.zeros((1, 8), np.uint8)
    pages = (contract.page(Zpl(), picture, cut=cut) for cut in (False, True, True, False, False))
    data = b"".join(piece.data for piece in Zpl().encode(pages))
    labels = data.split(b"^XZ")[:-1]
    assert [b"^MMC" in label for label in labels] == [False, True, True, False, False]
    assert [b"^MMT" in label for label in labels] == [False, False, False, True, False]
    assert len(Zpl.decode(data)) == 5


def test_no_prefix_in_data():
    rng = np.random.default_rng(2)
    picture = rng.integers(0, 2, (300, 300)).astype(np.uint8)
    for compression in COMPRESSIONS:
        for piece in contract.pieces(Zpl(compression), picture)[1:-1]:
            assert piece.data.count(b"^") == 3
            assert b"~" not in piece.data


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"compression": "zip"}, "compression"),
        ({"media": "paper"}, "media"),
        ({"max_bytes": 0}, "max_bytes"),
        ({"max_bytes": 100_000}, "max_bytes"),
        ({"x": -1}, "x = -1"),
        ({"y": 32_000}, "y = 32000"),
        ({"speed": "15"}, "speed"),
    ],
)
def test_wrong_options(options, named):
    with pytest.raises(UsageError, match=named):
        language("zpl", **options)


@pytest.mark.parametrize(
    ("zpl", "shape", "more", "named"),
    [
        (Zpl(), (1, 32_001), {}, "width.*32001"),
        (Zpl(x=10), (1, 31_991), {}, "width.*32001"),
        (Zpl(), (32_001, 1), {}, "height.*32001"),
        (Zpl(y=1), (32_000, 1), {}, "height.*32001"),
        (Zpl(), (1, 1), {"density": 31}, "density.*0 … 30"),
        (Zpl(), (1, 1), {"density": -1}, "density"),
    ],
)
def test_pages_that_do_not_fit(zpl, shape, more, named):
    with pytest.raises(UsageError, match=named):
        contract.stream(zpl, np.ones(shape, np.uint8), **more)


def test_rows_are_read_lazily_and_memory_is_that_of_a_field():
    asked = []

    def rows():
        for top in range(0, 31_000, 100):
            asked.append(top)
            yield np.full((100, 72), 0xA5, np.uint8)

    page = contract.page(Zpl(), np.zeros((1, 576), np.uint8))
    page = type(page)(576, 31_000, rows(), page.levels)
    made = Zpl("hex").encode([page])
    next(made)
    assert not asked
    next(made)
    assert len(asked) <= 5
    tracemalloc.start()
    for _ in made:
        pass
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert asked[-1] == 30_900
    assert peak < 1 << 19


# --- reading -----------------------------------------------------------------------------------


def dots(data: bytes) -> list[str]:
    """The only label as text, ``#`` ink."""
    (frame,) = Zpl.decode(data)
    return ["".join("#."[v] for v in row) for row in frame.indices]


def z64(data: bytes, name: bytes = b"Z", crc: int | None = None) -> bytes:
    text = base64.b64encode(zlib.compress(data) if name == b"Z" else data)
    return b":%s64:%s:%04X" % (name, text, binascii.crc_hqx(text, 0) if crc is None else crc)


def label(inside: bytes, width: int = 8, height: int = 2) -> bytes:
    return b"^XA^PW%d^LL%d%s^XZ" % (width, height, inside)


def test_the_crc_is_xmodems():
    assert binascii.crc_hqx(b"123456789", 0) == 0x31C3


@pytest.mark.parametrize(
    "data",
    [
        b"C3\r\n81",
        b"c381",
        z64(b"\xc3\x81"),
        z64(b"\xc3\x81", b"B"),
        b"C\n3\n8\n1\n",
        b"GCG3G8G1",
    ],
)
def test_forms_of_data(data):
    assert dots(label(b"^FO0,0^GFA,2,2,1," + data + b"^FS")) == ["##....##", "#......#"]


def test_alternative_compression():
    rows = [
        "f0000000",
        "a1ffffff",
        "a1ffffff",
        "00000000",
        "ffffffff",
        "33333333",
        "3333ffff",
        "00fffffe",
    ]
    data = b"F,A1LF:,NF\nG3G3L3\r\nJ3JF00KFE"
    assert dots(label(b"^FO0,0^GFA,32,32,4," + data + b"^FS", 32, 8)) == [
        f"{int(row, 16):032b}".replace("0", ".").replace("1", "#") for row in rows
    ]


def test_a_count_may_go_on_into_the_next_row():
    """Some encoders know no rows (zpl-image)."""
    assert dots(label(b"^FO0,0^GFA,2,2,1,8IF^FS")) == ["#...####", "########"]


def test_fields_lie_over_each_other_where_they_are_put():
    got = dots(
        label(b"^LH1,0^FO0,0^GFA,1,1,1,81^FS^FO2,1^GFA,2,2,2,8100^FS^FO7,0^GFA,1,1,1,C0^FS", 12, 2)
    )
    assert got == [".#......##..", "...#......#."]


def test_downloaded_images_as_cups_sends_them():
    data = (
        b"~SD15\n~DGR:CUPS.GRF,4,2,\nC3,:^XA\n^POI\n^PW10\n^PR4,4,4\n^LH0,0\n^MNM\n^LT0\n"
        b"^MTD\n^MMT,Y\n~TA000\n^JZY\n^PQ3, 0, 0, N\n^FO0,0^XGR:CUPS.GRF,1,1^FS\n^XZ\n"
        b"^XA\n^IDR:CUPS.GRF^FS\n^XZ\n^CN1\n"
    )
    (frame,) = Zpl.decode(data)
    assert frame.shape == (2, 10)
    assert frame.report["copies"] == 3
    assert (frame.report["density"], frame.report["speed"]) == (15, 4)
    with pytest.raises(ProtocolError, match="not downloaded"):
        Zpl.decode(data + label(b"^FO0,0^XGR:CUPS.GRF,1,1^FS"))


def test_size_and_settings_hold_for_the_next_label():
    one = b"^XA%s^FO0,0^GFA,1,1,1,80^FS^PQ%d^XZ"
    frames = Zpl.decode(one % (b"^PW9^LL3^PR2", 4) + b"^FX a comment\n" + one % (b"^LL5~SD03", 1))
    assert [frame.shape for frame in frames] == [(3, 9), (5, 9)]
    assert [frame.report["copies"] for frame in frames] == [4, 1]
    assert [frame.report["speed"] for frame in frames] == [2, 2]
    assert [frame.report.get("density") for frame in frames] == [None, 3]


def test_without_a_size_a_label_is_what_its_images_need():
    (frame,) = Zpl.decode(b"^XA^FO3,5^GFA,2,2,1,0180^FS^XZ")
    assert frame.shape == (7, 11)


OK = b"^FO0,0^GFA,2,2,1,8001^FS"


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (b"|", "command expected"),
        (b"| \r\n", "command expected"),
        (b"|hello", "command expected"),
        (b"^XA|", "not ended"),
        (b"^X|", "3 bytes expected"),
        (b"^XA|^XA", "within a label"),
        (b"|^XZ", "outside"),
        (b"|^FO0,0", "outside"),
        (b"^XA\n|^FDtext^FS^XZ", "unknown command"),
        (b"^XA|^PW0^XZ", "allowed: 1"),
        (b"^XA|^PW32001^XZ", "allowed: 1"),
        (b"^XA^PW|-1^XZ", "parameters"),
        (b"^XA^PR|A,B,Z^XZ", "parameters"),
        (b"~SD|31", "parameters"),
        (b"^XA|^PQ0^XZ", "0 copies"),
        (b"^XA|x^XZ", "command expected"),
        (label(b"^FO0,0|^FS"), "without an image"),
        (label(b"|^GFA,1,1,1,80^FS"), r"own \^FO"),
        (label(b"^FO0,0|^FO0,0"), "not ended by"),
        (label(b"^FO0,0^GFA,1,1,1,80|"), "not ended by"),
        (label(b"^FO0,0^GF|B,1,1,1,\x80^FS"), "three numbers"),
        (label(b"^FO0,0^GFA,|2,3,1,80^FS"), "2 bytes of data for 3"),
        (label(b"^FO0,0^GF|A,3,3,2,80^FS"), "whole rows"),
        (label(b"^FO0,0^GFA,2,2,1,8|^FS"), "0 of 2 bytes"),
        (label(b"^FO0,0^GFA,2,2,1,8000|FF^FS"), "command expected"),
        (label(b"^FO0,0^GFA,2,2,1,|:80^FS"), "CRC of four"),
        (label(b"^FO0,0^GFA,2,2,1,8|:0^FS"), "between rows"),
        (label(b"^FO0,0^GFA,2,2,1,|!00^FS"), "ink and others"),
        (label(b"^FO0,0^GFA,2,2,1,|G,^FS"), "count expected"),
        (label(b"^FO0,0^GFA,2,2,1,|gF^FS"), "longer than the image"),
        (label(b"^FO0,0^GFA,2,2,1," + z64(b"\x80\x01", crc=0x1234)[:-4] + b"|1234^FS"), "CRC 1234"),
        (label(b"^FO0,0^GFA,2,2,1,:Z64:|" + z64(b"\x80\x01\x02")[5:] + b"^FS"), "2 bytes.*, more given"),
        (label(b"^FO0,0^GFA,2,2,1,:Z64:|" + z64(b"\x80")[5:] + b"^FS"), "2 bytes.*, 1 given"),
        (label(b"^FO0,0^GFA,2,2,1,:Z64:|" + z64(b"\x80\x01", b"B")[5:] + b"^FS"), "error -3"),
        (label(b"^FO0,1|^GFA,2,2,1,8001^FS"), "ink outside"),
        (label(b"^FO1,0|^GFA,2,2,1,8001^FS"), "ink outside"),
        (label(b"^FO9,0|^GFA,2,2,1,8001^FS"), "ink outside"),
        (label(b"^FO0,9|^GFA,2,2,1,8001^FS"), "ink outside"),
        (label(OK + b"|^LL9"), "next label"),
        (label(b"^FO0,0^XG|R:A.GRF,2,2^FS"), "not magnified"),
        (label(b"^FO0,0|^XGR:A.GRF,1,1^FS"), "not downloaded"),
    ],
)
def test_the_offset_of_what_is_wrong(data, what):
    """The bar stands where the fault is, and is taken out."""
    with pytest.raises(ProtocolError, match=what) as caught:
        Zpl.decode(data.replace(b"|", b""))
    assert caught.value.offset == data.index(b"|")


def test_limits_are_checked_before_anything_is_made():
    bomb = label(b"^FO0,0^GFA,99999,99999,1," + z64(bytes(99_999)) + b"^FS", 8, 32_000)
    many = b"~DGA.GRF,9999,99,F," + b":" * 100 + b"^XA" + b"^FO0,0^XGA.GRF^FS" * 2000 + b"^XZ"
    big = label(b"^FO0,0^GFA,1,1,1,0^FS", 32_000, 32_000)
    lying = label(b"^FO0,0^GFA,2,2,1," + z64(bytes(10_000_000)) + b"^FS")
    tracemalloc.start()
    for data in (bomb, many, big, lying):
        with pytest.raises(ProtocolError):
            Zpl.decode(data, 1 << 16)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1 << 20
    with pytest.raises(ProtocolError, match="pixels"):
        Zpl.decode(label(OK), 15)
    assert Zpl.decode(label(OK), 16)[0].shape == (2, 8)


@given(st.binary(max_size=200))
def test_any_bytes(data):
    rng = np.random.default_rng(len(data))
    contract.check_damaged(Zpl(), b"^XA^FO0,0^GFA,9,9,3," + data, rng)
