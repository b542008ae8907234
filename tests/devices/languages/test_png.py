"""PNG as a language."""

from __future__ import annotations

import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from devices.errors import ProtocolError
from devices.languages.base import page_of
from devices.languages.png import Png
from halftone.errors import UsageError
from halftone.frame import Frame
from halftone.images import png as files
from halftone.tone.levels import Levels
from tests.devices.languages import contract

SIGNATURE = b"\x89PNG\r\n\x1a\n"
COUNTS = [2, 3, 4, 5, 16, 17, 256]
PICTURE = (np.arange(600).reshape(20, 30) % 7 > 2).astype(np.uint8)


def chunk(kind, data=b""):
    return len(data).to_bytes(4, "big") + kind + data + zlib.crc32(kind + data).to_bytes(4, "big")


def header(width, height, bits=8, colour=0, *rest):
    numbers = width.to_bytes(4, "big") + height.to_bytes(4, "big")
    return chunk(b"IHDR", numbers + bytes([bits, colour, *(rest or (0, 0, 0))]))


def file(*chunks):
    return SIGNATURE + b"".join(chunks)


def pixels(raw):
    return chunk(b"IDAT", zlib.compress(raw))


END = chunk(b"IEND")


@given(st.data(), st.sampled_from(COUNTS), st.lists(st.integers(0, 40)))
def test_round_trip(data, levels, split):
    picture = data.draw(contract.pictures(levels=levels))
    contract.check_round_trip(Png(), picture, split, levels=levels)
    contract.check_rows_are_counted(Png(), picture, levels=levels)


@given(st.data(), st.sampled_from(COUNTS), st.floats(0, 1))
def test_abort(data, levels, at):
    contract.check_abort(Png(), data.draw(contract.pictures(levels=levels)), at, levels=levels)


@pytest.mark.parametrize("levels", [2, 3, 256])
def test_abort_between_pieces(levels):
    """A picture of several pieces, broken off at any byte of the first two."""
    picture = np.random.default_rng(0).integers(0, levels, (600, 900)).astype(np.uint8)
    made = contract.pieces(Png(), picture, levels=levels)
    assert len(made) > 1
    size = sum(len(piece.data) for piece in made)
    for at in np.linspace(0, len(made[0].data) + 20, 9) / size:
        contract.check_abort(Png(), picture, float(at), levels=levels)


@settings(max_examples=20)
@given(st.data(), st.sampled_from(COUNTS), st.integers(0, 2**32 - 1))
def test_damaged(data, levels, seed):
    rng = np.random.default_rng(seed)
    stream = contract.stream(Png(), data.draw(contract.pictures(levels=levels)), levels=levels)
    for _ in range(100):
        contract.check_damaged(Png(), stream, rng)


@settings(max_examples=20)
@given(st.data(), st.sampled_from(COUNTS), st.integers(0, 2**32 - 1))
def test_damaged_rows_with_right_check_sums(data, levels, seed):
    """Damage that no check sum shows: filters, codes beyond the palette, too few or too many rows."""
    rng = np.random.default_rng(seed)
    picture = data.draw(contract.pictures(levels=levels))
    start, rest = files.encode(contract.frame_of(picture, levels)).split(b"IDAT")
    rows = zlib.decompress(rest)
    for _ in range(100):
        broken = start[:-4] + pixels(contract.damaged(rows, rng)) + END
        failed = None
        try:
            (got,) = Png.decode(broken, contract.FUZZ_LIMIT)
        except ProtocolError as error:
            failed = error
        if failed is not None:
            assert failed.offset == len(start) + 4
        else:
            assert got.indices.shape == picture.shape
            assert got.indices.max() < levels


@pytest.mark.parametrize("levels", [*COUNTS, "lstar:4", "0.02,0.3,0.3,0.9"])
def test_it_is_the_file_of_convert(levels):
    """The same chunks before the pixels, and the same pixels."""
    ladder = Levels.of(levels)
    picture = np.random.default_rng(0).integers(0, len(ladder), (50, 33)).astype(np.uint8)
    frame = Frame(picture, ladder, dpi=(203.2, 300.0))
    wanted = files.encode(frame)
    got = b"".join(piece.data for piece in Png().encode([page_of(Png(), frame)]))
    assert got.split(b"IDAT")[0][:-4] == wanted.split(b"IDAT")[0][:-4]
    for data in (wanted, got):
        (back,) = Png.decode(data)
        np.testing.assert_array_equal(back.indices, picture)
        np.testing.assert_array_equal(back.levels.srgb(), ladder.srgb())
        assert back.dpi == (203.2, 300.0)


def test_every_end():
    data = contract.stream(Png(), PICTURE)
    for end in range(len(data)):
        with pytest.raises(ProtocolError) as caught:
            Png.decode(data[:end])
        assert caught.value.offset <= end


FILTERED = np.random.default_rng(3).integers(0, 256, (5, 7)).astype(np.uint8)


