"""OBJ and MTL files, hand-made: every form of an index, and every kind of damage."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halftone.errors import InputFileError
from halftone.scene import shapes
from halftone.scene.obj import read_obj

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


@pytest.fixture
def read(tmp_path):
    def write_and_read(text, **files):
        for name, other in files.items():
            (tmp_path / name.replace("_", ".")).write_text(other)
        path = tmp_path / "mesh.obj"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_obj(path)

    return write_and_read


@pytest.mark.parametrize(
    "face",
    [
        *("1 2 3", "1/1 2/2 3/1", "1/1/1 2/1/1 3/1/1", "1//1 2//1 3//1", "-4 -3 -2"),
        *("-4//-1 -3//-1 -2//-1", "1 2/1 3//1", "1/ 2/ 3/", "  1   2\t3 ", "1 2 3 # a comment"),
        *("+1 +2 +3", "1 2 \\\n 3"),
    ],
)
def test_all_forms_of_a_corner(read, face):
    found = read(f"{SQUARE}vn 0 0 1\nvt 0 0\nf {face}\n")
    assert found.mesh.faces.tolist() == [[0, 1, 2]]
    if "//" in face or face.count("/") == 6:
        assert 0 in found.mesh.normal_index[0]
    else:
        assert (found.mesh.normal_index == -1).all()


@given(st.integers(0, 10**6))
def test_any_file_gives_its_numbers_back(tmp_path_factory, seed):
    """Random polygons in random forms and line ends, against what they were written from."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 12))
    points = rng.normal(size=(count, 3)) * 10.0 ** rng.integers(-30, 30)
    lines, wanted = [], []
    end = "\r\n" if rng.integers(2) else "\n"
    for point in points:
        lines.append("v " + " ".join(repr(float(p)) for p in point))
    for _ in range(int(rng.integers(1, 6))):
        corners = rng.permutation(count)[:3]
        form = ["{0}", "{0}/7", "{0}/7/1", "{0}//1", "{1}"][rng.integers(5)]
        lines.append("f " + " ".join(form.format(c + 1, c - count) for c in corners))
        wanted.append(corners.tolist())
    lines.insert(0, "vn 0 0 1")
    path = tmp_path_factory.mktemp("obj") / "a.obj"
    path.write_bytes((end.join(lines) + end * int(rng.integers(2))).encode())
    mesh = read_obj(path).mesh
    assert (mesh.vertices == points).all()
    assert mesh.faces.tolist() == wanted


def test_negative_numbers_count_from_their_line(read):
    mesh = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 5\nv 1 0 5\nv 0 1 5\nf -3 -2 -1\n").mesh
    assert mesh.faces.tolist() == [[0, 1, 2], [3, 4, 5]]


def test_numbers_out_of_range_stay_out_of_range(read):
    mesh = read(SQUARE + "vn 0 0 1\nf 1//9 2//1 99//1\nf -9 1 2\nf 0 1 2\n").mesh
    assert not ((mesh.faces >= 0) & (mesh.faces < 4)).all(axis=1).any()
    assert mesh.normal_index[0].tolist() == [8, 0, 0]  # of one normal


def test_polygons_concave_ones_too(read):
    mesh = read("v 0 0 0\nv 1 -1 0\nv 0 1 0\nv -1 -1 0\nf 1 2 3 4\n").mesh
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()


def test_materials(read):
    library = (
        "newmtl red wine\nKa .1 0 0\nKd .8 .1 .1\nKs .5 .5 .5\nNs 80\nd .25\nillum 2\nmap_Kd a.png\n"
    )
    library += (
        "newmtl dull\nKd 0.5\nKs 1 1 1\nillum 1\nTr 0.5\nnewmtl glass\nillum 7\nNi 1.5\nKs 1 1 1\n"
    )
    text = f"mtllib a.mtl\n{SQUARE}f 1 2 3\nusemtl red wine\nf 1 2 3\nusemtl dull\nf 2 3 4\n"
    found = read(text + "usemtl glass\nf 1 2 3 4\nusemtl red wine\nf 1 2 4\n", a_mtl=library)
    used = [found.materials[m] for m in found.mesh.material]
    assert [m.name for m in used] == ["default", "red wine", "dull", "glass", "glass", "red wine"]
    red, dull, glass = used[1:4]
    assert (red.ambient, red.diffuse, red.specular) == ((0.1, 0, 0), (0.8, 0.1, 0.1), (0.5, 0.5, 0.5))
    assert (red.exponent, red.transparency) == (80, 0.75)
    assert (dull.ambient, dull.specular, dull.transparency) == ((0.5,) * 3, (0, 0, 0), 0.5)
    assert (glass.fresnel.kind, glass.fresnel.n) == ("dielectric", 1.5)
    assert any("map_Kd" in note for note in found.notes)


