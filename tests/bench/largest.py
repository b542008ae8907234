"""The largest picture: 32,768 × 32,768 through the command, with its time and its peak memory."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from halftone.dithering import FILTERS
from halftone.tone import encoding
from tests.bench.peers.base import bits
from tests.bench.picture import picture
from tests.oracle.diffusion import diffuse_light

__all__ = ["SIDE", "Run", "run", "write_pgm"]

SIDE = 32_768
ROWS = 4  # compared with the slow twin
# Peak memory is that of the largest child of a small process: a child of this one would inherit ours.
WATCH = """
import json, resource, subprocess, sys, time
start = time.perf_counter()
done = subprocess.run(sys.argv[1:], stdin=subprocess.DEVNULL, capture_output=True, text=True)
seconds = time.perf_counter() - start
peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
print(json.dumps([done.returncode, seconds, peak, done.stderr[-2000:]]))
"""


@dataclass(frozen=True)
class Run:
    """seconds, peak in MB of 10⁶ bytes; or in *refused* why there is no result."""

    format: str
    seconds: float
    peak: float
    refused: str = ""


def write_pgm(path: Path, side: int) -> None:
    """A gray PGM of side × side pixels, band by band: the mosaic again and again."""
    tile = picture(1000, 4000)
    with path.open("wb") as file:
        file.write(b"P5\n%d %d\n255\n" % (side, side))
        for start in range(0, side, tile.shape[0]):
            rows = tile[: side - start]
            file.write(np.tile(rows, (1, -(-side // tile.shape[1])))[:, :side].tobytes())


def run(source: Path, format: str, timeout: float = 300) -> Run:
    """``halftone convert -m fs:raster`` of the PGM *source*, as a process of its own."""
    out = source.with_suffix(f".{format}")
    command = str(Path(sys.executable).with_name("halftone"))
    watched = [sys.executable, "-c", WATCH, command, "convert", source.name, out.name, "-m", "fs:raster"]
    try:
        done = subprocess.run(
            watched, capture_output=True, text=True, check=True, timeout=timeout, cwd=source.parent
        )
    except subprocess.TimeoutExpired:
        return Run(format, timeout, 0, f"not done in {timeout:.0f} s")
    code, seconds, peak, said = json.loads(done.stdout)
    refused = ""
    if code != 0:
        refused = f"exit code {code}: " + (said.strip().splitlines() or ["killed"])[-1]
    elif format == "pbm":
        _check(source, out)
    out.unlink(missing_ok=True)
    return Run(format, seconds, peak * 1024 / 1e6, refused)


def _check(source: Path, out: Path) -> None:
    """The first rows of a PBM equal the slow twin."""
    with source.open("rb") as file:
        side = _header(file, b"P5")
        file.readline()  # 255
        codes = np.frombuffer(file.read(ROWS * side), np.uint8).reshape(ROWS, side)
    with out.open("rb") as file:
        assert _header(file, b"P4") == side
        row = (side + 7) // 8
        packed = np.frombuffer(file.read(ROWS * row), np.uint8).reshape(ROWS, row)
    table = FILTERS["floyd-steinberg"]
    light = encoding("srgb").table(256)[codes]
    expected = diffuse_light(
        light, np.float32([0, 1]), list(table.taps), table.divisor, serpentine=False
    )
    np.testing.assert_array_equal(1 - bits(packed, side), expected)  # in a PBM 1 is black


def _header(file: BinaryIO, kind: bytes) -> int:
    """The side of a square PNM picture after its two first lines."""
    found, size = file.readline().split(), file.readline().split()
    assert found == [kind], found
    return int(size[0])
