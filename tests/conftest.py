"""Shared fixtures: a kernel cache of the test run's own, photographs, a seeded Hypothesis."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

settings.register_profile(
    "halftone",
    deadline=None,  # the first call of a kernel compiles it
    derandomize=True,  # the same examples in every run: a failure can be repeated
    max_examples=40,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
settings.load_profile("halftone")


@pytest.fixture(scope="session", autouse=True)
def _own_cache(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Kernels compiled by the tests stay out of the user's cache, but are kept between workers."""
    if "HALFTONE_CACHE_DIR" not in os.environ:
        base = tmp_path_factory.getbasetemp()
        shared = base.parent if os.environ.get("PYTEST_XDIST_WORKER") else base
        os.environ["HALFTONE_CACHE_DIR"] = str(shared / "kernels")


@pytest.fixture(scope="session")
def photograph() -> Path:
    """A colour JPEG that ships, 451 × 300."""
    from halftone.cli.demo import PHOTOGRAPH

    return PHOTOGRAPH


@pytest.fixture(scope="session")
def camera() -> np.ndarray:
    """scikit-image's camera, uint8 (512, 512)."""
    from skimage import data

    return np.asarray(data.camera())
