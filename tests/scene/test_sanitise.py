"""What cannot be shown is dropped and counted; scale and place of a scene do not matter."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halftone.errors import InputError
from halftone.scene import shapes
from halftone.scene.model import Camera, Fresnel, Light, Material, Mesh, Scene
from halftone.scene.sanitise import sanitised

POINTS = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
FACES = np.array([[0, 1, 2], [0, 2, 3]])


def mesh(points=POINTS, faces=FACES, **more):
    return Mesh(np.array(points), np.array(faces), np.zeros(len(faces), np.int64), **more)


def only(one, **more):
    clean, counts = sanitised(Scene((one,), camera=Camera(), **more))
    return clean.meshes[0], counts


def scaled(scene, factor, shift=0.0):
    """The scene with all lengths times *factor*, moved by *shift* along each axis."""

    def point(p):
        return tuple(float(x) * factor + shift for x in p)

    def light(one):
        a0, a1, a2 = one.attenuation
        flaps = tuple((low * factor + shift, high * factor + shift) for low, high in one.flaps)
        steep = (a0, a1 / factor, a2 / factor / factor)
        return replace(one, position=point(one.position), attenuation=steep, flaps=flaps)

    return replace(
        scene,
        meshes=[replace(m, vertices=m.vertices * factor + shift) for m in scene.meshes],
        lights=[light(one) for one in scene.lights],
        camera=replace(
            scene.camera,
            eye=point(scene.camera.eye),
            target=point(scene.camera.target),
            height=scene.camera.height * factor,
            near=scene.camera.near * factor,
        ),
    )


SCENE = Scene(
    (shapes.torus(12, 7), shapes.box(0.3, 2.0, 0.7)),
    lights=(
        Light(
            "warn", position=(1, 2, 3), attenuation=(1, 0.5, 0.25), flaps=((-1, 1), (-np.inf, 2), (0, 9))
        ),
        Light("distant"),
    ),
    camera=Camera((0.1, 1, 4), (0.1, 0.2, 0.3), height=3.0, near=0.01),
)


def same(one, other, tolerance):
    """Whether two clean scenes agree, bit by bit for tolerance 0."""

    def near(a, b):
        if tolerance == 0:
            return np.array_equal(a, b)
        return np.allclose(a, b, rtol=tolerance, atol=tolerance)

    assert all(near(a.vertices, b.vertices) for a, b in zip(one.meshes, other.meshes, strict=True))
    for a, b in zip(one.lights, other.lights, strict=True):
        assert near(a.attenuation, b.attenuation)
        assert near(a.flaps, b.flaps)
        assert a.kind == "distant" or near(a.position, b.position)
    for name in ("eye", "target", "height", "near"):
        assert near(getattr(one.camera, name), getattr(other.camera, name))


@given(st.integers(-300, 300))
def test_powers_of_two_give_the_same_bits(power):
    same(sanitised(scaled(SCENE, 2.0**power))[0], sanitised(SCENE)[0], 0)


@given(st.floats(-30, 30))
def test_any_scale_gives_the_same_scene(exponent):
    same(sanitised(scaled(SCENE, 10.0**exponent))[0], sanitised(SCENE)[0], 1e-14)


@pytest.mark.parametrize("shift", [1e3, 1e7, -1e7])
def test_far_from_the_origin(shift):
    same(sanitised(scaled(SCENE, 1.0, shift))[0], sanitised(SCENE)[0], 3e-16 * abs(shift) * 10)


def test_everything_that_is_seen_lies_within_one():
    clean, counts = sanitised(scaled(SCENE, 1e12, 5e12))
    assert max(np.abs(m.vertices).max() for m in clean.meshes) == pytest.approx(1)
    assert counts.scale == pytest.approx(1.4e12)


@pytest.mark.parametrize("size", [1e-320, 1e-200, 1e200, 1.7e308])
def test_the_ends_of_float64(size):
    one = mesh(POINTS * size - POINTS.mean(axis=0) * size)
    clean, counts = sanitised(Scene((one,)))
    clean = clean.meshes[0]
    assert np.isfinite(clean.vertices).all()
    assert counts.faces == 2 or size == 1e-320


@given(st.integers(0, 10**6), st.sampled_from([np.nan, np.inf, -np.inf]))
def test_faces_at_broken_vertices_are_dropped(seed, bad):
    rng = np.random.default_rng(seed)
    torus = shapes.torus(5, 4, exact=True)
    points = torus.vertices.copy()
    broken = rng.permutation(len(points))[: rng.integers(1, 6)]
    points[broken, rng.integers(0, 3, len(broken))] = bad
    clean, counts = only(replace(torus, vertices=points))
    wanted = ~np.isin(torus.faces, broken).any(axis=1)
    assert counts.nonfinite_vertices == len(broken)
    assert counts.nonfinite_faces == (~wanted).sum()
    assert np.isfinite(clean.vertices).all()
    kept = points[torus.faces[wanted]]
    shown = clean.vertices[clean.faces] * counts.scale + counts.centre
    assert np.allclose(shown, kept)
    assert np.allclose(clean.normals[clean.normal_index], torus.normals[torus.faces[wanted]])


@pytest.mark.parametrize("index", [-1, 4, 1 << 40, -(1 << 40)])
def test_indices_out_of_range(index):
    clean, counts = only(mesh(faces=[[0, 1, 2], [0, 1, index]]))
    assert (counts.out_of_range_faces, counts.faces) == (1, 1)
    assert clean.faces.tolist() == [[0, 1, 2]]


def test_triangles_without_area():
    points = [*POINTS.tolist(), [0.5, 0, 0], [2, 0, 0]]
    clean, counts = only(mesh(points, [[0, 0, 1], [0, 4, 1], [0, 1, 2], [1, 1, 1], [0, 5, 1]]))
    assert counts.degenerate_faces == 4
    assert clean.faces.tolist() == [[0, 1, 2]]


def test_slivers_with_area_stay():
    points = [[0, 0, 0], [1, 0, 0], [0.5, 1e-12, 0]]
    assert only(mesh(points, [[0, 1, 2]]))[1].faces == 1


@pytest.mark.parametrize("bad", [[0, 0, 0], [np.nan, 0, 1], [np.inf, 0, 0], [0, -np.inf, 0]])
def test_broken_normals_become_the_faces(bad):
    normals = np.array([[0, 0.6, 0.8], bad])
    index = np.array([[0, 1, 0], [0, -1, 1]])
    clean, counts = only(mesh(normals=normals, normal_index=index))
    assert counts.mended_normals == 2
    shown = clean.normals[clean.normal_index]
    assert np.allclose(shown[0], [[0, 0.6, 0.8], [0, 0, 1], [0, 0.6, 0.8]])
    assert shown[1, 2].tolist() == [0, 0, 1]
    assert clean.normal_index[1, 1] == -1
    assert np.isfinite(clean.normals).all()


@pytest.mark.parametrize("length", [1e-300, 1e-30, 1e30, 1e300])
def test_normals_of_any_length_become_1(length):
    clean, counts = only(mesh(normals=np.array([[0, 3, 4.0]] * 4) * length))
    assert counts.mended_normals == 0
    assert np.allclose(clean.normals, [0, 0.6, 0.8])


def test_normals_out_of_range():
    index = np.array([[0, 7, 0], [0, 0, 0]])
    clean, counts = only(mesh(normals=np.array([[0, 0, 1.0]]), normal_index=index))
    assert counts.mended_normals == 1
    assert clean.normal_index.max() < len(clean.normals)


def test_details_follow_the_faces_that_they_lie_on():
    faces = [[0, 0, 1], [0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3]]
    clean, counts = only(mesh(faces=faces, detail=np.array([-1, -1, 1, 2, 0])))
    assert clean.detail.tolist() == [-1, 0, 1, -1]
    assert (counts.degenerate_faces, counts.mended_details) == (1, 1)


def test_details_in_a_ring_or_on_nothing():
    faces = [[0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3], [2, 1, 0]]
    clean, counts = only(mesh(faces=faces, detail=np.array([1, 0, 2, 99, -7])))
    assert (clean.detail == -1).all()
    assert counts.mended_details == 5
    clean, _ = only(mesh(faces=faces, detail=np.array([-1, 0, 1, 2, 3])))
    assert clean.detail.tolist() == [-1, 0, 1, 2, 3]


def test_unknown_materials():
    clean, counts = only(Mesh(POINTS, FACES, np.array([-1, 5])))
    assert clean.material.tolist() == [0, 0]
    assert counts.mended_materials == 2


def test_stray_vertices_do_not_shrink_the_scene():
    clean, counts = only(mesh([*POINTS.tolist(), [1e300, -1e300, 0]]))
    assert counts.scale == 0.5
    assert np.abs(clean.vertices).max() <= 1


@pytest.mark.parametrize(
    "meshes", [(), (mesh(faces=[[0, 0, 0]]),), (mesh(np.zeros((0, 3)), [[0, 1, 2]]),)]
)
def test_nothing_to_see_is_no_error(meshes):
    clean, counts = sanitised(Scene(meshes))
    assert not counts.visible
    assert "nothing is visible" in counts.notes()[-1]
    assert clean.camera is not None


def test_the_input_is_not_changed():
    points = POINTS.copy()
    points[3] = np.nan
    given_mesh = mesh(points, normals=np.zeros((4, 3)))
    arrays = [given_mesh.vertices, given_mesh.faces, given_mesh.normals]
    before = [a.copy() for a in arrays]
    only(given_mesh)
    assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(before, arrays, strict=True))


def test_arrays_of_other_types_and_orders():
    clean, _ = only(Mesh(np.asfortranarray(POINTS, np.float32), FACES.astype(np.uint8), [0, 0]))
    for array, kind in (
        (clean.vertices, np.float64),
        (clean.faces, np.int64),
        (clean.material, np.int64),
    ):
        assert array.dtype == kind
        assert array.flags.c_contiguous


@pytest.mark.parametrize(
    "change",
    [
        {"vertices": np.zeros((4, 2))},
        {"vertices": np.array([["a"] * 3] * 4)},
        {"faces": np.zeros((2, 4), int)},
        {"faces": np.zeros((2, 3))},
        {"material": np.zeros(3, int)},
        {"normals": np.zeros((3, 3))},
        {"detail": np.zeros(1, int)},
        {"smooth": np.zeros(2)},
    ],
)
def test_arrays_that_do_not_fit_are_refused(change):
    with pytest.raises(InputError, match=next(iter(change))):
        only(replace(mesh(), **change))


BAD_CAMERAS = [
    {"eye": (0, 0, 0)},
    {"eye": (0, np.nan, 5)},
    {"target": (np.inf, 0, 0)},
    {"up": (0, 0, 0)},
    {"up": (0, 0, -2)},
    {"fov": 0.0},
    {"fov": 180.0},
    {"fov": -5.0},
    {"fov": np.nan},
    {"height": 0.0, "projection": "parallel"},
    {"near": 0.0},
    {"near": -1.0},
    {"projection": "fisheye"},
    {"eye": (0, 0, 1e300)},
]
BAD_LIGHTS = [
    {"kind": "laser"},
    {"intensity": (1.0, 1.0)},
    {"intensity": (1.0, np.nan, 1.0)},
    {"intensity": (1.0, -1.0, 1.0)},
    {"intensity": (1.0, np.inf, 1.0)},
    {"position": (0, 0)},
    {"position": (0, 0, 1e300)},
    {"kind": "spot", "direction": (0, 0, 0)},
    {"attenuation": (1, -1, 0)},
    {"attenuation": (1, np.nan, 0)},
    {"cutoff": 0.0},
    {"cutoff": 91.0},
    {"inner": 95.0},
    {"exponent": -1.0},
    {"exponent": np.nan},
    {"flaps": ((1, 0), (0, 1), (0, 1))},
    {"flaps": ((np.nan, 1), (0, 1), (0, 1))},
    {"flaps": ((0, 1), (0, 1))},
]
BAD_MATERIALS = [
    {"diffuse": (1.0,)},
    {"diffuse": 1.0},
    {"specular": (np.nan, 0, 0)},
    {"exponent": -0.5},
    {"exponent": np.nan},
    {"transparency": 1.5},
    {"rim": -0.1},
    {"rim_exponent": 0.0},
    {"fresnel": Fresnel("glass")},
    {"fresnel": Fresnel(n=0.0)},
    {"fresnel": Fresnel("conductor", k=-1.0)},
    {"fresnel": Fresnel("schlick", f0=2.0)},
    {"fresnel": Fresnel("table")},
    {"fresnel": Fresnel("table", angles=(0, 0), shares=(0.5, 0.5))},
    {"fresnel": Fresnel("table", angles=(0, 99), shares=(0.5, 0.5))},
    {"fresnel": Fresnel("table", angles=(0, 9), shares=(0.5, 1.5))},
]


@pytest.mark.parametrize("change", BAD_CAMERAS, ids=str)
def test_cameras_that_see_nothing(change):
    with pytest.raises(InputError, match=f"camera.{next(iter(change))}") as caught:
        sanitised(Scene((mesh(),), camera=replace(Camera(), **change)))
    assert "llowed" in str(caught.value)


@pytest.mark.parametrize("change", BAD_LIGHTS, ids=str)
def test_lights_without_meaning(change):
    with pytest.raises(InputError, match=r"lights\[1\]") as caught:
        sanitised(Scene((mesh(),), lights=(Light(), replace(Light(), **change)), camera=Camera()))
    assert list(change)[-1] in str(caught.value)
    assert "llowed" in str(caught.value)


@pytest.mark.parametrize("change", BAD_MATERIALS, ids=str)
def test_materials_without_meaning(change):
    with pytest.raises(InputError, match=r"materials\[0\]") as caught:
        sanitised(Scene((mesh(),), (replace(Material(), **change),), camera=Camera()))
    assert next(iter(change)) in str(caught.value)
    assert "llowed" in str(caught.value)


@pytest.mark.parametrize("change", [{"reflection": "x"}, {"normals": "x"}, {"overflow": "x"}])
def test_names_of_the_scene(change):
    with pytest.raises(InputError, match=next(iter(change))):
        sanitised(Scene(**change))


def test_infinite_exponents_and_flaps_are_allowed():
    sanitised(Scene((mesh(),), (Material(exponent=np.inf),), (Light(exponent=np.inf),), Camera()))
