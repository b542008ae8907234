"""What a scene file may ask for one day, and gets a clear answer for today."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from halftone.errors import InputError

__all__ = ["refuse_later"]

_KEYS = {
    "area lights": ("area", "size", "samples"),
    "refraction": ("refraction", "index", "ior", "eta", "refractive_index"),
    "dispersion": ("dispersion", "abbe"),
    "diffuse transmission": ("diffuse_transmission", "transmission", "translucency", "frosted"),
    "textures": ("texture", "textures", "uv", "pattern"),
    "maps": ("map", "maps", "bump", "bump_map", "normal_map", "environment", "environment_map"),
    "ray tracing": ("trace", "tracing", "ray_tracing", "mirror", "depth_limit", "lens", "aperture"),
    "radiosity": ("radiosity", "emission", "emitter"),
}
_KINDS = {"area": "area lights", "distributed": "area lights", "environment": "maps"}


def refuse_later(table: Mapping[str, Any], allowed: Collection[str], at: str) -> None:
    """InputError that names the feature, where *table* asks for one that is not there yet."""
    for key in table:
        if key in allowed:
            continue
        for feature, words in _KEYS.items():
            if key in words or (feature == "maps" and key.startswith("map_")):
                raise _later(f"{at}.{key}", feature)
    kind = table.get("kind")
    if at.startswith("lights") and isinstance(kind, str) and kind in _KINDS:
        raise _later(f"{at}.kind='{kind}'", _KINDS[kind])


def _later(place: str, feature: str) -> InputError:
    are = "are" if feature.endswith("s") else "is"
    return InputError(f"{place}: {feature} {are} not there yet; leave it out")
