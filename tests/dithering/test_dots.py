"""Dot diffusion against its slow twin; class matrices; tone, conservation, bands and workers."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halftone import UsageError, dither
from halftone._arrays import Source
from halftone.dithering.base import Job
from halftone.dithering.classes import CLASSES, ClassMatrix, classes, load_classes
from halftone.dithering.dots import DotDiffusion
from halftone.dithering.evolve import Evolution, FlatTones, evolve, main, score
from halftone.tone.levels import Levels
from tests.oracle import dots as oracle
from tests.strategies import ladders, light

KNUTH = [
    [34, 48, 40, 32, 29, 15, 23, 31],
    [42, 58, 56, 53, 21, 5, 7, 10],
    [50, 62, 61, 45, 13, 1, 2, 18],
    [38, 46, 54, 37, 25, 17, 9, 26],
    [28, 14, 22, 30, 35, 49, 41, 33],
    [20, 4, 6, 11, 43, 59, 57, 52],
    [12, 0, 3, 19, 51, 63, 60, 44],
    [24, 16, 8, 27, 39, 47, 55, 36],
]


@pytest.fixture
def eye():
    """The 7 × 7 eye filter trained by least mean squares, of Guo & Liu's papers."""
    return np.array(
        [
            [
                -0.001743412,
                0.001445723,
                0.007113962,
                0.008826460,
                0.006254165,
                -0.000353216,
                -0.003116813,
            ],
            [0.000833244, 0.009929635, 0.023728512, 0.029311034, 0.022933593, 0.009711988, 0.000118289],
            [0.005842017, 0.023691596, 0.048267152, 0.059043883, 0.046412889, 0.023315857, 0.005651780],
            [0.009138026, 0.032894130, 0.064200407, 0.078773930, 0.060303292, 0.029523382, 0.007565880],
            [0.007942508, 0.028669495, 0.053826022, 0.065024427, 0.050496807, 0.023933323, 0.005585837],
            [0.002404652, 0.014542416, 0.029730907, 0.035492112, 0.027318902, 0.011351292, 0.001239805],
            [
                -0.001666554,
                0.002380156,
                0.009867343,
                0.012292728,
                0.009216210,
                0.002268413,
                -0.001534185,
            ],
        ]
    )


@st.composite
def matrices(draw: st.DrawFn) -> ClassMatrix:
    """A class matrix that ships, or any permutation of 1 × 1 … 9 × 9."""
    if draw(st.booleans()):
        return classes(draw(st.sampled_from(CLASSES)))
    h, w = draw(st.integers(1, 9)), draw(st.integers(1, 9))
    order = np.random.default_rng(draw(st.integers(0, 2**32 - 1))).permutation(h * w)
    return ClassMatrix(order.reshape(h, w), "own")


def twin(picture, levels, matrix, strength=1.0):
    return oracle.diffuse(picture, np.float32(levels), matrix.classes.tolist(), strength)[0]


@given(light(), ladders(), matrices(), st.sampled_from([1, 0.7, 0]))
def test_kernel_equals_its_twin(picture, levels, matrix, strength):
    clipped = np.clip(picture, np.float32(levels[0]), np.float32(levels[-1]))
    frame = dither(picture, DotDiffusion(matrix, strength), levels=levels)
    np.testing.assert_array_equal(frame, twin(clipped, levels, matrix, strength))


@settings(max_examples=5)
@given(st.sampled_from(CLASSES), st.integers(0, 2**32 - 1), st.sampled_from([2, 256]))
def test_larger_than_the_tile_and_the_band(name, seed, levels):
    picture = np.random.default_rng(seed).random((150, 70), np.float32)
    expected = twin(picture, Levels.of(levels).luminance, classes(name))
    np.testing.assert_array_equal(dither(picture, DotDiffusion(name), levels=levels), expected)


@given(st.integers(0, 2**32 - 1), ladders(), matrices(), st.sampled_from([1, 0.7]))
def test_kernels_of_codes_equal_the_twin(seed, levels, matrix, strength):
    random = np.random.default_rng(seed)
    codes = random.integers(0, 256, random.integers(1, 41, 2), np.uint8)
    ladder = Levels.of(levels)
    table = np.clip(np.linspace(0, 1, 256, dtype=np.float32), ladder.darkest, ladder.lightest)
    method = DotDiffusion(matrix, strength)
    expected = twin(table[codes], levels, matrix, strength)
    for source in (Source(codes, table), Source(table[codes])):
        out = np.full(codes.shape, 99, np.uint8)
        method.halftoner(Job(source, ladder)).band(0, len(codes), out)
        np.testing.assert_array_equal(out, expected)


