"""Print curves: what is printed has the luminance asked for, and what happens where that cannot be."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import halftone
from devices.profile import load
from halftone import flatfield
from halftone.dithering.registry import method as find_method
from halftone.errors import UsageError
from halftone.flatfield import PrintCurve, print_curve
from halftone.tone.dotgain import DotModel
from halftone.tone.levels import Levels
from tests.oracle import dotgain as slow

ROUND = DotModel(2**0.5, 2**0.5)
BILEVEL = Levels.of(2)
RECEIPT = load("receipt-80mm")


@pytest.fixture(autouse=True)
def own_cache(tmp_path_factory, monkeypatch):
    """Kernels stay where they are; curves are forgotten in the process."""
    monkeypatch.setattr(flatfield, "_memory", {})


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder for curves alone."""
    monkeypatch.setattr(flatfield._objects, "directory", lambda: tmp_path)
    return tmp_path


def curve_of(*printed: float, **options) -> PrintCurve:
    asked = np.linspace(0, 1, len(printed))
    return PrintCurve(asked, np.array(printed), False, **options)


def ask(curve: PrintCurve, *light: float) -> list[float]:
    return curve.inverse(np.array(light, np.float32)).tolist()


def printed(method: str, levels: Levels, dot: DotModel, light: float, rows: int, columns: int) -> float:
    """Mean luminance in print of an even patch within its rim of 8."""
    frame = halftone.dither(np.full((rows, columns), light, np.float32), method, levels=levels)
    covered = dot.covered((frame.indices == 0).astype(np.uint8))[8:-8, 8:-8]
    return float(levels.lightest - (levels.lightest - levels.darkest) * covered.mean(dtype=np.float64))


@pytest.mark.parametrize(
    ("name", "side"),
    [
        ("floyd-steinberg", 304),
        ("zhou-fang", 240),
        ("riemersma", 272),
        ("dots:64", 208),
        ("blue-noise", 272),
        ("bayer4", 216),
        ("c7x7w", 219),
        ("screen:line@45:6px", 208),
        ("patterns:4", 40),
    ],
)
@pytest.mark.parametrize(
    ("levels", "dot"), [(BILEVEL, ROUND), (Levels.of([0.05, 0.8]), DotModel(1.6, 1.3))]
)
def test_the_print_has_the_luminance_asked_for(name, side, levels, dot):
    """At 17 tones, on patches of another size; bound: 1.5/255, or half the largest step of few tones."""
    curve = print_curve(name, levels, dot)
    span = curve.lightest - curve.darkest
    steps = np.diff(np.unique(curve.printed)).max() if curve.steps else 0.0
    for tone in np.linspace(curve.darkest, curve.lightest, 17):
        asked = float(curve.inverse(np.float32(tone)))
        seen = printed(name, levels, dot, asked, side, side + 8 * (not curve.steps))
        assert abs(seen - tone) <= max(1.5 / 255 * span, 0.53 * steps), (tone, asked)


def test_a_curve_is_the_loop_over_cells():
    levels, dot = Levels.of([0.1, 0.9]), DotModel(1.7, 1.2)
    curve = print_curve("bayer2", levels, dot)
    assert curve.asked == pytest.approx([0.1, 0.3, 0.5, 0.7, 0.9], abs=1e-6)
    for asked, seen in zip(curve.asked, curve.printed, strict=True):
        frame = halftone.dither(np.full((4, 4), asked, np.float32), "bayer2", levels=levels)
        cells = np.array(slow.covered((frame.indices == 0).astype(int).tolist(), dot.table.tolist()))
        assert seen == pytest.approx(0.9 - 0.8 * cells[1:3, 1:3].mean(), abs=1e-6)


@given(st.lists(st.floats(0, 1), min_size=0, max_size=30), st.booleans())
@settings(max_examples=200, deadline=None)
def test_an_inverse_rises_and_prints_the_nearest(inner, steps):
    curve = curve_of(0.0, *inner, 1.0, steps=steps)
    light = np.linspace(-0.1, 1.1, 200).astype(np.float32)
    asked = curve.inverse(light)
    assert (np.diff(asked) >= 0).all()
    assert asked[0] == 0
    assert asked[-1] == 1
    chain = curve.printed[flatfield._chain(curve.printed)]
    assert (np.diff(chain) > 0).all()
    if steps:  # one of the tones of the chain, and the nearest of them
        seen = np.interp(asked, curve.asked.astype(np.float32), curve.printed)
        best = np.abs(chain[:, None] - np.clip(light, 0, 1)).min(axis=0)
        np.testing.assert_allclose(np.abs(seen - np.clip(light, 0, 1)), best, atol=1e-4)


