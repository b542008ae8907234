"""What holds for every language, as functions that the tests of each of them call."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from devices.errors import ProtocolError
from devices.languages.base import Language, Page, Piece
from halftone.frame import Frame
from halftone.packing import pack
from halftone.tone.levels import Levels


@st.composite
def pictures(draw, width=70, height=40, levels=2):
    """Level indices (M, N): noise, blank, full, runs, repeated rows."""
    shape = draw(st.integers(1, height)), draw(st.integers(1, width))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    kind = draw(st.sampled_from(["noise", "sparse", "flat", "runs", "repeated"]))
    if kind == "flat":
        return np.full(shape, rng.integers(levels), np.uint8)
    picture = rng.integers(0, levels, shape).astype(np.uint8)
    if kind == "sparse":
        picture[rng.random(shape) < 0.95] = levels - 1
    elif kind == "runs":
        picture = np.repeat(picture, rng.integers(1, 20), axis=1)[:, : shape[1]]
    elif kind == "repeated":
        picture = np.repeat(picture, rng.integers(1, 20), axis=0)[: shape[0]]
    return np.ascontiguousarray(picture)


def frame_of(picture, levels=2, dpi=(203.0, 203.0)) -> Frame:
    return Frame(picture, Levels.of(levels), dpi=dpi)


def page(language: Language, picture, split=(), levels=2, dpi=(203.0, 203.0), **more) -> Page:
    """A page whose rows come in the bands that *split* cuts."""
    ladder = Levels.of(levels)
    packed = pack(picture, language.packing(ladder))
    cuts = sorted({c for c in split if 0 < c < len(picture)})
    rows = np.split(packed, cuts)
    return Page(picture.shape[1], len(picture), iter(rows), ladder, dpi, **more)


def pieces(language: Language, *pictures, **more) -> list[Piece]:
    return list(language.encode(page(language, picture, **more) for picture in pictures))


def stream(language: Language, *pictures, **more) -> bytes:
    return b"".join(piece.data for piece in pieces(language, *pictures, **more))


def check_same(got, picture, levels=2, exact=True) -> None:
    """*got* is the picture; unless *exact*, with paper to its right, where a language does not state
    the width in dots."""
    assert not exact or got.shape == picture.shape
    np.testing.assert_array_equal(got[:, : picture.shape[1]], picture)
    assert (got[:, picture.shape[1] :] == levels - 1).all()


def check_round_trip(language: Language, picture, split=(), levels=2, exact=True, **more) -> bytes:
    """decode(encode(picture)) is the picture, however its rows are cut into bands, and is detected."""
    data = stream(language, picture, levels=levels, **more)
    assert stream(language, picture, split=split, levels=levels, **more) == data
    (frame,) = language.decode(data)
    check_same(frame.indices, picture, levels, exact)
    assert len(frame.levels) == levels
    assert language.sniff(data[:1024])
    return data


def check_rows_are_counted(language: Language, picture, **more) -> None:
    """Pieces hold all the rows, and never claim rows whose bytes are not there."""
    made = pieces(language, picture, **more)
    assert sum(piece.rows for piece in made) == len(picture)
    for piece in made:
        counts = [piece.accepted(sent) for sent in range(len(piece.data) + 1)]
        assert counts == sorted(counts)
        assert counts[0] == 0 or not piece.rows
        assert counts[-1] == piece.rows


def check_abort(language: Language, picture, at: float, **more) -> None:
    """Broken off after a share *at* of its bytes, a job is completed to one that decodes: the rows
    that were accepted are the picture's, what is laid below is paper or the picture's; and a second
    job after it decodes whole."""
    made = pieces(language, picture, **more)
    place = int(at * sum(len(piece.data) for piece in made))
    sent, rows = b"", 0
    for piece in made:
        part = min(len(piece.data), place - len(sent))
        sent, rows = sent + piece.data[:part], rows + piece.accepted(part)
        if part < len(piece.data) or len(sent) == place:
            if not sent:
                return  # nothing was sent: nothing to complete
            if part:
                sent += piece.abort(part)
                break
        last = piece
    else:
        sent += last.abort(len(last.data))
    frames = language.decode(sent)
    if rows:
        got = frames[0].indices
        assert len(got) >= rows
        np.testing.assert_array_equal(got[:rows, : picture.shape[1]], picture[:rows])
        below = got[rows:, : picture.shape[1]]
        same = min(len(below), len(picture) - rows)
        paper = below[:same] == len(frames[0].levels) - 1
        assert (paper | (below[:same] == picture[rows : rows + same])).all()
    again = language.decode(sent + stream(language, picture, **more)) if appends(language) else frames
    if appends(language):
        check_same(again[-1].indices, picture, exact=False)


def check_abort_between_pages(language: Language, pictures, at: float, **more) -> None:
    """As :func:`check_abort` for a job of several pages: it decodes, and the pages that were accepted
    whole are there."""
    made = pieces(language, *pictures, **more)
    place = int(at * sum(len(piece.data) for piece in made))
    sent, rows = b"", 0
    for piece in made:
        part = min(len(piece.data), place - len(sent))
        if not part:
            break
        sent, rows, last = sent + piece.data[:part], rows + piece.accepted(part), (piece, part)
    if not sent:
        return
    frames = language.decode(sent + last[0].abort(last[1]))
    for picture, frame in zip(pictures, frames, strict=False):
        if rows < len(picture):
            break
        check_same(frame.indices, picture, exact=False)
        rows -= len(picture)


def appends(language: Language) -> bool:
    """Whether a second job may follow a first one in the same stream (printers; not files)."""
    return language.name not in ("png", "pwg", "cups-raster", "urf")


def damaged(data: bytes, rng) -> bytes:
    """*data* with bytes changed, cut, doubled, swapped or inserted."""
    out = bytearray(data)
    for _ in range(rng.integers(1, 4)):
        place, end = sorted(rng.integers(0, len(out) + 1, 2))
        kind = rng.integers(6)
        if kind == 0 and len(out):
            out[min(place, len(out) - 1)] = rng.integers(256)
        elif kind == 1:
            del out[place:]
        elif kind == 2:
            del out[place : min(end, place + 8)]
        elif kind == 3:
            out[place:place] = rng.integers(0, 256, rng.integers(1, 9)).astype(np.uint8).tobytes()
        elif kind == 4:
            out[place:place] = out[place : min(end, place + 64)]
        elif len(out):
            out[min(place, len(out) - 1)] ^= 1 << rng.integers(8)
    return bytes(out)


FUZZ_LIMIT = 1 << 20


def check_damaged(language: Language, data: bytes, rng) -> bool:
    """A damaged stream is an error with an offset within it, or pages within the limit."""
    broken = damaged(data, rng)
    failed = None
    try:
        frames = language.decode(broken, FUZZ_LIMIT)
    except ProtocolError as error:
        failed = error
    if failed is not None:
        assert 0 <= failed.offset <= len(broken)
        assert failed.language == language.name
        return False
    assert sum(frame.indices.size for frame in frames) <= FUZZ_LIMIT
    for frame in frames:
        assert frame.indices.max(initial=0) < len(frame.levels)
    return True
