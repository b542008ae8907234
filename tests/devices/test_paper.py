"""Simulated paper: cells, drawn dots, measured patches, and the eye from afar."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import halftone
from devices import eye
from devices import paper as module
from devices.paper import PATCH, Paper, at_distance, point_spread
from halftone.errors import HalftoneError, InputError, UsageError
from halftone.frame import Bands, Frame
from halftone.images.read import read_picture
from halftone.tone.dotgain import DotModel, neighbourhoods
from halftone.tone.levels import Levels
from halftone.tone.transfer import encoding
from tests.oracle import paper as twin

TWO = Levels.of([0.04, 0.9])
ROUND = DotModel(1.5, 1.5)
PULLED = ((0.04, 0.05), (0.3, 0.2), (0.6, 0.4), (0.9, 0.8))  # prints darker than predicted
LIFTED = ((0.04, 0.05), (0.3, 0.5), (0.6, 0.7), (0.9, 0.8))  # lighter than the straight line

indices = st.tuples(st.integers(1, 9), st.integers(1, 9), st.randoms(use_true_random=False)).map(
    lambda t: np.array([[t[2].randrange(2) for _ in range(t[1])] for _ in range(t[0])], np.uint8)
)
diameters = st.floats(0.1, 3).map(lambda d: round(d, 3))
dots = st.none() | st.builds(DotModel, diameters, diameters)
curves = st.sampled_from([None, PULLED, LIFTED])


def noise(rows: int, columns: int, share: float = 0.5) -> np.ndarray:
    return (np.random.default_rng(7).random((rows, columns)) > share).astype(np.uint8)


def banded(picture: np.ndarray, *heights: int) -> Bands:
    """*picture* as bands whose heights come round."""

    def parts():
        done = turn = 0
        while done < len(picture):
            rows = heights[turn % len(heights)]
            yield picture[done : done + rows]
            done, turn = done + rows, turn + 1

    return Bands(picture.shape, parts(), TWO)


def whole(paper: Paper, picture, scale: int) -> np.ndarray:
    return np.concatenate(list(paper.drawn(picture, scale)))


def cells(samples: np.ndarray, scale: int) -> np.ndarray:
    """Mean of every cell's samples."""
    rows, columns = samples.shape
    return samples.astype(np.float64).reshape(rows // scale, scale, columns // scale, scale).mean((1, 3))


@given(indices, dots)
def test_a_cell_has_the_light_of_the_dot_model(picture, dot):
    ink = (picture == 0).astype(np.uint8)
    area = ink if dot is None else dot.covered(ink)
    got = Paper(TWO, dot).seen(picture)
    assert got.dtype == np.float32
    assert got.shape == picture.shape
    np.testing.assert_allclose(got, 0.04 * area + 0.9 * (1.0 - area), atol=1e-6)


@settings(deadline=None, max_examples=30)
@given(indices, dots, curves, st.sampled_from([1, 2, 3, 8]))
def test_drawn_samples_have_the_mean_of_the_cell(picture, dot, measured, scale):
    paper = Paper(TWO, dot, measured)
    drawn = whole(paper, picture, scale)
    assert drawn.dtype == np.float32
    assert drawn.shape == (picture.shape[0] * scale, picture.shape[1] * scale)
    low, high = (0.04, 0.9) if measured is None else (0.05, 0.8)
    assert drawn.min() >= low - 1e-6
    assert drawn.max() <= high + 1e-6
    np.testing.assert_allclose(cells(drawn, scale), paper.seen(picture), atol=1e-4)


@settings(deadline=None, max_examples=15)
@given(
    st.lists(st.lists(st.integers(0, 1), min_size=3, max_size=3), min_size=1, max_size=3),
    diameters,
    diameters,
    st.sampled_from([1, 2, 3]),
)
def test_samples_are_areas_of_ellipses(rows, across, down, scale):
    picture = np.array(rows, np.uint8)
    points = 24 // scale
    expected = twin.drawn(1 - picture, (0.0, 1.0), (across, down), scale, points)
    got = whole(Paper(2, DotModel(across, down)), picture, scale)
    np.testing.assert_allclose(got, expected, atol=2.5 / points)
    # Errors of counted points cancel over a picture, which errors of ours would not.
    assert got.mean() == pytest.approx(np.mean(expected), abs=0.25 / points)


@pytest.mark.parametrize("diameter", [2**0.5, 1.25 * 2**0.5])
@pytest.mark.parametrize("scale", [4, 8])
def test_the_figures_of_pappas_and_neuhoff(diameter, scale):
    """A lone dot covers π·d²/4 in all; beside it a cell loses α, at a corner β (their table)."""
    alpha, beta = {2**0.5: (0.1427, 0.0)}.get(diameter, (0.3342, 0.0294))
    picture = np.ones((5, 5), np.uint8)
    picture[2, 2] = 0
    shares = 1 - cells(whole(Paper(2, DotModel(diameter, diameter)), picture, scale), scale)
    assert shares.sum() == pytest.approx(np.pi * diameter**2 / 4, abs=1e-4)
    np.testing.assert_allclose(shares[2, [1, 3]], alpha, atol=1e-4)
    np.testing.assert_allclose(shares[1:4:2, 1:4:2], beta, atol=1e-4)


def test_rows_gain_apart_from_columns():
    picture = np.ones((3, 3), np.uint8)
    picture[1, 1] = 0
    paper = Paper(2, DotModel(1.6, 0.8))
    share = 1 - paper.seen(picture)
    assert share.sum() == pytest.approx(np.pi / 4 * 1.6 * 0.8, abs=1e-5)
    assert share[1, 0] > 0.05
    assert share[0, 1] == 0
    np.testing.assert_array_equal(whole(paper, picture, 9)[:9], 1)
    turned = Paper(2, DotModel(0.8, 1.6))
    np.testing.assert_allclose(whole(turned, picture, 9), whole(paper, picture, 9).T, atol=1e-3)


@pytest.mark.parametrize("measured", [None, PULLED, LIFTED])
@pytest.mark.parametrize("dot", [None, DotModel(2**0.5, 2**0.5), DotModel(1.5, 2.0)])
def test_paper_stays_paper_and_solid_ink_is_ink(dot, measured):
    paper = Paper(TWO, dot, measured)
    low, high = (0.04, 0.9) if measured is None else (0.05, 0.8)
    picture = np.ones((40, 12), np.uint8)
    np.testing.assert_allclose(paper.seen(picture), high, atol=1e-6)
    np.testing.assert_allclose(whole(paper, picture, 3), high, atol=1e-6)
    picture[:] = 0
    np.testing.assert_allclose(paper.seen(picture)[1:-1, 1:-1], low, atol=1e-3)
    np.testing.assert_allclose(whole(paper, picture, 3)[3:-3, 3:-3], low, atol=1e-3)


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (7, 1), (2, 3)])
@pytest.mark.parametrize("measured", [None, PULLED])
def test_the_smallest_pictures(shape, measured):
    picture = np.zeros(shape, np.uint8)
    paper = Paper(TWO, ROUND, measured)
    assert paper.seen(picture).shape == shape
    assert whole(paper, picture, 5).shape == (shape[0] * 5, shape[1] * 5)
    assert at_distance(paper.seen(picture), 203, 12).shape == shape


