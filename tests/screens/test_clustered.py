"""Clustered dots: supercells, ranks, what ruling and angle the dots really have, and the method."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from halftone import UsageError, dither
from halftone.dithering.base import Job
from halftone.dithering.screened import ClusteredDot, screen, screened
from halftone.screens.clustered import (
    SHAPES,
    Supercell,
    clustered,
    clustered_ranks,
    find_supercell,
    rulings,
    screen_levels,
)
from tests.oracle import screens as oracle
from tests.strategies import ladders

shapes = st.sampled_from(list(SHAPES))
angles = st.floats(-180, 180).map(lambda a: round(a, 1))
resolutions = st.sampled_from([(203.0, 203.0), (600.0, 600.0), (180.0, 203.0), (600.0, 300.0)])


@st.composite
def supercells(draw: st.DrawFn) -> tuple[Supercell, float, float]:
    """A supercell with the angle and the ruling that were asked for."""
    dpi = draw(resolutions)
    low, high = max(dpi) / 20, min(dpi) / 2
    lpi = round(low + (high - low) * draw(st.floats(0, 1)) ** 2, 2)
    angle = draw(angles)
    try:
        cell = find_supercell(angle, min(max(lpi, low), high), dpi)
    except UsageError:
        assume(False)
    assume(math.prod(cell.tile) < 1 << 16)  # larger ones only take longer
    return cell, angle, lpi


def peak(patch: np.ndarray, dpi: tuple[float, float]) -> tuple[float, float]:
    """Lines per inch and angle, 0 … 90, of the strongest frequency of a tile."""
    power = np.abs(np.fft.fft2(patch - patch.mean()))
    fy, fx = (f[i] for f, i in zip(
        (np.fft.fftfreq(patch.shape[0]), np.fft.fftfreq(patch.shape[1])),
        np.unravel_index(power.argmax(), power.shape), strict=True,
    ))  # fmt: skip
    x, y = fx * dpi[0], -fy * dpi[1]
    return math.hypot(x, y), math.degrees(math.atan2(y, x)) % 90


@settings(max_examples=60)
@given(supercells(), shapes)
def test_each_rank_once(made, shape):
    cell, _, _ = made
    ranks = clustered_ranks(shape, cell)
    assert ranks.shape == cell.tile
    counts = np.bincount(ranks.ravel())
    assert counts.size == cell.pixels
    assert (counts == ranks.size // cell.pixels).all()
    # The tile repeats by both vectors of the supercell, and so do the ranks.
    for x, y in (cell.along, cell.across):
        np.testing.assert_array_equal(np.roll(ranks, (y, x), (0, 1)), ranks)


@settings(max_examples=60)
@given(supercells())
def test_within_tolerance_of_what_was_asked(made):
    cell, angle, lpi = made
    assert abs(cell.lpi / lpi - 1) < 0.021
    assert abs((cell.angle - angle + 180) % 360 - 180) < 1.001
    assert cell.tones >= 65


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(
    ("angle", "lpi", "dpi"),
    [
        (45, 50, (203.0, 203.0)),
        (15, 85, (600.0, 600.0)),
        (75, 106, (600.0, 600.0)),
        (0, 30, (180.0, 180.0)),
        (45, 60, (600.0, 300.0)),
        (30, 25, (180.0, 203.0)),
    ],
)
def test_the_spectrum_of_a_patch_shows_ruling_and_angle(shape, angle, lpi, dpi):
    cell = find_supercell(angle, lpi, dpi)
    patch = clustered_ranks(shape, cell) < 0.7 * cell.pixels
    ruling, direction = peak(patch.astype(float), dpi)
    assert abs(ruling / lpi - 1) < 0.03
    assert abs((direction - angle + 45) % 90 - 45) < 1.5


@settings(max_examples=40)
@given(supercells(), shapes, st.floats(0, 1))
def test_all_cells_are_filled_alike(made, shape, share):
    """At every tone each cell has its share of dark pixels, within one."""
    cell, _, _ = made
    ranks = clustered_ranks(shape, cell)
    owner = oracle.owners(cell.along, cell.across, cell.n, *ranks.shape)
    assume((owner >= 0).all())  # floats cannot tell the owner of a pixel on a border
    repeats = ranks.size // cell.pixels
    size = np.bincount(owner.ravel(), minlength=cell.n**2) // repeats
    tone = int(share * cell.pixels)
    dark = np.bincount(owner[ranks >= tone], minlength=cell.n**2) // repeats
    wanted = size * (1 - tone / cell.pixels)
    assert (np.abs(dark - wanted) <= 1.01).all()


@pytest.mark.parametrize("shape", ["round", "euclidean", "diamond", "square", "ellipse"])
def test_dots_grow_from_the_middle(shape):
    """Light tones: one compact dark dot in the middle of each cell; dark tones: light holes."""
    cell = find_supercell(0, 1 / 16, (1.0, 1.0))
    assert (cell.n, cell.along, cell.across) == (1, (16, 0), (0, -16))
    ranks = clustered_ranks(shape, cell)
    y, x = np.nonzero(ranks >= 256 - 12)
    assert (abs(y - 7.5).max(), abs(x - 7.5).max()) <= (2.5, 2.5)
    dark = np.nonzero(ranks.ravel() < 12)[0]
    assert (np.minimum(dark % 16, 15 - dark % 16) <= 2).all()  # holes at the corners


def test_shapes_at_a_quarter():
    """A 16 × 16 cell, a quarter dark: its extent along both axes tells the shapes apart."""
    cell = find_supercell(0, 1 / 16, (1.0, 1.0))
    extent, spread = {}, {}
    for shape in SHAPES:
        y, x = np.nonzero(clustered_ranks(shape, cell) >= 192)
        extent[shape] = (int(np.ptp(x)) + 1, int(np.ptp(y)) + 1)
        spread[shape] = float(((x - 7.5) ** 2 + (y - 7.5) ** 2).sum())
    assert extent["square"] == (8, 8)
    assert extent["line"] == (16, 4)
    assert extent["cross"] == (16, 16)
    assert spread["round"] == spread["euclidean"] == min(spread.values())
    assert spread["round"] < spread["diamond"] < spread["cross"]
    assert spread["round"] < spread["square"] < spread["line"]
    assert extent["ellipse"][0] > extent["ellipse"][1]


def test_euclidean_is_its_own_negative_at_half():
    ranks = clustered_ranks("euclidean", find_supercell(0, 1 / 16, (1.0, 1.0)))
    half = ranks < 128
    assert (np.roll(half, (8, 8), (0, 1)) == ~half).mean() > 0.87  # but for the rim


def test_angles_are_counter_clockwise():
    """Lines at 30° rise to the right: their pixels repeat along (cos 30°, −sin 30°), y downwards."""
    cell = find_supercell(30, 1 / 12, (1.0, 1.0))
    assert cell.along[0] > 0 > cell.along[1]
    ranks = clustered_ranks("line", cell)
    dark = ranks >= cell.pixels * 0.7
    x, y = round(7 * math.cos(math.pi / 6)), -round(7 * math.sin(math.pi / 6))
    same = (np.roll(dark, (y, x), (0, 1)) == dark).mean()
    other = (np.roll(dark, (-y, x), (0, 1)) == dark).mean()
    assert same > 0.8
    assert other < 0.5


@given(
    ladders(), shapes, st.sampled_from(["45:6px", "0:8px", "18.4:5px", "45:60lpi:dpi=203"]), st.data()
)
def test_tones_are_exact_on_whole_tiles(levels, shape, rest, data):
    made = screened(f"screen:{shape}@{rest}")
    cell = made.supercell()
    distinct = np.unique(np.float32(levels)).astype(np.float64)
    i = data.draw(st.integers(0, distinct.size - 2))
    k = data.draw(st.integers(0, cell.pixels))
    light = np.float32(distinct[i] + (distinct[i + 1] - distinct[i]) * k / cell.pixels)
    assert made.claim.tones == cell.tones
    if distinct[i + 1] - distinct[i] > 1e-3:  # closer levels leave float32 no room for the tones
        shown = dither(np.full(cell.tile, light, np.float32), made, levels=levels)
        lit = shown.luminance.astype(np.float64) > distinct[i]
        assert lit.sum() * cell.pixels == k * lit.size


def test_supercells_have_more_tones_than_a_cell():
    assert screen_levels(480, 60) == 65  # 60 lines on 480 dots: 8 × 8 cells
    assert screen_levels(203, 60) == 10
    assert find_supercell(45, 60, (203.0, 203.0)).tones == 289
    assert find_supercell(45, 60, (203.0, 203.0), tones=400).tones >= 400


def test_rulings_of_a_device():
    rows = rulings(203)
    assert [row.lpi for row in rows] == [20, 25, 30, 40, 50, 60, 65, 75, 85, 100]
    for row in rows:
        assert row.pixels == pytest.approx((203 / row.lpi) ** 2)
        assert row.tones == round(203 / row.lpi) ** 2 + 1
        assert row.supercell_tones >= 65
        assert row.achieved_lpi == pytest.approx(row.lpi, rel=0.021)
        assert row.achieved_angle == pytest.approx(45, abs=1)
    assert rulings((600, 300), 15)[0].lpi == 30


def test_cells_are_dispersed():
    """The first dark pixels, one in each of half the cells, lie no two in cells that touch."""
    cell = Supercell((32, 0), (0, -32), 8, (1.0, 1.0))
    first = np.argwhere(clustered_ranks("round", cell) >= cell.pixels - 16) // 4
    apart = np.abs(first[:, None] - first)
    apart = np.minimum(apart, 8 - apart).sum(axis=2) + 99 * np.eye(16)
    assert apart.min() >= 2


TEXTS = (
    "screen:round@45:60lpi",
    "screen:line@-22.5:85lpi:dpi=600x300",
    "screen:diamond@0:8px",
    "screen:euclidean@15:12.5px:tones=200:dot=2x3",
    "screen:cross@45:10px:strength=0.5",
)


@pytest.mark.parametrize("text", TEXTS)
def test_text_form(text):
    made = screened(text)
    assert made.text() == text
    assert screened(made.text()) == made


def test_short_forms():
    assert screened("Screen:8px") == ClusteredDot(period=8)
    assert screened("screen:round:60lpi@15") == ClusteredDot(angle=15, lpi=60)
    assert screened("screen:40lpi:dpi=203:dot=2").text() == "screen:round@45:40lpi:dpi=203:dot=2x2"


def test_the_devices_dpi():
    made = screen("screen:round@45:60lpi")
    assert made.claim.tones == 65
    light = np.full((48, 48), 0.5, np.float32)
    with pytest.raises(UsageError, match="dpi=203"):
        dither(light, made)
    assert made.supercell((203, 203)) == screened("screen:60lpi:dpi=203").supercell()
    given_dpi = dither(light, "none", levels=2)
    assert given_dpi.shape == (48, 48)


def test_a_job_with_dpi():
    from halftone._arrays import Source
    from halftone.tone.levels import Levels

    light = np.linspace(0, 1, 60 * 70, dtype=np.float32).reshape(60, 70)
    out = np.empty((60, 70), np.uint8)
    job = Job(Source(light), Levels.of(2), (203.0, 203.0))
    screened("screen:diamond@45:60lpi").halftoner(job).band(0, 60, out)
    np.testing.assert_array_equal(out, dither(light, screened("screen:diamond@45:60lpi:dpi=203")))


def test_dots_of_two_pixels_keep_the_ruling():
    made = screened("screen:round@45:40lpi:dpi=203:dot=2")
    cell = made.supercell()
    assert abs(cell.lpi / 40 - 1) < 0.02
    tile = made.screen().thresholds
    patch = (tile < 0.7).astype(float)
    ruling, direction = peak(patch, (203, 203))
    assert abs(ruling / 40 - 1) < 0.03
    assert abs((direction - 45 + 45) % 90 - 45) < 1.5
    for dy, dx in ((0, 1), (1, 0), (1, 1)):
        np.testing.assert_array_equal(tile[dy::2, dx::2], tile[::2, ::2])


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        ("screen", "one of them"),
        ("screen:round@45", "one of them"),
        ("screen:8px:60lpi", "one of them"),
        ("screen:rund:8px", "unknown"),
        ("screen:round@x:8px", "not a number"),
        ("screen:round@999:60lpi", "angle"),
        ("screen:round@nan:60lpi", "angle"),
        ("screen:1px", "2 … 20"),
        ("screen:30px", "2 … 20"),
        ("screen:nanpx", "2 … 20"),
        ("screen:0lpi", "above 0"),
        ("screen:-5lpi:dpi=203", "above 0"),
        ("screen:inflpi", "above 0"),
        ("screen:150lpi:dpi=203", "10.15 … 101.5"),
        ("screen:9lpi:dpi=203", "10.15 … 101.5"),
        ("screen:60lpi:dpi=0", "dpi"),
        ("screen:60lpi:dpi=600x30", "dpi"),
        ("screen:8px:tones=1", "tones"),
        ("screen:8px:tones=x", "not a number"),
        ("screen:8px:dot=0", "dot"),
        ("screen:8px:dot=2.5", "not a number"),
        ("screen:8px:strength=2", "strength"),
        ("screen:8px:serpentine", "unknown"),
    ],
)
def test_bad_input(bad, message):
    with pytest.raises(UsageError, match=message):
        screened(bad)


def test_bad_calls():
    with pytest.raises(UsageError, match="round"):
        clustered_ranks("rond", find_supercell(0, 1 / 8, (1.0, 1.0)))
    with pytest.raises(UsageError, match="no supercell"):
        find_supercell(17.3, 1 / 19.3, (1.0, 1.0), tones=65, lpi_tolerance=1e-6, angle_tolerance=1e-6)
    with pytest.raises(UsageError, match="does not apply"):
        ClusteredDot(period=8).with_options(serpentine=True)


def test_the_screen_is_made_once():
    cell = find_supercell(45, 1 / 8, (1.0, 1.0))
    assert clustered("round", cell, "a") is clustered("round", cell, "a")
