"""Against Linux itself: a frame buffer, vfb, in a virtual machine."""

from __future__ import annotations

import json

import pytest

from tests.peers import vm
from tests.peers.vm_fb_scenes import SCENES

pytestmark = [pytest.mark.peer, pytest.mark.vm]


def test_a_frame_buffer_in_a_virtual_machine() -> None:
    """All scenes in one machine, and so in one test: starting it takes as long as they do."""
    written = vm.run("from tests.peers.vm_fb_scenes import main\nmain()\n")
    outcomes = [json.loads(line) for line in written.splitlines() if line.startswith('{"name"')]
    assert [each["name"] for each in outcomes] == list(SCENES)
    wrong = [
        f"a frame buffer that {each['name']}:\n{each['wrong']}" for each in outcomes if each["wrong"]
    ]
    assert not wrong, "\n".join(wrong)
