"""What holds for every language in the table, so that a new one is held to it by its line there."""

from __future__ import annotations

import re
import tracemalloc
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from devices.decoding import decode
from devices.errors import ProtocolError
from devices.languages import detect, language, language_type, languages
from devices.languages.base import Page
from halftone.errors import InputFileError, UsageError
from halftone.tone.levels import Levels
from tests.devices.languages import contract
from tests.devices.languages.test_escpos import calm

NAMES = languages()
DPI = (300.0, 300.0)
WIDER = {"escpos", "brother-ql", "dymo", "tspl", "epl2"}
"""Do not state the width in dots: what comes back has paper to its right."""
LONGEST = {"brother-ql": 11_000, "dymo": 3000}
"""Rows of the longest label, for those that are short."""


def shapes(name: str) -> list[tuple[int, int]]:
    """(rows, columns) at the rims of what a language can hold."""
    return [(1, 1), (1, 7), (9, 8), (2, 9), (65_000, 1), (1, language_type(name).widest)]


def printable(name: str, picture):
    """*picture*, for ESC/POS without the bytes that it does not send as they are."""
    return calm(picture, "raster") if name == "escpos" else picture


@pytest.mark.parametrize("name", NAMES)
@given(picture=contract.pictures(), split=st.lists(st.integers(0, 40)), at=st.floats(0, 1))
def test_the_contract(name, picture, split, at):
    made, picture = language(name), printable(name, picture)
    data = contract.check_round_trip(made, picture, split, dpi=DPI, exact=name not in WIDER)
    assert detect(data) == name
    contract.check_rows_are_counted(made, picture, dpi=DPI)
    contract.check_abort(made, picture, at, dpi=DPI)


@pytest.mark.parametrize("name", [name for name in NAMES if name != "png"])
@given(job=st.lists(contract.pictures(), min_size=2, max_size=3), at=st.floats(0, 1))
def test_several_pages_broken_off(name, job, at):
    job = [printable(name, picture) for picture in job]
    contract.check_abort_between_pages(language(name), job, at, dpi=DPI)


@pytest.mark.parametrize("name", NAMES)
def test_rims(name):
    """Every shape is either printed whole or refused with a reason, before any piece."""
    rng = np.random.default_rng(5)
    refused = []
    for shape in shapes(name):
        picture = printable(name, (rng.random(shape) < 0.5).astype(np.uint8))
        try:
            data = contract.stream(language(name), picture, dpi=DPI)
        except UsageError as error:
            refused.append(str(error))
            continue
        (frame,) = language(name).decode(data)
        contract.check_same(frame.indices, picture, exact=name not in WIDER)
    assert len(refused) <= 2
    assert all(re.search("rows|dots|allowed|high|wide", text) for text in refused), refused


@pytest.mark.parametrize("name", NAMES)
def test_no_other_language_takes_it_for_its_own(name):
    data = contract.stream(language(name), np.eye(24, dtype=np.uint8), dpi=DPI)
    for other in NAMES:
        if other == name:
            continue
        assert not language_type(other).sniff(data[:1024])
        with pytest.raises(ProtocolError):
            language_type(other).decode(data)


@pytest.mark.parametrize("name", NAMES)
def test_every_beginning_of_a_stream_is_refused_or_right(name):
    picture = np.eye(20, 30, dtype=np.uint8)
    data = contract.stream(language(name), picture, dpi=DPI)
    for end in range(len(data)):
        frames, offset = [], 0
        try:
            frames = language_type(name).decode(data[:end])
        except ProtocolError as error:
            offset = error.offset
        assert offset <= end
        assert all((f.indices[:, :30] == picture[: len(f.indices)]).all() for f in frames)


@pytest.mark.parametrize("name", NAMES)
def test_a_limit_is_kept_before_memory_is_taken(name):
    picture = np.ones((LONGEST.get(name, 20_000), 600), np.uint8)
    data = contract.stream(language(name), picture, dpi=DPI)
    tracemalloc.start()
    try:
        with pytest.raises(ProtocolError, match="pixels"):
            language_type(name).decode(data, limit=100_000)
        assert tracemalloc.get_traced_memory()[1] < 3_000_000
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("name", NAMES)
def test_memory_is_that_of_a_band(name):
    """Rows that are made as they are asked for are never held."""
    made, rows, made_rows = language(name), LONGEST.get(name, 30_000), 0
    bits = made.packing(Levels.of(2)).bits
    rng = np.random.default_rng(3)

    def bands():
        nonlocal made_rows
        while made_rows < rows:
            count = min(64, rows - made_rows)
            band = rng.integers(0, 2, (count, 576), np.uint8)
            made_rows += count
            yield np.packbits(band, axis=1) if bits == 1 else band * np.uint8(255)

    page = Page(576, rows, bands(), Levels.of(2), DPI)
    next(made.encode([page]))
    assert made_rows < rows, "the first piece waits for all rows"
    made_rows, total = 0, 0
    tracemalloc.start()
    try:
        for piece in made.encode([Page(576, rows, bands(), Levels.of(2), DPI)]):
            assert len(piece.data) <= 1 << 18
            total += len(piece.data)
        assert tracemalloc.get_traced_memory()[1] < 2_500_000
    finally:
        tracemalloc.stop()
    assert total > rows * 60


@pytest.mark.parametrize("name", NAMES)
def test_wrong_rows_are_refused(name):
    made = language(name)
    for width, height, rows in (
        (9, 3, np.zeros((3, 1), np.uint8)),
        (800, 3, np.zeros((2, 100), np.uint8)),
    ):
        with pytest.raises(UsageError):
            list(made.encode([Page(width, height, iter([rows]), Levels.of(2), DPI)]))


@pytest.mark.parametrize("name", NAMES)
def test_options_are_checked(name):
    with pytest.raises(UsageError, match="option"):
        language(name, no_such_option=1)
    for field in fields(language_type(name)):
        if isinstance(field.default, bool):
            assert getattr(language(name, **{field.name: "yes"}), field.name) is True
            with pytest.raises(UsageError, match="yes, no"):
                language(name, **{field.name: "perhaps"})
        elif isinstance(field.default, int):
            with pytest.raises(UsageError, match="integer"):
                language(name, **{field.name: "many"})


@pytest.mark.parametrize("name", NAMES)
def test_copies_are_native_or_refused(name):
    made, picture = language(name), np.eye(16, dtype=np.uint8)
    if made.native_copies:
        data = contract.stream(made, picture, dpi=DPI, copies=3)
        assert [frame.report["copies"] for frame in made.decode(data)] == [3]
    else:
        with pytest.raises(UsageError, match="copies"):
            contract.stream(made, picture, dpi=DPI, copies=3)


def test_unknown_names_and_streams():
    with pytest.raises(UsageError, match="Did you mean escpos"):
        language("escpoz")
    with pytest.raises(InputFileError, match="none of the languages"):
        detect(b"hello")
    with pytest.raises(InputFileError, match="empty"):
        decode(b"")
