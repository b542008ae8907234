"""The fit: simulated printers found again, freedom only where it is demanded, contradictions named."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from devices.calibration import fit, relative_light, save
from devices.chart import Chart, make_chart, read_chart
from devices.profile import load
from halftone import dither
from halftone.errors import OutputError, UsageError
from halftone.tone.dotgain import DotModel
from tests.devices.photographed import pattern, photo, printed


@lru_cache(maxsize=1)
def _chart() -> Chart:
    return make_chart(load("receipt-80mm"))


def _light(across: float, down: float, black: float, spread: float = 1.0) -> np.ndarray:
    covered = _chart().patterns @ DotModel(across, down).table.astype(np.float64)
    return (1 - covered + covered * black ** (1 / spread)) ** spread


@given(d=st.floats(1.1, 2.3), black=st.floats(0.01, 0.12))
def test_a_printer_of_the_model_is_found(d: float, black: float) -> None:
    light = _light(d, d, black)[:9]
    found = fit(_chart().patterns[:9], light)
    np.testing.assert_allclose(found.light(_chart().patterns[:9]), light, atol=6e-3)
    assert found.dot.across == found.dot.down == pytest.approx(d, abs=0.03)


def test_simple_readings_get_a_simple_model() -> None:
    rng = np.random.default_rng(3)
    plain = [
        fit(_chart().patterns[:9], _light(1.6, 1.6, 0.05)[:9] + rng.normal(0, 0.01, 9), 0.01).measured
        for _ in range(40)
    ]
    assert sum(measured is None for measured in plain) >= 32


def test_lines_tell_two_diameters_apart() -> None:
    light = _light(1.8, 1.4, 0.05)
    found = fit(_chart().patterns, light, steps=9)
    assert (found.dot.across, found.dot.down) == pytest.approx((1.8, 1.4), abs=0.01)
    alone = fit(_chart().patterns[:9], light[:9])
    assert alone.dot.across == alone.dot.down


def test_spread_light_becomes_a_curve() -> None:
    light = _light(1.5, 1.5, 0.08, 1.8)
    found = fit(_chart().patterns[:9], light[:9])
    assert found.measured is not None
    pairs = np.array(found.measured)
    assert (np.diff(pairs, axis=0) > 0).all()
    np.testing.assert_allclose(found.light(_chart().patterns), light, atol=3e-3)


def test_what_no_model_has_becomes_free_points() -> None:
    straight = _light(1.5, 1.5, 0.05)[:9]
    light = np.interp(straight, [0.05, 0.5, 1], [0.05, 0.54, 1])
    found = fit(_chart().patterns[:9], light, noise=0.003)
    assert found.measured is not None
    assert np.abs(light - found.light(_chart().patterns[:9])).max() < 0.02


@pytest.mark.parametrize(("step", "off"), [(0, 0.2), (4, 0.2), (6, -0.25), (8, -0.15)])
def test_a_wrong_reading_is_named(step: int, off: float) -> None:
    light = _light(1.6, 1.6, 0.05)[:9] + np.random.default_rng(0).normal(0, 0.004, 9)
    light[step] = max(0, light[step] + off)
    with pytest.raises(UsageError, match=f"number {step + 1} is .* again") as caught:
        fit(_chart().patterns[:9], light)
    assert str(caught.value).count("number") == 1


def test_readings_backwards_are_refused() -> None:
    with pytest.raises(UsageError, match="contradict"):
        fit(_chart().patterns[:9], _light(1.6, 1.6, 0.05)[8::-1])


def test_scales_of_readings() -> None:
    light = np.array([0.03, 0.2, 0.9])
    np.testing.assert_allclose(relative_light(light * 100), light)
    np.testing.assert_allclose(relative_light(-np.log10(light), "density"), light)
    np.testing.assert_allclose(relative_light(116 * np.cbrt(light) - 16, "lstar"), light)
    for bad, scale in (([120], "light"), ([-1], "light"), ([float("nan")], "light"), ([-1], "density")):
        with pytest.raises(UsageError, match="reading 1 is"):
            relative_light(bad, scale)
    with pytest.raises(UsageError, match="allowed: light"):
        relative_light([1], "lux")


def test_mistakes_are_named() -> None:
    with pytest.raises(UsageError, match="3 readings"):
        fit(_chart().patterns[:3], np.ones(3))
    with pytest.raises(UsageError, match="noise"):
        fit(_chart().patterns[:9], _light(1.6, 1.6, 0.05)[:9], noise=2)


def test_saved_profiles_load_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    base = replace(load("receipt-80mm"), title='of "make" \\ model')
    found = fit(_chart().patterns[:9], _light(1.5, 1.5, 0.08, 1.8)[:9])
    path = save(found, base, "mine", "Said of it")
    own = load("mine")
    assert own.dot == found.dot
    assert own.measured == found.measured
    assert own.levels.darkest == pytest.approx(found.black)
    assert own.title == base.title + ", calibrated"
    assert own.provenance.endswith("Said of it")
    for name in ("width", "dpi", "codes", "language", "cut", "options", "density", "method"):
        assert getattr(own, name) == getattr(base, name)
    before = path.read_bytes()
    with pytest.raises(OutputError, match="--force"):
        save(found, base, "mine", "again")
    assert path.read_bytes() == before
    save(found, base, "mine", "again", overwrite=True)
    assert load("mine").provenance.endswith("again")
    with pytest.raises(UsageError, match="profile name"):
        save(found, base, "../mine", "")


def test_the_whole_loop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Print, photograph, read, fit, save; then even patches have the light that was asked for."""
    from halftone.recipe import Recipe

    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    dots, black = (1.75, 1.6), 0.07
    chart = _chart()
    photographed = photo(printed(chart.frame.indices, dots, black), turn=-8, tilt=0.1)
    (tmp_path / "photo.jpg").write_bytes(photographed)
    reading = read_chart(tmp_path / "photo.jpg")
    save(fit(chart.patterns, reading.light, steps=9), load("receipt-80mm"), "mine", "a test")
    mine = replace(load("mine"), width=None)
    table = DotModel(*dots).table
    asked = np.linspace(0.1, 0.95, 18)
    off, before = [], []
    for light in asked:
        even = np.full((160, 160), light, np.float32)
        sent = Recipe(profile=mine).convert(even).indices
        plain = dither(even).indices
        for indices, found in ((sent, off), (plain, before)):
            found.append(1 - (1 - black) * (pattern(indices[48:, 48:]) @ table) - light)
    assert np.abs(off).max() < 0.02
    assert np.abs(before).max() > 0.2


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("measured = [[0, 0], [0.5, 0.4], [1, 1]]", ""),
        ("measured = [[0, 0], [0.5, 0.4], [0.4, 1]]", "both rising"),
        ("measured = [[0, 0], [0.5, 0], [1, 1]]", "both rising"),
        ("measured = [[0, 0]]", "two or more"),
        ("measured = [[0, 0], [1]]", "number, number"),
        ("measured = [[0, 0], [1, true]]", "number, number"),
        ("measured = [0, 1]", "number, number"),
    ],
)
def test_measured_in_a_profile_is_checked(tmp_path: Path, text: str, complaint: str) -> None:
    path = tmp_path / "made.toml"
    path.write_text(f'title = "t"\nprovenance = "p"\ndot_x = 1.5\ndot_y = 1.5\n{text}\n')
    if not complaint:
        assert load(path).measured == ((0.0, 0.0), (0.5, 0.4), (1.0, 1.0))
        return
    with pytest.raises(UsageError, match=complaint):
        load(path)
    path.write_text(f'title = "t"\nprovenance = "p"\n{text}\n')
    with pytest.raises(UsageError):
        load(path)


def test_readings_that_say_nothing_are_refused():
    chart = make_chart(load("receipt-80mm"), 9)
    for light in (0.0, 0.05, 1.0):
        with pytest.raises(UsageError, match="differ by less than 10 %"):
            fit(chart.patterns[:9], np.full(9, light), None, 9)
