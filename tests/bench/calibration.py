"""How right a calibration from noisy readings is: python -m tests.bench.calibration [TRIALS [STEPS]]

Each trial is a simulated printer with random dots, 1.2 … 2.2 times the distance between them, and a
random black. The steps of the chart are printed, read with noise, and fitted; a trial is good if the
fitted print curve is within 2 % of the paper's light of the true one at all of 65 tones, which is how
far off a corrected even patch is printed at most. Beside it, the same readings interpolated.

Printers: (a) print as the dot model says, black .02 … .08; (b) their paper spreads the light (Yule
and Nielsen, n = 1 … 2.5) and black is lighter, .04 … .15; (c) a bend that no model of ours has,
±.05 of light, on top of (a). Noise: Gaussian, σ = .02 of the paper's light, or σ = 2 % of the reading
itself; all lights are of the paper, which is 1 and known.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

from devices import profile
from devices.calibration import fit
from devices.chart import STEPS, make_chart
from halftone import dither
from halftone.errors import UsageError
from halftone.tone.dotgain import DotModel
from tests.devices.photographed import pattern

TONES = np.linspace(0, 1, 65)
WITHIN = 0.02


def curve(kind: str, rng: np.random.Generator) -> Any:
    """A printer: from neighbourhoods of patches (n, 512) to their light."""
    across = rng.uniform(1.2, 2.2)
    table = DotModel(across, across).table.astype(np.float64)
    black = rng.uniform(0.04, 0.15) if kind == "b" else rng.uniform(0.02, 0.08)
    spread = rng.uniform(1, 2.5) if kind == "b" else 1.0
    bend, where = (rng.uniform(-0.05, 0.05), rng.uniform(0.6, 1.6)) if kind == "c" else (0.0, 1.0)

    def light(patterns: Any) -> Any:
        covered = patterns @ table
        straight = (1 - covered + covered * black ** (1 / spread)) ** spread
        return straight + bend * np.sin(np.pi * np.clip(1 - covered, 0, 1) ** where)

    return light


def trial(kind: str, noise: Any, chart: Any, tones: Any, seed: int) -> tuple[float, float]:
    """Largest error of the fitted print curve, and of the interpolated readings."""
    rng = np.random.default_rng(seed)
    printer = curve(kind, rng)
    light = printer(chart)
    true = printer(tones)
    read = np.clip(light + rng.normal(size=len(light)) * noise(light), 0, 1.1)
    try:
        found = np.abs(fit(chart, read).light(tones) - true).max()
    except UsageError:  # a reading was refused: it would be taken again; counted as a failure
        found = np.inf
    asked = [*STEPS[len(light)], 1.0]
    plain = np.interp(TONES, asked, np.maximum.accumulate([*read, 1.0]))
    return float(found), float(np.abs(plain - true).max())


def main(trials: int = 1000, steps: int = 9) -> None:
    tones = [pattern(dither(np.full((160, 160), t), "fs").indices[48:, 48:]) for t in TONES]
    noises = {"σ = .02 of paper": lambda y: 0.02, "σ = 2 % of the reading": lambda y: 0.02 * y}
    print(f"{trials} trials; within {100 * WITHIN:.0f} % of the paper's light at {len(TONES)} tones")
    chart = make_chart(profile.load("receipt-80mm"), steps).patterns[:steps]
    for text, noise in noises.items():
        for kind in "abc":
            tried = [trial(kind, noise, chart, np.array(tones), seed) for seed in range(trials)]
            errors = np.array(tried)
            good, refused = (errors <= WITHIN).mean(0), np.isinf(errors[:, 0]).mean()
            p90 = np.quantile(errors, 0.9, axis=0)
            print(
                f"{steps:2} readings, {text:23} ({kind}): {good[0]:6.1%} (90 % within {p90[0]:.3f}; "
                f"refused {refused:.1%}); interpolated {good[1]:6.1%} (90 % within {p90[1]:.3f})",
                flush=True,
            )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
