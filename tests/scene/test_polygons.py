"""Polygons of any shape become triangles that cover them once and turn as they do."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from halftone.scene.polygons import triangles


def areas(points, cut):
    a, b, c = (points[cut[:, k]] for k in range(3))
    return np.cross(b - a, c - a) / 2


def flat(points):
    """(n, 2) to (n, 3) in a tilted plane."""
    return np.array(points, float) @ np.array([[1, 0.2, 0.3], [0, 1, -0.4]])


@given(st.integers(3, 12), st.integers(0, 10**6), st.booleans())
def test_star_shaped_polygons_keep_their_area(sides, seed, backwards):
    """All triangles turn alike and their areas add up: no overlap, nothing outside."""
    rng = np.random.default_rng(seed)
    angle = 2 * np.pi * (np.arange(sides) + rng.uniform(0.0, 0.8, sides)) / sides
    radius = rng.uniform(0.2, 1.0, sides)
    ring = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    gaps = np.diff(np.append(angle, angle[0] + 2 * np.pi))
    if gaps.max() >= np.pi:  # then the centre is outside: it may cross itself
        return
    points = flat(ring[::-1] if backwards else ring)
    cut, owner = triangles(np.array([sides]), points, np.arange(sides))
    assert (owner == 0).all()
    assert len(cut) == sides - 2
    each = areas(points, cut)
    whole = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0) / 2
    assert np.allclose(each.sum(axis=0), whole)
    assert (each @ whole > 0).all()


def test_an_arrowhead_is_not_cut_as_a_fan():
    points = flat([(0, 0), (1, -1), (0, 1), (-1, -1)])
    for start in range(4):
        turned = np.roll(points, start, axis=0)
        cut, _ = triangles(np.array([4]), turned, np.arange(4))
        whole = np.cross(turned, np.roll(turned, -1, axis=0)).sum(axis=0)
        assert (areas(turned, cut) @ whole > 0).all()


def test_mixed_polygons_keep_their_order():
    points = flat([(0, 0), (1, 0), (1, 1), (0, 1), (-1, 0.5)])
    corners = np.array([0, 1, 2, 0, 1, 2, 3, 0, 1, 2, 3, 4, 2, 1, 0])
    cut, owner = triangles(np.array([3, 4, 5, 3]), points, corners)
    assert owner.tolist() == [0, 1, 1, 2, 2, 2, 3]
    assert corners[cut][-1].tolist() == [2, 1, 0]


def test_what_crosses_itself_or_is_not_there_still_ends():
    points = flat([(0, 0), (1, 1), (1, 0), (0, 1), (0.5, 2)])
    for corners in ([0, 1, 2, 3, 4], [0, 0, 0, 0, 0], [0, 1, 99, -3, 2]):
        cut, _ = triangles(np.array([5]), points, np.array(corners))
        assert cut.shape == (3, 3)
    broken = np.full((5, 3), np.nan)
    assert triangles(np.array([5]), broken, np.arange(5))[0].shape == (3, 3)
