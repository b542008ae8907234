"""``halftone --help``, ``--version``, ``list`` and ``demo``."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.cli.command import run
from tests.cli.files import shown

COMMANDS = ("convert", "render", "plan", "demo", "list", "cache")


@pytest.mark.parametrize("args", [(), ("--help",), ("-h",)])
def test_help_names_all_commands_and_exit_codes(args: tuple[str, ...]) -> None:
    result = run(*args)
    assert (result.code, result.err) == (0, "")
    assert all(name in result.text for name in COMMANDS)
    assert "130 interrupted" in result.text


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_a_command(command: str) -> None:
    result = run(command, "--help")
    assert (result.code, result.err) == (0, "")
    assert result.text.startswith(f"usage: halftone {command}")


def test_version() -> None:
    import halftone

    result = run("--version")
    assert (result.code, result.text) == (0, f"halftone {halftone.__version__}\n")
    assert re.fullmatch(r"\d+\.\d+\.\d+\S*", halftone.__version__)


@pytest.mark.parametrize(
    ("what", "key", "names"),
    [
        ("methods", "method", ("floyd-steinberg", "bayer8", "none", "atkinson")),
        ("devices", "device", ("epaper-4gray", "framebuffer-16", "generic-1bit", "receipt-80mm")),
        ("encodings", "encoding", ("srgb", "bt709", "gamma:G", "linear")),
        ("levels", "levels", ("N", "uniform-linear:N", "lstar:N", "log:I0:N", "Y0,Y1,…")),
    ],
)
def test_list(what: str, key: str, names: tuple[str, ...]) -> None:
    plain, listed = run("list", what), run("list", what, "--json")
    assert (plain.code, plain.err, listed.code, listed.err) == (0, "", 0, "")
    rows = json.loads(listed.text)
    assert {row[key] for row in rows} >= set(names)
    lines = plain.text.splitlines()
    assert len(lines) == len(rows) + 1
    assert lines[0].split()[0] == key
    for row, line in zip(rows, lines[1:], strict=True):
        assert line.startswith(f"{row[key]} ")
        assert all(str(value) in line for value in row.values())


def test_every_listed_method_converts(gray: Path, tmp_path: Path) -> None:
    import halftone

    rows = json.loads(run("list", "methods", "--json").text)
    for row in rows:
        frame = halftone.convert(gray, method=row["method"])
        assert frame.shape == (24, 41)
        for alias in row["also"].split():
            assert np.array_equal(halftone.convert(gray, method=alias), frame)


@pytest.mark.parametrize("what", ["devices", "levels"])
@pytest.mark.parametrize("more", [(), ("--json",)])
def test_list_where_the_terminal_knows_ascii_only(what: str, more: tuple[str, ...]) -> None:
    result = run("list", what, *more, env={"PYTHONIOENCODING": "ascii"})
    assert (result.code, result.err) == (0, "")


def test_list_devices_has_the_users_own(tmp_path: Path) -> None:
    folder = tmp_path / "halftone" / "profiles"
    folder.mkdir(parents=True)
    (folder / "my-panel.toml").write_text('title = "Mine"\nprovenance = "a test"\nwidth = 123\n')
    text = run("list", "devices", env={"XDG_CONFIG_HOME": str(tmp_path)}).text
    assert "my-panel" in text
    assert "123" in text


def test_demo(tmp_path: Path) -> None:
    out = tmp_path / "strip.png"
    result = run("demo", out, "--width", "60")
    assert (result.code, result.err) == (0, "")
    assert str(out) in result.text
    codes = shown(out)
    assert codes.shape[1] > 3 * 60
    assert len(np.unique(codes)) > 50


def test_demo_of_a_picture_of_ones_own(gray: Path, tmp_path: Path) -> None:
    piped = run("demo", "-", "--picture", gray, "--width", "41")
    assert (piped.code, piped.err) == (0, "")
    assert shown(piped.out).shape[1] > 3 * 41
    named = run("demo", "--picture", gray, "--width", "41", cwd=tmp_path)
    assert named.code == 0
    assert (tmp_path / "halftone-demo.png").read_bytes() == piped.out


@pytest.mark.parametrize(
    ("args", "code"),
    [
        (("out.jpg",), 2),
        (("out.png", "--width", "1"), 2),
        (("out.png", "--picture", "missing.png"), 3),
        (("missing/out.png",), 1),
    ],
)
def test_demo_refuses(args: tuple[str, ...], code: int, tmp_path: Path) -> None:
    run("demo", *args, cwd=tmp_path).complaint(code)
    assert list(tmp_path.iterdir()) == []


def test_the_strip_shows_the_original_first(tmp_path: Path) -> None:
    """White in, white out on every tile that has white."""
    Image.new("L", (40, 20), 255).save(tmp_path / "white.png")
    piped = run("demo", "-", "--picture", tmp_path / "white.png", "--width", "40")
    assert (shown(piped.out)[6:26, 6:46] == 255).all()
