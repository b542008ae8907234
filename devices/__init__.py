"""What a device is, and how it is spoken to. Part of halftone-kit."""

__halftone__ = True
"""Marks this package as ours: ``devices`` is a common name."""