@pytest.mark.parametrize("levels", [2, 5])
def test_a_wide_picture(levels):
    picture = np.random.default_rng(4).random((2, 33001), np.float32)
    expected = twin(picture, Levels.of(levels).luminance, classes("knuth"))
    np.testing.assert_array_equal(dither(picture, DotDiffusion("knuth"), levels=levels), expected)


def test_codes_equal_their_light(camera):
    codes = camera[:100, :90]
    table = (np.arange(256) / 255).astype(np.float32)
    by_code = dither(codes, DotDiffusion("knuth"), encoding="linear", levels=3)
    np.testing.assert_array_equal(by_code, dither(table[codes], DotDiffusion("knuth"), levels=3))


@given(light(), ladders(), matrices(), st.lists(st.integers(1, 17), min_size=1), st.randoms())
def test_bands_of_any_height_in_any_order(picture, levels, matrix, heights, random):
    ladder = Levels.of(levels)
    clipped = np.clip(picture, np.float32(ladder.darkest), np.float32(ladder.lightest))
    method = DotDiffusion(matrix)
    whole = dither(clipped, method, levels=levels)
    halftoner = method.halftoner(Job(Source(clipped), ladder))
    assert halftoner.parallel
    bands, start = [], 0
    while start < len(clipped):
        bands.append((start, min(start + heights[len(bands) % len(heights)], len(clipped))))
        start = bands[-1][1]
    random.shuffle(bands)
    out = np.full(clipped.shape, 99, np.uint8)
    for start, stop in bands:
        halftoner.band(start, stop, out[start:stop])
    np.testing.assert_array_equal(out, whole)


@pytest.mark.parametrize("name", CLASSES)
@pytest.mark.parametrize("workers", [2, 3])
def test_workers_do_not_change_the_picture(name, workers, camera):
    one = dither(camera, DotDiffusion(name), levels=4)
    np.testing.assert_array_equal(dither(camera, DotDiffusion(name), levels=4, workers=workers), one)


@given(light(), matrices())
def test_nothing_is_lost_but_at_barons(picture, matrix):
    """Light = what is shown + what those kept who had nobody to give to."""
    shown, kept = oracle.diffuse(picture, np.float32([0, 1]), matrix.classes.tolist())
    frame = dither(picture, DotDiffusion(matrix))
    total = frame.indices.sum(dtype=np.float64) + kept.sum(dtype=np.float64)
    assert abs(picture.sum(dtype=np.float64) - total) < 1e-4
    assert (shown == frame.indices).all()


def test_who_gives_what_by_hand():
    """Classes 0 1 / 2 3 in a picture of 2 × 2: 0.4 → 0 gives 2 : 2 : 1 of 0.4."""
    matrix = ClassMatrix([[0, 1], [2, 3]], "own")
    # class 1: 0.4 + 0.16 = 0.56 → 1, error −0.44: 1 part to class 2, 2 parts to class 3
    # class 2: 0.4 + 0.16 − 0.1467 = 0.4133 → 0, all to class 3
    # class 3: 0.4 + 0.08 − 0.2933 + 0.4133 = 0.6 → 1
    assert dither(np.full((2, 2), 0.4), DotDiffusion(matrix)).indices.tolist() == [[0, 1], [0, 1]]


def test_knuth_as_printed():
    knuth = classes("knuth")
    assert knuth.classes.tolist() == KNUTH
    assert knuth.barons == (62, 63)


def test_mese_and_vaidyanathan():
    assert classes("mese8").barons == (46, 54, 59, 60, 62, 63)
    assert classes("mese16").barons == (255,)
    assert classes("mese16").classes[0].tolist() == [
        207, 0, 13, 17, 28, 55, 18, 102, 81, 97, 74, 144, 149, 169, 170, 172
    ]  # fmt: skip


def reach_by_hand(matrix):
    """Longest chains by recursion over the highest classes first."""
    h, w = matrix.classes.shape
    down, up = {}, {}
    places = [(y, x) for y in range(h) for x in range(w)]
    for y, x in sorted(places, key=lambda p: -int(matrix.classes[p])):
        down[y, x] = up[y, x] = 0
        for dy, dx in oracle.AROUND:
            q = (y + dy) % h, (x + dx) % w
            if matrix.classes[q] > matrix.classes[y, x]:
                down[y, x] = max(down[y, x], dy + down[q])
                up[y, x] = max(up[y, x], -dy + up[q])
    return [[d[y, x] for y in range(h) for x in range(w)] for d in (down, up)]


