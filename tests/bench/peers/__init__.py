"""Other people's halftoning, called in process: one module a library, each with ``load()``."""

from __future__ import annotations

import importlib

from tests.bench.peers.base import Peer

__all__ = ["MODULES", "UNPACKAGED", "installed"]

MODULES = {
    "zimg": "Debian libzimg2",
    "pillow": "pip pillow",
    "leptonica": "Debian liblept5",
    "swscale": "Debian libswscale6",
    "ipp": "pip ipp",
    "epaper": "pip epaper-dithering",
    "plain_numpy": "pip numpy",
}
"""Module in this folder → the package that it needs (tests/peers/install.sh installs them)."""

UNPACKAGED = (
    "libdither and pixkit (serpentine, 12 taps, Ostromoukhov, Zhou–Fang, dot diffusion) are in "
    "neither Debian, pip, npm nor crates.io",
    "dithr 0.3.0 (Ostromoukhov, dot diffusion) is Rust source on crates.io, not a library that a "
    "process can load",
)


def installed() -> tuple[list[Peer], list[str]]:
    """The peers found here, and for each that is not, why."""
    found, missing = [], []
    for name, package in MODULES.items():
        try:
            found.append(importlib.import_module(f"tests.bench.peers.{name}").load())
        except (ImportError, OSError, RuntimeError) as error:
            missing.append(f"{name} ({package}): {error}")
    return found, missing
