"""Three panels side by side: each against what its name says, made in another way."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from devices.framebuffer import FrameBuffer
from devices.paper import Paper, at_distance
from devices.preview import GRAY, PIXELS, SEPARATOR, WIDE, Preview
from devices.profile import DeviceProfile, load
from halftone.errors import InputError, InputFileError, UsageError
from halftone.frame import Frame
from halftone.recipe import Recipe
from halftone.tone.levels import Levels
from tests.cli.files import GRAY as CODES
from tests.cli.files import RGB, codes_of, light_of

PRINTER = DeviceProfile(
    "printer", "Printer", "made up", dpi_x=203.2, dpi_y=203.2, dot_x=1.414, dot_y=1.414, codes=(1, 0)
)
PANEL = DeviceProfile("panel", "Panel", "made up", level_luminance=(0.1, 0.3, 0.8), bits=2)


def ramp(rows: int = 24, columns: int = 40) -> np.ndarray:
    return np.tile(np.linspace(0.02, 0.9, columns, dtype=np.float32), (rows, 1))


def panels(preview: Preview, scale: int) -> list[np.ndarray]:
    """The three panels, cut out of the picture; the separators are checked."""
    picture = np.concatenate(list(preview.bands(scale).indices))
    rows, columns = preview.shape
    assert picture.shape == (rows * scale, 3 * columns * scale + 2 * SEPARATOR)
    step = columns * scale + SEPARATOR
    for left in (step - SEPARATOR, 2 * step - SEPARATOR):
        assert (picture[:, left : left + SEPARATOR] == GRAY).all()
    return [picture[:, k * step : k * step + columns * scale] for k in range(3)]


@pytest.mark.parametrize("pixels", [CODES, RGB], ids=["gray", "colour"])
@pytest.mark.parametrize("method", ["floyd-steinberg", "bayer4", "patterns:classic3"])
def test_asked_is_the_light_of_the_picture_in_the_range_of_the_levels(
    pixels: np.ndarray, method: str
) -> None:
    made = Preview.of(pixels, levels="0.1,0.8", method=method)
    wanted = np.clip(light_of(pixels), 0.1, 0.8)
    assert made.asked.dtype == np.float32
    np.testing.assert_allclose(made.asked, wanted, atol=2e-6)
    assert np.abs(panels(made, 1)[0] - codes_of(wanted)).max() <= 0.501


def test_asked_is_adjusted_and_of_the_devices_size() -> None:
    made = Preview.of(ramp(), profile=PANEL, width=20, invert=True, brightness=0.2)
    plain = Preview.of(ramp(), levels="0.1,0.3,0.8", width=20)
    assert made.asked.shape == made.sent.shape == (12, 20)
    assert np.abs(made.asked - plain.asked).max() > 0.3


def test_sent_is_what_convert_sends() -> None:
    wanted = Recipe(profile=PRINTER, method="bayer8").convert(ramp())
    made = Preview.of(ramp(), profile=PRINTER, method="bayer8")
    assert np.array_equal(made.sent.indices, wanted.indices)
    for scale in (1, 3):
        block = wanted.preview().repeat(scale, axis=0).repeat(scale, axis=1)
        assert np.array_equal(panels(made, scale)[1], block)


def test_seen_is_paper_at_a_distance() -> None:
    made = Preview.of(ramp(), profile=PRINTER, distance=40)
    near = Paper(PRINTER.levels, PRINTER.dot).seen(made.sent)
    far = at_distance(near, PRINTER.dpi, 40 / 2.54)
    assert np.array_equal(made.light("seen"), far)
    assert np.abs(panels(made, 1)[2] - codes_of(np.clip(far, 0, 1))).max() <= 0.501
    assert np.array_equal(Preview.of(ramp(), profile=PRINTER, distance=0).light("seen"), near)


@pytest.mark.parametrize("distance", [0.0, 30.0])
def test_from_scale_4_on_dots_have_shapes(distance: float) -> None:
    made = Preview.of(ramp(), profile=PRINTER, distance=distance)
    drawn = np.concatenate(list(Paper(PRINTER.levels, PRINTER.dot).drawn(made.sent, 4)))
    if distance:
        drawn = at_distance(drawn, (812.8, 812.8), distance / 2.54)
    assert np.abs(panels(made, 4)[2] - codes_of(np.clip(drawn, 0, 1))).max() <= 0.501
    cells = panels(made, 3)[2].reshape(24, 3, 40, 3)
    assert (cells == cells[:, :1, :, :1]).all()  # below, a dot is a square
    assert not np.array_equal(panels(made, 4)[2][::4], panels(made, 4)[2][1::4])


def test_from_too_far_away_dots_have_no_shapes() -> None:
    made = Preview.of(ramp(4, 6), profile=PRINTER, distance=400)
    cells = panels(made, 8)[2].reshape(4, 8, 6, 8)
    assert (cells == cells[:, :1, :, :1]).all()


def test_what_is_seen_of_a_printed_tone_is_what_was_asked_for() -> None:
    flat = np.full((96, 96), 0.4, np.float32)
    made = Preview.of(flat, profile=PRINTER)
    means = {name: float(made.light(name)[16:-16, 16:-16].mean()) for name in ("asked", "sent", "seen")}
    assert means["asked"] == pytest.approx(0.4, abs=1e-6)
    assert means["seen"] == pytest.approx(0.4, abs=0.02)
    assert means["sent"] > 0.5  # the ink that spreads is left out
    kept = Preview.of(flat, profile=PRINTER, dot_gain="keep")
    assert float(kept.light("seen")[16:-16, 16:-16].mean()) < 0.3
    assert np.array_equal(kept.asked, made.asked)


def test_without_dots_or_dpi_the_levels_are_seen() -> None:
    for options in ({"profile": PANEL}, {"levels": 4}):
        made = Preview.of(ramp(), **options)
        assert np.array_equal(made.light("seen"), made.sent.luminance)


def test_glass_is_seen_with_its_ambient_light() -> None:
    glass = DeviceProfile(
        "g", "g", "made up", level_luminance=(0.0, 0.5, 1.0), bits=2, glass={"ambient": 0.1}
    )
    made = Preview.of(ramp(), profile=glass)
    np.testing.assert_allclose(made.light("seen"), made.sent.luminance + 0.1, atol=1e-6)
    given = Preview.of(ramp(), profile=glass, levels=(0.0, 0.2, 1.0))
    np.testing.assert_allclose(given.light("seen"), given.sent.luminance + 0.1, atol=1e-6)


def test_colour_glass_is_seen_by_its_luminance() -> None:
    profile = load("lcd-rgb565")
    made = Preview.of(ramp(240, 320), profile=profile, distance=0)
    glass = FrameBuffer(profile)
    glass.write(made.sent)
    wanted = glass.snapshot() @ np.array([0.2126, 0.7152, 0.0722])
    np.testing.assert_allclose(made.light("seen"), wanted, atol=1e-6)


@pytest.mark.parametrize("shape", [(3, 5), (200, 300), (100, 700), (5000, 20), (10, 3000)])
def test_the_default_scale_is_the_largest_that_fits(shape: tuple[int, int]) -> None:
    frame = Frame(np.zeros(shape, np.uint8), Levels.of(2))
    made = Preview(frame.luminance, frame, frame.luminance, 30)
    scale = made.best_scale()

    def fits(n: int) -> bool:
        rows, columns = shape[0] * n, 3 * shape[1] * n
        return columns + 2 * SEPARATOR <= WIDE and rows * columns <= PIXELS and n <= 256

    assert scale == max([1, *filter(fits, range(1, 257))])


def test_files_and_notebooks_show_the_same(tmp_path: Path) -> None:
    made = Preview.of(ramp(), profile=PRINTER)
    made.save(tmp_path / "look.png")
    assert made._repr_png_() == (tmp_path / "look.png").read_bytes()
    with Image.open(io.BytesIO(made._repr_png_())) as picture:
        assert picture.mode == "L"
        assert np.array_equal(np.asarray(picture), np.concatenate(list(made.bands().indices)))


def test_one_panel_alone() -> None:
    made = Preview.of(ramp(), profile=PRINTER)
    for name, panel in zip(("asked", "sent", "seen"), panels(made, 2), strict=True):
        assert np.array_equal(np.concatenate(list(made.bands(2, name).indices)), panel)


def test_what_cannot_be_shown_is_refused(tmp_path: Path) -> None:
    made = Preview.of(ramp(), profile=PRINTER)
    with pytest.raises(UsageError, match="panel 'send'.*sent"):
        made.bands(panel="send")
    with pytest.raises(UsageError, match="scale=0"):
        made.bands(0)
    for distance in (-1, 501, float("nan")):
        with pytest.raises(UsageError, match="distance"):
            Preview.of(ramp(), distance=distance)
    with pytest.raises(InputFileError, match="none.png"):
        Preview.of(tmp_path / "none.png")


def test_a_preview_that_takes_too_much_memory_is_refused() -> None:
    with pytest.raises(InputError, match="a preview of 1000 × 1000.*max-memory"):
        Preview.of(np.zeros((1000, 1000), np.uint8), max_memory=20 << 20)
    made = Preview.of(ramp(64, 64), profile=PRINTER, max_memory=8 << 20)
    with pytest.raises(InputError, match="a preview of 3080 × 1024"):
        made.bands(16)
