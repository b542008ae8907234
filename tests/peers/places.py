"""Where the peers are that install.sh installs; a test whose peer is not there says so and skips."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent.parent.parent / ".peers"
"""What no package manager of the system installs: npm's modules, cargo's programs, a kernel."""


def program(name: str) -> str:
    """The path of a program."""
    own = FOLDER / "cargo" / "bin" / name
    found = (
        str(own) if own.is_file() else shutil.which(name) or shutil.which(name, path="/usr/sbin:/sbin")
    )
    if found is None:
        pytest.skip(f"{name} is not installed (tests/peers/install.sh installs it)")
    return found


def file(path: str) -> str:
    """A file of a package, as the filters of CUPS."""
    if not Path(path).is_file():
        pytest.skip(f"{path} is not installed (tests/peers/install.sh installs it)")
    return path


def npm(package: str) -> Path:
    """The folder with node_modules that has *package*; run node there."""
    program("node")
    folder = FOLDER / "npm"
    if not (folder / "node_modules" / package).is_dir():
        pytest.skip(f"npm's {package} is not installed (tests/peers/install.sh installs it)")
    return folder