@given(matrices())
def test_reach(matrix):
    assert [r.ravel().tolist() for r in matrix.reach()] == reach_by_hand(matrix)


@given(ladders(), matrices(), st.tuples(st.integers(1, 24), st.integers(1, 24)))
def test_a_constant_picture_at_a_level_is_that_level(levels, matrix, shape):
    values = np.float32(levels)
    for value in np.unique(values):
        frame = dither(np.full(shape, value), DotDiffusion(matrix), levels=levels)
        assert (frame.indices == np.flatnonzero(values == value)[0]).all()


@given(light(), matrices())
def test_bilevel_pictures_pass_untouched(picture, matrix):
    mask = np.where(picture > 0.5, np.float32(1), np.float32(0))
    np.testing.assert_array_equal(dither(mask, DotDiffusion(matrix)), mask)


@pytest.mark.parametrize("name", ["knuth", CLASSES[-1]])
@pytest.mark.parametrize("shape", [(1, 1), (1, 700), (700, 1), (2, 2)])
def test_narrow_pictures(name, shape):
    ramp = np.linspace(0, 1, shape[0] * shape[1], dtype=np.float32).reshape(shape)
    expected = twin(ramp, [0, 1], classes(name))
    np.testing.assert_array_equal(dither(ramp, DotDiffusion(name), levels=[0, 1]), expected)


@pytest.mark.parametrize("name", CLASSES)
@pytest.mark.parametrize("shape", [(3, 65_000), (1, 65_000), (65_000, 1)])
def test_very_long_pictures(name, shape):
    ramp = np.linspace(0, 1, shape[0] * shape[1], dtype=np.float32).reshape(shape)
    shown = dither(ramp, DotDiffusion(name)).indices
    assert shown.shape == shape
    assert abs(shown.mean() - 0.5) < 0.01
    assert shown[0, 0] == 0
    assert shown[-1, -1] == 1


@pytest.mark.parametrize("name", CLASSES)
def test_claims_at_256_tones(name):
    method = DotDiffusion(name)
    tones = np.arange(256) / 255
    shown = [dither(np.full((192, 192), t, np.float32), method).indices.mean() for t in tones]
    worst = np.abs(shown - tones).max()
    if method.claim.kind == "exact":
        assert worst <= 0.5 / 255
    else:
        assert method.claim.kind == "tones"
        assert 0.5 / 255 < worst <= 0.5 / (method.claim.tones - 1)
    assert str(DotDiffusion(name, 0.5).claim) == "none"


@settings(max_examples=60)
@given(st.sampled_from(CLASSES), ladders(), st.floats(0, 1))
def test_claims_on_measured_ladders(name, levels, share):
    claim = DotDiffusion(name).claim
    values = np.unique(np.float32(levels))
    span = float(values[-1]) - float(values[0])
    tone = np.clip(np.float32(values[0] + share * span), values[0], values[-1])
    frame = dither(np.full((192, 192), tone), DotDiffusion(name), levels=levels)
    largest = np.diff(values.astype(np.float64)).max()
    allowed = 0.5 / 255 * span if claim.kind == "exact" else largest / (claim.tones - 1) / 2
    # float32 light rounds each luminance by 6e-8, which counts where levels are 1e-6 apart.
    assert abs(frame.luminance.mean(dtype=np.float64) - float(tone)) <= allowed + 1.2e-7


def test_text_and_strength():
    assert DotDiffusion("KNUTH").text() == "dots:knuth"
    assert DotDiffusion("mese16", 0.8).text() == "dots:mese16:strength=0.8"
    assert DotDiffusion("mese16").with_options(strength=0.8) == DotDiffusion("mese16", 0.8)
    with pytest.raises(UsageError, match="strength"):
        DotDiffusion("knuth", 1.5)
    with pytest.raises(UsageError, match="ClassMatrix"):
        DotDiffusion(np.arange(4).reshape(2, 2))
    with pytest.raises(UsageError, match="seed"):
        DotDiffusion("knuth").with_options(seed=3)


def test_strength_zero_is_the_nearest_level(camera):
    nearest = camera > 127
    np.testing.assert_array_equal(
        dither(camera, DotDiffusion("knuth", 0.0), encoding="linear").indices, nearest
    )


