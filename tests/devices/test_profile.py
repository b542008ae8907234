"""Device profiles: ours, a user's own, and every mistake with its place."""

from __future__ import annotations

from pathlib import Path

import pytest

from devices.profile import DeviceProfile, folders, load, names
from halftone.errors import DeviceNotFoundError, UsageError
from halftone.tone.levels import Levels

OURS = sorted(p.stem for p in (Path(__file__).parents[2] / "devices" / "profiles").glob("*.toml"))
HEAD = 'title = "a test"\nprovenance = "made up"\n'


@pytest.fixture(autouse=True)
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's folder of profiles, empty."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    folder = tmp_path / "config" / "halftone" / "profiles"
    folder.mkdir(parents=True)
    return folder


def _written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "made.toml"
    path.write_text(HEAD + text)
    return path


def _mistake(tmp_path: Path, text: str) -> str:
    path = _written(tmp_path, text)
    with pytest.raises(UsageError) as caught:
        load(path)
    return str(caught.value)


def test_there_are_ours() -> None:
    assert set(OURS) >= {"epaper-4gray", "framebuffer-16", "generic-1bit", "receipt-80mm"}
    assert names() == OURS


@pytest.mark.parametrize("name", OURS)
def test_ours_load(name: str) -> None:
    made = load(name)
    assert made.name == name
    assert made.title
    assert made.provenance
    assert 2 <= len(made.levels) <= 1 << made.packing.bits
    assert made.packing.bits == made.bits
    assert (made.dpi is None) == (made.dpi_x is None)
    if made.codes is not None:
        assert len(made.codes) == len(made.levels)


@pytest.mark.parametrize("name", OURS)
def test_ours_convert(name: str) -> None:
    import numpy as np

    import halftone

    frame = halftone.convert(np.full((40, 60), 0.5, np.float32), profile=load(name))
    made = load(name)
    assert made.width in (None, frame.shape[1])
    assert made.height in (None, frame.shape[0])
    assert frame.packed().shape == (frame.shape[0], (frame.shape[1] * made.bits + 7) // 8)
    assert frame.dpi == made.dpi


def test_figures_of_ours() -> None:
    receipt = load("receipt-80mm")
    assert (receipt.width, receipt.height, receipt.dpi) == (576, None, (203.2, 203.2))
    assert receipt.packing.codes == (1, 0)
    paper = load("epaper-4gray")
    assert (paper.width, paper.height, paper.bits, len(paper.levels)) == (400, 300, 2, 4)


def test_fields_and_their_defaults(tmp_path: Path) -> None:
    made = load(_written(tmp_path, ""))
    assert (made.name, made.title, made.provenance) == ("made", "a test", "made up")
    assert (made.width, made.height, made.dpi, made.method) == (None, None, None, None)
    assert made.levels.luminance.tolist() == [0, 1]
    assert (made.packing.bits, made.packing.order, made.packing.codes) == (1, "msb", None)


def test_all_fields(tmp_path: Path) -> None:
    text = """
    name = "panel"
    width = 100
    height = 50
    dpi_x = 96
    dpi_y = 48.5
    level_luminance = [0.02, 0.3, 1]
    bits = 2
    bit_order = "lsb"
    codes = [3, 1, 0]
    default_method = "stucki"
    """
    made = load(_written(tmp_path, text))
    assert (made.name, made.width, made.height, made.dpi) == ("panel", 100, 50, (96, 48.5))
    assert made.levels.luminance.tolist() == pytest.approx([0.02, 0.3, 1])
    assert (made.packing.bits, made.packing.order, made.packing.codes) == (2, "lsb", (3, 1, 0))
    assert made.method == "stucki"


@pytest.mark.parametrize(("levels", "count"), [("16", 16), ('"lstar:4"', 4), ('"0.1,0.9"', 2)])
def test_forms_of_levels(levels: str, count: int, tmp_path: Path) -> None:
    made = load(_written(tmp_path, f"level_luminance = {levels}\nbits = 8\n"))
    expected = Levels.of(levels.strip('"'))
    assert made.levels.luminance.tolist() == expected.luminance.tolist()
    assert len(made.levels) == count


@pytest.mark.parametrize(
    ("key", "meant"),
    [("widht", "width"), ("level_luminence", "level_luminance"), ("bitorder", "bit_order"),
     ("dpix", "dpi_x"), ("methods", "default_method")],
)  # fmt: skip
def test_an_unknown_key_is_named_with_its_place(key: str, meant: str, tmp_path: Path) -> None:
    message = _mistake(tmp_path, f"{key} = 5\n")
    assert str(tmp_path / "made.toml") in message
    assert f"'{key}'" in message
    assert meant in message
    if key != "methods":
        assert f"Did you mean {meant}" in message


def test_a_table_is_an_unknown_key(tmp_path: Path) -> None:
    assert "'panel'" in _mistake(tmp_path, "[panel]\nwidth = 5\n")


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("name", "5"),
        ("width", '"576"'),
        ("width", "576.0"),
        ("width", "true"),
        ("height", "[1]"),
        ("dpi_x", '"203"'),
        ("dpi_x", "false"),
        ("bits", '"1"'),
        ("bits", "1.0"),
        ("bits", "true"),
        ("bit_order", "1"),
        ("level_luminance", "2.5"),
        ("level_luminance", "true"),
        ("level_luminance", '["0", "1"]'),
        ("level_luminance", "[true, false]"),
        ("level_luminance", "{black = 0}"),
        ("codes", "1"),
        ("codes", '["1", "0"]'),
        ("codes", "[1.5, 0]"),
        ("default_method", "1"),
        ("default_method", '["fs"]'),
    ],
)
def test_a_wrong_type_is_named_with_its_place(key: str, value: str, tmp_path: Path) -> None:
    message = _mistake(tmp_path, f"{key} = {value}\n")
    assert str(tmp_path / "made.toml") in message
    assert key in message
    assert "allowed" in message
    assert "tuple" not in message


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("width = 0", "width"),
        ("width = -5", "width"),
        ("height = 2000000", "height"),
        ("dpi_x = nan\ndpi_y = 1", "dpi_x"),
        ("dpi_x = inf\ndpi_y = 1", "dpi_x"),
        ("dpi_x = 100", "dpi_y"),
        ("level_luminance = 4", "bits"),
        ("level_luminance = 17\nbits = 4", "17 levels"),
        ("codes = []", "codes"),
        ("codes = [1]", "1 codes for 2 levels"),
        ("bits = 2\ncodes = [1, 0, 2]", "3 codes for 2 levels"),
        ("bits = 3", "bits"),
        ('bit_order = "big"', "bit order"),
        ("codes = [1, 1]", "twice"),
        ("codes = [2, 0]", "bits"),
        ("level_luminance = [1, 0]", "fall"),
        ("level_luminance = [0.5, nan]", "NaN"),
        ('level_luminance = "lstra:4"', "lstra:4"),
        ("level_luminance = 1", "levels"),
    ],
)
def test_a_mistake_in_a_value_is_named_with_its_place(text: str, word: str, tmp_path: Path) -> None:
    message = _mistake(tmp_path, text + "\n")
    assert word in message
    assert "made" in message, "nothing says which profile"


