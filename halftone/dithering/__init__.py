"""Halftoning methods: from linear light to level indices. A family is loaded when it is used."""

from __future__ import annotations

from typing import Any

_PUBLIC = {
    "FILTERS": "filters",
    "Claim": "base",
    "ClassMatrix": "classes",
    "DotDiffusion": "dots",
    "ErrorDiffusion": "diffusion",
    "ErrorFilter": "filters",
    "FloydSteinberg": "diffusion",
    "Job": "base",
    "Method": "base",
    "Nearest": "threshold",
    "ClusteredDot": "screened",
    "Ordered": "ordered",
    "Patterns": "patterns",
    "RandomDither": "noise",
    "Riemersma": "curve",
    "Threshold": "threshold",
    "ToneDiffusion": "toned",
    "method": "registry",
    "methods": "registry",
}

__all__ = [*_PUBLIC]


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    from importlib import import_module

    return getattr(import_module(f"{__name__}.{_PUBLIC[name]}"), name)


def __dir__() -> list[str]:
    return sorted(_PUBLIC)
