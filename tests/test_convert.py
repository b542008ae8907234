"""halftone.convert and halftone.read, as a user calls them."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

import halftone
from devices import profile
from halftone import InputError, InputFileError, UsageError, convert, dither
from halftone.errors import DeviceNotFoundError, OutputError


@pytest.mark.parametrize("mode", ["1", "L", "P", "RGB", "CMYK", "YCbCr", "F", "I;16"])
def test_pil_images(mode, camera):
    gray = Image.fromarray(camera[::8, ::8])
    if mode == "F":
        image = Image.fromarray(camera[::8, ::8].astype(np.float32) / 255)
    elif mode == "I;16":
        image = Image.fromarray(camera[::8, ::8].astype(np.uint16) * 257)
    else:
        image = gray.convert(mode)
    frame = dither(image, "none", levels=256, encoding="srgb")
    worst = {"1": 255, "YCbCr": 2, "P": 0}.get(mode, 0)
    assert np.abs(frame.indices.astype(int) - camera[::8, ::8]).max() <= worst


def test_the_report_says_what_was_done_and_what_was_left_out(photograph):
    frame = convert(photograph, width=120, brightness=0.1)
    stages = {s["stage"]: s for s in frame.report["stages"]}
    assert list(stages) == ["read", "resize", "adjust", "dither"]
    assert stages["read"]["size"] == [451, 300]
    assert stages["resize"]["size"] == [120, 80]
    assert all(s["seconds"] >= 0 for s in stages.values())
    assert "alpha" in {entry["stage"] for entry in frame.report["left_out"]}
    plain = dither(np.zeros((4, 4), np.uint8), "bayer8")
    left = {entry["stage"]: entry["why"] for entry in plain.report["left_out"]}
    assert "no compiled code" in left["numba"]
    assert "integer codes" in left["float copy"]


def test_convert_takes_arrays_and_files_alike(photograph):
    light = halftone.read(photograph)
    assert light.shape == (300, 451, 3)
    assert light.dtype == np.float32
    np.testing.assert_array_equal(convert(light), convert(photograph))


def test_convert_for_a_device(photograph):
    device = profile.load("receipt-80mm")
    frame = convert(photograph, profile=device)
    assert frame.shape == (383, 576)
    assert frame.dpi == (203.2, 203.2)
    assert "scaled to 576 × 383 for 'receipt-80mm'" in frame.report["notes"][0]
    ink = np.unpackbits(frame.packed(), axis=1)
    np.testing.assert_array_equal(ink, 1 - frame.indices)
    narrow = convert(photograph, profile=device, width=300)
    assert narrow.shape == (200, 300)
    with pytest.raises(UsageError, match="576 dots"):
        convert(photograph, profile=device, width=577)
    panel = convert(photograph, profile=profile.load("epaper-4gray"))
    assert panel.shape == (300, 400)
    assert panel.packed().shape == (300, 100)
    assert (panel.indices[:16] == 3).all()  # 4:3 panel, 3:2 picture: white above and below
    with pytest.raises(DeviceNotFoundError, match="receipt-80mm"):
        profile.load("receipt")


def test_adjustments_act_on_light():
    light = np.full((40, 40), 0.25, np.float32)
    fine = "uniform-linear:256"

    def shown(**options) -> float:
        return float(convert(light, method="none", levels=fine, **options).luminance.mean())

    assert shown() == pytest.approx(0.25, abs=1 / 510)
    assert shown(brightness=0.5) == pytest.approx(0.5, abs=1 / 510)
    assert shown(brightness=-1) == pytest.approx(1 / 16, abs=1 / 510)
    assert shown(contrast=0.5) == pytest.approx(0.18 * (0.25 / 0.18) ** 2, abs=1 / 510)
    assert shown(invert=True) == pytest.approx(0.75, abs=1 / 510)
    assert shown(auto_levels=True) == pytest.approx(0.25, abs=1 / 510)
    ramp = np.tile(np.linspace(0.2, 0.6, 400, dtype=np.float32), (10, 1))
    stretched = convert(ramp, method="none", levels=fine, auto_levels=True).luminance
    assert stretched.min() == 0
    assert stretched.max() == 1


def test_too_large_is_refused_before_it_is_read_or_made(photograph):
    with pytest.raises(InputFileError, match="MiB"):
        convert(photograph, max_memory=1 << 18)  # not even the rows held of the file
    with pytest.raises(InputError, match="the size 451 × 300"):
        convert(photograph, max_memory=1 << 20)
    with pytest.raises(InputError, match="the size 1000000"):
        convert(photograph, width=1_000_000)


def test_files_that_are_not_there(tmp_path):
    with pytest.raises(InputFileError, match="nothing.png.*No such file"):
        convert(tmp_path / "nothing.png")
    with pytest.raises(OutputError, match="cannot be written"):
        dither(np.zeros((2, 2))).save(tmp_path / "no folder" / "out.png")
    with pytest.raises(UsageError, match="JPEG"):
        dither(np.zeros((2, 2))).save(tmp_path / "out.jpg")
    assert list(tmp_path.iterdir()) == []


def test_content_chooses_a_method(camera):
    def used(content: str, levels: int = 2) -> str:
        return convert(camera, content=content, levels=levels).method

    assert used("text") == "threshold"
    assert used("text", 4) == "none"
    assert used("graphic") == "bayer8"
    assert used("photo") == "floyd-steinberg"
    with pytest.raises(UsageError, match="graphic"):
        used("grafic")
    with pytest.raises(UsageError, match="give one"):
        convert(camera, content="text", method="fs")


def test_an_option_that_is_given_counts_even_where_it_is_the_default():
    light = np.full((9, 9), 0.4)
    assert dither(light, "random:seed=7", seed=0).method == "random"
    assert dither(light, "fs:strength=0.5", strength=1).method == "floyd-steinberg"
    for options in ({"seed": 0}, {"strength": 1}, {"serpentine": False}):
        with pytest.raises(UsageError, match="does not apply"):
            dither(light, "none", **options)
    with pytest.raises(UsageError, match="both a width and a height"):
        convert(light, width=5, fit="cover")


@pytest.mark.parametrize("method", ["patterns:classic2", "patterns:classic3", "patterns:8"])
def test_patterns_fill_the_size_that_was_asked_for(method, photograph):
    device = profile.load("epaper-4gray")
    assert convert(photograph, method=method, profile=device).shape == (300, 400)
    assert convert(photograph, method=method, width=101).shape == (67, 101)
    assert convert(photograph, method=method).shape == (300, 451)
    n = halftone.method(method).scale
    assert dither(np.zeros((5, 7)), method).shape == (5 * n, 7 * n)


@pytest.mark.parametrize("n", [2, 3, 8, 16])
@pytest.mark.parametrize("size", [(100, 100), (50, 50), (33, 17), (9, 9)])
def test_patterns_show_the_whole_picture(n, size):
    """The right quarter is black: as many black dots, but for the cell at its border."""
    picture = np.ones((100, 100), np.float32)
    picture[:, 75:] = 0
    frame = convert(picture, method=f"patterns:{n}", width=size[0], height=size[1], fit="stretch")
    assert frame.shape == size[::-1]
    black = 1 - frame.indices.mean()
    assert abs(black - 0.25) <= n / size[0]
    if size[0] >= 8 * n:  # the last cell is black for sure
        assert (frame.indices[:, -1] == 0).all()
