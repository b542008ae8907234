"""What is timed: each job once, with its arithmetic and the slow twin that its result must equal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import halftone
from halftone.tone import encoding
from tests.bench.peers.base import Bytes, Timed, bits
from tests.bench.twins import (
    ROWS,
    SPARE,
    Twin,
    codes_twin,
    dots_twin,
    light_twin,
    ordered_twin,
    toned_twin,
)

__all__ = ["JOBS", "PAIRS", "Job", "Pair", "checked"]

INTEGERS = "int, 1/16 code"
FLOAT = "float32"
FS, JJN, STUCKI = "floyd-steinberg", "jarvis-judice-ninke", "stucki"
LINEAR = {"encoding": "linear"}
MEASURED = {"levels": (0.03, 0.2, 0.5, 0.9)}


@dataclass(frozen=True)
class Job:
    """A call of :func:`halftone.dither`; *key* is also that of the peers' jobs.

    small : timed at 512 × 512 pixels, too. packed : to packed rows of bits instead of indices.
    """

    key: str
    title: str
    method: str
    arithmetic: str
    twin: Twin
    options: dict[str, Any] = field(default_factory=dict)
    small: bool = False
    packed: bool = False

    @property
    def output(self) -> str:
        return "packed bits" if self.packed else "uint8"

    def ours(self, codes: Bytes, workers: int = 1) -> Timed:
        def call() -> Any:
            options = {"method": self.method, "workers": workers, **self.options}
            if self.packed:
                return halftone.convert_bands(codes, **options).packed()
            return halftone.dither(codes, **options).indices

        width = codes.shape[1]
        return Timed(call, (lambda made: bits(made, width)) if self.packed else lambda made: made)


@dataclass(frozen=True)
class Pair:
    """Two ways of ours to one result."""

    title: str
    first: Callable[[Bytes], Timed]
    second: Callable[[Bytes], Timed]


def checked(job: Job, codes: Bytes, indices: Bytes) -> int:
    """Pixels of a timed result that equal the slow twin; AssertionError where one differs.

    Pictures of up to 512 × 512 pixels are compared as a whole, the others in their first rows.
    """
    rows = codes.shape[0] if codes.size <= 512**2 else ROWS
    light = encoding(job.options.get("encoding", "srgb")).table(256)[codes[: rows + SPARE]]
    levels = job.options.get("levels", 2)
    ladder = halftone.dither(np.zeros((1, 1), np.uint8), "none", levels=levels).levels
    expected = job.twin(codes, light, ladder.luminance, rows)
    shown = indices[: expected.shape[0], : expected.shape[1]]
    np.testing.assert_array_equal(shown, expected, err_msg=f"{job.title}: not what its slow twin gives")
    return expected.size


_RASTER = "Floyd–Steinberg, raster, codes as light"
_SERPENTINE = "Floyd–Steinberg, serpentine, codes as light"
_MEASURED = "Floyd–Steinberg, raster, sRGB codes, measured levels .03 .2 .5 .9"
_STUCKI = "Stucki, raster, codes as light"
_fs, _snake = light_twin(FS, False), light_twin(FS, True)
_jjn, _stucki = light_twin(JJN, False), light_twin(STUCKI, False)
_bayer, _noise = ordered_twin("bayer8"), ordered_twin("blue-noise")

JOBS = (
    Job("fs", _RASTER, "fs:raster", INTEGERS, codes_twin(False), LINEAR, small=True),
    Job("fs-bits", _RASTER, "fs:raster", INTEGERS, codes_twin(False), LINEAR, small=True, packed=True),
    Job("fs-srgb", "Floyd–Steinberg, raster, sRGB codes", "fs:raster", FLOAT, _fs, small=True),
    Job("fs-measured", _MEASURED, "fs:raster", FLOAT, _fs, MEASURED),
    *(
        Job(
            f"fs-{n}",
            f"{_RASTER}, {n} uniform levels",
            "fs:raster",
            FLOAT,
            _fs,
            LINEAR | {"levels": f"uniform-linear:{n}"},
        )
        for n in (4, 5, 16, 17)
    ),
    Job("fs-serpentine", _SERPENTINE, "fs", INTEGERS, codes_twin(True), LINEAR, small=True),
    Job("fs-serpentine-srgb", "Floyd–Steinberg, serpentine, sRGB codes", "fs", FLOAT, _snake),
    Job("jarvis", "Jarvis–Judice–Ninke, raster, codes as light", "jjn:raster", FLOAT, _jjn, LINEAR),
    Job("stucki", _STUCKI, "stucki:raster", FLOAT, _stucki, LINEAR),
    Job("stucki-bits", _STUCKI, "stucki:raster", FLOAT, _stucki, LINEAR, packed=True),
    Job("bayer-bits", "Bayer 8 × 8", "bayer8", "uint8", _bayer, LINEAR, small=True, packed=True),
    Job("noise-bits", "blue noise 256 × 256", "blue-noise", "uint8", _noise, LINEAR, packed=True),
    Job(
        "ostromoukhov",
        "Ostromoukhov, serpentine, sRGB codes",
        "ostromoukhov",
        FLOAT,
        toned_twin("ostromoukhov"),
    ),
    Job("zhou-fang", "Zhou–Fang, serpentine, sRGB codes", "zhou-fang", FLOAT, toned_twin("zhou-fang")),
    Job("dots", "dot diffusion (Knuth), sRGB codes", "dots:knuth", FLOAT, dots_twin("dots:knuth")),
)

_BY_KEY = {job.key: job for job in JOBS}


def _two_threads(key: str) -> Pair:
    job = _BY_KEY[key]
    return Pair(
        f"two threads instead of one: {job.title}",
        lambda codes: job.ours(codes, workers=1),
        lambda codes: job.ours(codes, workers=2),
    )


PAIRS = (
    Pair(f"packed bits instead of uint8: {_RASTER}", _BY_KEY["fs"].ours, _BY_KEY["fs-bits"].ours),
    *(_two_threads(key) for key in ("fs", "fs-srgb", "jarvis", "dots")),
)
