"""halftone.dither and the Frame, as a user calls them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

import halftone
from halftone import Frame, HalftoneError, InputError, UsageError, convert, dither
from halftone.tone import encoding


def test_defaults_are_floyd_steinberg_serpentine_on_two_levels(camera):
    frame = dither(camera)
    assert isinstance(frame, Frame)
    assert frame.method == "floyd-steinberg"
    np.testing.assert_array_equal(frame, dither(camera, "fs:serpentine", levels=2, encoding="srgb"))
    assert frame.indices.dtype == np.uint8
    # linear light: the mean of the dots is the mean of the light, not of the codes
    light = encoding("srgb").table(256)[camera]
    assert abs(frame.indices.mean() - light.mean()) < 0.001
    assert abs(frame.indices.mean() - camera.mean() / 255) > 0.1


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.uint32])
def test_integers_are_srgb_codes_over_the_full_range(dtype):
    top = np.iinfo(dtype).max
    codes = np.linspace(0, top, 64).astype(dtype).reshape(1, -1)
    light = encoding("srgb").decode(codes / top).astype(np.float32)
    for name in ("none", "bayer8"):
        np.testing.assert_array_equal(dither(codes, name, levels=9), dither(light, name, levels=9))
    linear = (codes / top).astype(np.float32)
    for name in ("none", "bayer8"):
        ours = dither(codes, name, levels=9, encoding="linear")
        np.testing.assert_array_equal(ours, dither(linear, name, levels=9))


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64])
def test_floats_are_light(dtype):
    light = np.linspace(0, 1, 33).astype(dtype).reshape(3, 11)
    expected = dither(light.astype(np.float32), "bayer4")
    np.testing.assert_array_equal(dither(light, "bayer4"), expected)
    assert dither(light.tolist(), "bayer4").shape == (3, 11)
    coded = dither(light, "bayer4", encoding="srgb")
    decoded = encoding("srgb").decode(light).astype(np.float32)
    np.testing.assert_array_equal(coded, dither(decoded, "bayer4"))


def test_bool_is_black_and_white():
    mask = np.eye(5, dtype=bool)
    np.testing.assert_array_equal(dither(mask, "fs"), mask)


@pytest.mark.parametrize("mode", ["RGBA", "LA"])
def test_pil_images_with_alpha_are_refused_and_say_why(mode):
    with pytest.raises(InputError, match="alpha"):
        dither(Image.new(mode, (3, 3)))


@given(st.integers(0, 255), st.sampled_from(["srgb", "linear", "gamma:2.2"]))
def test_a_neutral_colour_keeps_its_light_exactly(code, name):
    gray = np.full((2, 3), code, np.uint8)
    colour = np.repeat(gray[:, :, None], 3, axis=2)
    levels = np.unique(np.r_[0, encoding(name).table(256)[code], 1])
    frame = dither(colour, "bayer16", levels=levels, encoding=name)
    assert (frame.luminance == encoding(name).table(256)[code]).all()


def test_luminance_of_colours():
    colours = np.float32([[[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.25, 1]]])
    expected = np.float32([0.2126, 0.7152, 0.0722, 0.2126 * 0.5 + 0.7152 * 0.25 + 0.0722])
    frame = dither(colours, "none", levels=np.sort(expected))
    np.testing.assert_array_equal(frame.luminance[0], expected)


@pytest.mark.parametrize(
    "picture",
    [
        np.zeros((0, 5)),
        np.zeros((5, 0), np.uint8),
        np.zeros(5),
        np.zeros((2, 2, 2)),
        np.zeros((2, 2, 4)),
        np.zeros((1, 2, 2, 3)),
        np.zeros((2, 2), np.int64),
        np.zeros((2, 2), np.int8),
        np.zeros((2, 2), complex),
        np.array([["a"]]),
        [[0.1], [0.2, 0.3]],
        "picture.png",
        None,
    ],
    ids=lambda p: str(getattr(p, "shape", p)) + str(getattr(p, "dtype", "")),
)
def test_arrays_that_are_no_pictures(picture):
    with pytest.raises(InputError) as caught:
        dither(picture)
    assert caught.value.exit_code == 3
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("shape", [(200, 7), (200, 7, 3)])
def test_nan_and_infinity(value, shape):
    picture = np.full(shape, 0.5, np.float32)
    picture[130, 3] = value
    with pytest.raises(InputError, match="row 130, column 3.*nonfinite='clip'"):
        dither(picture)
    frame = dither(picture, "none", nonfinite="clip")
    assert frame.indices[130, 3] == (1 if value == np.inf else 0)
    with pytest.raises(UsageError, match="nonfinite"):
        dither(picture, nonfinite="ignore")
    for rule in ("scale", "compress"):
        assert dither(picture, "fs", nonfinite="clip", range=rule).shape == shape[:2]


def test_a_float64_beyond_float32_is_infinite():
    with pytest.raises(InputError, match="inf"):
        dither(np.full((2, 2), 1e300))


def test_range_rules():
    render = np.float32([[0, 0.5, 1, 2, 4]])
    assert dither(render, "none", levels="uniform-linear:9").indices.tolist() == [[0, 4, 8, 8, 8]]
    scaled = dither(render, "none", levels="uniform-linear:9", range="scale")
    assert scaled.indices.tolist() == [[0, 1, 2, 4, 8]]
    rolled = dither(render, "none", levels=256, range="compress").luminance[0]
    assert rolled[1] == pytest.approx(0.5, abs=0.005)
    assert (np.diff(rolled) > 0).all()
    with pytest.raises(UsageError, match="clip, compress, scale"):
        dither(render, range="wrap")


@pytest.mark.parametrize(
    ("options", "part"),
    [
        ({"method": "floyd"}, "Did you mean floyd-steinberg"),
        ({"method": 3}, "a name, or a method"),
        ({"method": "bayer8", "serpentine": True}, "does not apply"),
        ({"method": "none", "strength": 0.5}, "does not apply"),
        ({"method": "fs", "seed": 3}, "seed does not apply"),
        ({"strength": 1.5}, "allowed: 0"),
        ({"strength": float("nan")}, "allowed: 0"),
        ({"levels": 1}, "allowed"),
        ({"levels": 257}, "allowed"),
        ({"levels": 2.5}, "allowed"),
        ({"levels": None}, "allowed"),
        ({"levels": True}, "allowed"),
        ({"levels": "log:0:4"}, "above 0"),
        ({"levels": "log:4"}, "not understood"),
        ({"levels": [0, 0.5, 0.4]}, "fall"),
        ({"levels": [0.4, 0.4]}, "no picture"),
        ({"levels": [0, 1], "gamma": 2.2}, "does not apply"),
        ({"gamma": 0}, "gamma"),
        ({"gamma": "sgrb"}, "srgb"),
        ({"encoding": "bt79"}, "bt709"),
        ({"workers": -1}, "workers"),
        ({"workers": 1.5}, "workers"),
        ({"method": "random", "seed": -1}, "seed"),
    ],
    ids=str,
)
def test_options_that_are_wrong(options, part):
    with pytest.raises(UsageError) as caught:
        dither(np.zeros((2, 2)), **options)
    assert part in str(caught.value)
    assert caught.value.exit_code == 2


def test_gamma_is_the_response_of_the_device():
    light = np.float32([[0.0, 0.2, 0.5, 1.0]])
    frame = dither(light, "none", levels=16, gamma=2.2)
    np.testing.assert_allclose(frame.levels.luminance, (np.arange(16) / 15) ** 2.2, rtol=1e-6)
    again = dither(light, "none", levels=16, gamma="gamma:2.2")
    np.testing.assert_array_equal(again.levels.luminance, frame.levels.luminance)


def test_frame_values():
    frame = dither(np.float32([[0.1, 0.5], [0.9, 0.02]]), "none", levels=[0.02, 0.1, 0.5, 0.9])
    assert frame.indices.tolist() == [[1, 2], [3, 0]]
    np.testing.assert_array_equal(frame.luminance, np.float32([[0.1, 0.5], [0.9, 0.02]]))
    assert frame.packed().tolist() == [[0b01100000], [0b11000000]]
    assert frame.upscaled(2).indices.tolist() == [[1, 1, 2, 2]] * 2 + [[3, 3, 0, 0]] * 2
    assert np.asarray(frame, dtype=int).dtype == int
    assert frame._repr_png_().startswith(b"\x89PNG")
    for bad in (0, 257, 1.5, True):
        with pytest.raises(UsageError):
            frame.upscaled(bad)


def test_progress_rises_to_one():
    for workers in (1, 2):
        seen: list[float] = []
        dither(np.zeros((500, 40)), "bayer8", workers=workers, progress=seen.append)
        assert seen == sorted(seen)
        assert seen[-1] == 1
        assert len(seen) == 8


@pytest.mark.parametrize("workers", [1, 2])
def test_what_progress_raises_stops_the_run(workers):
    def stop(share: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        dither(np.zeros((500, 40)), "bayer8", workers=workers, progress=stop)


def test_all_errors_have_one_root_and_an_exit_code():
    from halftone import errors

    classes = [getattr(errors, n) for n in errors.__all__ if n != "near"]
    assert all(issubclass(c, HalftoneError) for c in classes)
    assert {c.__name__: c.exit_code for c in classes} == {
        "HalftoneError": 1,
        "UsageError": 2,
        "InputError": 3,
        "InputFileError": 3,
        "OutputError": 1,
        "DeviceNotFoundError": 4,
        "DeviceFaultError": 5,
        "ThresholdError": 6,
    }


def test_regions_keep_text_free_of_dots(camera):
    light = encoding("srgb").table(256)[camera]
    mask = np.zeros(camera.shape, bool)
    mask[100:200, 50:300] = True
    frame = dither(light, "fs", regions=[(mask, "threshold")])
    np.testing.assert_array_equal(frame.indices[mask], dither(light, "threshold").indices[mask])
    np.testing.assert_array_equal(frame.indices[~mask], dither(light, "fs").indices[~mask])
    for bad in (mask[:, 1:], mask.astype(np.uint8)):
        with pytest.raises(UsageError, match="mask"):
            dither(light, "fs", regions=[(bad, "threshold")])
    with pytest.raises(UsageError, match="two levels"):
        dither(light, "fs", levels=3, regions=[(mask, "threshold")])


@pytest.mark.parametrize("kind", [np.int64, np.uint8, np.uint32])
def test_numpy_integers_are_integers(kind):
    light = np.random.default_rng(0).random((9, 9))
    expected = dither(light, "random:triangular", seed=7)
    np.testing.assert_array_equal(dither(light, "random:triangular", seed=kind(7)), expected)
    assert convert(light, width=kind(5), workers=kind(2)).shape == (5, 5)
    for bad in (7.0, True, "7"):
        with pytest.raises(UsageError, match="seed"):
            dither(light, "random", seed=bad)
    for bad in (5.5, float("nan"), "abc", 0, True):
        with pytest.raises(UsageError, match="width"):
            convert(light, width=bad)


@pytest.mark.parametrize("side", [255, 256, 300])
@pytest.mark.parametrize("levels", [2, 3])
def test_screens_of_more_than_65535_thresholds(side, levels):
    from halftone import Ordered
    from halftone.screens import from_ranks

    order = np.random.default_rng(1).permutation(side * side).reshape(side, side)
    method = Ordered(from_ranks(order, "own"))
    codes = np.random.default_rng(2).integers(0, 256, (64, 64)).astype(np.uint8)
    light = encoding("srgb").table(256)[codes]
    expected = dither(light, method, levels=levels)
    np.testing.assert_array_equal(dither(codes, method, levels=levels), expected)
    white = dither(np.full((32, 32), 255, np.uint8), method, levels=levels)
    assert (white.indices == levels - 1).all()


def test_a_pil_image_with_a_transparent_key_is_refused():
    image = Image.new("L", (4, 4), 77)
    image.info["transparency"] = 77
    with pytest.raises(InputError, match="alpha"):
        dither(image)


def test_text_forms_keep_all_digits():
    for text in (
        "fs:strength=0.123456789",
        "bayer8:strength=0.3333333333333333",
        "ed:7.1234567,3,5,0.8/16",
    ):
        made = halftone.method(text)
        assert halftone.method(made.text()) == made
    assert halftone.method("fs : raster").text() == "floyd-steinberg:raster"
    with pytest.raises(UsageError):
        halftone.method("fs:strength=1_0")


def test_strange_values_are_usage_errors():
    light = np.full((4, 4), 0.3)
    for options in (
        {"strength": "1"},
        {"serpentine": "no"},
        {"method": "riemersma:memory=2.5"},
        {"method": "fs:raster:serpentine"},
        {"method": "fs:strength=.5:strength=.7"},
        {"method": "threshold:0.3:0.5"},
    ):
        with pytest.raises(UsageError):
            dither(light, **options)
    at = halftone.Threshold(np.float32(0.3))
    assert dither(np.array([[0.2, 0.31]]), at).indices.tolist() == [[0, 1]]
    assert halftone.method("BAYER8:DOT=2") == halftone.method("bayer8:dot=2")
    made = halftone.Riemersma(memory=np.int64(3), decay=np.float64(0.5))
    assert halftone.method(made.text()) == made
