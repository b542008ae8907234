"""Evolves a class matrix for dot diffusion: ``python -m halftone.dithering.evolve FILE``.

A class matrix begins as a slanted scan of its tile (place (y, x) has the key slope·y + x) in which
every key is raised by a random number 0 … jitter: error runs on almost as in error diffusion, few
places are barons, and the disorder breaks worms and checkerboards. Then some of these numbers are
drawn anew, time after time, and what scores no worse is kept. The weights stay Knuth's.

The score looks at flat tones only. Dot diffusion of a flat tone repeats itself from tile to tile,
so that one tile that goes on for ever shows all of it: its periodogram gives the error seen through
a Gaussian eye, and the highest peak over the variance, which is what stands out as texture.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from halftone.dithering.classes import AROUND, ClassMatrix
from halftone.errors import HalftoneError, UsageError

__all__ = ["Evolution", "FlatTones", "evolve", "main", "ranks", "score"]

TONES = np.arange(4, 128, dtype=np.float32) / np.float32(255)
"""Tones from 4/255 to the middle; the lighter half is their complement."""

WINDOW = 128
"""Side of the periodograms in which a peak is counted: a tile that is smaller repeats in it."""


@dataclass(frozen=True)
class Evolution:
    """How a class matrix is evolved.

    side : of the tile, a divisor of 128. slope : a row's step in the keys, a column's being 1.
    turns : how many changes are tried. peak : highest wanted ratio of a periodogram to its variance.
    eye : standard deviation of the Gaussian, in pixels. The same values give the same matrix on
    one machine; FFTs that round differently may decide a turn otherwise. The defaults made the class
    matrix ``64`` that ships, in about a minute.
    """

    side: int = 64
    slope: float = 2.5
    jitter: float = 2.0
    seed: int = 1
    turns: int = 4500
    peak: float = 80.0
    eye: float = 1.4

    def __post_init__(self) -> None:
        if self.side < 1 or WINDOW % self.side:
            raise UsageError(f"side={self.side}; allowed: 1, 2, 4, 8, 16, 32, 64, 128")
        for name in ("slope", "jitter", "peak", "eye"):
            if not 0 < getattr(self, name) < float("inf"):
                raise UsageError(f"{name}={getattr(self, name)}; allowed: any number above 0")
        for name in ("turns", "seed"):
            if getattr(self, name) < 0:
                raise UsageError(f"{name}={getattr(self, name)}; allowed: 0, 1, …")


class FlatTones:
    """Judges class matrices of one side by the flat tones 4 … 127 of 255."""

    def __init__(self, side: int, eye: float) -> None:
        n = side
        y, x = np.divmod(np.arange(n * n), n)
        near = [((y + dy) % n) * n + (x + dx) % n for dy, dx in AROUND]
        self.side = n
        self.near = np.ascontiguousarray(np.stack(near, axis=1), np.int64)
        self.share = np.zeros((n * n, TONES.size), np.float32)
        self.lit = np.zeros((n * n, TONES.size), np.uint8)
        fy, fx = np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n)
        twice = np.where((fx == 0) | (fx == 0.5), 1, 2)  # rfft2 leaves the other half out
        self.seen = (twice * np.exp(-4 * np.pi**2 * eye**2 * (fy**2 + fx**2))).astype(np.float32)

    def measure(self, keys: NDArray[np.float64]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Mean square of the error as seen, and highest periodogram over variance, of each tone."""
        from halftone.dithering._dots_kernels import diffuse_flats

        n = self.side
        order = np.argsort(keys, kind="stable")
        diffuse_flats(order, ranks(keys), self.near, TONES, self.share, self.lit)
        error = self.lit.reshape(n, n, -1).transpose(2, 0, 1).astype(np.float32)
        error -= TONES[:, None, None]
        spectrum = np.fft.rfft2(error)
        power = (spectrum.real**2 + spectrum.imag**2) / np.float32(n * n)
        visible = (power * self.seen).sum(axis=(1, 2)) / np.float32(n * n)
        power[:, 0, 0] = 0
        repeats = np.float32((WINDOW / n) ** 2)
        return visible, power.max(axis=(1, 2)) * repeats / (TONES * (1 - TONES))


def evolve(plan: Evolution) -> ClassMatrix:
    """The best class matrix found."""
    random = np.random.default_rng(plan.seed)
    judge = FlatTones(plan.side, plan.eye)
    y, x = np.divmod(np.arange(plan.side**2), plan.side)
    base = plan.slope * y + x
    jitter = random.random(base.size)
    best = score(judge, base + plan.jitter * jitter, plan.peak)
    for _ in range(plan.turns):
        count = 1 << int(random.integers(0, 9))
        places = random.integers(0, base.size, count)
        before = jitter[places]
        jitter[places] = random.random(count)
        found = score(judge, base + plan.jitter * jitter, plan.peak)
        if found >= best:
            best = found
        else:
            # A place drawn twice had one value before: both copies of it are the same.
            jitter[places] = before
    made = ranks(base + plan.jitter * jitter).reshape(plan.side, plan.side)
    return ClassMatrix(made, f"{plan.side}", "evolved")


def ranks(keys: NDArray[np.float64]) -> NDArray[np.int64]:
    """The class of each place: how many keys are lower, or as low and before it."""
    made = np.empty(keys.size, np.int64)
    made[np.argsort(keys, kind="stable")] = np.arange(keys.size)
    return made


def score(judge: FlatTones, keys: NDArray[np.float64], peak: float) -> float:
    """dB of the error as seen, less a penalty for every tone with a peak above the wanted one."""
    visible, peaks = judge.measure(keys)
    excess = np.maximum(peaks / peak - 1, 0)
    return float(-10 * np.log10(visible.mean()) - (excess**2).sum() - 0.1 * excess.sum())


def main(arguments: Sequence[str] | None = None) -> None:
    """Evolve a class matrix and write it to a file."""
    parser = argparse.ArgumentParser(prog="python -m halftone.dithering.evolve", description=__doc__)
    parser.add_argument("file", type=Path, help="where to write it: .npz, or text with commas")
    for name, default in vars(Evolution()).items():
        parser.add_argument(f"--{name}", type=type(default), default=default)
    given = vars(parser.parse_args(arguments))
    file = given.pop("file")
    try:
        evolve(Evolution(**given)).save(file)
    except HalftoneError as error:
        parser.exit(error.exit_code, f"{error}\n")


if __name__ == "__main__":
    main()