def test_what_is_not_there_is_noted(read):
    found = read(f"mtllib gone.mtl\n{SQUARE}usemtl nobody\nf 1 2 3\nl 1 2\nl 2 3\ncurv2 1\n")
    notes = " ".join(found.notes)
    for text in ("gone.mtl", "nobody", "2 × 'l'", "1 × 'curv2'"):
        assert text in notes


def test_smoothing_groups(read):
    plain = SQUARE + "f 1 2 3\nf 1 3 4\n"
    assert read(plain).mesh.smooth is None
    mesh = read(SQUARE + "f 1 2 3\ns 1\nf 1 3 4\ns off\nf 1 2 4\n").mesh
    assert mesh.smooth.tolist() == [False, True, False]
    mesh = read(SQUARE + "s 1\nf 1 2 3\ns 2\nf 1 3 4\ns 1\nf 2 3 4\n").mesh
    assert mesh.smooth.all()
    first, second, third = (set(face) for face in mesh.faces.tolist())
    assert not first & second
    assert first & third
    assert (mesh.vertices[mesh.faces[1]] == [[0, 0, 0], [1, 1, 0], [0, 1, 0]]).all()


@pytest.mark.parametrize(
    ("line", "allowed"),
    [
        ("v 1 2", "3 numbers"),
        ("v 1 2 x", "numbers only"),
        ("v 1 2 3-4", "numbers only"),
        ("vn 1", "3 numbers"),
        ("f 1 2", "3 corners"),
        ("f 1 2 three", "whole numbers"),
        ("f 1 2 3.5", "whole numbers"),
        ("f 1/2/3/4 1 2", "v//n"),
        ("f /1 /1 /1", "v//n"),
        ("f 1 2-3 4", "whole numbers"),
        ("f", "3 corners"),
    ],
)
def test_a_damaged_line_is_named(read, line, allowed):
    bare = line.split()[0] if line != "f" else "f"
    with pytest.raises(InputFileError) as caught:
        read(f"{SQUARE}f 1 2 3\n{line} \nf 1 2 3\n")
    assert "mesh.obj:6:" in str(caught.value)
    assert bare in str(caught.value)
    assert allowed in str(caught.value)


def test_lines_that_go_on_are_counted(read):
    with pytest.raises(InputFileError, match=r"mesh\.obj:7:"):
        read(SQUARE + "f 1 \\\n2 3\nf 1 x 3\n")


def test_nan_and_infinity_are_read_and_left_to_sanitise(read):
    mesh = read("v nan 0 0\nv inf 0 0\nv 0 1e999 0\nf 1 2 3\n").mesh
    assert not np.isfinite(mesh.vertices).all(axis=1).any()


@pytest.mark.parametrize(
    "text", [b"", b"\n", b"# only\n", b"v 0 0 0", b"\xff\xfe\x00", b"v 0 0 0\r" * 3]
)
def test_files_without_faces(read, text):
    mesh = read(text).mesh
    assert mesh.faces.shape == (0, 3)
    assert mesh.vertices.shape[1] == 3


@pytest.mark.parametrize("name", ["/etc/x.mtl", "../x.mtl", "a/../../x.mtl", "C:\\x.mtl", "..\\x.mtl"])
def test_material_files_elsewhere_are_refused(read, name):
    with pytest.raises(InputFileError, match="inside the scene's folder"):
        read(f"mtllib {name}\n{SQUARE}f 1 2 3\n")


def test_a_link_that_leads_out_is_refused(read, tmp_path):
    (tmp_path.parent / "outside.mtl").write_text("newmtl a\n")
    (tmp_path / "link.mtl").symlink_to(tmp_path.parent / "outside.mtl")
    with pytest.raises(InputFileError, match="inside the scene's folder"):
        read(f"mtllib link.mtl\n{SQUARE}f 1 2 3\n")


@pytest.mark.parametrize(
    "line", ["Kd 1 2", "Kd a b c", "Ns -1", "d 2", "Kd nan 0 0", "Kd inf 0 0", "Ns"]
)
def test_a_damaged_material_is_named(read, line):
    with pytest.raises(InputFileError, match=r"a\.mtl:2:"):
        read(f"mtllib a.mtl\n{SQUARE}f 1 2 3\n", a_mtl=f"newmtl a\n{line}\n")


def test_a_generated_mesh_comes_back(read):
    torus = shapes.torus(20, 10, exact=True)
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in torus.vertices.tolist()]
    lines += [f"vn {x!r} {y!r} {z!r}" for x, y, z in torus.normals.tolist()]
    lines += [f"f {a}//{a} {b}//{b} {c}//{c}" for a, b, c in (torus.faces + 1).tolist()]
    mesh = read("\n".join(lines)).mesh
    assert (mesh.faces == torus.faces).all()
    assert (mesh.normal_index == torus.faces).all()
    assert (mesh.vertices == torus.vertices).all()
    assert (mesh.normals == torus.normals).all()