def test_of_a_curve_that_never_falls_all_tones_are_used():
    curve = curve_of(0.0, 0.1, 0.3, 0.6, 1.0)
    assert ask(curve, 0.05, 0.2, 0.3, 0.8) == pytest.approx([0.125, 0.375, 0.5, 0.875], abs=1e-4)


def test_a_dip_and_a_bump_are_passed_over():
    dip = curve_of(0.0, 0.2, 0.4, 0.1, 0.45, 0.7, 1.0)  # the third falls below its neighbours
    assert ask(dip, 0.41, 0.44) == pytest.approx([2 / 6, 4 / 6], abs=1e-6)
    bump = curve_of(0.0, 0.2, 0.4, 0.9, 0.5, 0.7, 1.0)
    assert ask(bump, 0.44, 0.46, 0.6) == pytest.approx([2 / 6, 4 / 6, 4.5 / 6], abs=1e-4)


def test_a_curve_that_falls_says_so():
    curve = print_curve("floyd-steinberg", BILEVEL, ROUND)
    assert not curve.rising
    assert 0.01 < curve.falls < 0.03
    assert curve.note == ""  # a little is said in the report only
    frame = halftone.convert(PHOTO.astype(np.uint8), profile=RECEIPT, method="floyd-steinberg")
    assert 0.01 < stages(frame)["tone"]["falls"] < 0.03
    assert "falls by up to 0.0" in print_curve("dots:knuth", BILEVEL, ROUND).note
    smooth = print_curve("zhou-fang", BILEVEL, ROUND)
    assert smooth.rising
    assert smooth.note == ""


def test_dots_that_leave_paper_between_them_say_how_dark_it_gets():
    dot = DotModel(1, 1)
    curve = print_curve("bayer8", BILEVEL, dot)
    assert curve.darkest == pytest.approx(1 - dot.solid)
    assert "the darkest luminance that can be printed is 0.215" in curve.note
    assert ask(curve, 0.0, 0.1, 1.0) == [0, 0, 1]
    profile = replace(RECEIPT, dot_x=1.0, dot_y=1.0)
    frame = halftone.convert(np.zeros((16, 16), np.float32), profile=profile, width=16, method="bayer8")
    assert any("0.215" in note for note in frame.report["notes"])
    assert not frame.indices.any()


def test_more_levels_than_two_are_refused():
    with pytest.raises(UsageError, match="4 levels; allowed: 2"):
        print_curve("bayer8", Levels.of(4), ROUND)


def test_readings_are_laid_on_top_of_the_prediction():
    plain = print_curve("bayer8", BILEVEL, ROUND)
    measured = ((0.0, 0.1), (0.5, 0.4), (1.0, 0.95))
    curve = print_curve("bayer8", BILEVEL, ROUND, measured=measured)
    np.testing.assert_allclose(curve.printed, np.interp(plain.printed, *np.transpose(measured)))
    assert (curve.darkest, curve.lightest) == (0.1, 0.95)
    with pytest.raises(UsageError, match="do not rise"):
        print_curve("bayer8", BILEVEL, ROUND, measured=((0.0, 0.5), (1.0, 0.5)))


# --- kept curves


def test_a_curve_is_kept(folder):
    first = print_curve("bayer4", BILEVEL, ROUND)
    again = print_curve("bayer4", BILEVEL, ROUND)
    flatfield._memory.clear()
    later = print_curve("bayer4", BILEVEL, ROUND)
    assert [c.origin for c in (first, again, later)] == ["computed", "memory", "file"]
    np.testing.assert_array_equal(first.printed, later.printed)
    np.testing.assert_array_equal(first.table, later.table)


@pytest.mark.parametrize(
    "change",
    [
        {"method": "bayer8"},
        {"method": "bayer4:strength=0.5"},
        {"levels": Levels.of([0.1, 1])},
        {"dot": DotModel(1.5, 1.4)},
        {"method": "screen:round@45:60lpi", "dpi": (203, 203)},
        {"method": "screen:round@45:60lpi", "dpi": (300, 300)},
    ],
)
def test_all_that_a_curve_depends_on_is_in_its_key(change):
    given = {"method": "bayer4", "levels": BILEVEL, "dot": ROUND, "dpi": None}
    changed = given | change
    keys = [
        flatfield._key(find_method(g["method"]), g["levels"], g["dot"], g["dpi"])
        for g in (given, changed, changed | {"dpi": (1.0, 1.0)}, given)
    ]
    assert keys[0] == keys[3]
    assert len(set(keys)) == 3


