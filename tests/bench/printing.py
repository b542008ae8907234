"""How fast every language is written and read, how large it is, and what memory it takes.

``python -m tests.bench.printing [--md]``. The rows are a photograph halftoned by Floyd–Steinberg at
576 dots, stretched to 2,400 rows (30 cm); best and median of seven runs. A head that moves
100 mm a second at 8 dots/mm burns 800 rows a second. Memory is the peak of what Python and NumPy
allocate while a whole page is encoded band by band: the 2 m roll, and A4 at 1200 dpi; — where the
language, or its labels, end before that.
"""

from __future__ import annotations

import argparse
import statistics
import time
import tracemalloc
from collections.abc import Iterator
from typing import Any

import numpy as np

import halftone
from devices.languages import language, language_type
from devices.languages.base import Language, Page
from halftone.cli.demo import PHOTOGRAPH
from halftone.packing import pack
from halftone.tone.levels import Levels

VARIANTS: list[tuple[str, dict[str, Any]]] = [
    ("escpos", {"command": "raster"}),
    ("escpos", {"command": "graphics"}),
    ("escpos", {"command": "column"}),
    ("escpos", {"command": "dc2"}),
    ("zpl", {"compression": "acs"}),
    ("zpl", {"compression": "hex"}),
    ("zpl", {"compression": "z64"}),
    ("tspl", {}),
    ("epl2", {}),
    ("brother-ql", {}),
    ("dymo", {}),
    ("pcl", {}),
    ("pwg", {}),
    ("cups-raster", {"version": 2}),
    ("cups-raster", {"version": 3}),
    ("urf", {}),
    ("png", {}),
    ("pbm", {}),
]
BAND = 64


def halftoned(width: int, rows: int) -> np.ndarray:
    """Level indices of the photograph, stretched: no row comes twice, which would flatter zlib."""
    return halftone.convert(PHOTOGRAPH, width=width, height=rows, fit="stretch").indices


def page(made: Language, picture: np.ndarray, rows: int, dpi: float) -> Page:
    """A page of *rows* rows that repeats *picture*, packed band by band as it is asked for."""
    levels = Levels.of(2)
    packed = pack(picture, made.packing(levels))

    def bands() -> Iterator[np.ndarray]:
        done = 0
        while done < rows:
            top = done % (len(packed) - BAND)
            count = min(BAND, rows - done)
            yield packed[top : top + count]
            done += count

    return Page(picture.shape[1], rows, bands(), levels, (dpi, dpi))


def name_of(name: str, options: dict[str, Any]) -> str:
    return " ".join([name, *map(str, options.values())])


def measure(name: str, options: dict[str, Any], picture: np.ndarray) -> dict[str, Any]:
    """One line of the table."""
    made = language(name, **options)
    rows = len(picture)
    writing, reading, data = [], [], b""
    for _ in range(7):
        start = time.perf_counter()
        data = b"".join(p.data for p in made.encode([page(made, picture, rows, 300)]))
        writing.append(time.perf_counter() - start)
    for _ in range(3):
        start = time.perf_counter()
        language_type(name).decode(data)
        reading.append(time.perf_counter() - start)
    return {
        "language": name_of(name, options),
        "rows/s written, best": round(rows / min(writing)),
        "median": round(rows / statistics.median(writing)),
        "rows/s read": round(rows / min(reading)),
        "bytes a row": round(len(data) / rows, 1),
        "MB, 2 m roll": peak(made, picture, 16_000, 300),
        "MB, A4 1200 dpi": peak(made, halftoned(9921, 400), 14_031, 1200),
    }


def peak(made: Language, picture: np.ndarray, rows: int, dpi: float) -> float | str:
    """MB that encoding takes beside the picture itself."""
    from halftone.errors import UsageError

    sheet = page(made, picture, rows, dpi)
    tracemalloc.start()
    try:
        for _ in made.encode([sheet]):
            pass
        return round(tracemalloc.get_traced_memory()[1] / 1e6, 2)
    except UsageError:  # wider or longer than it can be
        return "—"
    finally:
        tracemalloc.stop()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--md", action="store_true", help="as a Markdown table")
    parser.add_argument("--only", help="languages whose name begins so")
    options = parser.parse_args()
    picture = halftoned(576, 2400)
    lines = [
        measure(name, given, picture) for name, given in VARIANTS if name.startswith(options.only or "")
    ]
    if options.md:
        print("| " + " | ".join(lines[0]) + " |\n|" + "---|" * len(lines[0]))
    for line in lines:
        text = [f"{v:,}" if isinstance(v, int) else str(v) for v in line.values()]
        print("| " + " | ".join(text) + " |" if options.md else dict(zip(line, text, strict=True)))


if __name__ == "__main__":
    main()
