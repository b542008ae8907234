"""EPL2 as a language."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from devices.errors import ProtocolError
from devices.languages.epl2 import Epl2
from halftone.errors import UsageError
from tests.devices.languages import contract

dialects = st.builds(Epl2, st.integers(0, 6), st.sampled_from(["", "continuous"]))


@given(dialects, contract.pictures(), st.lists(st.integers(0, 40)))
def test_round_trip(epl2, picture, split):
    contract.check_round_trip(epl2, picture, split)
    contract.check_rows_are_counted(epl2, picture)


@settings(max_examples=200)
@given(dialects, contract.pictures(), st.floats(0, 1))
def test_abort(epl2, picture, at):
    contract.check_abort(epl2, picture, at)


@settings(max_examples=20)
@given(dialects, contract.pictures(), st.integers(0, 2**32 - 1))
def test_damaged(epl2, picture, seed):
    rng = np.random.default_rng(seed)
    data = contract.stream(epl2, picture)
    for _ in range(100):
        contract.check_damaged(epl2, data, rng)


def test_the_bytes():
    picture = np.ones((2, 10), np.uint8)
    picture[1] = 0
    data = contract.stream(Epl2(4, "continuous"), picture, copies=3, density=9, cut=True)
    assert data == (b"\nN\nZT\nR0,0\nS4\nD9\nq10\nQ2,0\nGW0,0,2,2,\xff\xff\x00\x3f\nP3\nC\n")
    (frame,) = Epl2.decode(data)
    assert (frame.indices == picture).all()
    assert frame.report.items() >= {"copies": 3, "density": 9, "speed": 4}.items()


def test_single_rows_as_cups_and_lprint_send_them():
    """They skip blank rows; the line ends before the data."""
    (frame,) = Epl2.decode(b"\nN\nOD\nS4\nD7\nq16\nGW0,0,2,1\n\x00\xff\nGW0,2,2,1\n\n\r\nP1\nC\n")
    assert frame.shape == (3, 16)
    assert (frame.indices == 0).sum(axis=1).tolist() == [8, 0, 11]


@pytest.mark.parametrize(
    ("shape", "more", "named"),
    [((1, 8), {"density": 16}, "density.*0 … 15"), ((32_001, 1), {}, "height")],
)
def test_pages_that_do_not_fit(shape, more, named):
    with pytest.raises(UsageError, match=named):
        contract.stream(Epl2(), np.ones(shape, np.uint8), **more)


@pytest.mark.parametrize("options", [{"media": "gap"}, {"speed": 7}])
def test_wrong_options(options):
    with pytest.raises(UsageError, match="epl2"):
        Epl2(**options)


START = b"\nN\nq8\nQ2,24\n"


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (b"|", "command expected"),
        (b"|N", "ends with its line"),
        (b"|A50,0,0,1,1,1\n", "unknown command"),
        (b"|D16\n", "unknown command"),
        (START + b"|P1\n", "without a bitmap"),
        (START + b"GW|0,0,1;", "four numbers"),
        (START + b"GW0,0,|0,1,", "without dots"),
        (START + b"GW0,0,1,2,x|", "2 bytes expected, 1 left"),
        (START + b"|GW0,1,1,2,xx\nP1\n", "ink outside"),
        (START + b"|GW8,0,1,2,xx\nP1\n", "ink outside"),
        (START + b"GW0,0,1,1,x\n|P0\n", "0 copies"),
    ],
)
def test_the_offset_of_what_is_wrong(data, what):
    """The bar stands where the fault is, and is taken out."""
    with pytest.raises(ProtocolError, match=what) as caught:
        Epl2.decode(data.replace(b"|", b""))
    assert caught.value.offset == data.index(b"|")


def test_declared_sizes_are_checked_first():
    with pytest.raises(ProtocolError, match="pixels"):
        Epl2.decode(START + b"GW0,0,60000,60000,", 1 << 16)
    with pytest.raises(ProtocolError, match="pixels"):
        Epl2.decode(b"\nN\nq60000\nQ60000,0\nGW0,0,1,1,x\nP1\n", 1 << 16)