def test_a_square_dot_is_the_frame():
    picture = noise(5, 6)
    np.testing.assert_array_equal(Paper(TWO, None).seen(picture), Frame(picture, TWO).luminance)
    drawn = whole(Paper(TWO, None), Frame(picture, TWO), 3)
    np.testing.assert_array_equal(drawn, Frame(picture, TWO).upscaled(3).luminance)


@settings(deadline=None, max_examples=40)
@given(st.lists(st.integers(1, 30), min_size=1, max_size=4), curves, st.integers(1, 60))
def test_bands_are_the_whole(heights, measured, rows):
    picture = noise(rows, 23)
    paper = Paper(TWO, ROUND, measured)
    seen = np.concatenate(list(paper.seen(banded(picture, *heights))))
    np.testing.assert_array_equal(seen, paper.seen(picture))
    drawn = whole(paper, banded(picture, *heights), 2)
    np.testing.assert_array_equal(drawn, whole(paper, Frame(picture, TWO), 2))


def test_pieces_are_the_whole(monkeypatch):
    picture = noise(50, 23)
    paper = Paper(TWO, ROUND, PULLED)
    seen, drawn = paper.seen(picture), whole(paper, picture, 2)
    monkeypatch.setattr(module, "PIECE", 23 * 4 * 3)
    parts = list(paper.drawn(picture, 2))
    assert max(len(part) for part in parts) <= 2 * (3 + PATCH + 1)
    np.testing.assert_array_equal(np.concatenate(parts), drawn)
    np.testing.assert_array_equal(paper.seen(picture), seen)


def test_a_band_comes_before_the_last_is_asked_for():
    """What is held of the bands is a row of look-ahead, not the page."""
    asked = []

    def parts():
        for k in range(100):
            asked.append(k)
            yield noise(4, 8)

    drawn = Paper(TWO, ROUND).drawn(Bands((400, 8), parts(), TWO), 2)
    for k in range(1, 50):
        next(drawn)
        assert len(asked) <= k + 1


@pytest.mark.parametrize("measured", [PULLED, LIFTED])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.8])
def test_a_flat_patch_has_the_measured_luminance(share, measured):
    bayer = halftone.dither(np.full((96, 96), 1 - share, np.float32), "bayer4").indices
    predicted = Paper(TWO, ROUND).seen(bayer)[24:72, 24:72].mean()
    got = Paper(TWO, ROUND, measured).seen(bayer)[24:72, 24:72].mean()
    assert got == pytest.approx(np.interp(predicted, *np.array(measured).T), abs=2e-3)


