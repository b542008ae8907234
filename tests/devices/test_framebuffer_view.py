"""What differs between two pictures on a panel, and what its pixels look like from near and afar."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from devices.differences import boxes
from devices.framebuffer import Box, FrameBuffer
from devices.profile import DeviceProfile, load
from halftone.errors import InputError, UsageError
from halftone.tone.dotgain import DotModel


@given(
    spots=st.lists(st.tuples(st.integers(0, 59), st.integers(0, 76)), max_size=40),
    columns=st.sampled_from([1, 2, 4, 8]),
    most=st.integers(1, 20),
)
def test_boxes_hold_every_difference_and_start_at_bytes(
    spots: list[tuple[int, int]], columns: int, most: int
) -> None:
    differ = np.zeros((60, 77), bool)
    for y, x in spots:
        differ[y, x] = True
    found = boxes(differ, columns, most)
    assert len(found) <= most
    count = np.zeros(differ.shape, int)
    for box in found:
        assert box.left % columns == 0
        assert (box.left + box.width) % columns == 0 or box.left + box.width == 77
        count[box.top : box.top + box.height, box.left : box.left + box.width] += 1
        inside = differ[box.top : box.top + box.height, box.left : box.left + box.width]
        assert inside[0].any()
        assert inside[-1].any()
    assert count.max(initial=0) <= 1, "no overlap"
    assert not differ[count == 0].any()


def test_differences_of_a_panel() -> None:
    panel = FrameBuffer(load("epaper-4gray"))
    assert panel.difference(panel.memory) == []
    new = panel.memory.copy()
    new[100:120, 101:130] = 0
    new[200, 399] = 1
    found = panel.difference(new)
    assert found == [Box(100, 100, 20, 32), Box(200, 396, 1, 4)]
    assert panel.difference(new, most=1) == [Box(100, 100, 101, 300)]
    panel.write(new)
    assert panel.difference(new) == []
    with pytest.raises(InputError, match=r"shape \(2, 2\)"):
        panel.difference(new[:2, :2])


def test_differences_of_colours() -> None:
    panel = FrameBuffer((20, 30), glass={"format": "rgb565"})
    new = panel.memory.copy()
    new[3, 7, 2] = 0
    assert panel.difference(new) == [Box(3, 7, 1, 1)]


# --- shapes and distance


@given(scale=st.integers(1, 12), fill=st.floats(0.05, 0.78))
def test_round_leds_keep_the_light_of_their_cells(scale: int, fill: float) -> None:
    panel = FrameBuffer((3, 4), 16, glass={"pixel": "led", "fill": fill})
    panel.write(np.arange(12).reshape(3, 4))
    view = panel.view(scale)
    assert view.shape == (3 * scale, 4 * scale)
    cells = view.reshape(3, scale, 4, scale).astype(np.float64).mean(axis=(1, 3))
    assert cells == pytest.approx(panel.snapshot(), rel=1e-5)
    if scale > 2:
        assert view[-scale, -scale] < panel.snapshot()[-1, -1], "corners are darker than the middle"


def test_the_disc_of_a_led() -> None:
    """Lit share of a cell at a fine scale."""
    panel = FrameBuffer((1, 1), 2, glass={"pixel": "led", "fill": 0.3})
    view = panel.view(32)
    assert (view > 0).mean() == pytest.approx(0.3, abs=0.06)
    assert view.max() == pytest.approx(1 / 0.3, rel=0.01)
    assert view[16, 16] > 0
    assert view[0, 0] == 0


def test_boxes_are_repeated() -> None:
    panel = FrameBuffer((2, 3), 16)
    panel.write(np.arange(6).reshape(2, 3))
    assert panel.view(3).tolist() == np.kron(panel.snapshot(), np.ones((3, 3), np.float32)).tolist()
    colour = FrameBuffer((2, 2), glass={"format": "rgb888"})
    colour.write(np.arange(12).reshape(2, 2, 3) * 20)
    assert colour.view(2)[::2, ::2].tolist() == colour.snapshot().tolist()


@pytest.mark.parametrize("scale", [1, 4])
def test_printed_dots_overlap_as_the_table_says(scale: int) -> None:
    dot = DotModel(1.5, 1.25)
    panel = FrameBuffer((12, 16), "0.1,0.9", dot=dot, glass={"pixel": "dot"})
    levels = np.random.default_rng(2).integers(0, 2, (12, 16)).astype(np.uint8)
    panel.write(levels)
    expected = 0.9 - 0.8 * dot.covered(1 - levels)
    assert panel.snapshot() == pytest.approx(expected, abs=1e-6)
    cells = panel.view(scale).reshape(12, scale, 16, scale).mean(axis=(1, 3))
    assert cells == pytest.approx(expected, abs=1e-4)


def test_a_printer_with_a_measured_dot_shows_dots() -> None:
    profile = DeviceProfile("p", "t", "made up", 2, 8, 8, codes=(1, 0), dot_x=1.5, dot_y=1.5)
    panel = FrameBuffer(profile)
    panel.write(np.eye(8, dtype=np.uint8))
    assert panel.snapshot() == pytest.approx(
        1 - profile.dot.covered(1 - np.eye(8, dtype=np.uint8)), abs=1e-6
    )


def test_a_calibrated_printer_shows_what_was_measured() -> None:
    measured = ((0.0, 0.05), (0.5, 0.4), (1.0, 0.95))
    profile = DeviceProfile(
        "p", "t", "made up", 2, 40, 40, codes=(1, 0), dot_x=1.5, dot_y=1.5, measured=measured
    )
    panel = FrameBuffer(profile)
    assert panel.snapshot() == pytest.approx(np.full((40, 40), 0.95), abs=1e-5)
    panel.write(np.zeros((40, 40), int))
    assert panel.snapshot()[20, 20] == pytest.approx(0.05, abs=1e-5)


def test_a_view_at_a_distance_is_a_low_pass_in_linear_light() -> None:
    panel = FrameBuffer((64, 64), 2, dpi=(100, 100))
    panel.write(np.indices((64, 64)).sum(axis=0) % 2)
    near, far = panel.view(2, distance=5), panel.view(2, distance=100)
    assert panel.view(2).std() > near.std() > far.std()
    assert far == pytest.approx(np.full((128, 128), 0.5), abs=0.01), "half the light, not half the code"
    panel.write(np.ones((64, 64), int))
    assert panel.view(2, distance=20) == pytest.approx(np.ones((128, 128)), abs=1e-6)
    colour = FrameBuffer((16, 16), glass={"format": "rgb565"})
    seen = colour.view(1, distance=10, dpi=100)
    assert seen.shape == (16, 16, 3)
    assert seen == pytest.approx(np.ones((16, 16, 3)), abs=1e-6)
    with pytest.raises(UsageError, match="give dpi="):
        colour.view(1, distance=10)


# --- writing
