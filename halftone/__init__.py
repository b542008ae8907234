"""Halftoning for devices that can show only a few intensities.

``import halftone`` loads nothing but this page; every name below is loaded when it is first used.
"""

from __future__ import annotations

from typing import Any

__version__ = "0.1.0"

_PUBLIC = {
    "Bands": "halftone.frame",
    "Frame": "halftone.frame",
    "Levels": "halftone.tone.levels",
    "Packing": "halftone.packing",
    "convert": "halftone.pipeline",
    "convert_bands": "halftone.pipeline",
    "dither": "halftone.pipeline",
    "read": "halftone.pipeline",
    "render": "halftone.scene.public",
    "method": "halftone.dithering",
    "methods": "halftone.dithering",
    "ClassMatrix": "halftone.dithering",
    "DotDiffusion": "halftone.dithering",
    "ErrorDiffusion": "halftone.dithering",
    "ErrorFilter": "halftone.dithering",
    "FloydSteinberg": "halftone.dithering",
    "Nearest": "halftone.dithering",
    "Ordered": "halftone.dithering",
    "ClusteredDot": "halftone.dithering",
    "PatternFamily": "halftone.screens.family",
    "Patterns": "halftone.dithering",
    "RandomDither": "halftone.dithering",
    "Riemersma": "halftone.dithering",
    "Threshold": "halftone.dithering",
    "ToneDiffusion": "halftone.dithering",
    "Screen": "halftone.screens",
    "HalftoneError": "halftone.errors",
    "InputError": "halftone.errors",
    "InputFileError": "halftone.errors",
    "OutputError": "halftone.errors",
    "UsageError": "halftone.errors",
}

__all__ = [*_PUBLIC, "__version__"]  # pyright: ignore


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'halftone' has no attribute '{name}'")
    from importlib import import_module

    value = getattr(import_module(_PUBLIC[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_PUBLIC})
