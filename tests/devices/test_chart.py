"""The chart, and reading it from simulated photos: turned, tilted, unevenly lit, and bad ones."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest

from devices.chart import STEPS, Chart, make_chart, read_chart
from devices.profile import load, names
from halftone.errors import InputFileError, UsageError
from halftone.tone.dotgain import DotModel
from tests.devices.photographed import Light, pattern, photo, printed

DOTS, BLACK = (1.7, 1.5), 0.06


@lru_cache(maxsize=2)
def _chart(steps: int) -> tuple[Chart, Light]:
    chart = make_chart(load("receipt-80mm"), steps)
    return chart, printed(chart.frame.indices, DOTS, BLACK)


def _true(chart: Chart) -> np.ndarray:
    return 1 - (1 - BLACK) * (chart.patterns @ DotModel(*DOTS).table)


@pytest.mark.parametrize("name", names())
def test_every_printer_of_two_levels_has_a_chart(name: str) -> None:
    profile = load(name)
    if len(profile.levels) != 2:
        with pytest.raises(UsageError, match="levels"):
            make_chart(profile)
        return
    chart = make_chart(profile)
    assert chart.patterns.shape == (11, 512)
    np.testing.assert_allclose(chart.patterns.sum(1), 1)
    if profile.width is not None:
        assert chart.frame.shape[1] <= profile.width


@pytest.mark.parametrize("steps", STEPS)
def test_steps_have_the_ink_that_is_asked(steps: int) -> None:
    chart, _ = _chart(steps)
    own = np.array([bool(code >> 4 & 1) for code in range(512)])
    ink = chart.patterns @ own
    np.testing.assert_allclose(ink[:steps], 1 - np.array(STEPS[steps]), atol=0.015)
    np.testing.assert_allclose(ink[steps:], 1 / 3, atol=0.02)


def test_patterns_are_those_of_the_dots() -> None:
    rng = np.random.default_rng(0)
    indices = rng.integers(0, 2, (30, 20)).astype(np.uint8)
    from devices.calibration import pattern as ours

    np.testing.assert_allclose(ours(indices), pattern(indices))


def test_a_profile_that_corrects_has_the_same_chart() -> None:
    from dataclasses import replace

    profile = load("receipt-80mm")
    other = replace(profile, dot_x=2.0, dot_y=2.0, measured=((0.0, 0.0), (0.5, 0.4), (1.0, 1.0)))
    np.testing.assert_array_equal(make_chart(profile).frame.indices, make_chart(other).frame.indices)


@pytest.mark.parametrize("steps", STEPS)
@pytest.mark.parametrize(
    "how",
    [
        {},
        {"turn": 93, "tilt": 0.12, "noise": 0.02},
        {"turn": -170, "vignette": 0.5, "exposure": 0.3},
        {"turn": 25, "table": 0.9},
    ],
    ids=str,
)
def test_photos_are_read(tmp_path: Path, steps: int, how: dict[str, float]) -> None:
    chart, paper = _chart(steps)
    file = tmp_path / "photo.jpg"
    file.write_bytes(photo(paper, **how))
    reading = read_chart(file)
    assert reading.steps == steps
    np.testing.assert_allclose(reading.light, _true(chart), atol=0.012)
    assert (reading.spread < 0.01).all()


def test_a_scan_as_an_array_is_read() -> None:
    chart, paper = _chart(9)
    scan = np.pad(paper * np.float32(0.8), 60, constant_values=0.8)
    np.testing.assert_allclose(read_chart(scan).light, _true(chart), atol=0.01)
    colour = np.stack([scan] * 3, axis=-1)
    np.testing.assert_allclose(read_chart(colour).light, read_chart(scan).light, atol=1e-5)


@pytest.mark.parametrize(
    ("how", "complaint"),
    [
        ({"exposure": 0.03, "noise": 0.0}, "too dark"),
        ({"exposure": 3.0}, "over-exposed"),
        ({"size": (200, 175)}, "too small"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_bad_photos_are_named(tmp_path: Path, how: dict, complaint: str) -> None:
    _, paper = _chart(9)
    file = tmp_path / "photo.jpg"
    file.write_bytes(photo(paper, **how))
    with pytest.raises(InputFileError, match=complaint):
        read_chart(file)


def test_what_is_no_chart_is_not_found(photograph: Path) -> None:
    with pytest.raises(InputFileError, match="no chart was found"):
        read_chart(photograph)
    with pytest.raises(InputFileError, match="no chart was found"):
        read_chart(np.full((300, 300), 0.5, np.float32))
    _, paper = _chart(9)
    cut = np.pad(paper * np.float32(0.8), 60, constant_values=0.8)[:, 200:]
    with pytest.raises(InputFileError, match="no chart was found"):
        read_chart(cut)


def test_mistakes_are_named() -> None:
    with pytest.raises(UsageError, match="9 or 17"):
        make_chart(load("receipt-80mm"), 8)
