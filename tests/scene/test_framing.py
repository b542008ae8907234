"""A bare mesh is seen whole, and lit."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halftone.errors import UsageError
from halftone.scene import shapes
from halftone.scene.framing import camera_for, framed
from halftone.scene.model import Camera, Light, Mesh, Scene


def projected(camera, points, aspect):
    """Places in the picture, −1 … 1 from left to right and from bottom to top."""
    eye = np.array(camera.eye)
    ahead = np.array(camera.target) - eye
    ahead /= np.linalg.norm(ahead)
    side = np.cross(ahead, camera.up)
    side /= np.linalg.norm(side)
    up = np.cross(side, ahead)
    from_eye = points - eye
    depth = from_eye @ ahead
    assert (depth > 0).all()
    slope = np.tan(np.radians(camera.fov) / 2)
    return np.stack([from_eye @ side / aspect, from_eye @ up], axis=1) / depth[:, None] / slope


@given(
    st.integers(0, 10**6),
    st.sampled_from([0.25, 0.5, 1.0, 16 / 9, 5.0]),
    st.sampled_from([1e-30, 1e-3, 1.0, 1e30]),
)
def test_all_of_it_is_in_the_picture(seed, aspect, size):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(30, 3)) * rng.uniform(0.01, 1, 3) * size + rng.normal(size=3) * size
    mesh = Mesh(points, rng.integers(0, 30, (20, 3)), np.zeros(20, np.int64))
    used = points[np.unique(mesh.faces)]
    seen = np.abs(projected(camera_for([mesh], aspect), used, aspect)).max()
    assert 0.5 < seen <= 1 / 1.07


def test_stray_and_broken_vertices_do_not_count():
    torus = shapes.torus(8, 6)
    points = np.concatenate([torus.vertices, [[1e9, 0, 0], [np.nan, 0, 0]]])
    more = Mesh(points, np.concatenate([torus.faces, [[0, 1, 49], [0, 1, 777]]]), np.zeros(98, np.int64))
    assert camera_for([more]) == camera_for([torus])


def test_what_a_scene_has_is_kept():
    camera, light = Camera(), Light()
    scene = framed(Scene((shapes.box(),), camera=camera, lights=(light,)))
    assert scene.camera is camera
    assert scene.lights == (light,)


@pytest.mark.parametrize(
    "meshes", [(), (Mesh(np.zeros((1, 3)), np.zeros((1, 3), int), np.zeros(1, int)),)]
)
def test_nothing_and_a_point_have_a_camera_too(meshes):
    camera = framed(Scene(meshes)).camera
    assert np.isfinite([*camera.eye, *camera.target]).all()
    assert camera.eye != camera.target


@pytest.mark.parametrize("aspect", [0, -1, np.nan, np.inf])
def test_wrong_shapes_of_pictures(aspect):
    with pytest.raises(UsageError, match="aspect"):
        framed(Scene(), aspect)
