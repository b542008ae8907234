"""The simulated frame buffer: levels, look-up tables, ghosts, boxes, shapes, and every mistake."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import halftone
from devices.framebuffer import FrameBuffer
from devices.glass import Glass
from devices.palette import Palette
from devices.pixels import Fields, Indexed
from devices.profile import load, names
from halftone.errors import InputError, UsageError
from halftone.packing import Packing
from halftone.tone.dotgain import DotModel
from halftone.tone.ladder import log_ladder, ratio
from halftone.tone.lut import combined_table, gamma_table, hardware_table, to_dac, wrong_codes
from halftone.tone.transfer import voltage
from tests.oracle.framebuffer import ghosted, on_time, srgb_to_light, through_table

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def _ramp(n: int) -> np.ndarray:
    return np.arange(n, dtype=np.uint8)[None]


def _shown(levels: object, glass: dict[str, object], lut: object = None, n: int = 16) -> np.ndarray:
    """Light of all codes of a panel of 4 bits."""
    panel = FrameBuffer((1, n), levels, packing=Packing(4), glass=glass)
    panel.lut = lut
    panel.write(_ramp(n))
    return panel.snapshot()[0]


# --- profiles


@pytest.mark.parametrize("name", names())
def test_every_profile_has_a_frame_buffer(name: str) -> None:
    profile = load(name)
    panel = FrameBuffer(profile, shape=(20, 24))
    white = panel.snapshot()
    assert white.dtype == np.float32
    assert np.isfinite(white).all()
    shown = white @ LUMINANCE if white.ndim == 3 else white
    assert shown == pytest.approx(panel.levels.lightest, abs=1e-5), "white at first"
    levels = np.random.default_rng(1).integers(0, len(profile.levels), (20, 24))
    panel.write(levels)
    packed = panel.read_bytes()
    other = FrameBuffer(profile, shape=(20, 24))
    other.write_bytes(packed.tobytes())
    assert other.memory.tolist() == panel.memory.tolist()
    panel.refresh()
    shown = panel.snapshot() @ LUMINANCE if white.ndim == 3 else panel.snapshot()
    if profile.dot is None:
        tolerance = 1e-4 if "time_bits" not in profile.glass else 1 / 4094
        assert np.abs(shown - profile.levels.luminance[levels]).max() <= tolerance


@pytest.mark.parametrize(
    ("name", "size"),
    [("epaper-2gray", 2), ("epaper-4gray", 4), ("epaper-16gray", 16), ("oled-16gray", 16),
     ("lcd-rgb565", 32), ("led-matrix", 256), ("framebuffer-log-16", 16)],
)  # fmt: skip
def test_panels_of_glass(name: str, size: int) -> None:
    profile = load(name)
    assert len(profile.levels) == size
    assert Glass.of(profile.glass).needs_refresh == name.startswith("epaper")


def test_convert_and_show_a_colour_panel_in_black_and_white() -> None:
    """What halftone sends to a panel of colours are the codes of its black and its white."""
    profile = load("spectra6")
    frame = halftone.convert(
        np.linspace(0, 1, 800, dtype=np.float32)[None].repeat(480, 0), profile=profile
    )
    panel = FrameBuffer(profile)
    panel.write_bytes(frame.packed())
    panel.refresh()
    assert set(np.unique(frame.packed())) <= {0x00, 0x01, 0x10, 0x11}
    expected = Palette.load("spectra6").relative[np.asarray(frame)]
    assert panel.snapshot().tolist() == expected.tolist()


def test_palette_colours_and_codes() -> None:
    panel = FrameBuffer(load("spectra6"), shape=(1, 6))
    panel.write(_ramp(6))
    assert panel.read_bytes().tolist() == [[0x01, 0x23, 0x56]]
    assert panel.snapshot()[0] == pytest.approx(panel.palette.relative[[1] * 6]), "not refreshed yet"
    panel.refresh()
    assert panel.snapshot()[0].tolist() == panel.palette.relative.tolist()
    white = [srgb_to_light(code) for code in (168, 180, 182)]
    assert panel.snapshot(absolute=True)[0, 1] == pytest.approx(white, rel=1e-5)
    with pytest.raises(UsageError, match="device code 4 belongs to no level"):
        panel.write_bytes(b"\x44\x11\x11")
    with pytest.raises(InputError, match="0 … 6; allowed: 0 … 5"):
        panel.write(_ramp(7)[:, [0, 1, 2, 3, 4, 6]])


# --- ladders and the three paths of look-up tables (Hearn & Baker)


def test_ladders_of_equal_ratios() -> None:
    assert ratio(1 / 8, 3) == pytest.approx(2)
    assert ratio(0.01, 255) == pytest.approx(1.0182, abs=5e-5)
    four = FrameBuffer((1, 4), "log:0.125:4")
    four.write(_ramp(4))
    assert four.snapshot()[0].tolist() == [0.125, 0.25, 0.5, 1]
    many = FrameBuffer((1, 256), "log:0.01:256")
    many.write(_ramp(256))
    shown = many.snapshot()[0]
    assert np.round(shown[:6], 4).tolist() == pytest.approx(
        [0.01, 0.0102, 0.0104, 0.0106, 0.0107, 0.0109]
    )
    assert np.round(shown[-2:], 4).tolist() == pytest.approx([0.9821, 1])
    assert shown[1:] / shown[:-1] == pytest.approx(ratio(0.01, 255), rel=1e-6)


@pytest.mark.parametrize("gamma", [1.8, 2.2, 3.0])
def test_a_table_of_voltages_makes_pixel_values_linear(gamma: float) -> None:
    glass = {"response": f"gamma:{gamma}"}
    linear = _ramp(16)[0] / 15
    assert _shown(16, glass, gamma_table(16, gamma)) == pytest.approx(linear, abs=gamma / 65535)
    assert _shown(16, glass) == pytest.approx(linear**gamma, abs=1e-6), "without it, by the response"
    assert _shown(16, glass, linear) == pytest.approx(linear**gamma, abs=1e-4), "codes as voltages"


@pytest.mark.parametrize("a", [0.5, 1.0, 2.0])
def test_the_light_at_full_voltage(a: float) -> None:
    glass = {"response": "gamma:2.2", "a": a}
    light = np.linspace(0, min(a, 1), 16)
    assert _shown(16, glass, voltage(light, 2.2, a)) == pytest.approx(light, abs=1e-4)


@pytest.mark.parametrize("by", ["ratio", "arithmetic"])
@pytest.mark.parametrize("steps", [3, 7, 15])
def test_the_combined_table_equals_its_two_steps(steps: int, by: str) -> None:
    ladder = log_ladder(0.05, steps)
    glass = {"response": "gamma:2.2"}
    combined = _shown(16, glass, combined_table(16, ladder, 2.2, by=by))
    step = halftone.tone.ladder.nearest(np.arange(16) / 15, ladder, by)
    assert combined == pytest.approx(_shown(16, glass, voltage(ladder[step], 2.2)), abs=1e-7)
    assert combined == pytest.approx(ladder[step], abs=1e-4)


def test_a_display_that_corrects_for_gamma_itself_is_not_corrected_twice() -> None:
    ladder = log_ladder(0.02, 15)
    own = {"response": "linear"}
    right = _shown(16, own, hardware_table(ladder))
    assert right == pytest.approx(ladder, abs=1e-5)
    twice = _shown(16, own, voltage(ladder, 2.2))
    never = _shown(16, {"response": "gamma:2.2"}, hardware_table(ladder))
    assert twice[:-1] == pytest.approx(ladder[:-1] ** (1 / 2.2), abs=1e-4), "too light"
    assert never[:-1] == pytest.approx(ladder[:-1] ** 2.2, abs=1e-4), "too dark"


@pytest.mark.parametrize("bits", [4, 8])
def test_wrong_codes_of_small_tables(bits: int) -> None:
    """The converter shows as many wrong codes as the table sends."""
    size = 1 << bits
    pixel = np.arange(4096) / 4095
    entry = np.rint(pixel * (size - 1)).astype(np.uint8)
    panel = FrameBuffer(
        (1, 4096), size, packing=Packing(bits), glass={"response": "gamma:2.2", "dac_bits": 8}
    )
    panel.lut = gamma_table(size, 2.2)
    panel.write(entry[None])
    exact = (to_dac(voltage(pixel, 2.2), 8) / 255) ** 2.2
    wrong = (np.abs(panel.snapshot()[0] - exact) > 1e-6).sum()
    assert wrong == wrong_codes(size, 2.2, 8, 12) > 0


@given(
    table=st.lists(st.floats(0, 1), min_size=16, max_size=16),
    gamma=st.floats(1, 3),
    a=st.floats(0.1, 2),
    dac_bits=st.integers(1, 16),
    black=st.floats(0, 0.2),
)
def test_look_up_tables_equal_the_twin(
    table: list[float], gamma: float, a: float, dac_bits: int, black: float
) -> None:
    glass = {"response": f"gamma:{gamma!r}", "a": a, "dac_bits": dac_bits, "black": black}
    expected = through_table(range(16), table, gamma, a, dac_bits, black)
    assert _shown(16, glass, table) == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_a_table_is_by_code_and_goes_away() -> None:
    panel = FrameBuffer((1, 2), 2, packing=Packing(1, codes=(1, 0)), glass={"response": "linear"})
    panel.write(_ramp(2))
    panel.lut = [0.25, 0.75]
    assert panel.snapshot()[0] == pytest.approx([0.75, 0.25], abs=1e-4)
    panel.lut = None
    assert panel.snapshot()[0].tolist() == [0, 1]


def test_tables_of_channels_are_independent() -> None:
    panel = FrameBuffer((1, 3), glass={"format": "rgb565", "response": "gamma:2.2"})
    panel.write(np.array([[[31, 0, 0], [0, 63, 0], [0, 0, 31]]]))
    before = panel.snapshot()
    red, green, blue = (gamma_table(1 << bits, 2.2) for bits in (5, 6, 5))
    panel.lut = (red * 0, green, blue)
    after = panel.snapshot()
    assert before[0].tolist() == np.eye(3).tolist()
    assert after[0, 0].tolist() == [0, 0, 0]
    assert after[0, 1:].tolist() == before[0, 1:].tolist()
    panel.write(np.array([[[0, 32, 16]]]))
    assert panel.snapshot()[0, 0] == pytest.approx([0, 32 / 63, 16 / 31], abs=1e-4)


@pytest.mark.parametrize(
    ("table", "word"),
    [
        (np.zeros(15), r"shape \(15,\); allowed: \(16,\)"),
        (np.zeros((16, 3)), "3 look-up tables; allowed: 1|shape"),
        ([0.5] * 15 + [1.01], "outside of 0 … 1"),
        ([0.5] * 15 + [-0.1], "outside of 0 … 1"),
        ([0.5] * 15 + [np.nan], "NaN"),
        (["a"] * 16, "shape"),
    ],
)
def test_wrong_tables(table: object, word: str) -> None:
    with pytest.raises(UsageError, match=word):
        _shown(16, {"response": "gamma:2.2"}, table)


def test_no_table_without_a_response() -> None:
    with pytest.raises(UsageError, match="no look-up table"):
        _shown("log:0.02:16", {}, np.zeros(16))
    colour = FrameBuffer((2, 2), glass={"format": "rgb565", "response": "srgb"})
    with pytest.raises(UsageError, match=r"\(31,\); allowed: \(32,\)"):
        colour.lut = (np.zeros(31), np.zeros(64), np.zeros(32))
    with pytest.raises(UsageError, match="2 look-up tables; allowed: 3"):
        colour.lut = (np.zeros(32), np.zeros(64))


# --- what the panel adds


def test_black_ambient_and_absolute_light() -> None:
    plain = _shown(16, {})
    assert _shown(16, {"black": 0.1}) == pytest.approx(0.1 + 0.9 * plain)
    assert _shown(16, {"ambient": 0.1}) == pytest.approx(plain + 0.1)
    panel = FrameBuffer((1, 16), 16, glass={"white": 0.7, "ambient": 0.1})
    panel.write(_ramp(16))
    assert panel.snapshot(absolute=True)[0] == pytest.approx(0.7 * (plain + 0.1))


def test_leds_are_lit_in_whole_steps_of_time() -> None:
    panel = FrameBuffer(load("led-matrix"), shape=(1, 256))
    panel.write(_ramp(256))
    times = [on_time(value) for value in range(256)]
    assert panel.snapshot()[0] * 2047 == pytest.approx(times, abs=1e-3)
    assert times[128] / 2047 == pytest.approx(0.18, abs=0.01), (
        "half the lightness is lit 18 % of the time"
    )


@given(
    targets=st.lists(st.integers(0, 3), min_size=1, max_size=6),
    g=st.floats(0, 0.9),
)
def test_ghosts_equal_the_twin_and_a_full_refresh_clears_them(targets: list[int], g: float) -> None:
    panel = FrameBuffer((2, 2), 4, glass={"needs_refresh": True, "ghosting": g})
    light = panel.levels.luminance.tolist()
    for level in targets:
        panel.write(np.full((2, 2), level))
        panel.refresh(full=False)
    expected = ghosted([light[level] for level in targets], light[-1], g)
    assert panel.snapshot() == pytest.approx(np.full((2, 2), expected), abs=1e-6)
    panel.refresh()
    assert (panel.snapshot() == light[targets[-1]]).all()


def test_a_partial_refresh_of_a_box() -> None:
    panel = FrameBuffer((8, 16), 2, glass={"needs_refresh": True, "ghosting": 0.25})
    panel.write(np.zeros((8, 16), int))
    panel.refresh(full=False, box=(2, 8, 3, 8))
    expected = np.ones((8, 16), np.float32)
    expected[2:5, 8:16] = 0.25
    assert panel.snapshot().tolist() == expected.tolist()
    with pytest.raises(UsageError, match="full refresh is of the whole panel"):
        panel.refresh(box=(0, 0, 1, 1))
    with pytest.raises(UsageError, match="reach beyond"):
        panel.refresh(full=False, box=(7, 0, 2, 1))


# --- differences


@settings(max_examples=30)
@given(y=st.integers(-2, 12), x=st.integers(-2, 12), rows=st.integers(1, 6), columns=st.integers(1, 6))
def test_writing_stays_inside(y: int, x: int, rows: int, columns: int) -> None:
    panel = FrameBuffer((10, 10), 4)
    part = np.zeros((rows, columns), int)
    if 0 <= y <= 10 - rows and 0 <= x <= 10 - columns:
        panel.write(part, (y, x))
        assert (panel.memory == 0).sum() == part.size
        assert (panel.memory[y : y + rows, x : x + columns] == 0).all()
    else:
        with pytest.raises(UsageError, match="reach beyond the panel's 10 × 10"):
            panel.write(part, (y, x))
        assert (panel.memory == 3).all()


def test_bytes_of_a_part() -> None:
    panel = FrameBuffer((4, 8), 4, packing=Packing(2))
    panel.write_bytes(bytes([0b00011011, 0b11100100]), (1, 4), width=4)
    assert panel.memory[1:3, 4:].tolist() == [[0, 1, 2, 3], [3, 2, 1, 0]]
    assert (panel.memory[0] == 3).all()
    with pytest.raises(InputError, match="2 for a row of 8"):
        panel.write_bytes(b"\0\0\0")
    with pytest.raises(InputError, match="0 values"):
        panel.write_bytes(b"")
    with pytest.raises(InputError, match="float64"):
        panel.write_bytes(np.zeros(4))
    with pytest.raises(UsageError, match="width=9"):
        panel.write_bytes(b"\0" * 6, width=9)


def test_grays_on_a_panel_of_colours() -> None:
    panel = FrameBuffer((1, 4), 4, glass={"format": "rgb565"})
    panel.write(_ramp(4))
    assert isinstance(panel.format, Fields)
    assert panel.memory[0].tolist() == [[0, 0, 0], [10, 21, 10], [21, 42, 21], [31, 63, 31]]


@pytest.mark.parametrize(
    ("pixels", "word"),
    [
        (np.zeros((2, 2)), "float64; allowed: level indices"),
        (np.full((2, 2), np.nan), "float64"),
        (np.full((2, 2), 4), "4 … 4; allowed: 0 … 3"),
        (np.full((2, 2), -1), "-1 … -1"),
        (np.zeros((2, 2, 3), int), r"shape \(2, 2, 3\)"),
        (np.zeros(4, int), r"shape \(4,\)"),
        ("black", "<U5"),
    ],
)
def test_wrong_pixels(pixels: object, word: str) -> None:
    with pytest.raises(InputError, match=word):
        FrameBuffer((4, 4), 4).write(pixels)


def test_wrong_panels() -> None:
    for levels, word in (([1, 0], "fall"), ([0, float("nan")], "NaN"), ([0.5, 0.5], "no picture")):
        with pytest.raises(UsageError, match=word):
            FrameBuffer((2, 2), levels)
    for shape in ((0, 5), (5,), 5, (2.0, 2), (1 << 20, 1 << 20)):
        with pytest.raises(UsageError, match="rows|shape|pixels"):
            FrameBuffer(shape, 2)  # type: ignore[arg-type]
    with pytest.raises(UsageError, match="leaves its size open"):
        FrameBuffer(load("receipt-80mm"))
    with pytest.raises(UsageError, match="has its own"):
        FrameBuffer(load("epaper-4gray"), 2)
    with pytest.raises(UsageError, match="needs two levels"):
        FrameBuffer((2, 2), 4, dot=DotModel(1.5, 1.5), glass={"pixel": "dot"})
    with pytest.raises(UsageError, match="33 … 64|allowed: 1 … 32"):
        FrameBuffer((2, 2)).view(33)
    with pytest.raises(UsageError, match="too large"):
        FrameBuffer((2000, 2000)).view(32)
    assert isinstance(FrameBuffer((2, 2)).format, Indexed)


@pytest.mark.parametrize(
    ("table", "word"),
    [
        ({"ghosts": 0.1}, "unknown key 'ghosts'. Did you mean ghosting"),
        ({"ghosting": 0.1}, "needs_refresh"),
        ({"ghosting": 1, "needs_refresh": True}, "ghosting = 1"),
        ({"format": "rgb566"}, "Did you mean rgb565"),
        ({"format": 5}, "format = 5"),
        ({"format": "rgb565", "palette": "spectra6"}, "no use for the format"),
        ({"response": "gama:2.2"}, "gama"),
        ({"pixel": "round"}, "unknown pixel 'round'"),
        ({"fill": 0.8}, "fill = 0.8"),
        ({"black": float("nan")}, "black = nan"),
        ({"ambient": -1}, "ambient = -1"),
        ({"a": True}, "a = True"),
        ({"dac_bits": 17}, "dac_bits=17"),
        ({"time_bits": 0}, "time_bits=0"),
        ({"needs_refresh": 1}, "needs_refresh = 1"),
    ],
)
def test_mistakes_in_the_table_of_glass(table: dict[str, object], word: str) -> None:
    with pytest.raises(UsageError, match=word):
        Glass.of(table)


def test_a_picture_without_pixels_is_refused():
    for shape in ((0, 0), (1, 0)):
        with pytest.raises(InputError, match="no pixels"):
            FrameBuffer(load("epaper-4gray")).write(np.zeros(shape, np.uint8))
