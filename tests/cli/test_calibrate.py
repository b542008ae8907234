"""``halftone calibrate``: chart, read, fit; and what is wrong is said in one line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.cli.command import run
from tests.devices.photographed import photo, printed

READINGS = "5.2,6.1,7.9,17.8,44.8,53.8,61.7,73.1,81.4"


def test_three_commands(tmp_path: Path, photograph: Path) -> None:
    env = {"XDG_CONFIG_HOME": str(tmp_path / "config")}
    chart = tmp_path / "chart.png"
    done = run("calibrate", "chart", "-d", "receipt-80mm", chart, env=env)
    assert done.code == 0, done.err
    from PIL import Image

    indices = (np.asarray(Image.open(chart).convert("L")) > 127).astype(np.uint8)
    photographed = tmp_path / "photo.jpg"
    photographed.write_bytes(photo(printed(indices, (1.6, 1.6), 0.06)))
    read = run("calibrate", "read", photographed, "--json")
    facts = json.loads(read.text)
    assert facts["steps"] == 9
    assert len(facts["light"]) == len(facts["spread"]) == 11
    fit = ("calibrate", "fit", "-d", "receipt-80mm", photographed, "--save", "mine")
    done = run(*fit, "--json", env=env)
    assert done.code == 0, done.err
    found = json.loads(done.text)
    assert found["dot"] == pytest.approx([1.6, 1.6], abs=0.08)
    assert Path(found["profile"]).is_file()
    assert "--force" in run(*fit, env=env).complaint(1)
    assert run(*fit, "--force", env=env).code == 0
    out = tmp_path / "out.png"
    assert run("convert", photograph, out, "-d", "mine", "-q", env=env).code == 0
    plain = tmp_path / "plain.png"
    assert run("convert", photograph, plain, "-d", "generic-1bit", "--width", "576", "-q").code == 0
    assert np.asarray(Image.open(out)).mean() > np.asarray(Image.open(plain)).mean()


def test_the_chart_goes_to_a_printer(tmp_path: Path) -> None:
    chart, job, back = (tmp_path / name for name in ("chart.png", "job.bin", "back.png"))
    assert run("calibrate", "chart", "-d", "receipt-80mm", chart).code == 0
    assert run("calibrate", "chart", "-d", "receipt-80mm", "--to", f"file:{job}").code == 0
    assert run("decode", job, back).code == 0
    from PIL import Image

    sent, there = (np.asarray(Image.open(p).convert("L")) for p in (chart, back))
    rows, columns = sent.shape
    # ESC/POS moves the few dots whose bytes would be a real-time command.
    assert ((there[:rows, :columns] > 127) != (sent > 127)).mean() < 1e-4


def test_typed_readings() -> None:
    done = run("calibrate", "fit", "-d", "receipt-80mm", "--readings", READINGS, "--noise", "1")
    assert done.code == 0, done.err
    assert "round dot" in done.text
    densities = ",".join(f"{-np.log10(float(v) / 100):.4f}" for v in READINGS.split(","))
    other = run(
        *("calibrate", "fit", "-d", "receipt-80mm", "--readings", densities, "--as", "density"),
        *("--noise", "1"),
    )
    assert other.text == done.text


@pytest.mark.parametrize(
    ("args", "complaint"),
    [
        (["chart", "x.png"], "which device"),
        (["chart", "-d", "receipt-80mm"], "where does the chart go"),
        (["chart", "-d", "receipt-80mm", "x.png", "--steps", "5"], "9 or 17"),
        (["chart", "-d", "epaper-4gray", "x.png"], "4 levels"),
        (["chart", "-d", "receipt-80mm", "x.png", "--noise", "2"], "--noise does not apply"),
        (["read"], "needs a PHOTO"),
        (["fit", "-d", "receipt-80mm"], "from what"),
        (["fit", "-d", "receipt-80mm", "--readings", "1,2,3"], "3 readings"),
        (["fit", "-d", "receipt-80mm", "--readings", "1,b"], "numbers with commas"),
        (["fit", "-d", "receipt-80mm", "--readings", READINGS, "--lines", "3"], "V,H"),
        (["fit", "-d", "receipt-80mm", "--readings", READINGS.replace("44.8", "75")], "number 5"),
        (["fit", "-d", "receipt-80mm", "--readings", READINGS.replace("44.8", "448")], "reading 5"),
    ],
    ids=lambda value: " ".join(value)[:40] if isinstance(value, list) else "",
)
def test_mistakes(args: list[str], complaint: str, tmp_path: Path) -> None:
    assert complaint in run("calibrate", *args, cwd=tmp_path).complaint(2)
    assert not list(tmp_path.iterdir())


def test_no_chart_in_the_photo(photograph: Path) -> None:
    assert "no chart was found" in run("calibrate", "read", photograph).complaint(3)


def test_no_profile_of_ours_is_hidden_without_force(tmp_path: Path) -> None:
    env = {"XDG_CONFIG_HOME": str(tmp_path)}
    args = ("calibrate", "fit", "-d", "receipt-80mm", "--readings", "1,4,9,14,22,32,44,60,80", "--save")
    result = run(*args, "generic-1bit", env=env)
    assert (result.code, "a profile 'generic-1bit' exists" in result.err) == (1, True)
    assert list(tmp_path.iterdir()) == []
    assert run(*args, "generic-1bit", "--force", env=env).code == 0


def test_options_that_do_not_apply_are_refused_whatever_they_say(tmp_path: Path) -> None:
    for option in (("--noise", "0"), ("--readings", ""), ("--save", "")):
        result = run("calibrate", "chart", "-d", "receipt-80mm", tmp_path / "c.png", *option)
        assert (result.code, "does not apply" in result.err) == (2, True)
    assert run("calibrate", "chart", "-d", "receipt-80mm", tmp_path / "c.png", "--steps", "0").code == 2
