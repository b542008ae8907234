"""One photograph, and what five limited devices show of it: writes examples/01_limits.png."""

from pathlib import Path

from halftone.cli.demo import PHOTOGRAPH, strip

Path(__file__).with_suffix(".png").write_bytes(strip(PHOTOGRAPH, 300))
