"""Whatever a file holds: a scene that can be shown, or one clear line. Never another exception."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from halftone.errors import InputFileError
from halftone.scene import shapes
from halftone.scene.load import load, named
from halftone.scene.sanitise import sanitised
from tests.scene.test_load import FULL
from tests.scene.test_ply import made

BALL = shapes.sphere(5, 4, exact=True)


def obj():
    lines = ["mtllib a.mtl", "o ball"]
    lines += [f"v {x:.3f} {y:.3f} {z:.3e}" for x, y, z in BALL.vertices]
    lines += [f"vn {x:.3f} {y:.3f} {z:.3f}" for x, y, z in BALL.normals]
    lines += ["usemtl a", "s 1"] + [f"f {a}//{a} {b}//{b} -{c}//{c}" for a, b, c in BALL.faces + 1]
    return ("\n".join(lines) + "\nf 1 2 3 4 5\n").encode()


def ply(kind):
    faces = [tuple(face) for face in BALL.faces.tolist()]
    return made(kind, BALL.vertices, [*faces, (0, 1, 2, 3)], BALL.normals)


FILES = [
    ("a.obj", obj()),
    ("a.ply", ply("ascii")),
    ("b.ply", ply("binary_little_endian")),
    ("c.ply", ply("binary_big_endian")),
    ("a.toml", FULL.encode()),
]


def shown(path):
    """The clean scene, or None where the file was refused with its name."""
    refusal = ""
    try:
        with named(path):
            return sanitised(load(path))[0]
    except InputFileError as error:
        refusal = str(error)
    assert path.name in refusal
    assert "\n" not in refusal
    return None


PIECES = [
    b"nan",
    b"inf",
    b"-inf",
    b"1e999",
    b"-1",
    b"0",
    b"/",
    b"//",
    b"\n",
    b"\r",
    b"\0",
    b"\xff",
    b" ",
]
PIECES += [
    b"99999999999999999999",
    b"v ",
    b"f ",
    b"f 1 2 3\n",
    b"e",
    b".",
    b"-",
    b"#",
    b"\\\n",
    b"[[",
    b'"',
]


@st.composite
def damaged(draw):
    """One of the files with pieces put in, taken out, doubled or cut off."""
    name, data = draw(st.sampled_from(FILES))
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(data)))
        far = min(len(data), at + draw(st.integers(0, 12)))
        what = draw(st.sampled_from([*PIECES, data[far : far + 20], b""]))
        data = data[:at] + what + data[far:]
    return name, data


@settings(max_examples=300)
@given(damaged())
def test_files_with_random_damage(tmp_path_factory, case):
    name, data = case
    folder = tmp_path_factory.mktemp("damaged")
    (folder / "a.mtl").write_text("newmtl a\nKd 1 0 0\n")
    (folder / name).write_bytes(data)
    clean = shown(folder / name)
    for mesh in clean.meshes if clean else ():
        assert np.isfinite(mesh.vertices).all()
        assert ((mesh.faces >= 0) & (mesh.faces < len(mesh.vertices))).all()
        assert ((mesh.material >= 0) & (mesh.material < len(clean.materials))).all()
        if mesh.normals is not None:
            assert np.isfinite(mesh.normals).all()
            assert mesh.normal_index.max(initial=-1) < len(mesh.normals)


@given(st.binary(max_size=200), st.sampled_from([".obj", ".ply", ".toml"]))
def test_files_of_random_bytes(tmp_path_factory, data, ending):
    path = tmp_path_factory.mktemp("random") / f"a{ending}"
    path.write_bytes(data)
    shown(path)
