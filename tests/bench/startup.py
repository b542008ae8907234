"""Whole processes on a small PNG, from start to exit, reading and writing included."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from tests.bench.picture import picture
from tests.bench.timing import Seconds, compare, process

__all__ = ["start_up"]


def start_up(folder: Path, runs: int = 9) -> dict[str, Seconds]:
    """Seconds of each process; files go into *folder*."""
    from PIL import Image

    png, out = str(folder / "576.png"), str(folder / "out.pbm")
    Image.fromarray(picture(576, 576)).save(png)
    command = str(Path(sys.executable).with_name("halftone"))
    kept, cold = folder / "kept", folder / "cold"

    def convert(method: str, cache: Path = kept):
        return process(command, "convert", png, out, "-m", method, HALFTONE_CACHE_DIR=str(cache))

    def first_ever() -> None:
        shutil.rmtree(cold, ignore_errors=True)
        convert("fs", cold)()

    pillow = "import sys; from PIL import Image; Image.open(sys.argv[1]).convert('1').save(sys.argv[2])"
    times = compare(
        {
            "`python -c pass` (yardstick)": process(sys.executable, "-c", "pass"),
            "`import numpy` (yardstick)": process(sys.executable, "-c", "import numpy"),
            "… and OpenImageIO (yardstick)": process(sys.executable, "-c", "import numpy, OpenImageIO"),
            "Pillow, PNG → PBM, `convert('1')`": process(sys.executable, "-c", pillow, png, out),
            "`halftone --help`": process(command, "--help"),
            "PNG → PBM, `threshold`": convert("threshold"),
            "PNG → PBM, `bayer8`": convert("bayer8"),
            "PNG → PBM, `floyd-steinberg`, warm": convert("fs"),
        },
        runs,
    )
    return times | compare({"PNG → PBM, `floyd-steinberg`, first ever": first_ever}, min(runs, 5))
