"""Palettes: ours, a user's, and every mistake with its place."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from devices.palette import XYZ_TO_RGB, Palette
from devices.profile import load, names
from halftone.errors import DeviceNotFoundError, UsageError
from halftone.tone.ladder import lightness
from tests.oracle.framebuffer import srgb_to_light


def _colour(**changes: Any) -> dict[str, Any]:
    return {"name": "black", "code": 0, "srgb": [1, 2, 3], **changes}


def _data(*colours: dict[str, Any], **changes: Any) -> dict[str, Any]:
    white = {"name": "white", "code": 1, "srgb": [250, 250, 250]}
    return {"title": "t", "provenance": "p", "colour": [*(colours or [_colour()]), white], **changes}


@pytest.mark.parametrize("name", Palette.known())
def test_ours_load(name: str) -> None:
    palette = Palette.load(name)
    assert palette.name == name
    assert palette.title
    assert len(palette.provenance) > 40
    assert palette.names[:2] == ("black", "white")
    assert palette.paper == 1
    assert (palette.light >= 0).all()
    assert (palette.light <= 1).all()
    assert palette.relative @ [0.2126, 0.7152, 0.0722] == pytest.approx(
        palette.luminance / palette.white
    )


def test_figures_of_ours() -> None:
    """Codes of Waveshare's drivers; L* as computed with colour-science from the published triplets."""
    spectra, acep = Palette.load("spectra6"), Palette.load("acep")
    assert spectra.codes == (0, 1, 2, 3, 5, 6)
    assert spectra.names == ("black", "white", "yellow", "red", "blue", "green")
    assert acep.codes == (0, 1, 2, 3, 4, 5, 6)
    assert acep.names == ("black", "white", "green", "blue", "red", "yellow", "orange")
    for palette, stars in ((spectra, (10, 72.5, 69, 24, 31, 33)), (acep, (11, 95, 60, 26, 44, 84, 50))):
        assert lightness(palette.luminance) == pytest.approx(stars, abs=0.7)
    white = [srgb_to_light(code) for code in (168, 180, 182)]
    assert spectra.light[1].tolist() == pytest.approx(white, rel=1e-6)


def test_levels_of_profiles_are_black_and_white_of_their_palettes() -> None:
    """Level indices 0 and 1 are palette indices 0 and 1, and the same codes on the wire."""
    found = 0
    for name in names():
        profile = load(name)
        if "palette" in profile.glass:
            found += 1
            palette = Palette.load(profile.glass["palette"])
            assert profile.codes == palette.codes[:2]
            expected = palette.luminance[:2] / palette.white
            assert profile.levels.luminance == pytest.approx(expected, abs=1e-4)
            assert "black and white" in profile.title
    assert found >= 2


def test_white_is_the_one_called_so_or_the_lightest() -> None:
    inky = Palette.load("spectra6-inky")  # its yellow is lighter than its white
    assert inky.paper == 1
    assert inky.luminance.argmax() == inky.names.index("yellow")
    unnamed = Palette("x", "t", "p", ("a", "b"), (0, 1), np.array([[0.5] * 3, [0.1] * 3], np.float32))
    assert unnamed.paper == 0


def test_xyz() -> None:
    d65 = [0.95047, 1.0, 1.08883]
    made = Palette.of(_data({"name": "paper", "code": 5, "xyz": d65}), "x")
    assert made.light[0] == pytest.approx([1, 1, 1], abs=1e-4)
    back = np.linalg.inv(np.array(XYZ_TO_RGB))[1]
    assert back == pytest.approx([0.2126, 0.7152, 0.0722], abs=1e-4)


def test_a_users_file(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(
        'title = "t"\nprovenance = "me"\n'
        '[[colour]]\nname = "k"\ncode = 3\nxyz = [0.01, 0.01, 0.01]\n'
        '[[colour]]\nname = "w"\ncode = 0\nsrgb = [200, 200.5, 200]\n'
    )
    made = Palette.load(path)
    assert (made.name, made.codes, made.paper) == ("mine", (3, 0), 1)
    path.write_text("title = = 1")
    with pytest.raises(UsageError, match=r"mine\.toml' is not TOML"):
        Palette.load(str(path))
    with pytest.raises(DeviceNotFoundError, match="cannot be read"):
        Palette.load(tmp_path / "none.toml")
    with pytest.raises(UsageError, match="Did you mean spectra6"):
        Palette.load("spectra")


@pytest.mark.parametrize(
    ("data", "word"),
    [
        (_data(titel="x"), "Did you mean title"),
        (_data(title=3), "title is missing, or no text"),
        (_data(provenance=None), "provenance is missing"),
        (_data(colour=[]), "2 … 256"),
        (_data(colour=3), "colours are missing"),
        (_data(_colour(nmae="x")), "colour 0: unknown key 'nmae'. Did you mean name"),
        (_data(_colour(name="")), "name = ''"),
        (_data(_colour(code="1")), "code = '1'"),
        (_data(_colour(code=True)), "code = True"),
        (_data(_colour(code=1)), "the code 1 is there twice"),
        (_data(_colour(code=256)), "code 256; allowed: 0 … 255"),
        (_data(_colour(name="white")), "the name white is there twice"),
        (_data(_colour(xyz=[1, 1, 1])), "either srgb or xyz"),
        (_data(_colour(srgb=[1, 2])), r"srgb = \[1, 2\]; allowed: three numbers 0 … 255"),
        (_data(_colour(srgb=[1, 2, 256])), "256"),
        (_data(_colour(srgb=[1, 2, float("nan")])), "nan"),
        (_data(_colour(srgb=[1, 2, True])), "True"),
        (_data(_colour(srgb="black")), "'black'"),
        (_data(colour=[_colour(), _colour(name="white", code=1, srgb=[0, 0, 0])]), "white has no light"),
    ],
)
def test_mistakes_are_named_with_their_place(data: dict[str, Any], word: str) -> None:
    with pytest.raises(UsageError, match=word) as caught:
        Palette.of(data, "mine")
    assert "palette 'mine'" in str(caught.value)


def test_arrays_that_do_not_fit() -> None:
    light = np.zeros((2, 3), np.float32)
    with pytest.raises(UsageError, match="3 names, 2 codes"):
        Palette("x", "t", "p", ("a", "b", "c"), (0, 1), light)
    with pytest.raises(UsageError, match="NaN"):
        Palette("x", "t", "p", ("a", "b"), (0, 1), light + np.float32(np.nan))
