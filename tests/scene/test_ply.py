"""PLY files in all three formats, whole, truncated and damaged."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halftone.errors import InputFileError
from halftone.scene.ply import read_ply

ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 2, 0]])


def made(kind, points=POINTS, faces=((0, 1, 2),), normals=None, extra="", face_extra=""):
    """A file, written element by element."""
    columns = points if normals is None else np.hstack([points, normals])
    names = ["x", "y", "z", "nx", "ny", "nz"][: columns.shape[1]]
    head = f"ply\nformat {kind} 1.0\ncomment made by hand\n{extra}element vertex {len(points)}\n"
    head += "".join(f"property double {name}\n" for name in names)
    head += (
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\n{face_extra}end_header\n"
    )
    order = ORDERS[kind]
    if not order:
        lines = [" ".join(repr(float(v)) for v in row) for row in columns]
        lines += [
            f"{len(face)} {' '.join(str(i) for i in face)}{' 7' * bool(face_extra)}" for face in faces
        ]
        return (head + "\n".join(lines) + "\n").encode()
    body = columns.astype(f"{order}f8").tobytes()
    for face in faces:
        body += bytes([len(face)]) + np.array(face, f"{order}i4").tobytes() + b"\7" * bool(face_extra)
    return head.encode() + body


@pytest.fixture
def read(tmp_path):
    def write_and_read(data):
        path = tmp_path / "mesh.ply"
        path.write_bytes(data)
        return read_ply(path)

    return write_and_read


@pytest.mark.parametrize("kind", ORDERS)
def test_polygons_normals_and_further_properties(read, kind):
    normals = np.tile([0.0, 0, 1], (5, 1))
    faces = [(0, 1, 2), (0, 2, 3), (0, 1, 2, 3), (0, 1, 2, 4, 3), (2, 3, 0)]
    found = read(made(kind, faces=faces, normals=normals, face_extra="property uchar flags\n"))
    mesh = found.mesh
    assert (mesh.vertices == POINTS).all()
    assert (mesh.normals == normals).all()
    assert mesh.faces.tolist()[:2] == [[0, 1, 2], [0, 2, 3]]
    assert mesh.faces.tolist()[-1] == [2, 3, 0]
    assert len(mesh.faces) == 1 + 1 + 2 + 3 + 1
    assert (mesh.normal_index == mesh.faces).all()
    assert any("flags" in note for note in found.notes)


@given(st.integers(0, 10**6), st.sampled_from(sorted(ORDERS)))
def test_runs_of_any_lengths(tmp_path_factory, seed, kind):
    """Lists whose lengths change at random, against what was written."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(8, 3)) * 10.0 ** rng.integers(-30, 30)
    lengths = rng.choice([1, 3, 3, 3, 4], size=int(rng.integers(0, 60)))
    faces = [tuple(rng.permutation(8)[:n].tolist()) for n in lengths]
    path = tmp_path_factory.mktemp("ply") / "a.ply"
    path.write_bytes(made(kind, points, faces))
    mesh = read_ply(path).mesh
    assert (mesh.vertices == points).all()
    assert len(mesh.faces) == sum(max(n - 2, 0) for n in lengths)
    triangles = list(mesh.faces.tolist())
    assert triangles == [list(f) for f in faces if len(f) == 3] or 4 in lengths


@pytest.mark.parametrize("kind", ORDERS)
def test_every_truncation_is_named(read, kind):
    data = made(kind, faces=[(0, 1, 2), (0, 1, 2, 3)]).rstrip(b"\n")
    body = data.index(b"end_header\n") + len(b"end_header\n")
    for end in range(0, len(data), 7 if kind == "ascii" else 1):
        if kind == "ascii" and end > body and not data[end : end + 1].isspace():
            continue  # a number cut short is still a number
        with pytest.raises(InputFileError, match="mesh.ply"):
            read(data[:end])


@pytest.mark.parametrize("kind", ["binary_little_endian", "ascii"])
def test_other_elements_are_passed_over(read, kind):
    data = made(kind, extra="element camera 2\nproperty list uchar short path\nproperty float f\n")
    at = data.index(b"end_header\n") + len(b"end_header\n")
    if kind == "ascii":
        cameras = b"2 5 6 0.5\n0 1.5\n"
    else:
        cameras = b"\2" + np.array([5, 6], "<i2").tobytes() + np.float32(0.5).tobytes()
        cameras += b"\0" + np.float32(1.5).tobytes()
    found = read(data[:at] + cameras + data[at:])
    assert found.mesh.faces.tolist() == [[0, 1, 2]]
    assert any("camera" in note for note in found.notes)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b"ply\n", b"plx\n"),
        (b"format ascii", b"format utf8"),
        (b"element vertex 5", b"element vertex five"),
        (b"element vertex 5", b"element vertex -5"),
        (b"property double x", b"property quad x"),
        (b"property double x", b"property double q"),
        (b"list uchar int", b"list float int"),
        (b"vertex_indices", b"corners"),
        (b"end_header", b"end"),
        (b"format ascii 1.0\n", b""),
        (b"3 0 1 2", b"3 0 1 x"),
        (b"3 0 1 2", b"-3 0 1 2"),
        (b"3 0 1 2", b"2.5 0 1 2"),
        (b"element face 1", b"element face 999999999999"),
    ],
)
def test_damage_is_named(read, old, new):
    data = made("ascii")
    assert old in data
    with pytest.raises(InputFileError, match="mesh.ply"):
        read(data.replace(old, new))


def test_a_bad_line_has_its_number(read):
    data = made("ascii").replace(b"3 0 1 2", b"3 0 1 x")
    lines = len(data.splitlines())
    with pytest.raises(InputFileError, match=rf"mesh\.ply:{lines}:"):
        read(data)


def test_a_huge_list_is_not_allocated(read):
    data = made("binary_little_endian").replace(b"list uchar int", b"list uint int ")
    with pytest.raises(InputFileError, match="truncated"):
        read(data[:-13] + b"\xff\xff\xff\xff" + b"\0" * 9)


def test_indices_out_of_range_stay_so(read):
    mesh = read(made("ascii", faces=[(0, 1, 99), (-1, 0, 1)])).mesh
    assert mesh.faces.tolist() == [[0, 1, 99], [-1, 0, 1]]
