"""Scenes: illumination and polygon shading, to linear radiance at the size of a device."""
