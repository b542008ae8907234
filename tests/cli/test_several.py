"""Several inputs: into a folder, by several threads, and one bad picture among them."""

from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image

from tests.cli.command import run
from tests.cli.files import shown


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory, photograph: Path) -> list[Path]:
    """Six parts of the photograph, of different sizes."""
    folder = tmp_path_factory.mktemp("parts")
    paths = [folder / f"part{k}.png" for k in range(6)]
    with Image.open(photograph) as picture:
        for k, path in enumerate(paths):
            picture.crop((40 * k, 20 * k, 40 * k + 100 + 17 * k, 20 * k + 140)).save(path)
    return paths


def test_one_file_each_in_the_folder(pictures: list[Path], tmp_path: Path) -> None:
    result = run("convert", *pictures, tmp_path / "new" / "folder", "--format", "pgm")
    assert (result.code, result.out, result.err) == (0, b"", "")
    for k, path in enumerate(pictures):
        assert shown(tmp_path / "new" / "folder" / f"{path.stem}.pgm").shape == (140, 100 + 17 * k)


@pytest.mark.parametrize("jobs", ["2", "0", "5"])
def test_the_bytes_do_not_depend_on_the_jobs(jobs: str, pictures: list[Path], tmp_path: Path) -> None:
    args = ("-l", "4", "-m", "jjn", "--width", "90")
    assert run("convert", *pictures, tmp_path / "1", *args).code == 0
    assert run("convert", *pictures, tmp_path / "n", *args, "-j", jobs).code == 0
    for path in pictures:
        name = f"{path.stem}.png"
        assert (tmp_path / "n" / name).read_bytes() == (tmp_path / "1" / name).read_bytes()


@pytest.mark.parametrize("method", ["bayer8", "random:seed=3", "floyd-steinberg:raster"])
def test_nor_with_threads_within_one_picture(method: str, photo_png: Path, tmp_path: Path) -> None:
    for jobs in "13":
        args = ("convert", photo_png, tmp_path / f"{jobs}.png", "-m", method, "-j", jobs)
        assert run(*args).code == 0
    assert (tmp_path / "3.png").read_bytes() == (tmp_path / "1.png").read_bytes()


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_a_bad_one_is_named_and_the_others_are_converted(
    jobs: str, pictures: list[Path], tmp_path: Path
) -> None:
    bad = tmp_path / "bad.png"
    bad.write_bytes(pictures[0].read_bytes()[:500])
    line = run("convert", *pictures[:2], bad, *pictures[2:4], tmp_path / "out", "-j", jobs).complaint(3)
    assert str(bad) in line
    names = sorted(p.name for p in (tmp_path / "out").iterdir())
    assert names == ["part0.png", "part1.png", "part2.png", "part3.png"]


def test_every_bad_one_has_its_line(pictures: list[Path], tmp_path: Path) -> None:
    empty, missing = tmp_path / "empty.png", tmp_path / "missing.png"
    empty.touch()
    result = run("convert", empty, pictures[0], missing, tmp_path / "out")
    assert result.code == 3
    first, second = result.err.splitlines()
    assert str(empty) in first
    assert str(missing) in second
    assert [p.name for p in (tmp_path / "out").iterdir()] == ["part0.png"]


def test_two_of_one_name_are_refused_before_any_work(pictures: list[Path], tmp_path: Path) -> None:
    twin = tmp_path / "part0.jpg"
    Image.new("L", (4, 4)).save(twin)
    line = run("convert", pictures[0], twin, tmp_path / "out").complaint(2)
    assert str(pictures[0]) in line
    assert str(twin) in line
    assert not (tmp_path / "out").exists()


def test_an_unknown_method_leaves_no_folder_behind(pictures: list[Path], tmp_path: Path) -> None:
    run("convert", *pictures[:2], tmp_path / "out", "-m", "sticki").complaint(2)
    assert not (tmp_path / "out").exists()


def test_several_do_not_fit_into_one_file(pictures: list[Path], tmp_path: Path) -> None:
    assert "folder" in run("convert", *pictures[:2], "-").complaint(2)
    (tmp_path / "file.png").write_bytes(b"kept")
    line = run("convert", *pictures[:2], tmp_path / "file.png").complaint(1)
    assert str(tmp_path / "file.png") in line
    assert (tmp_path / "file.png").read_bytes() == b"kept"


def test_an_input_is_never_overwritten(pictures: list[Path]) -> None:
    before = pictures[0].read_bytes()
    run("convert", pictures[0], pictures[0]).complaint(2)
    run("convert", *pictures[:2], pictures[0].parent).complaint(2)
    assert pictures[0].read_bytes() == before


@pytest.mark.parametrize("jobs", ["-1", "x", "1.5"])
def test_jobs_that_are_none(jobs: str, pictures: list[Path], tmp_path: Path) -> None:
    run("convert", *pictures[:2], tmp_path / "out", f"--jobs={jobs}").complaint(2)
