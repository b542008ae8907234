"""``halftone preview``: to a file, to stdout, and on a terminal."""

from __future__ import annotations

import os
import pty
import re
import subprocess
import termios
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from devices.preview import SEPARATOR, Preview
from devices.profile import load
from halftone.cli.terminal import RAMP, lines, reduced
from tests.cli.command import environment, names_in, run, script
from tests.cli.files import GRAY, codes_of, header_of, light_of, shown

COLUMNS = 60
CELL = re.compile(r"(?:\x1b\[38;2;(\d+);\1;\1m)?(?:\x1b\[48;2;(\d+);\2;\2m)?▀")


def on_terminal(*args: str | Path, columns: int = COLUMNS, **env: str) -> str:
    """What ``halftone *args*`` writes to a terminal of *columns*."""
    ours, theirs = pty.openpty()
    termios.tcsetwinsize(theirs, (24, columns))
    changes = {
        "TERM": "xterm-256color",
        "PYTHONIOENCODING": "utf-8",
        "NO_COLOR": "",
        "COLUMNS": "",
    } | env
    process = subprocess.Popen(
        [script(), *map(str, args)],
        stdin=subprocess.DEVNULL,
        stdout=theirs,
        stderr=subprocess.PIPE,
        env=environment(changes),
    )
    os.close(theirs)
    parts = []
    try:
        while part := os.read(ours, 65536):
            parts.append(part)
    except OSError:  # the other side is closed
        pass
    os.close(ours)
    _, error = process.communicate(timeout=60)
    assert process.returncode == 0, error.decode()
    return b"".join(parts).decode().replace("\r\n", "\n")


def pixels(text: str) -> np.ndarray:
    """Codes of the half blocks of one picture on a terminal, two rows a line."""
    rows = []
    for line in text.splitlines():
        assert line.endswith("\x1b[0m")
        cells, upper, lower, done = [], -1, -1, 0
        for cell in CELL.finditer(line):
            assert cell.start() == done, line
            done = cell.end()
            upper = upper if cell[1] is None else int(cell[1])
            lower = lower if cell[2] is None else int(cell[2])
            cells.append((upper, lower))
        assert line[done:] == "\x1b[0m"
        rows += [[c[0] for c in cells], [c[1] for c in cells]]
    return np.array(rows)


def test_the_file_is_the_preview(gray: Path, tmp_path: Path) -> None:
    options = ("-d", "receipt-58mm", "--width", "80", "-q")
    assert run("preview", gray, tmp_path / "a.png", *options).code == 0
    Preview.of(str(gray), profile=load("receipt-58mm"), width=80).save(tmp_path / "b.png")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    piped = run("preview", "-", "-", *options, input=gray.read_bytes())
    assert piped.out == (tmp_path / "a.png").read_bytes()
    assert run("convert", gray, tmp_path / "c.png", "--preview", *options).code == 0
    assert (tmp_path / "c.png").read_bytes() == piped.out


def test_scale_panel_and_distance(gray: Path) -> None:
    options = ("-l", "3", "--scale", "3")
    assert header_of(run("preview", gray, "-", *options).out) == (3 * 123 + 2 * SEPARATOR, 72, 8, 0)
    one = run("preview", gray, "-", *options, "--panel", "asked").out
    assert header_of(one) == (123, 72, 8, 0)
    assert np.array_equal(shown(one)[::3, ::3], GRAY)
    device = ("-d", "receipt-58mm", "--width", "60", "--panel", "seen", "-q")
    far, near = (run("preview", gray, "-", *device, "--distance", d).out for d in ("60", "0"))
    assert 0 < np.std(shown(far).astype(float)) < 0.9 * np.std(shown(near).astype(float))


def test_without_dots_an_inch_a_distance_is_noted(gray: Path, tmp_path: Path) -> None:
    done = run("preview", gray, tmp_path / "o.png", "--distance", "50")
    assert done.code == 0
    assert "how many dots" in done.err


