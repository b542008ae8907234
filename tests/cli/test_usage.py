"""What is asked for and does not exist: one line, a near match, the right exit code."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.command import run


@pytest.mark.parametrize(
    ("args", "code", "words"),
    [
        (("-m", "floyd-stienberg"), 2, ("'floyd-stienberg'", "Did you mean floyd-steinberg")),
        (("-m", "bayer3"), 2, ("'bayer3'", "Did you mean", "bayer2")),
        (("-m", "zzz"), 2, ("'zzz'", "Allowed: atkinson")),
        (("-m", "stucki:rastr"), 2, ("'rastr'", "raster")),
        (("-m", "fs:strength=x"), 2, ("'x'", "number")),
        (("-d", "recept-80mm"), 4, ("'recept-80mm'", "Did you mean receipt-80mm")),
        (("-d", "nowhere/mine.toml"), 4, ("nowhere/mine.toml",)),
        (("--device="), 4, ("device", "generic-1bit")),
        (("--wdith", "5"), 2, ("--wdith", "--width")),
        (("-l", "foo"), 2, ("'foo'", "uniform-linear:N", "lstar:N")),
        (("-l", "lstra:4"), 2, ("'lstra:4'", "lstar:N")),
        (("-l", "1"), 2, ("2 … 256",)),
        (("-l", "257"), 2, ("2 … 256",)),
        (("-l", "0.5,0.2"), 2, ("fall", "0.5", "0.2")),
        (("-l", "0.5,0.5"), 2, ("0.5",)),
        (("-l", "0,nan"), 2, ("NaN",)),
        (("-l", "log:0:4"), 2, ("I0", "above 0")),
        (("-l", "log:0.02"), 2, ("log:I0:N",)),
        (("--encoding", "sgrb"), 2, ("'sgrb'", "Did you mean srgb")),
        (("--gamma", "nan"), 2, ("nan",)),
        (("--range", "clap"), 2, ("'clap'", "Did you mean clip")),
        (("--fit", "covr"), 2, ("'covr'", "cover")),
        (("--nonfinite", "x"), 2, ("'x'", "clip")),
        (("--strength", "2"), 2, ("strength", "0", "1")),
        (("--strength", "nan"), 2, ("strength",)),
        (("--strength", "x"), 2, ("strength",)),
        (("--strength", "0.5", "-m", "threshold"), 2, ("strength", "threshold")),
        (("--seed", "3"), 2, ("seed", "floyd-steinberg")),
        (("--seed", "-1", "-m", "random"), 2, ("seed",)),
        (("--serpentine", "-m", "bayer8"), 2, ("serpentine", "bayer8")),
        (("--brightness", "2"), 2, ("brightness",)),
        (("--contrast", "nan"), 2, ("contrast",)),
        (("--format", "jpg"), 2, ("'jpg'", "png")),
        (("--max-memory", "x"), 2, ("'x'", "500M")),
        (("--max-memory", "0"), 2, ("0",)),
    ],
)
def test_of_convert(
    args: tuple[str, ...], code: int, words: tuple[str, ...], gray: Path, tmp_path: Path
) -> None:
    args = (args,) if isinstance(args, str) else args
    line = run("convert", gray, tmp_path / "out.png", *args).complaint(code)
    for word in words:
        assert word in line, line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("args", "word"),
    [
        (("convrt", "a", "b"), "convrt"),
        (("convert",), "IN"),
        (("convert", "a.png"), "OUT"),
        (("list",), "methods"),
        (("list", "method"), "methods"),
        (("cache",), "warm"),
        (("cache", "wram"), "warm"),
        (("demo", "a.png", "b.png"), "b.png"),
        (("--nonsense",), "--nonsense"),
    ],
)
def test_of_commands(args: tuple[str, ...], word: str) -> None:
    assert word in run(*args).complaint(2)


def test_usage_is_judged_before_the_picture(tmp_path: Path) -> None:
    """An unknown method is said even where the picture is missing, too."""
    args = ("convert", tmp_path / "missing.png", tmp_path / "out.png", "-m", "stuki")
    assert "stucki" in run(*args).complaint(2)


def test_a_dark_ladder_is_noted_in_one_line(gray: Path, tmp_path: Path) -> None:
    """A warning, for a user of the command: no path and no source code of ours."""
    result = run("convert", gray, tmp_path / "out.png", "-l", "log:0.0001:4")
    line = result.complaint(0)
    assert "0.0001" in line


def test_a_long_name_of_a_device_is_an_unknown_one(gray: Path, tmp_path: Path) -> None:
    run("convert", gray, tmp_path / "out.png", "-d", "x" * 300).complaint(4)


def test_options_may_stand_between_inputs(gray: Path, tmp_path: Path) -> None:
    twin = tmp_path / "twin.png"
    twin.write_bytes(gray.read_bytes())
    out = tmp_path / "out"
    result = run("convert", gray, "-m", "fs", twin, "--width", "9", f"{out}/")
    assert (result.code, result.err) == (0, "")
    assert sorted(p.name for p in out.iterdir()) == sorted([gray.name, "twin.png"])


def test_a_default_that_is_given_counts(gray: Path, tmp_path: Path) -> None:
    args = ("convert", gray, tmp_path / "o.png", "-m", "none")
    assert "does not apply" in run(*args, "--seed", "0").complaint(2)
    assert "does not apply" in run(*args, "--strength", "1").complaint(2)
    assert "width and a height" in run(*args, "--width", "5", "--fit", "cover").complaint(2)


def test_list_screens() -> None:
    result = run("list", "screens", "--dpi", "203")
    assert result.code == 0
    assert "screen:round@45:60lpi" in result.text
    run("list", "screens", "--dpi", "3").complaint(2)
    run("list", "methods", "--dpi", "203").complaint(2)
