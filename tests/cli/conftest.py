"""Files that many of the command's tests share."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.cli.files import GRAY, RGB


@pytest.fixture(scope="session")
def gray(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A gray PNG, 41 × 24."""
    path = tmp_path_factory.mktemp("gray") / "gray.png"
    Image.fromarray(GRAY).save(path)
    return path


@pytest.fixture(scope="session")
def colour(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An RGB PNG, 41 × 24."""
    path = tmp_path_factory.mktemp("colour") / "colour.png"
    Image.fromarray(RGB).save(path)
    return path


@pytest.fixture(scope="session")
def photo_png(tmp_path_factory: pytest.TempPathFactory, photograph: Path) -> Path:
    """The photograph that ships as a gray PNG, 300 × 200."""
    path = tmp_path_factory.mktemp("photo") / "photo.png"
    with Image.open(photograph) as picture:
        picture.convert("L").resize((300, 200)).save(path)
    return path


@pytest.fixture(scope="session")
def large(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A PGM of 6000 × 4000 pixels, which takes about a second."""
    path = tmp_path_factory.mktemp("large") / "large.pgm"
    rows = np.random.default_rng(1).integers(0, 256, (250, 6000), np.uint8)
    path.write_bytes(b"P5\n6000 4000\n255\n" + rows.tobytes() * 16)
    return path


@pytest.fixture(scope="session")
def slow(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A PNG of 1700 × 1700 pixels: some seconds where NUMBA_DISABLE_JIT=1 is set."""
    path = tmp_path_factory.mktemp("slow") / "slow.png"
    Image.fromarray(np.random.default_rng(2).integers(0, 256, (1700, 1700), np.uint8)).save(path)
    return path
