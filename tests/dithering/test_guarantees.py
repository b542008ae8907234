"""What every method promises: fixed points, tone, determinism, bands, workers, untouched input."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import halftone.stages
from halftone import dither, method, methods
from halftone.dithering.registry import NAMES
from halftone.tone.range import compress, scale
from tests.strategies import DIFFUSION, SAME_SIZE, ladders, light, method_names, texts

ALL = sorted(SAME_SIZE)


def shown(picture, name, levels) -> float:
    return float(dither(picture, name, levels=levels).luminance.mean(dtype=np.float64))


@given(texts, ladders(), st.tuples(st.integers(1, 24), st.integers(1, 24)))
def test_a_constant_picture_at_a_level_is_that_level(name, levels, shape):
    values = np.float32(levels)
    for value in np.unique(values):
        frame = dither(np.full(shape, value), name, levels=levels)
        assert (frame.indices == np.flatnonzero(values == value)[0]).all()


@given(texts, light(), st.integers(2, 256))
def test_black_stays_black_and_white_white(name, picture, n):
    mask = picture > 0.5
    codes = np.where(mask, np.uint8(255), np.uint8(0))
    assert (dither(np.zeros_like(codes), name, levels=n).indices == 0).all()
    assert (dither(np.full_like(codes, 255), name, levels=n).indices == n - 1).all()
    # what is bilevel already passes through untouched
    np.testing.assert_array_equal(dither(codes, name, levels=n).indices, np.where(mask, n - 1, 0))


@pytest.mark.parametrize("name", ["threshold", "threshold:otsu", "threshold:0.9"])
def test_threshold_keeps_two_levels(name):
    codes = np.kron(np.uint8([[0, 255], [255, 0]]), np.ones((5, 7), np.uint8))
    np.testing.assert_array_equal(dither(codes, name).indices, codes // 255)


@pytest.mark.parametrize("scan", [":serpentine", ":raster"])
@pytest.mark.parametrize("name", [n for n in DIFFUSION if methods()[n].claim.kind == "exact"])
def test_exact_claims_at_256_tones(name, scan):
    chosen = method(name + scan)
    side = chosen.claim.side
    for k in [
        *(k / 255 for k in range(256)),
        *(k / 64 for k in range(65)),
        *(k / 48 for k in range(49)),
    ]:
        tone = np.float32(k)
        assert abs(shown(np.full((side, side), tone), chosen, 2) - tone) <= 0.5 / 255, k


def test_the_integer_kernel_is_exact_too():
    for k in range(256):
        frame = dither(np.full((256, 256), k, np.uint8), "fs", encoding="linear")
        assert abs(frame.indices.mean() - k / 255) <= 0.5 / 255, k


@settings(max_examples=12)
@given(st.sampled_from(DIFFUSION), ladders(), st.floats(0, 1))
def test_exact_claims_on_measured_ladders(name, levels, share):
    claim = method(name).claim
    span = levels[-1] - levels[0]
    tone = np.float32(levels[0] + share * span)
    tone = np.clip(tone, np.float32(levels[0]), np.float32(levels[-1]))
    if claim.kind == "exact":
        patch = np.full((claim.side, claim.side), tone)
        # float32 light rounds each luminance by 6e-8, which counts where levels are 1e-6 apart.
        assert abs(shown(patch, name, levels) - tone) <= 0.5 / 255 * span + 1.2e-7


@pytest.mark.parametrize("name", ["bayer2", "bayer4", "bayer8", "bayer16", "random", "random:seed=9"])
@pytest.mark.parametrize("levels", [2, "uniform-linear:5", [0.02, 0.1, 0.15, 0.7, 1.0]])
def test_claims_of_k_tones(name, levels):
    claim = method(name).claim
    assert claim.kind == "tones"
    values = dither(np.zeros((1, 1)), "none", levels=levels).levels.luminance
    for k in range(256):
        tone = np.float32(values[0] + (values[-1] - values[0]) * k / 255)
        step = np.diff(values).max() / (claim.tones - 1)
        assert abs(shown(np.full((192, 192), tone), name, levels) - tone) <= step / 2 + 1e-6, k


@pytest.mark.parametrize("name", [n for n in ALL if str(methods()[n].claim) != "none"])
def test_tones_rise_with_the_light(name):
    tones = [shown(np.full((96, 96), np.float32(k / 64)), name, 2) for k in range(65)]
    assert (np.diff(tones) > -0.5 / 96).all()
    assert tones[0] == 0
    assert tones[-1] == 1


@given(texts, light(-0.5, 1.5), ladders(), st.integers(1, 30))
def test_bands_give_the_whole(name, picture, levels, rows):
    whole = dither(picture, name, levels=levels)
    kept = halftone.stages.BAND_ROWS
    try:
        halftone.stages.BAND_ROWS = rows
        for workers in (1, 3):
            again = dither(picture, name, levels=levels, workers=workers)
            np.testing.assert_array_equal(again, whole)
    finally:
        halftone.stages.BAND_ROWS = kept


@given(texts, light(), ladders())
def test_the_input_is_not_touched_and_the_result_repeats(name, picture, levels):
    before = picture.copy()
    picture.flags.writeable = False
    first = dither(picture, name, levels=levels)
    np.testing.assert_array_equal(picture, before)
    np.testing.assert_array_equal(dither(picture, name, levels=levels, workers=2), first)
    strided = np.asfortranarray(np.kron(picture, np.ones((2, 2), np.float32)))[::2, ::2]
    np.testing.assert_array_equal(dither(strided, name, levels=levels), first)


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("shape", [(1, 1), (1, 65_000), (65_000, 1), (3, 65_000), (2, 2)])
def test_extreme_shapes(name, shape):
    ramp = np.linspace(0, 1, shape[0] * shape[1], dtype=np.float32).reshape(shape)
    frame = dither(ramp, name)
    assert frame.shape == shape
    if name == "riemersma" or name.startswith("dots:"):
        return  # these look ahead: along the curve of a strip, and to pixels of lower class
    # What comes later never changes the rows before it …
    rows = max(1, shape[0] * 2 // 3)
    np.testing.assert_array_equal(dither(ramp[:rows], name).indices, frame.indices[:rows])
    if shape[0] == 1 and shape[1] > 1:  # … nor, in a single row, the columns before it
        np.testing.assert_array_equal(
            dither(ramp[:, :40_000], name).indices[0], frame.indices[0, :40_000]
        )
        assert frame.indices[0, 0] == 0
        assert frame.indices[0, -1] == 1


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("value", [1e-45, 1e-30, 3.4e38, -3.4e38, 1 - 2**-24, np.float32(2**-149)])
def test_extreme_values(name, value):
    picture = np.full((9, 9), value, np.float32)
    picture[4, 4] = 0.5
    frame = dither(picture, name)
    if name.startswith("dots:"):
        return  # the middle pixel's error ends at a baron, wherever that is
    far = np.delete(frame.indices.ravel(), 40)
    assert set(np.unique(far)) == {1 if value > 0.5 else 0}


@given(method_names, ladders(), light(-1e30, 1e30))
def test_light_far_outside_the_levels(name, levels, picture):
    low, high = np.float32(levels[0]), np.float32(levels[-1])
    clipped = dither(np.clip(picture, low, high), name, levels=levels)
    np.testing.assert_array_equal(dither(picture, name, levels=levels), clipped)
    brightest = float(picture.max())
    scaled = scale(float(high) / brightest)(picture) if brightest > high else picture
    for rule, brought in (("scale", scaled), ("compress", compress(float(high))(picture))):
        expected = dither(np.clip(brought, low, high), name, levels=levels)
        np.testing.assert_array_equal(dither(picture, name, levels=levels, range=rule), expected)


@pytest.mark.parametrize("name", [n for n in ALL if n != "threshold"])
def test_levels_a_millionth_apart(name):
    levels = [0.5, 0.500001, 0.500002, 1.0]
    picture = np.full((64, 64), 0.5000015, np.float32)
    frame = dither(picture, name, levels=levels)
    assert frame.indices.max() <= 2
    if methods()[name].claim.kind == "exact":
        assert abs(frame.luminance.mean(dtype=np.float64) - 0.5000015) < 2e-7


@given(texts)
def test_the_text_form_makes_an_equal_method(name):
    made = method(name)
    assert method(made.text()) == made
    assert method(made.text().upper().replace("-", "_")) == made
    assert hash(made) == hash(method(made.text()))


def test_a_picture_and_its_complement_by_noise_and_order_differ_only_in_ties(camera):
    light = camera.astype(np.float32) / 255
    for name in ("bayer8", "random", "none"):
        dots = dither(light, name).indices.mean() + dither(1 - light, name).indices.mean()
        assert abs(dots - 1) < 0.02


def test_the_registry_names_what_the_families_have():
    """Names are written out in the registry, so that no family is loaded to list them."""
    from halftone.dithering import FILTERS
    from halftone.dithering.classes import CLASSES
    from halftone.dithering.screened import NAMES as SCREENS
    from halftone.dithering.toned import TABLES

    assert {n for n, family in NAMES.items() if family == "diffusion"} == set(FILTERS)
    assert {n for n, family in NAMES.items() if family == "toned"} == set(TABLES)
    assert {n for n in NAMES if n.startswith("dots:")} == {f"dots:{c}" for c in CLASSES}
    listed = {n.split(":")[0] for n, family in NAMES.items() if family == "screened"}
    assert listed == set(SCREENS) - {"mask"}


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("dots", "dots:64"),
        ("knuth", "dots:knuth"),
        ("Knuth:strength=0.5", "dots:knuth:strength=0.5"),
        ("DOTS : mese16", "dots:mese16"),
        ("void-and-cluster", "blue-noise"),
        ("Blue Noise", "blue-noise"),
        ("bluenoise:8x8:seed=2", "blue-noise:8x8:seed=2"),
        ("classic2", "patterns:classic2"),
        ("Patterns:8", "patterns:8"),
        ("ordered:bayer8:strength=0.5", "bayer8:strength=0.5"),
        ("hilbert", "riemersma"),
        ("O4X4", "o4x4"),
    ],
)
def test_names_that_mean_the_same(text, meant):
    assert method(text).text() == method(meant).text()


@pytest.mark.parametrize(
    "text",
    [
        "dots:knut",
        "dots:",
        "screen:",
        "mask:",
        "patterns:",
        "patterns:17",
        "patterns:1",
        "growth:x",
        "screen:round@45",
        "screen:rond@45:8px",
        "blue-noise:0x8",
        "mask:none.png",
        ":",
        "h4x4a:3",
        "fs:wram",
    ],
)
def test_names_that_mean_nothing(text):
    from halftone import UsageError

    with pytest.raises(UsageError) as caught:
        method(text)
    assert "64:knut" not in str(caught.value)
