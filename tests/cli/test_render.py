"""``halftone render`` and ``halftone plan``: a scene file to a picture file, and why."""

import json

import numpy as np
import pytest
from PIL import Image

from tests.cli.command import names_in, run

SCENE = """
background = 0.25
[camera]
eye = [0, 2, 5]
[[lights]]
kind = "distant"
direction = [-1, -1, -1]
[[materials]]
diffuse = [0.8, 0.4, 0.2]
[[meshes]]
shape = "sphere"
u = 24
v = 12
"""
MESH = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\n"


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    return path


def test_a_scene_becomes_dots_of_the_device(scene, tmp_path):
    out = tmp_path / "out.png"
    done = run("render", scene, out, "--device", "receipt-80mm", "--json")
    assert (done.code, done.err) == (0, "")
    image = Image.open(out)
    assert (image.mode, image.size) == ("1", (576, 432))
    assert 0.1 < np.asarray(image).mean() < 0.9
    report = json.loads(done.text)
    assert (report["width"], report["height"], report["levels"]) == (576, 432, [0.0, 1.0])
    assert report["why"][0] == "576 dots wide: rendered at 576"
    assert "resize" in [stage["stage"] for stage in report["left_out"]]
    assert names_in(tmp_path) == ["out.png", "scene.toml"]


@pytest.mark.parametrize("shading", ["flat", "gouraud", "phong", "fast-phong"])
def test_every_shading_and_what_is_not_shown_is_the_background(scene, tmp_path, shading):
    out = tmp_path / "out.pgm"
    options = ("--shading", shading, "--size", "64x48", "-l", "uniform-linear:256", "-m", "none")
    assert run("render", scene, out, *options).code == 0
    shown = np.asarray(Image.open(out)).astype(float)
    assert shown.shape == (48, 64)
    assert len(np.unique(shown[10:38, 20:44])) > 5  # the ball has tones
    assert len(np.unique(shown[:, 0])) == 1  # the background has one


def test_the_light_is_that_of_halftone_render(scene, tmp_path):
    import halftone

    out = tmp_path / "out.png"
    assert run("render", scene, out, "--size", "60x40", "-m", "bayer8", "-l", "4").code == 0
    light = halftone.render(scene, 60, 40).radiance
    wanted = halftone.dither(light, "bayer8", levels=4)
    assert np.array_equal(np.asarray(Image.open(out).convert("L")), wanted.preview())


def test_a_bare_mesh_is_framed_and_what_was_left_out_said(tmp_path):
    mesh = tmp_path / "bunny.obj"
    mesh.write_text(MESH)
    out = tmp_path / "out.png"
    done = run("render", mesh, out, "--size", "64x64", "-m", "none", "-l", "16")
    assert done.code == 0
    assert "1 × 'l' left out" in done.err
    shown = np.asarray(Image.open(out).convert("L"))
    assert 0.1 < (shown < 255).mean() < 0.9
    assert (shown[[0, -1]] == 255).all()  # all of it is in the picture
    assert (shown[:, [0, -1]] == 255).all()


@pytest.mark.parametrize(
    ("size", "shape"), [("100x", (75, 100)), ("x75", (75, 100)), ("7x9", (9, 7)), (None, (384, 512))]
)
def test_sizes(scene, tmp_path, size, shape):
    out = tmp_path / "out.pbm"
    given = [] if size is None else ["--size", size]
    assert run("render", scene, out, *given).code == 0
    assert np.asarray(Image.open(out)).shape == shape


@pytest.mark.parametrize(
    ("options", "code", "text"),
    [
        (["--shading", "fong"], 2, "Did you mean"),
        (["--samples", "0"], 2, "samples=0"),
        (["--size", "0x5"], 2, "0"),
        (["--device", "toaster"], 4, "toaster"),
        (["--device", "receipt-80mm", "--size", "600x10"], 2, "576"),
        (["-m", "floid-steinberg"], 2, "Did you mean"),
        (["--levels", "4", "--format", "pbm"], 2, "PBM holds 2 levels"),
        (["--upscale", "0"], 2, "upscale"),
        (["--size", "100000x100000"], 3, "MiB"),
    ],
)
def test_wrong_options_are_one_line(scene, tmp_path, options, code, text):
    done = run("render", scene, tmp_path / "out.png", *options)
    assert text in done.complaint(code)
    assert names_in(tmp_path) == ["scene.toml"]


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (SCENE.replace("diffuse", "difuse"), "mean diffuse"),
        (SCENE + 'file = "../a.obj"\n', "file and shape"),
        ('[[lights]]\nkind = "area"\n', "area lights are not there yet"),
        ("[camera]\nfov = 0\n", "fov"),
        (SCENE.replace('"distant"', '"point"\nposition = [0, 0, 1e30]'), "lights[0].position"),
    ],
)
def test_wrong_scenes_are_one_line(tmp_path, content, text):
    path = tmp_path / "scene.toml"
    path.write_text(content)
    for words in (["render", path, tmp_path / "out.png"], ["plan", path]):
        line = run(*words).complaint(3)
        assert text in line
        assert "scene.toml" in line
    assert names_in(tmp_path) == ["scene.toml"]


def test_nothing_to_see_is_no_error_but_said(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text("background = 1\n")
    done = run("render", path, tmp_path / "out.pbm", "--size", "8x8")
    assert done.code == 0
    assert "nothing is visible" in done.err
    assert np.asarray(Image.open(tmp_path / "out.pbm")).all()


def test_plan_says_what_is_left_out_and_why(scene):
    done = run("plan", scene, "--device", "receipt-80mm")
    assert (done.code, done.err) == (0, "")
    for text in ("576 dots wide: rendered at 576", "no specular coefficient", "luminance only"):
        assert text in done.text
    lines = done.text.splitlines()
    assert all(line.startswith(("used", "left out")) for line in lines)


def test_plan_as_json(scene):
    rows = json.loads(run("plan", scene, "--json", "--shading", "flat").text)["stages"]
    assert {"stage", "used", "why"} <= set(rows[0])
    assert {row["used"] for row in rows} == {True, False}
    with_highlight = SCENE.replace("diffuse =", "specular = 0.5\ndiffuse =")
    scene.write_text(with_highlight)
    again = json.loads(run("plan", scene, "--json", "--shading", "flat").text)["stages"]
    used = [{row["stage"] for row in part if row["used"]} for part in (rows, again)]
    assert "specular" in used[1] - used[0]
