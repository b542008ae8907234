"""From intensities to what a device must be asked for: encodings, ladders, tables, ranges."""

from halftone.tone.ladder import (
    lightness,
    log_ladder,
    lstar_ladder,
    luminance,
    nearest,
    ratio,
    uniform_ladder,
    visible_steps,
)
from halftone.tone.levels import Levels
from halftone.tone.lut import combined_table, gamma_table, hardware_table, to_dac, wrong_codes
from halftone.tone.transfer import Encoding, encoding, intensity, voltage

__all__ = [
    "Encoding",
    "Levels",
    "combined_table",
    "encoding",
    "gamma_table",
    "hardware_table",
    "intensity",
    "lightness",
    "log_ladder",
    "lstar_ladder",
    "luminance",
    "nearest",
    "ratio",
    "to_dac",
    "uniform_ladder",
    "visible_steps",
    "voltage",
    "wrong_codes",
]
