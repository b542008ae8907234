"""``--json``: what was done, what was left out, and how long it took."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from tests.cli.command import run


def _stages(picture: dict[str, Any]) -> list[str]:
    return [stage["stage"] for stage in picture["stages"]]


def test_says_what_was_done(gray: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.png"
    result = run("convert", gray, out, "--json", "-l", "0,0.5,1", "-m", "STUCKI")
    assert (result.code, result.err) == (0, "")
    report = json.loads(result.text)
    assert report["failed"] == 0
    (picture,) = report["pictures"]
    assert picture["input"] == str(gray)
    assert picture["output"] == str(out)
    assert (picture["width"], picture["height"]) == (41, 24)
    assert picture["method"] == "stucki"
    assert picture["levels"] == [0, 0.5, 1]
    assert _stages(picture) == ["read", "dither", "write"]
    assert all(0 <= stage["seconds"] < 30 for stage in picture["stages"])
    assert sum(stage["seconds"] for stage in picture["stages"]) <= picture["seconds"] + 0.001
    assert picture["stages"][-1]["bytes"] == out.stat().st_size
    left_out = {entry["stage"]: entry["why"] for entry in picture["left_out"]}
    assert {"alpha", "resize", "adjust"} <= set(left_out)
    assert all(left_out.values())


def test_what_is_done_is_not_left_out(gray: Path, tmp_path: Path) -> None:
    args = ("--json", "--width", "30", "--contrast", "0.2")
    result = run("convert", gray, tmp_path / "out.png", *args)
    (picture,) = json.loads(result.text)["pictures"]
    assert _stages(picture) == ["read", "resize", "adjust", "dither", "write"]
    assert not {entry["stage"] for entry in picture["left_out"]} & set(_stages(picture))


def test_alpha_is_said_where_it_is_done(tmp_path: Path) -> None:
    Image.new("LA", (4, 3), (0, 128)).save(tmp_path / "in.png")
    result = run("convert", tmp_path / "in.png", tmp_path / "out.png", "--json")
    (picture,) = json.loads(result.text)["pictures"]
    assert "alpha" not in {entry["stage"] for entry in picture["left_out"]}
    said = [{**stage, "file": ""} for stage in picture["stages"]]  # the path holds any word
    assert "alpha" in json.dumps([said, picture["notes"]])


def test_goes_to_stderr_beside_a_picture_on_stdout(gray: Path) -> None:
    plain = run("convert", gray, "-")
    result = run("convert", gray, "-", "--json")
    assert result.code == 0
    assert result.out == plain.out
    assert json.loads(result.err)["pictures"][0]["output"] == "-"


def test_names_the_failed_ones_too(gray: Path, tmp_path: Path) -> None:
    bad = tmp_path / "bad.png"
    bad.write_bytes(b"nothing")
    result = run("convert", gray, bad, tmp_path / "out", "--json")
    line = result.complaint(3)
    report = json.loads(result.text)
    assert report["failed"] == 1
    good, failed = report["pictures"]
    assert "error" not in good
    assert failed["exit_code"] == 3
    assert line == f"halftone: {failed['error']}"


@pytest.mark.parametrize("name", ["ä ö 日本.png", 'quote".png', "new\nline.png"])
def test_holds_any_name(name: str, gray: Path, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(gray.read_bytes())
    result = run("convert", tmp_path / name, tmp_path / "out.png", "--json")
    assert (result.code, result.err) == (0, "")
    assert json.loads(result.text)["pictures"][0]["input"] == str(tmp_path / name)
