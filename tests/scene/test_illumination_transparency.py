"""I18: the transparency coefficient, constant or by the slope of the surface."""

from __future__ import annotations

import numpy as np
import pytest

from halftone.scene.illumination import Illumination
from halftone.scene.model import Material
from halftone.scene.transparency import transparency

SLOPES = np.array([1.0, -1.0, 0.5, -0.25, 0.0, np.nan, 1.0000001], np.float32)


def of(material, n_z=SLOPES, **options):
    return transparency([material], np.zeros(len(n_z), np.int32), n_z, **options)


@pytest.mark.parametrize("k", [0.0, 0.3, 1.0])
def test_a_constant_coefficient_is_exact(k):
    np.testing.assert_array_equal(of(Material(transparency=k)), np.float32(k))
    np.testing.assert_array_equal(of(Material(transparency=k, rim=k)), np.float32(k))
    np.testing.assert_array_equal(of(Material(transparency=k), force_all=True), np.float32(k))


def test_layers_multiply():
    k = of(Material(transparency=0.3))[0]
    behind = np.float32(1.0)
    for _ in range(5):  # black layers before a white wall
        behind = (1 - k) * np.float32(0) + k * behind
    assert behind == pytest.approx(0.3**5)


@pytest.mark.parametrize("m", [0.5, 1.0, 3.0])
@pytest.mark.parametrize(("middle", "rim"), [(0.8, 0.1), (0.1, 0.9)])
def test_kay_and_greenberg(m, middle, rim):
    seen = of(Material(transparency=middle, rim=rim, rim_exponent=m))
    slope = np.nan_to_num(np.minimum(np.abs(SLOPES), 1)).astype(np.float64)
    expected = rim + (middle - rim) * (1 - (1 - slope) ** m)
    np.testing.assert_allclose(seen, expected, atol=3e-7)
    assert seen[0] == seen[1] == np.float32(middle)
    assert seen[4] == np.float32(rim)


def test_each_sample_by_its_material():
    materials = [Material(transparency=0.2), Material(transparency=0.5, rim=0.0), Material()]
    numbers = np.array([0, 1, 1, 2], np.int32)
    n_z = np.array([0.0, 0.0, 1.0, 0.5], np.float32)
    lit = Illumination(materials)
    np.testing.assert_array_equal(lit.transparency(numbers, n_z), np.float32([0.2, 0.0, 0.5, 0.0]))
    assert ("transparency", True, "2 of 3 materials") in lit.stages()