def test_flat_tones_are_those_of_the_picture():
    """The middle of a large picture repeats the tile that FlatTones computes."""
    knuth = classes("knuth")
    judge = FlatTones(8, 1.4)
    visible, peaks = judge.measure(knuth.classes.ravel().astype(float))
    for t in (0, 28, 60, 123):
        tone = np.float32((t + 4) / 255)
        tile = dither(np.full((72, 72), tone), DotDiffusion(knuth)).indices[32:40, 32:40]
        np.testing.assert_array_equal(judge.lit[:, t].reshape(8, 8), tile)
        power = np.abs(np.fft.fft2(tile - float(tone))) ** 2 / 64
        f = np.fft.fftfreq(8)
        eye = np.exp(-4 * (np.pi * 1.4) ** 2 * np.add.outer(f**2, f**2))
        assert visible[t] == pytest.approx((power * eye).sum() / 64, rel=1e-4)
        power[0, 0] = 0
        assert peaks[t] == pytest.approx(power.max() * 256 / (tone * (1 - tone)), rel=1e-4)


def test_evolution_repeats_and_improves():
    plan = Evolution(side=16, turns=25, peak=2000.0)
    start, end = evolve(Evolution(side=16, turns=0, peak=2000.0)), evolve(plan)
    assert evolve(plan) == end
    assert end != start
    judge = FlatTones(16, plan.eye)
    scores = [score(judge, m.classes.ravel().astype(float), 2000.0) for m in (start, end)]
    assert scores[1] > scores[0]


def test_evolution_as_a_command(tmp_path):
    path = tmp_path / "own.csv"
    main([str(path), "--side", "8", "--turns", "3", "--seed", "5"])
    assert load_classes(path) == evolve(Evolution(side=8, turns=3, seed=5))
    for wrong in ("48", "0", "256"):
        with pytest.raises(SystemExit, match="2"):
            main([str(path), "--side", wrong])
    for wrong in ({"side": 48}, {"jitter": 0.0}, {"peak": float("nan")}, {"turns": -1}):
        with pytest.raises(UsageError, match=next(iter(wrong))):
            Evolution(**wrong)


def test_our_matrix():
    """The matrix that ships; to be changed knowingly, with the figures measured anew."""
    own = classes("64")
    assert own.classes.shape == (64, 64)
    assert hashlib.sha256(own.classes.astype("<u2").tobytes()).hexdigest()[:16] == "39a054ad3516375d"
    assert len(own.barons) <= 8


def test_our_matrix_as_a_photograph(camera, eye):
    """Quality seen through the eye's filter; Mese and Vaidyanathan's 16 × 16 as the measure."""
    assert hpsnr(camera, "64", eye) >= 34.5
    assert 33.7 <= hpsnr(camera, "mese16", eye) <= 33.9  # as published for comparison
    assert 29.2 <= hpsnr(camera, "knuth", eye) <= 29.4


def hpsnr(codes, name, eye):
    """dB of the error after correlation with *eye*, the picture reflected about its border pixels."""
    error = dither(codes, DotDiffusion(name), encoding="linear").indices - codes / 255
    padded = np.pad(error, 3, mode="reflect")
    seen = np.lib.stride_tricks.sliding_window_view(padded, (7, 7))
    return -10 * np.log10(np.mean(np.einsum("yxij,ij->yx", seen, eye) ** 2))


def test_our_matrix_has_no_texture_that_stands_out():
    method, worst = DotDiffusion("64"), 0.0
    for k in range(4, 252):
        shown = dither(np.full((512, 512), k, np.uint8), method, encoding="linear").indices
        windows = shown.reshape(4, 128, 4, 128).swapaxes(1, 2).astype(np.float64)
        windows -= windows.mean(axis=(2, 3), keepdims=True)
        power = (np.abs(np.fft.rfft2(windows)) ** 2).mean(axis=(0, 1)) / 128**2
        worst = max(worst, power.max() / (k / 255 * (1 - k / 255)))
    assert worst < 100


def test_a_tile_need_not_be_square():
    picture = np.random.default_rng(1).random((20, 30), np.float32)
    matrix = ClassMatrix(np.random.default_rng(2).permutation(21).reshape(3, 7), "own")
    np.testing.assert_array_equal(
        dither(picture, DotDiffusion(matrix), levels=[0, 1]), twin(picture, [0, 1], matrix)
    )
