"""The golden streams: what each language makes of one bilevel picture. Run to make them anew::

    python -m tests.golden.streams

A printer gets these bytes, so a change here is an entry in CHANGELOG.md. Where zlib makes the bytes
(PNG, ZPL's Z64) they are those of its version; what they decode to is held by other tests.
"""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from devices.languages import language
from devices.languages.base import encoded
from halftone.frame import Frame
from halftone.tone.levels import Levels
from tests.golden.make import picture

FILE = Path(__file__).with_name("streams.txt")

CASES: list[tuple[str, dict[str, Any]]] = [
    *(("escpos", {"command": command}) for command in ("raster", "graphics", "column", "dc2")),
    ("zpl", {"compression": "acs"}),
    ("zpl", {"compression": "hex"}),
    ("tspl", {}),
    ("epl2", {}),
    ("brother-ql", {}),
    ("dymo", {}),
    ("pcl", {}),
    ("pwg", {}),
    ("cups-raster", {}),
    ("urf", {}),
    ("pbm", {}),
]


def frame() -> Frame:
    """Rings and ramps against a fixed checkerboard of thresholds: level indices (200, 173)."""
    codes = np.pad(picture(), ((0, 104), (0, 61)), mode="symmetric")
    y, x = np.indices(codes.shape)
    indices = (codes > (x * 37 + y * 101) % 251).astype(np.uint8)
    return Frame(indices, Levels.of(2), dpi=(300.0, 300.0))


def line(name: str, options: dict[str, Any]) -> str:
    text = " ".join([name, *(f"{k}={v}" for k, v in options.items())])
    data = encoded(language(name, **options), frame())
    return f"{text}: {len(data)} bytes, {sha256(data).hexdigest()}"


def main() -> None:
    FILE.write_text("".join(line(*case) + "\n" for case in CASES))


if __name__ == "__main__":
    main()
