"""Profiles by the command line, and a package ``devices`` that is not ours."""

from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image

from tests.cli.command import run

PROFILE = 'title = "a test"\nprovenance = "made up"\nwidth = 13\nbits = 1\ncodes = [1, 0]\n'


@pytest.fixture(scope="module")
def picture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Black, 13 × 4."""
    path = tmp_path_factory.mktemp("picture") / "black.png"
    Image.new("L", (13, 4), 0).save(path)
    return path


@pytest.fixture
def foreign(tmp_path: Path) -> str:
    """A folder for PYTHONPATH with a package of the same name."""
    package = tmp_path / "foreign" / "devices"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text('"""Somebody else\'s."""\n')
    (package / "profile.py").write_text("def load(name):\n    return 1 / 0\n")
    return str(tmp_path / "foreign")


def test_a_path_to_a_profile(picture: Path, tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(PROFILE)
    for name in (str(tmp_path / "mine.toml"), "mine.toml", "./mine.toml"):
        result = run("convert", picture, "out.raw", "-d", name, cwd=tmp_path)
        assert (result.code, result.err) == (0, "")
        assert (tmp_path / "out.raw").read_bytes() == b"\xff\xf8" * 4


def test_the_users_own_profile(picture: Path, tmp_path: Path) -> None:
    folder = tmp_path / "config" / "halftone" / "profiles"
    folder.mkdir(parents=True)
    (folder / "generic-1bit.toml").write_text(PROFILE)
    env = {"XDG_CONFIG_HOME": str(tmp_path / "config")}
    for settings, row in ((env, b"\xff\xf8"), (None, b"\0\0")):
        args = ("convert", picture, tmp_path / "out.raw", "-d", "generic-1bit")
        assert run(*args, env=settings).code == 0
        assert (tmp_path / "out.raw").read_bytes() == row * 4


@pytest.mark.parametrize(
    ("text", "code", "word"),
    [
        (PROFILE + "widht = 3\n", 2, "Did you mean width"),
        (PROFILE + "width = 3\n", 2, "TOML"),
        ("", 2, "title"),
        (PROFILE + 'default_method = "stuki"\n', 2, "Did you mean stucki"),
        (PROFILE + 'bit_order = "big"\n', 2, "msb, lsb"),
        (None, 4, "no such file"),
    ],
    ids=["key", "toml", "title", "method", "bit order", "missing"],
)
def test_a_mistake_is_said_in_one_line(
    text: str | None, code: int, word: str, picture: Path, tmp_path: Path
) -> None:
    path = tmp_path / "mine.toml"
    if text is not None:
        path.write_text(text)
    line = run("convert", picture, tmp_path / "out.png", "-d", path).complaint(code)
    assert str(path) in line
    assert word in line
    assert not (tmp_path / "out.png").exists()


@pytest.mark.parametrize(
    "args", [("list", "devices"), ("convert", "{in}", "{out}", "--device", "generic-1bit")]
)
def test_a_foreign_package_is_one_clear_error(
    args: tuple[str, ...], picture: Path, foreign: str, tmp_path: Path
) -> None:
    out = tmp_path / "out.png"
    filled = [a.replace("{in}", str(picture)).replace("{out}", str(out)) for a in args]
    line = run(*filled, env={"PYTHONPATH": foreign}).complaint(1)
    assert "'devices'" in line
    assert foreign in line
    assert not out.exists()


def test_a_foreign_module_is_one_too(picture: Path, tmp_path: Path) -> None:
    (tmp_path / "devices.py").write_text("profile = None\n")
    args = ("convert", picture, tmp_path / "out.png", "-d", "generic-1bit")
    assert "devices.py" in run(*args, env={"PYTHONPATH": str(tmp_path)}).complaint(1)


def test_a_foreign_package_that_does_not_even_load(picture: Path, foreign: str, tmp_path: Path) -> None:
    (Path(foreign) / "devices" / "__init__.py").write_text("import no_such_module_at_all\n")
    args = ("convert", picture, tmp_path / "out.png", "-d", "generic-1bit")
    assert "'devices'" in run(*args, env={"PYTHONPATH": foreign}).complaint(1)


def test_it_does_not_matter_where_no_device_is_named(
    picture: Path, foreign: str, tmp_path: Path
) -> None:
    result = run("convert", picture, tmp_path / "out.png", env={"PYTHONPATH": foreign})
    assert (result.code, result.err) == (0, "")