def filtered(rows, kinds):
    """Rows with filters, after clause 9 of the standard."""
    raw = b""
    above = [0] * rows.shape[1]
    for row, kind in zip(rows.tolist(), kinds, strict=True):
        left = [0, *row[:-1]]
        corner = [0, *above[:-1]]
        guess = []
        for a, b, c in zip(left, above, corner, strict=True):
            paeth = min((a, b, c), key=lambda v, p=a + b - c: abs(p - v))
            guess.append((0, a, b, (a + b) // 2, paeth)[kind])
        raw += bytes([kind, *((x - g) % 256 for x, g in zip(row, guess, strict=True))])
        above = row
    return raw


@given(contract.pictures(levels=256, width=20), st.data())
def test_filters(rows, data):
    kinds = data.draw(st.lists(st.integers(0, 4), min_size=len(rows), max_size=len(rows)))
    height, width = rows.shape
    (frame,) = Png.decode(file(header(width, height), pixels(filtered(rows, kinds)), END))
    np.testing.assert_array_equal(frame.indices, rows)


def test_a_palette_in_another_order_is_sorted():
    palette = np.repeat(np.array([255, 0, 90], np.uint8), 3).tobytes()
    data = file(header(3, 1, 2, 3), chunk(b"PLTE", palette), pixels(b"\0\x18"), END)
    (frame,) = Png.decode(data)
    assert frame.indices.tolist() == [[2, 0, 1]]
    assert frame.levels.srgb().tolist() == [0, 90, 255]


HEAD = header(8, 2, 1)
BODY = pixels(b"\0\xaa\0\x55")
GRAYS = chunk(b"PLTE", b"\0\0\0\xff\xff\xff")


def test_what_is_allowed():
    extra = chunk(b"gAMA", (45_455).to_bytes(4, "big")) + chunk(b"tEXt", b"a\0b")
    extra += chunk(b"pHYs", b"\0\0\0\1\0\0\0\1\0")
    raw = zlib.compress(b"\0\xaa\0\x55")
    parts = [chunk(b"IDAT", raw[:3]), chunk(b"IDAT"), chunk(b"IDAT", raw[3:])]
    (frame,) = Png.decode(file(HEAD, extra, *parts, chunk(b"tIME", bytes(7)), END))
    assert frame.indices.tolist() == [[1, 0] * 4, [0, 1] * 4]
    assert frame.dpi is None


@pytest.mark.parametrize(
    ("data", "offset"),
    [
        (file(BODY, END), 12),
        (file(header(8, 2, 16), BODY, END), 24),
        (file(header(8, 2, 8, 2), BODY, END), 25),
        (file(header(8, 2, 1, 0, 1, 0, 0), BODY, END), 26),
        (file(header(8, 2, 1, 0, 0, 0, 1), BODY, END), 28),
        (file(header(0, 2, 1), BODY, END), 16),
        (file(header(8, 1 << 31, 1), BODY, END), 20),
        (file(header(1 << 15, 1 << 15, 1), BODY, END), 16),
        (file(chunk(b"IHDR", bytes(12)), BODY, END), 8),
        (file(HEAD, HEAD, BODY, END), 37),
        (file(HEAD, END), 45),
        (file(HEAD, BODY, BODY, END), 41),
        (file(HEAD, BODY, chunk(b"tIME"), BODY, END), 33 + len(BODY) + 12 + 4),
        (file(HEAD, BODY, GRAYS, END), 33 + len(BODY) + 4),
        (file(HEAD, GRAYS, BODY, END), 37),
        (file(header(8, 2, 1, 3), BODY, END), 37),
        (file(header(8, 2, 1, 3), chunk(b"PLTE", b"\0\0\0\1\2\2"), BODY, END), 44),
        (file(header(8, 2, 1, 3), chunk(b"PLTE", b"\0\0\0"), BODY, END), 41),
        (file(header(8, 2, 1, 3), chunk(b"PLTE", bytes(9)), BODY, END), 41),
        (file(HEAD, chunk(b"tRNS", b"\0\0"), BODY, END), 37),
        (file(HEAD, chunk(b"ABCD"), BODY, END), 37),
        (file(HEAD, chunk(b"ab1d"), BODY, END), 37),
        (file(HEAD, chunk(b"gAMA", b"\0\1\0\0"), BODY, END), 41),
        (file(HEAD, BODY[:-1] + b"!", END), 33 + len(BODY) - 4),
        (file(HEAD, BODY, END) + b"\0", 33 + len(BODY) + 12),
        (file(HEAD, BODY, chunk(b"IEND", b"a")), 33 + len(BODY) + 8),
        (file(HEAD, pixels(b"\0\xaa\0"), END), 41),
        (file(HEAD, pixels(b"\0\xaa\0\x55\0"), END), 41),
        (file(HEAD, pixels(bytes(1 << 24)), END), 41),
        (file(HEAD, pixels(b"\5\xaa\0\x55"), END), 41),
        (file(HEAD, chunk(b"IDAT", zlib.compress(b"\0\xaa\0\x55") + b"a"), END), 41),
        (file(HEAD, chunk(b"IDAT", b"not zlib"), END), 41),
    ],
)
def test_the_offset_of_what_is_wrong(data, offset):
    with pytest.raises(ProtocolError) as caught:
        Png.decode(data)
    assert caught.value.offset == offset


def test_pixels_beyond_the_palette():
    data = file(header(8, 1, 2, 3), chunk(b"PLTE", b"\0\0\0\1\1\1\2\2\2"), pixels(b"\0\0\3"), END)
    with pytest.raises(ProtocolError, match="beyond the palette"):
        Png.decode(data)


def test_pages_that_cannot_be_expressed():
    with pytest.raises(UsageError, match="one page"):
        contract.stream(Png(), PICTURE, PICTURE)
    with pytest.raises(UsageError, match="copies"):
        contract.stream(Png(), PICTURE, copies=2)
    with pytest.raises(UsageError, match="level"):
        Png(level=10)


def test_pieces_are_small_and_read_as_they_are_asked_for():
    read = []

    def rows():
        for number in range(50):
            read.append(number)
            yield np.random.default_rng(number).integers(0, 256, (10, 2000)).astype(np.uint8)

    page = contract.page(Png(), np.zeros((500, 2000), np.uint8), levels=256)
    made = Png().encode([type(page)(2000, 500, rows(), page.levels)])
    assert len(next(made).data) < 40_000
    assert len(read) == 2
    assert max(len(piece.data) for piece in made) < 40_000
