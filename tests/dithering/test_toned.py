"""Tone-dependent error diffusion, modulation, the warm start and the Hilbert curve."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import halftone.stages
from halftone import ErrorDiffusion, UsageError, dither, method
from halftone._arrays import Source
from halftone.dithering import FILTERS
from halftone.dithering.base import Job
from halftone.dithering.curve import Riemersma, hilbert
from halftone.dithering.modulation import Decisions, Modulation
from halftone.dithering.toned import PLACES, ToneDiffusion, tone_table
from halftone.tone import encoding as find_encoding
from halftone.tone.levels import Levels
from tests.oracle import point
from tests.oracle import toned as oracle
from tests.strategies import ladders, light


@given(
    light(-0.1, 1.1),
    ladders(),
    st.sampled_from(["ostromoukhov", "zhou-fang"]),
    st.booleans(),
    st.booleans(),
    st.sampled_from([0.0, 0.5, -2.0, 10.0]),
    st.integers(0, 99),
)
def test_tone_diffusion_equals_its_twin(picture, levels, name, serpentine, right, edges, seed):
    seed = seed if name == "zhou-fang" else 0
    weights, width = tone_table(name)
    made = ToneDiffusion(name, serpentine, from_right=right, edges=edges, seed=seed)
    expected = oracle.diffuse_toned(
        picture, levels, list(PLACES), weights.astype(np.float32), serpentine, right,
        width.astype(np.float32) if width.any() else 0.0, edges, seed,
    )  # fmt: skip
    np.testing.assert_array_equal(dither(picture, made, levels=levels), expected)


@given(
    light(),
    ladders(),
    st.sampled_from(sorted(FILTERS)),
    st.sampled_from([0.0, 0.3, 1.0]),
    st.sampled_from([0.0, 0.7, -3.0]),
    st.booleans(),
)
def test_modulated_filters_equal_their_twin(picture, levels, name, noise, edges, serpentine):
    table = FILTERS[name]
    weights = [[np.float32(w / table.divisor) for _, _, w in table.taps]] * 256
    places = [(dy, dx) for dy, dx, _ in table.taps]
    made = ErrorDiffusion(name, serpentine, noise=noise, edges=edges)
    expected = oracle.diffuse_toned(picture, levels, places, weights, serpentine, False, noise, edges)
    if noise or edges:
        np.testing.assert_array_equal(dither(picture, made, levels=levels), expected)
    else:
        np.testing.assert_array_equal(
            dither(picture, name + (":raster" * (not serpentine)), levels=levels), expected
        )


@given(
    st.integers(0, 2**32 - 1),
    st.one_of(ladders(), st.sampled_from([2, 3, 16, 256])),
    st.sampled_from(["ostromoukhov", "zhou-fang"]),
    st.booleans(),
    st.booleans(),
    st.sampled_from([0.0, 0.5, -2.0, 10.0]),
    st.sampled_from([1.0, 0.75, 0.0]),
    st.sampled_from(["srgb", "linear"]),
)
def test_tone_diffusion_of_codes_equals_its_twin(
    random, levels, name, serpentine, right, edges, strength, encoding
):
    """8-bit codes have a kernel of their own; it gives what their light gives."""
    codes = any_codes(random)
    made = ToneDiffusion(name, serpentine, strength, right, edges=edges)
    table = find_encoding(encoding).table(256)
    weights, width = tone_table(name)
    ladder = Levels.of(levels)
    expected = oracle.diffuse_toned(
        table[codes], ladder.luminance, list(PLACES), (weights * strength).astype(np.float32),
        serpentine, right, width.astype(np.float32) if width.any() else 0.0, edges, 0,
    )  # fmt: skip
    by_code = dither(codes, made, levels=ladder, encoding=encoding)
    np.testing.assert_array_equal(by_code, expected)
    np.testing.assert_array_equal(dither(table[codes], made, levels=ladder), expected)


def any_codes(seed: int) -> np.ndarray:
    """A picture of 1 × 1 … 40 × 40: noise, a ramp or one tone with a little noise."""
    random = np.random.default_rng(seed)
    shape = random.integers(1, 41, 2)
    ramp = np.linspace(0, 255, shape[0] * shape[1]).reshape(shape)
    kinds = [
        random.integers(0, 256, shape),
        ramp,
        random.integers(0, 254) + random.integers(0, 3, shape),
    ]
    return kinds[random.integers(3)].astype(np.uint8)


@pytest.mark.parametrize(("name", "levels"), [("ostromoukhov", 2), ("zhou-fang", 5)])
@pytest.mark.parametrize("right", [False, True])
def test_tone_diffusion_of_wide_codes(name, levels, right):
    codes = np.random.default_rng(3).integers(0, 256, (3, 33000), np.uint8)
    table = find_encoding("srgb").table(256)
    weights, width = tone_table(name)
    expected = oracle.diffuse_toned(
        table[codes], Levels.of(levels).luminance, list(PLACES), weights.astype(np.float32), True, right,
        width.astype(np.float32) if width.any() else 0.0,
    )  # fmt: skip
    made = ToneDiffusion(name, from_right=right)
    np.testing.assert_array_equal(dither(codes, made, levels=levels), expected)
    np.testing.assert_array_equal(dither(table[codes], made, levels=levels), expected)


@given(st.integers(0, 2**32 - 1), ladders(), st.lists(st.integers(1, 17), min_size=1), st.booleans())
def test_bands_of_codes(seed, levels, heights, serpentine):
    """Bands of any height give the whole, of codes and of light."""
    codes = any_codes(seed)
    ladder = Levels.of(levels)
    table = np.clip(find_encoding("srgb").table(256), ladder.darkest, ladder.lightest)
    made = ToneDiffusion("zhou-fang", serpentine, seed=seed)
    whole = dither(codes, made, levels=levels)
    for source in (Source(codes, table), Source(table[codes])):
        halftoner = made.halftoner(Job(source, ladder))
        out = np.full(codes.shape, 99, np.uint8)
        start = number = 0
        while start < len(codes):
            stop = min(start + heights[number % len(heights)], len(codes))
            halftoner.band(start, stop, out[start:stop])
            start, number = stop, number + 1
        np.testing.assert_array_equal(out, whole)


@given(light(-0.1, 1.1), ladders(), st.sampled_from([0.0, 0.4, 1.0]), st.sampled_from([0.0, 3.0, -10.0]))
def test_decisions_equal_their_twin(picture, levels, noise, edges):
    ladder = Levels.of(levels)
    made = Decisions(ladder, Modulation(noise, edges, 5))
    random = made.noise(3, 3 + picture.shape[0], picture.shape[1])
    found = made.band(picture, random)
    for (y, x), v in np.ndenumerate(picture):
        r = point.noise(5, 3 + y, x)
        if noise:
            assert random[y, x] == np.float32(r)
        low, tone, threshold = oracle.decision(v, ladder.distinct, noise, edges, r)
        assert (found[0][y, x], found[1][y, x]) == (low, tone)
        if noise or edges:
            assert found[2][y, x] == threshold


@settings(max_examples=6)
@given(
    st.tuples(st.integers(1, 300), st.integers(1, 60)), ladders(), st.integers(1, 6), st.integers(0, 99)
)
def test_riemersma_equals_its_twin(shape, levels, memory, seed):
    picture = np.random.default_rng(seed).random(shape).astype(np.float32)
    made = Riemersma(memory)
    expected = oracle.diffuse_along(picture, levels, made.weights())
    np.testing.assert_array_equal(dither(picture, made, levels=levels), expected)


def test_riemersma_crosses_blocks_and_strips():
    picture = np.random.default_rng(1).random((258, 260)).astype(np.float32)
    expected = oracle.diffuse_along(picture, [0, 1], Riemersma().weights())
    np.testing.assert_array_equal(dither(picture, "hilbert"), expected)


def test_the_curve_visits_every_place_in_steps_of_one():
    y, x = (v.astype(int) for v in hilbert())
    assert len(set(zip(y.tolist(), x.tolist(), strict=True))) == 65536
    assert (np.abs(np.diff(y)) + np.abs(np.diff(x)) == 1).all()
    assert (y[0], x[0], y[-1], x[-1]) == (0, 0, 0, 255)


def test_published_coefficients():
    """Rows printed in the papers; every row sums to 1 and mirrors."""
    weights, noise = tone_table("ostromoukhov")
    assert not noise.any()
    np.testing.assert_allclose(weights[0], np.array([13, 0, 5]) / 18)
    np.testing.assert_allclose(weights[2], np.array([21, 0, 10]) / 31)
    np.testing.assert_allclose(weights[127], weights[128])
    zhou, modulation = tone_table("zhou-fang")
    np.testing.assert_allclose(zhou[2], np.array([214114, 287, 99357]) / 313758)
    assert modulation[0] == 0
    assert modulation.max() == pytest.approx(128 / 255)
    for table in (weights, zhou):
        np.testing.assert_allclose(table.sum(axis=1), 1, atol=1e-12)
        np.testing.assert_array_equal(table, table[::-1])
        assert (table >= 0).all()


@pytest.mark.parametrize(
    "name", ["ostromoukhov", "zhou-fang", "riemersma", "fs:noise=0.5", "fs:edges=2"]
)
def test_exact_claims_at_256_tones(name):
    made = method(name)
    assert made.claim.kind == "exact"
    for k in range(256):
        tone = np.float32(k / 255)
        frame = dither(np.full((made.claim.side, made.claim.side), tone), made)
        assert abs(frame.luminance.mean(dtype=np.float64) - tone) <= 0.5 / 255, k


@pytest.mark.parametrize("name", ["fs", "fs:raster", "ostromoukhov", "zhou-fang"])
def test_a_warm_start_has_no_voids(name):
    """First dots within 1.5/√g rows, and the first 16 rows right within 0.5/255."""
    for tone in range(1, 255):
        g = tone / 255
        frame = dither(np.full((32, 512), g, np.float32), f"{name}:warm")
        assert abs(frame.indices[:16].mean() - g) <= 0.5 / 255, tone
        minority = frame.indices == (1 if g <= 0.5 else 0)
        first = int(np.flatnonzero(minority.any(axis=1))[0])
        assert first <= 1.5 / np.sqrt(min(g, 1 - g)), tone


def test_a_cold_start_has_voids():
    """What the warm start cures: 71 rows without a dot at 1/255."""
    frame = dither(np.full((96, 512), 1 / 255, np.float32), "fs:raster")
    assert not frame.indices[:70].any()


@given(
    light(), ladders(), st.integers(1, 9), st.sampled_from(["fs:warm", "stucki:warm", "zhou-fang:warm"])
)
def test_warm_bands_give_the_whole(picture, levels, rows, name):
    whole = dither(picture, name, levels=levels)
    kept = halftone.stages.BAND_ROWS
    try:
        halftone.stages.BAND_ROWS = rows
        np.testing.assert_array_equal(dither(picture, name, levels=levels), whole)
    finally:
        halftone.stages.BAND_ROWS = kept


@given(light(), ladders(), st.booleans())
def test_a_warm_start_is_diffusion_over_mirrored_margins(picture, levels, serpentine):
    """The margins are nothing but more picture, and the first carries are known."""
    from halftone.dithering.diffusion import _Light
    from halftone.dithering.noise import uniform_noise
    from halftone.dithering.warm import COLUMNS, ROWS, _payable

    ladder = Levels.of(levels)
    wide = np.pad(picture, ((ROWS, 0), (COLUMNS, COLUMNS)), mode="symmetric")
    wide = np.clip(wide, ladder.distinct[0], ladder.distinct[-1])
    cold = _Light(ErrorDiffusion("floyd-steinberg", serpentine), Job(Source(wide), ladder))
    low = np.searchsorted(ladder.distinct[1:-1], wide[:1], side="right")
    noise = uniform_noise(0, 0, 1, wide.shape[1]) - np.float32(0.5)
    cold.carry[:1] = noise * _payable(wide[:1], low, ladder.distinct)
    expected = np.empty(wide.shape, np.uint8)
    cold.band(0, wide.shape[0], expected)
    made = ErrorDiffusion("floyd-steinberg", serpentine, start="warm")
    frame = dither(picture, made, levels=levels)
    np.testing.assert_array_equal(frame, expected[ROWS:, COLUMNS:-COLUMNS])


def test_edge_enhancement_sharpens_and_keeps_the_mean():
    step = np.full((256, 256), 0.3, np.float32)
    step[:, 128:] = 0.6
    plain, sharp = (dither(step, f"fs:edges={k}").indices.astype(float) for k in (0.001, 3))
    for frame in (plain, sharp):
        assert frame[:, :120].mean() == pytest.approx(0.3, abs=0.01)
        assert frame[:, 136:].mean() == pytest.approx(0.6, abs=0.01)
    contrast = [f[:, 128:130].mean() - f[:, 126:128].mean() for f in (plain, sharp)]
    assert contrast[1] > contrast[0] + 0.1


def test_noise_breaks_the_checkerboard():
    def peak(name: str) -> float:
        dots = dither(np.full((128, 128), 127 / 255, np.float32), name).indices - 127 / 255
        return float((np.abs(np.fft.fft2(dots)) ** 2).max() / 128**2 / 0.25)

    assert peak("zhou-fang") < 30 < peak("ostromoukhov") < peak("fs:raster")


@pytest.mark.parametrize(
    "text",
    [
        "fs:noise=1.5", "fs:noise=-1", "fs:edges=11", "fs:seed=1", "ostromoukhov:noise=0.5",
        "ostromoukhov:seed=1", "zhou-fang:strength=2", "riemersma:memory=0", "riemersma:decay=0",
        "riemersma:warm", "bayer8:warm", "zhou-fang:lukewarm",
    ],
)  # fmt: skip
def test_options_that_are_wrong(text):
    with pytest.raises(UsageError):
        method(text)


@pytest.mark.parametrize("levels", [[0.3, 0.3001, 0.9], [0.3, 0.30001, 0.9], [0, 0.001, 0.5, 0.51, 1]])
@pytest.mark.parametrize("name", ["fs:warm", "false-floyd-steinberg:warm", "ostromoukhov:warm"])
def test_a_warm_start_keeps_levels_beside_narrow_steps(name, levels):
    values = np.float32(levels)
    for i, value in enumerate(values):
        for width in (1, 9, 41):
            frame = dither(np.full((37, width), value), name, levels=levels)
            assert (frame.indices == i).all()
    blocks = np.kron(np.float32([[0, 1, 0, 1]]), np.ones((30, 100), np.float32)) * values[-1]
    blocks = np.maximum(blocks, values[0])
    shown = dither(blocks, name, levels=levels).luminance
    np.testing.assert_array_equal(shown, blocks)


@pytest.mark.parametrize("edges", [-10, -3, 2, 10])
def test_claims_with_edge_enhancement(edges):
    made = method(f"fs:edges={edges}")
    for tone in (1 / 16, 0.25, 28 / 255, 0.5, 227 / 255):
        patch = np.full((made.claim.side, made.claim.side), tone, np.float32)
        assert abs(dither(patch, made).luminance.mean(dtype=np.float64) - np.float32(tone)) <= 0.5 / 255
