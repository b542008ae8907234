"""Scene files: every key of the model, every mistake with its place, nothing outside the folder."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from halftone.errors import InputFileError
from halftone.scene.load import load, read_scene
from halftone.scene.model import Camera, Fresnel, Light, Material, Scene
from halftone.scene.sanitise import sanitised

SCENES = Path(__file__).parents[2] / "examples" / "scenes"
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
BOX = '[[meshes]]\nshape = "box"\n'


@pytest.fixture
def read(tmp_path):
    def write_and_load(text, **files):
        for name, other in files.items():
            (tmp_path / name.replace("_", ".")).write_text(other)
        path = tmp_path / "scene.toml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return load(path)

    return write_and_load


@pytest.fixture
def refused(read):
    def message(text, **files):
        with pytest.raises(InputFileError) as caught:
            read(text, **files)
        assert "\n" not in str(caught.value)
        return str(caught.value)

    return message


FULL = """
name = "all"
ambient = [0.1, 0.2, 0.3]
background = 0.5
reflection = "phong"
normals = "area"
overflow = "clamp"
[camera]
eye = [1, 2, 3]
target = [0, 0, 0.5]
up = [0, 0, 1]
projection = "parallel"
fov = 30
height = 4
near = 0.1
[[lights]]
kind = "warn"
intensity = [1, 0.5, 0.25]
position = [1, 2, 3]
direction = [0, -1, 0]
attenuation = [1, 0.5, 0.25]
cutoff = 60
inner = 50
exponent = 8
flaps = [[-inf, inf], [0, 1], [-2.5, 3]]
shadows = true
[[materials]]
name = "gold"
ambient = 0.25
diffuse = [0.5, 0.4, 0.1]
specular = 1
exponent = inf
transparency = 0.25
rim = 0.75
rim_exponent = 3
two_sided = false
fresnel = { kind = "conductor", n = 0.2, k = 3.0, f0 = 0.5, angles = [0, 90], shares = [0.5, 1] }
[[meshes]]
name = "lid"
material = "gold"
smooth = false
shape = "sphere"
u = 6
v = 4
scale = [1, 2, 3]
"""


def test_every_key_of_the_model(read):
    scene = read(FULL)
    camera = Camera((1, 2, 3), (0, 0, 0.5), (0, 0, 1), "parallel", 30, 4, 0.1)
    flaps = ((-np.inf, np.inf), (0, 1), (-2.5, 3))
    light = Light(
        "warn", (1, 0.5, 0.25), (1, 2, 3), (0, -1, 0), (1, 0.5, 0.25), 60, 50, 8, flaps, shadows=True
    )
    fresnel = Fresnel("conductor", 0.2, 3.0, 0.5, (0, 90), (0.5, 1))
    gold = Material(
        "gold", (0.25,) * 3, (0.5, 0.4, 0.1), (1,) * 3, np.inf, 0.25, 0.75, 3, fresnel, two_sided=False
    )
    assert (scene.camera, scene.lights, scene.materials) == (camera, (light,), (gold,))
    assert (scene.ambient, scene.background) == ((0.1, 0.2, 0.3), (0.5,) * 3)
    named = (scene.name, scene.reflection, scene.normals, scene.overflow)
    assert named == ("all", "phong", "area", "clamp")
    mesh = scene.meshes[0]
    assert (mesh.name, mesh.smooth.any(), (mesh.material == 0).all()) == ("lid", False, True)
    assert np.allclose(mesh.vertices.max(axis=0)[1:], [2, 3 * np.sin(np.pi / 3)])


@pytest.mark.parametrize("kind", [Scene, Camera, Light, Material, Fresnel])
def test_the_full_scene_above_misses_no_field(kind):
    for field in fields(kind):
        assert field.name in FULL, f"{kind.__name__}.{field.name}"


def test_defaults_are_those_of_the_model(read):
    scene = read(BOX + "[[lights]]\n[[materials]]\n")
    assert (scene.lights, scene.materials) == ((Light(),), (Material(),))
    assert (scene.ambient, scene.background) == (Scene().ambient, Scene().background)
    assert scene.camera is not None


@pytest.mark.parametrize("channels", [1, 2, 4, 31])
def test_any_number_of_channels(read, channels):
    text = f"[[lights]]\nintensity = {[0.5] * channels}\n[[materials]]\ndiffuse = 0.25\n{BOX}"
    scene = sanitised(read(text))[0]
    colours = (scene.ambient, scene.background, scene.materials[0].ambient, scene.lights[0].intensity)
    assert {len(colour) for colour in colours} == {channels}


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("ambeint = 1", ["scene.toml: the scene", "'ambeint'", "mean ambient"]),
        ("[[lights]]\n[[lights]]\nintensty = 1", ["lights[1]", "mean intensity"]),
        ("[camera]\nfovy = 3", ["camera", "mean fov"]),
        ("[[materials]]\nfresnel = {knd = 1}", ["materials[0].fresnel", "mean kind"]),
        ('[[meshes]]\nshape = "box"\nwidht = 2', ["meshes[0]", "mean width"]),
        ('[[meshes]]\nshape = "boks"', ["meshes[0].shape", "mean box"]),
        ('[[materials]]\nname = "red"\n[[meshes]]\nshape = "box"\nmaterial = "rde"', ["mean red"]),
        ("[[meshes]]\nfil = 'a.obj'", ["meshes[0]", "mean file"]),
        ('[[meshes]]\nname = "x"', ["meshes[0]", "one of file, shape, vertices"]),
        ('[[meshes]]\nshape = "box"\nfile = "a.obj"', ["file and shape"]),
        ('[[meshes]]\nshape = "torus"\nu = 2', ["meshes[0].u=2", "3 …"]),
        ('[[meshes]]\nshape = "torus"\nradius = "big"', ["meshes[0].radius", "a number"]),
        ('[[meshes]]\nshape = "box"\nscale = 0', ["meshes[0].scale", "other than 0"]),
        ('[[meshes]]\nshape = "box"\nscale = nan', ["meshes[0].scale", "finite"]),
        ('[[meshes]]\nshape = "box"\nrotate = 5', ["meshes[0].rotate", "three"]),
        ('[[meshes]]\nshape = "box"\nsmooth = 1', ["meshes[0].smooth", "true or false"]),
        ('[[meshes]]\nfile = "a.stl"', ["meshes[0].file", ".obj"]),
        ('[[meshes]]\nfile = "a.obj"', ["a.obj", "cannot be read"]),
        ("[[meshes]]\nfile = 5", ["meshes[0].file=5", "a text"]),
        ("[meshes]\nfile = 'a.obj'", ["meshes", "[[meshes]]"]),
        ("camera = 5", ["camera=5", "a table"]),
        ("lights = [5]", ["lights[0]=5", "a table"]),
        ('[[lights]]\nintensity = "white"', ["lights[0]: intensity"]),
        ("[[lights]]\nintensity = [1, 2]\n[[materials]]\ndiffuse = [1, 2, 3]", ["2 channels"]),
        ("[[lights]]\nshadows = 1", ["lights[0].shadows=1", "true or false"]),
        ("[[lights]]\nposition = [1, 2, inf]", ["lights[0]: position", "finite"]),
        ("[camera]\neye = [0, 0, 0]", ["camera.eye and camera.target"]),
        ("[camera]\nnear = true", ["camera.near=True"]),
        ("name = 5", ["name=5", "a text"]),
        ("a = 5 5", ["not TOML", "line 1"]),
        ("ambient = 1\nambient = 2", ["not TOML"]),
        (f"ambient = 1{'0' * 400}", ["ambient"]),
        (f"ambient = 1{'0' * 9000}", ["not TOML"]),
        (f"[camera]\nfov = 1{'0' * 400}", ["camera.fov"]),
        (f'[[meshes]]\nshape = "sphere"\nradius = 1{"0" * 400}', ["meshes[0].radius"]),
        (f'[[meshes]]\nshape = "sphere"\nscale = 1{"0" * 400}', ["meshes[0].scale"]),
        (f"[[meshes]]\nvertices = []\nfaces = [[1, 2, 1{'0' * 20}]]", ["meshes[0].faces"]),
    ],
)
def test_mistakes_have_their_place(refused, text, parts):
    message = refused(text)
    assert "scene.toml" in message or "a.obj" in message
    for part in parts:
        assert part in message


@pytest.mark.parametrize(
    ("text", "feature"),
    [
        ('[[lights]]\nkind = "area"', "area lights are not there yet"),
        ("[[lights]]\nsize = [1, 1]", "area lights are not there yet"),
        ("[[materials]]\nior = 1.5", "refraction is not there yet"),
        ("[[materials]]\ndispersion = 0.1", "dispersion is not there yet"),
        ("[[materials]]\ndiffuse_transmission = 0.1", "diffuse transmission is not there yet"),
        ('[[materials]]\ntexture = "a.png"', "textures are not there yet"),
        ('[[materials]]\nmap_diffuse = "a.png"', "maps are not there yet"),
        ('[[materials]]\nbump = "a.png"', "maps are not there yet"),
        ('environment = "a.hdr"', "maps are not there yet"),
        ("[trace]\ndepth = 3", "ray tracing is not there yet"),
        ("[radiosity]\n", "radiosity is not there yet"),
        ("[[materials]]\nemission = 1", "radiosity is not there yet"),
    ],
)
def test_what_comes_later_is_named(refused, text, feature):
    assert feature in refused(text)


@pytest.mark.parametrize("name", ["/a.obj", "../a.obj", "b/../../a.obj", "C:/a.obj", "..\\\\a.obj", ""])
def test_files_elsewhere_are_refused(refused, name):
    assert "inside the scene's folder" in refused(f'[[meshes]]\nfile = "{name}"', a_obj=TRIANGLE)


def test_links_that_lead_out_are_refused(refused, tmp_path):
    (tmp_path.parent / "outside.obj").write_text(TRIANGLE)
    (tmp_path / "link.obj").symlink_to(tmp_path.parent / "outside.obj")
    assert "inside the scene's folder" in refused('[[meshes]]\nfile = "link.obj"')
    (tmp_path / "far").symlink_to(tmp_path.parent)
    assert "inside the scene's folder" in refused('[[meshes]]\nfile = "far/outside.obj"')


def test_meshes_of_files_bring_their_materials(read):
    text = '[[materials]]\nname = "own"\n[[meshes]]\nfile = "a.obj"\n[[meshes]]\nfile = "a.obj"\n'
    library = "newmtl red\nKd 1 0 0\n"
    scene = read(
        text + 'material = "own"\n', a_obj=f"mtllib a.mtl\nusemtl red\n{TRIANGLE}", a_mtl=library
    )
    used = [scene.materials[mesh.material[0]].name for mesh in scene.meshes]
    assert used == ["red", "own"]


def test_colours_of_files_in_one_channel_are_their_luminance(read, refused):
    text = '[[lights]]\nintensity = {}\n[[meshes]]\nfile = "a.obj"\n'
    files = {"a_obj": f"mtllib a.mtl\nusemtl red\n{TRIANGLE}", "a_mtl": "newmtl red\nKd 1 0.5 0\n"}
    scene = read(text.format("[1]"), **files)
    diffuse = scene.materials[scene.meshes[0].material[0]].diffuse
    assert diffuse == pytest.approx((0.2126 + 0.5 * 0.7152,))
    assert "3 or 1" in refused(text.format("[1, 1, 1, 1]"), **files)


def test_placing_is_scale_then_rotate_then_translate(read):
    head = '[[meshes]]\nfile = "a.obj"\n'
    mesh = read(head + "scale = 2\nrotate = [90, 0, 90]\ntranslate = [1, 0, 0]", a_obj=TRIANGLE)
    assert np.allclose(mesh.meshes[0].vertices, [[1, 0, 0], [1, 2, 0], [1, 0, 2]])


@pytest.mark.parametrize(
    "scale", ["[-1, 1, 1]", "[1, -2, 3]", "-1", "[-1, -1, 2]", "[-1e-170, 2e-170, 1e-170]"]
)
def test_mirrored_bodies_keep_their_fronts_outside(read, scale):
    text = f'[[meshes]]\nshape = "sphere"\nu = 8\nv = 6\nexact = true\nscale = {scale}\n'
    mesh = read(text + "rotate = [10, 20, 30]").meshes[0]
    points = mesh.vertices / np.abs(mesh.vertices).max()
    a, b, c = (points[mesh.faces[:, k]] for k in range(3))
    out = np.cross(b - a, c - a)
    assert (np.einsum("fx,fx->f", out, a + b + c) > 0).all()
    normals = mesh.normals[mesh.normal_index]
    assert (np.einsum("fx,fkx->fk", out, normals) > 0).all()


def test_vertices_in_the_scene_file_with_details(read):
    text = """[[meshes]]
    vertices = [[0,0,0],[1,0,0],[1,1,0],[0,1,0],[0.2,0.2,0],[0.8,0.2,0],[0.5,0.8,0]]
    faces = [[0,1,2,3],[4,5,6],[0,2,3]]
    detail = [-1, 0, -1]
    material = ["a", "b", 0]
    [[materials]]
    name = "a"
    [[materials]]
    name = "b"
    """
    mesh = read(text).meshes[0]
    assert mesh.material.tolist() == [0, 0, 1, 1, 0]
    # The quad is two triangles: the detail lies on each of them.
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 5, 6], [0, 2, 3]]
    assert mesh.detail.tolist() == [-1, -1, 0, 1, -1]


@pytest.mark.parametrize(
    "text",
    [
        "vertices = 5",
        "vertices = [[0, 0]]\nfaces = []",
        "vertices = [[0, 0, 0]]",
        "vertices = [[0, 0, 0]]\nfaces = [[0, 0]]",
        "vertices = [[0, 0, 0]]\nfaces = [[0, 0, true]]",
        "vertices = [[0, 0, 0]]\nfaces = [[0, 0, 0.5]]",
        "vertices = [[0, 0, 0]]\nfaces = [[0, 0, 0]]\ndetail = [1]",
        "vertices = [[0, 0, 0]]\nfaces = [[0, 0, 0]]\ndetail = 0",
        "vertices = [[0, 0, 0]]\nfaces = [[0, 0, 0]]\nmaterial = [0, 0]",
        "vertices = [[0, 0, 0]]\nfaces = [[0, 0, 0]]\nmaterial = ['x']",
        "shape = 'box'\nmaterial = [0]",
    ],
)
def test_vertices_in_the_scene_file_that_do_not_fit(refused, text):
    assert "meshes[0]" in refused(f"[[meshes]]\n{text}")


def test_nan_in_a_mesh_is_dropped_and_counted(read):
    text = "[[meshes]]\nvertices = [[0,0,0],[1,0,0],[0,1,0],[nan,inf,0]]\nfaces = [[0,1,2],[0,1,3]]\n"
    _, counts = sanitised(read(text))
    assert (counts.nonfinite_vertices, counts.nonfinite_faces, counts.faces) == (1, 1, 1)


def test_a_bare_mesh_has_camera_lights_and_notes(tmp_path):
    path = tmp_path / "mesh.OBJ"
    path.write_text(TRIANGLE + "l 1 2\n")
    scene, notes = read_scene(path)
    assert scene.camera is not None
    assert len(scene.lights) == 2
    assert "'l'" in notes[0]


@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda path: path.name)
def test_the_examples_need_no_mending(path):
    scene, notes = read_scene(path)
    _, counts = sanitised(scene)
    assert (notes, counts.notes()) == ([], [])


@pytest.mark.parametrize("name", ["scene.gltf", "scene", "gone.toml", "gone.obj", "gone.ply"])
def test_other_files_are_refused(tmp_path, name):
    with pytest.raises(InputFileError, match=name):
        load(tmp_path / name)


def test_folders_and_other_bytes_are_refused(tmp_path, refused):
    (tmp_path / "folder.toml").mkdir()
    with pytest.raises(InputFileError, match="not a file"):
        load(tmp_path / "folder.toml")
    assert "not TOML" in refused(b"\xff\xfe")