@pytest.mark.parametrize(
    ("args", "what"),
    [
        (("a.png", "b.png", "c.png"), "paths given: 3"),
        (("IN", "out.pbm"), "a preview is a PNG, not pbm"),
        (("IN", "IN"), "is the input itself"),
        (("IN",), "stdout is no terminal"),
        (("IN", "o.png", "--scale", "0"), "scale=0"),
        (("IN", "o.png", "--panel", "dots"), "panel 'dots'"),
        (("IN", "o.png", "--distance", "-1"), "distance -1 cm"),
        (("IN", "o.png", "-l", "0.5,0.1"), "levels fall"),
    ],
)
def test_mistakes_in_the_command(args: tuple[str, ...], what: str, gray: Path, tmp_path: Path) -> None:
    named = [str(gray) if arg == "IN" else arg for arg in args]
    assert what in run("preview", *named, cwd=tmp_path).complaint(2)
    assert names_in(tmp_path) == []


def test_pictures_that_cannot_be_shown(gray: Path, tmp_path: Path) -> None:
    out = tmp_path / "o.png"
    assert "none.png" in run("preview", tmp_path / "none.png", out).complaint(3)
    line = run("preview", "-", out, input=gray.read_bytes()[:60]).complaint(3)
    assert "stdin" in line
    assert "/proc/" not in line
    line = run("preview", gray, out, "--scale", "200", "--max-memory", "1").complaint(3)
    assert "--max-memory" in line
    assert names_in(tmp_path) == []
    out.write_bytes(b"kept")
    assert "exists" in run("preview", gray, out, "--no-overwrite").complaint(1)
    assert out.read_bytes() == b"kept"


def test_a_terminal_shows_half_blocks_of_the_mean_light(gray: Path) -> None:
    text = on_terminal("preview", gray, "--panel", "asked", columns=20)
    blocks = pixels(text)
    assert blocks.shape == (12, 20)
    light = reduced(light_of(GRAY).astype(np.float32), 12, 20)
    assert np.abs(blocks - codes_of(light)).max() <= 0.51


def test_a_terminal_shows_three_panels_and_no_more_pixels_than_there_are(gray: Path) -> None:
    text = on_terminal("preview", gray, "-l", "2")
    wide = [CELL.sub("#", line).replace("\x1b[0m", "") for line in text.splitlines()]
    assert set(wide) == {"#" * 19 + " " + "#" * 19 + " " + "#" * 19}
    assert pixels(on_terminal("preview", gray, "--panel", "sent", columns=200)).shape == (24, 41)


@pytest.mark.parametrize(
    "env", [{"NO_COLOR": "1"}, {"TERM": "dumb"}, {"PYTHONIOENCODING": "ascii"}], ids=str
)
def test_a_terminal_without_colours_gets_letters(env: dict[str, str], gray: Path) -> None:
    text = on_terminal("preview", gray, "--panel", "asked", columns=20, **env)
    assert set(text) <= {*RAMP, "\n"}
    ranks = [RAMP.index(letter) for letter in text.splitlines()[3]]
    assert len(ranks) == 20
    assert ranks == sorted(ranks)
    assert (ranks[0], ranks[-1]) == (0, len(RAMP) - 1)


def test_dots_that_are_not_square_keep_the_shape_of_the_print() -> None:
    light = np.zeros((100, 50), np.float32)
    assert len([*lines([light], 25, True)]) == 25
    assert len([*lines([light], 25, True, aspect=2.0)]) == 50
    assert len([*lines([light], 1, False)]) == 1


@given(
    st.integers(1, 9), st.integers(1, 9), st.integers(1, 9), st.integers(1, 9), st.integers(0, 2**32 - 1)
)
def test_reduced_is_the_mean_over_the_area(
    height: int, width: int, rows: int, columns: int, seed: int
) -> None:
    light = np.random.default_rng(seed).random((height, width), np.float32)
    fine = light.astype(np.float64).repeat(rows, axis=0).repeat(columns, axis=1)
    wanted = fine.reshape(rows, height, columns, width).mean(axis=(1, 3))
    np.testing.assert_allclose(reduced(light, rows, columns), wanted, atol=1e-12)
