"""PBM as a language."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from devices.errors import ProtocolError
from devices.languages.pbm import Pbm
from tests.devices.languages import contract


@given(contract.pictures(), st.lists(st.integers(0, 40)))
def test_round_trip(picture, split):
    contract.check_round_trip(Pbm(), picture, split)
    contract.check_rows_are_counted(Pbm(), picture)


@given(contract.pictures(), st.floats(0, 1))
def test_abort(picture, at):
    contract.check_abort(Pbm(), picture, at)


@settings(max_examples=20)
@given(contract.pictures(), st.integers(0, 2**32 - 1))
def test_damaged(picture, seed):
    rng = np.random.default_rng(seed)
    data = contract.stream(Pbm(), picture)
    for _ in range(100):
        contract.check_damaged(Pbm(), data, rng)


@pytest.mark.parametrize(
    ("data", "offset"),
    [(b"", 0), (b"P5", 1), (b"P4x", 2), (b"P4 0 1\n", 4), (b"P4\n8 2\n\xff", 8), (b"P4 7 1\n\x01", 7)],
)
def test_the_offset_of_what_is_wrong(data, offset):
    with pytest.raises(ProtocolError) as caught:
        Pbm.decode(data)
    assert caught.value.offset == offset
