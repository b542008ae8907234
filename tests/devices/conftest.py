"""What several files of this folder are given."""

from __future__ import annotations

import pytest

from tests.devices.simulated_screen import Driver


@pytest.fixture
def driver(tmp_path):
    made = []

    def make(*given, **changes):
        made.append(Driver(tmp_path / f"fb{len(made)}", *given, **changes))
        return made[-1]

    yield make
    assert all(each.nothing_is_open() for each in made)
