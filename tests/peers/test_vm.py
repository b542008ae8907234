"""Against Linux itself: a USB printer gadget, printed to by libusb and usblp, in a virtual machine."""

from __future__ import annotations

import json

import pytest

from tests.peers import vm
from tests.peers.vm_scenes import SCENES

pytestmark = [pytest.mark.peer, pytest.mark.vm]


@pytest.fixture(scope="module")
def outcomes() -> dict[str, str]:
    """What went wrong in each scene, all of them in one machine."""
    written = vm.run("from tests.peers.vm_scenes import main\nmain()\n")
    lines = [json.loads(line) for line in written.splitlines() if line.startswith('{"name"')]
    return {line["name"]: line["wrong"] for line in lines}


@pytest.mark.parametrize("scene", SCENES)
def test_a_printer_that(outcomes: dict[str, str], scene: str) -> None:
    assert not outcomes[scene], outcomes[scene]
