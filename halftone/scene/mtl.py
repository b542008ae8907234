"""Materials of an OBJ file: Ka, Kd, Ks, Ns, Ni, d or Tr, and illum."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from pathlib import Path

from halftone.errors import InputFileError
from halftone.scene.model import Fresnel, Material
from halftone.scene.paths import contents

__all__ = ["read_mtl"]

REFRACTING = (5, 7)  # illum: reflection by the Fresnel formulas
NUMBERS = {"Ka": 3, "Kd": 3, "Ks": 3, "Ns": 1, "Ni": 1, "d": 1, "Tr": 1, "illum": 1}


def read_mtl(path: Path, notes: list[str]) -> dict[str, Material]:
    """The materials of a file by name. What was left out is appended to *notes*.

    Without Ka the ambient colour is Kd. illum 0 and 1 have no highlights, 5 and 7 weigh them by the
    Fresnel reflection of the index Ni. Raises InputFileError, with the line's number, for damage.
    """
    found: dict[str, dict[str, tuple[float, ...]]] = {}
    current: dict[str, tuple[float, ...]] | None = None
    unknown: Counter[str] = Counter()
    for number, line in enumerate(contents(path).decode("utf-8", "replace").splitlines(), 1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        key, rest = words[0], words[1:]
        if key == "newmtl":
            current = found.setdefault(" ".join(rest), {})
        elif key not in NUMBERS or (rest and rest[0] in ("spectral", "xyz", "-halo")):
            unknown[key] += 1
        elif current is None:
            raise _damaged(path, number, line, "a newmtl line first")
        else:
            current[key] = _numbers(path, number, line, rest, NUMBERS[key])
    for key, count in sorted(unknown.items()):
        why = (
            "textures and maps are not there yet"
            if key.startswith(("map_", "bump", "disp", "refl"))
            else "which is not read"
        )
        notes.append(f"{path.name}: {count} × '{key}' left out, {why}")
    return {name: _material(name, values) for name, values in found.items()}


def _material(name: str, given: dict[str, tuple[float, ...]]) -> Material:
    diffuse = given.get("Kd", (0.8, 0.8, 0.8))
    illum = given.get("illum", (2.0,))[0]
    material = Material(
        name,
        ambient=given.get("Ka", diffuse),
        diffuse=diffuse,
        exponent=given.get("Ns", (10.0,))[0],
        transparency=given["Tr"][0] if "Tr" in given else 1 - given.get("d", (1.0,))[0],
    )
    if illum >= 2:
        material = replace(material, specular=given.get("Ks", (0.0, 0.0, 0.0)))
    if illum in REFRACTING and given.get("Ni", (1.0,))[0] > 1:
        material = replace(material, fresnel=Fresnel("dielectric", n=given["Ni"][0]))
    return material


def _numbers(path: Path, number: int, line: str, words: list[str], count: int) -> tuple[float, ...]:
    try:
        values = tuple(float(word) for word in words)
    except ValueError:
        raise _damaged(path, number, line, "numbers only") from None
    if len(values) not in (1, count):
        raise _damaged(path, number, line, f"{count} number{'s' if count > 1 else ''}")
    key = line.split()[0]
    most = 1.0 if key in ("d", "Tr") else math.inf
    if not all(0 <= value <= most and (key == "Ns" or value < math.inf) for value in values):
        raise _damaged(path, number, line, "finite numbers from 0" + (" to 1" if most == 1 else ""))
    return values * (count if len(values) == 1 else 1)


def _damaged(path: Path, number: int, line: str, allowed: str) -> InputFileError:
    text = " ".join(line.split())[:60]
    return InputFileError(f"{path}:{number}: '{text}' is damaged; allowed: {allowed}")