@pytest.mark.parametrize(("text", "word"), [("", "title and provenance"), ('title = "x"', "provenance")])
def test_what_is_missing_is_named(text: str, word: str, tmp_path: Path) -> None:
    path = tmp_path / "made.toml"
    path.write_text(text)
    with pytest.raises(UsageError, match=word):
        load(path)


def test_no_toml(tmp_path: Path) -> None:
    message = _mistake(tmp_path, "width = = 5\n")
    assert "TOML" in message
    assert str(tmp_path / "made.toml") in message
    (tmp_path / "made.toml").write_bytes(HEAD.encode() + b'name = "\xff"\n')
    with pytest.raises((UsageError, DeviceNotFoundError), match=r"made\.toml"):
        load(tmp_path / "made.toml")


def test_no_such_device(tmp_path: Path) -> None:
    with pytest.raises(DeviceNotFoundError, match="Did you mean receipt-80mm"):
        load("receipt80mm")
    with pytest.raises(DeviceNotFoundError, match="no such file"):
        load(tmp_path / "none.toml")
    for name in ("", ".", "../profiles/generic-1bit.x", "x" * 300):
        with pytest.raises(DeviceNotFoundError):
            load(name)


def test_the_users_own_come_first(own: Path) -> None:
    assert load("generic-1bit").width is None
    (own / "generic-1bit.toml").write_text(HEAD + "width = 77\n")
    (own / "mine.toml").write_text(HEAD + "width = 78\n")
    assert folders()[0] == own
    assert load("generic-1bit").width == 77
    assert load("mine").width == 78
    assert names() == sorted([*OURS, "mine"])


def test_a_home_folder_without_xdg(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("XDG_CONFIG_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    folder = tmp_path / ".config" / "halftone" / "profiles"
    folder.mkdir(parents=True)
    (folder / "mine.toml").write_text(HEAD)
    assert "mine" in names()


def test_a_profile_in_python() -> None:
    made = DeviceProfile("mine", "a test", "made up", (0.1, 0.9), width=5)
    assert made.levels.luminance.tolist() == pytest.approx([0.1, 0.9])
    with pytest.raises(UsageError, match="mine"):
        DeviceProfile("mine", "a test", "made up", width=0)


@pytest.mark.parametrize("pairs", ["[[0.0, 0.0], [1.0, 1e-300]]", "[[1.5, 0.1], [1.6, 1.9]]"])
def test_measured_luminances_that_do_not_rise_from_ink_to_paper(tmp_path: Path, pairs: str) -> None:
    text = f'title = "t"\nprovenance = "p"\ndot_x = 1.4\ndot_y = 1.4\nmeasured = {pairs}\n'
    (tmp_path / "x.toml").write_text(text)
    with pytest.raises(UsageError, match="measured: from ink to paper"):
        load(tmp_path / "x.toml")