def test_patches_of_measured_paper_are_those_of_the_twin():
    picture = noise(25, 21)
    areas = ROUND.covered((picture == 0).astype(np.uint8))
    codes = neighbourhoods(np.pad((picture == 0).astype(np.uint16), 1))
    got = module._patch_means(ROUND.table.astype(np.float64), codes, 3, 25)
    for row, column in [(3, 0), (11, 10), (24, 20), (16, 7)]:
        expected = twin.patch_mean(areas.tolist(), row, column, PATCH)
        assert got[row - 3, column] == pytest.approx(expected, abs=1e-8)


def test_the_point_spread_of_the_twin():
    got = point_spread((203.2, 180), 12)
    assert got.shape[0] % 2 == got.shape[1] % 2 == 1
    assert got.min() > 0
    assert got.sum() == pytest.approx(1)
    np.testing.assert_allclose(got, twin.point_spread((203.2, 180), 12, *got.shape), rtol=1e-9)


@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (30, 4), (1, 9)])
def test_at_a_distance_is_the_sum_of_the_twin(shape, monkeypatch):
    monkeypatch.setattr(eye, "PIECE", 12 * shape[1])
    light = np.random.default_rng(1).random(shape, np.float32)
    expected = twin.blurred(light.tolist(), point_spread((60, 40), 9).tolist())
    got = at_distance(light, (60, 40), 9)
    assert got.dtype == np.float32
    assert got.shape == shape
    np.testing.assert_allclose(got, expected, atol=2e-6)


def test_from_afar_dots_melt_into_gray():
    picture = np.indices((96, 96)).sum(0).astype(np.uint8) % 2
    light = Paper(2, None).seen(picture)
    near, far = (at_distance(light, 203, inches).std() for inches in (4, 40))
    assert near > 10 * far
    assert far < 1e-3
    np.testing.assert_allclose(at_distance(np.full((9, 9), 0.3, np.float32), 203, 20), 0.3, atol=1e-6)


@pytest.mark.parametrize("distance", [None, 12])
def test_a_saved_picture_shows_the_light_in_srgb(tmp_path, distance, monkeypatch):
    monkeypatch.setattr(module, "PIECE", 4000)
    paper, picture = Paper(TWO, ROUND), noise(60, 20)
    frame = Frame(picture, TWO, dpi=(203, 180))
    paper.save(tmp_path / "a.png", frame, 3, distance)
    read = read_picture(str(tmp_path / "a.png"), 1 << 30)
    light = whole(paper, frame, 3)
    if distance is not None:
        light = at_distance(light, (609, 540), distance)
    expected = encoding("srgb").encode(light) * 255
    np.testing.assert_allclose(read.pixels[:].reshape(light.shape), expected, atol=0.6)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: Paper(4, ROUND), "4 levels"),
        (lambda: Paper([0.9, 0.1], ROUND), "fall"),
        (lambda: Paper([0.5, 0.5], ROUND), "same|all levels"),
        (lambda: Paper(2, ROUND, [(0, 0)]), "two or more pairs"),
        (lambda: Paper(2, ROUND, [(0, 0), (1, np.nan)]), "two or more pairs"),
        (lambda: Paper(2, ROUND, "dark"), "two or more pairs"),
        (lambda: Paper(2, ROUND, [(0, 0.1), (0.5, 0.4), (1, 0.3)]), "must rise"),
        (lambda: Paper(2, ROUND, [(0, 0.1), (0, 0.4)]), "must rise"),
        (lambda: Paper(2, ROUND, [(0, 0.3), (1, 0.3)]), "both measured"),
        (lambda: Paper(2, ROUND).drawn(noise(2, 2), 0), "scale=0"),
        (lambda: Paper(2, ROUND).drawn(noise(2, 2), 33), "scale=33"),
        (lambda: Paper(2, ROUND).drawn(noise(2, 2), 1.5), "scale=1.5"),
        (lambda: Paper(2, ROUND).seen(Frame(noise(2, 2), Levels.of(4))), "picture of 4 levels"),
        (lambda: Paper(2, ROUND).drawn(Frame(noise(2, 2), Levels.of(4)), 2), "picture of 4 levels"),
        (lambda: Paper(2, ROUND).save("x.png", Frame(noise(2, 2), TWO), 2, 12), "without dpi"),
        (lambda: point_spread(0, 12), "allowed: above 0"),
        (lambda: point_spread(203, float("nan")), "allowed: above 0"),
        (lambda: point_spread(203, "near"), "allowed: above 0"),
        (lambda: point_spread(203, 1e9), "fewer samples"),
    ],
)
def test_refused(call, said):
    with pytest.raises(UsageError, match=said):
        call()


@pytest.mark.parametrize(
    "picture", [np.full((2, 2), 2, np.uint8), np.zeros((0, 4), np.uint8), np.zeros((2, 2)), np.zeros(4)]
)
def test_refused_pictures(picture):
    with pytest.raises(InputError, match="ink"):
        Paper(2, ROUND).seen(picture)
    with pytest.raises(HalftoneError):
        list(Paper(2, ROUND).drawn(picture, 2))
    with pytest.raises(InputError, match="light of shape"):
        at_distance(np.zeros((0, 4), np.float32), 203, 12)
