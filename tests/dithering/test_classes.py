"""Class matrices: what is refused, and files of them."""

from __future__ import annotations

import numpy as np
import pytest

from halftone import UsageError, method
from halftone.dithering.classes import ClassMatrix, classes, load_classes
from halftone.dithering.dots import DotDiffusion
from halftone.errors import HalftoneError, InputFileError


@pytest.mark.parametrize(
    ("array", "message"),
    [
        ([[0, 1], [1, 3]], "1 comes more than once and 2 is missing"),
        ([[1, 2], [3, 4]], "holds 4"),
        ([[0, -1]], "holds -1"),
        ([[0, 0.5]], "holds 0.5"),
        ([[0, float("nan")]], "holds nan"),
        ([0, 1], "allowed"),
        (np.zeros((0, 4)), "allowed"),
        (np.arange(65_537)[None], "65,536"),
        ([["a", "b"]], "allowed"),
    ],
)
def test_what_is_no_permutation_is_refused(array, message):
    with pytest.raises(UsageError, match=message):
        ClassMatrix(np.array(array), "own")


@pytest.mark.parametrize("file", ["own.csv", "own.txt", "own.npz"])
def test_files_come_back(tmp_path, file):
    path = tmp_path / file
    classes("knuth").save(path)
    again = classes(str(path))
    assert again == classes("knuth")
    assert hash(again) == hash(classes("knuth"))
    assert DotDiffusion(str(path)).text() == f"dots:{path}"
    assert DotDiffusion(DotDiffusion(str(path)).text().removeprefix("dots:")) == DotDiffusion(again)


@pytest.mark.parametrize("content", [b"", b"1,2\n3", b"a b\n", b"0.5 1\n", b"\xff\xfe\0", b"9" * 40])
@pytest.mark.parametrize("ending", [".csv", ".npz"])
def test_files_that_hold_no_class_matrix(tmp_path, content, ending):
    path = tmp_path / f"own{ending}"
    path.write_bytes(content)
    with pytest.raises(HalftoneError, match="own"):
        load_classes(path)


def test_a_file_is_read_each_time(tmp_path):
    path = tmp_path / "own.csv"
    for rows in ("0,1\n2,3\n", "3,1\n2,0\n"):
        path.write_text(rows)
        expected = [[int(v) for v in row.split(",")] for row in rows.split()]
        assert method(f"dots:{path}").classes.classes.tolist() == expected


def test_files_that_are_not_there(tmp_path):
    with pytest.raises(InputFileError, match="nowhere"):
        classes(str(tmp_path / "nowhere.csv"))
    np.savez(tmp_path / "other.npz", order=np.arange(4))
    with pytest.raises(InputFileError, match="classes"):
        classes(str(tmp_path / "other.npz"))
    with pytest.raises(UsageError, match="knuth"):
        classes("knut")


def test_the_matrix_given_is_copied_and_cannot_be_changed():
    array = np.arange(4).reshape(2, 2)
    matrix = ClassMatrix(array, "own")
    array[0, 0] = 3
    assert matrix.classes[0, 0] == 0
    with pytest.raises(ValueError, match="read-only"):
        matrix.classes[0, 0] = 1
