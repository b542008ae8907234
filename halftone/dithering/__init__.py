"""Halftoning methods: from linear light to level indices."""

from halftone.dithering.base import Claim, Job, Method
from halftone.dithering.diffusion import ErrorDiffusion, FloydSteinberg
from halftone.dithering.filters import FILTERS, ErrorFilter
from halftone.dithering.noise import RandomDither
from halftone.dithering.ordered import Ordered
from halftone.dithering.registry import method, methods
from halftone.dithering.threshold import Nearest, Threshold

__all__ = [
    "FILTERS",
    "Claim",
    "ErrorDiffusion",
    "ErrorFilter",
    "FloydSteinberg",
    "Job",
    "Method",
    "Nearest",
    "Ordered",
    "RandomDither",
    "Threshold",
    "method",
    "methods",
]