@pytest.mark.parametrize("damage", [lambda b: b[:-1], lambda b: b"", lambda b: b[:60] + b"x" + b[61:]])
def test_a_damaged_file_is_computed_again(folder, damage):
    first = print_curve("bayer4", BILEVEL, ROUND)
    (path,) = folder.glob("*.curve")
    path.write_bytes(damage(path.read_bytes()))
    flatfield._memory.clear()
    again = print_curve("bayer4", BILEVEL, ROUND)
    assert again.origin == "computed"
    np.testing.assert_array_equal(first.printed, again.printed)
    flatfield._memory.clear()
    assert print_curve("bayer4", BILEVEL, ROUND).origin == "file"


def test_a_cache_that_cannot_be_written_is_no_error(tmp_path, monkeypatch):
    blocked = tmp_path / "file"
    blocked.write_bytes(b"")
    monkeypatch.setattr(flatfield._objects, "directory", lambda: blocked)
    assert print_curve("bayer4", BILEVEL, ROUND).origin == "computed"
    assert blocked.read_bytes() == b""


# --- in the pipeline


def stages(frame: halftone.Frame) -> dict[str, dict]:
    return {entry["stage"]: entry for entry in frame.report["stages"]}


def left_out(frame: halftone.Frame) -> dict[str, str]:
    return {entry["stage"]: entry["why"] for entry in frame.report["left_out"]}


PHOTO = np.arange(240 * 576, dtype=np.uint32).reshape(240, 576) % 251
CODES = PHOTO.astype(np.uint8)


def test_codes_stay_codes_and_print_as_their_light_does():
    for method in ("floyd-steinberg", "bayer8", "dots:64"):
        frame = halftone.convert(CODES, profile=RECEIPT, method=method)
        light = halftone.tone.encoding("srgb").table(256)[CODES]
        same = halftone.convert(light, profile=RECEIPT, method=method)
        np.testing.assert_array_equal(frame.indices, same.indices)
        assert "float copy" in left_out(frame)
        assert stages(frame)["tone"]["dot"] == [1.415, 1.415]
        assert stages(same)["tone"]["curve"] == "memory"


def test_dot_gain_can_be_kept():
    kept = halftone.convert(CODES, profile=RECEIPT, dot_gain="keep")
    np.testing.assert_array_equal(kept.indices, halftone.dither(CODES, "floyd-steinberg").indices)
    assert left_out(kept)["tone"] == "dot gain is kept, as was asked for"
    corrected = halftone.convert(CODES, profile=RECEIPT)
    assert corrected.indices.mean() > kept.indices.mean() + 0.05
    with pytest.raises(UsageError, match="'korrect'"):
        halftone.convert(CODES, dot_gain="korrect")


def test_where_there_is_nothing_to_correct_the_report_says_why():
    reasons = {
        "no device": halftone.convert(CODES),
        "whose printed dots are known": halftone.convert(CODES, profile=load("generic-1bit")),
        "prints no tone between": halftone.convert(CODES, profile=RECEIPT, content="text"),
    }
    for why, frame in reasons.items():
        assert why in left_out(frame)["tone"]
        assert "tone" not in stages(frame)
    np.testing.assert_array_equal(
        reasons["prints no tone between"].indices, halftone.dither(CODES, "threshold").indices
    )


def test_a_profile_of_somebody_else_needs_no_dots():
    fields = ("name", "width", "height", "dpi", "levels", "packing", "method")
    bare = SimpleNamespace(**{name: getattr(RECEIPT, name) for name in fields})
    assert "tone" in left_out(halftone.convert(CODES, profile=bare))


@pytest.mark.parametrize("rule", ["clip", "scale", "compress"])
def test_the_range_comes_first(rule):
    """Light beyond paper is brought in by the rule, and what is then meant is printed."""
    light = np.linspace(0.2, 2.0, 576, dtype=np.float32)[None].repeat(200, axis=0)
    frame = halftone.convert(light, profile=RECEIPT, method="zhou-fang", range=rule)
    meant = {
        "clip": np.clip(light, 0, 1),
        "scale": light / 2,
        "compress": np.where(light > 0.8, 1 - 0.2 / (1 + (light - 0.8) / 0.2), light),
    }[rule]
    ink = (frame.indices == 0).astype(np.uint8)
    seen = 1 - RECEIPT.dot.covered(ink)[8:-8].reshape(184, 18, 32).mean(axis=(0, 2))
    wanted = meant[8:-8].reshape(184, 18, 32).mean(axis=(0, 2))
    np.testing.assert_allclose(seen[1:-1], wanted[1:-1], atol=0.02)
    assert stages(frame)["tone"]["range"] == rule


def test_bands_are_the_whole():
    whole = halftone.convert(CODES, profile=RECEIPT)
    parts = np.vstack([part.indices for part in halftone.convert_bands(CODES, profile=RECEIPT)])
    np.testing.assert_array_equal(parts, whole.indices)
