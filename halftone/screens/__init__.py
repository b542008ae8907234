"""Threshold arrays."""

from halftone.screens.bayer import bayer
from halftone.screens.order import Screen, from_ranks

__all__ = ["Screen", "bayer", "from_ranks"]
