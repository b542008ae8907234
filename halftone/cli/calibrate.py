"""``halftone calibrate``: print a step chart, read it, and keep what it says of the printer."""

from __future__ import annotations

import argparse
import os
import sys
from typing import Any

from halftone.errors import UsageError

__all__ = ["arguments", "run"]

_WHAT = {
    "chart": "print a step chart with --to URI, or write it to OUT.png",
    "read": "the light of the chart's patches in a PHOTO or a scan of it",
    "fit": "what a PHOTO, or --readings, says of the printer; --save NAME keeps it as a profile",
}


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = "\n".join(f"  {name:6} {text}" for name, text in _WHAT.items())
    add = parser.add_argument
    add("what", choices=_WHAT, metavar="|".join(_WHAT))
    add("paths", nargs="*", metavar="OUT|PHOTO")
    add("-d", "--device", metavar="NAME", help="the profile the printer has so far")
    add("-m", "--method", help="the method that prints the steps; default: the device's, as for convert")
    add("--steps", type=int, metavar="N", help="9 (default) or 17 steps; a photo says it itself")
    add("--to", metavar="URI", help="chart: the printer, as for halftone print")
    add("--encoding", metavar="E", help="read, fit: what the photo's codes mean (sRGB)")
    add("--readings", metavar="R,R,...", help="fit: the steps read by hand, from the darkest on")
    add("--lines", metavar="V,H", help="fit: the two patches of lines, read like the steps")
    kinds = ("light", "density", "lstar")
    add("--as", dest="scale", choices=kinds, help="what readings are (light in %%)")
    add("--noise", type=float, metavar="S", help="fit: standard deviation of a reading, in %% of paper")
    add("--save", metavar="NAME", help="fit: write the profile NAME to the user's own")
    add("--force", action="store_true", help="fit: replace a profile of that name")
    add("--json", action="store_true", help="read, fit: as JSON")


_ALLOWED = {
    "chart": {"device", "method", "steps", "to"},
    "read": {"encoding", "json"},
    "fit": {
        *("device", "method", "steps", "encoding", "readings", "lines", "scale", "noise"),
        *("save", "force", "json"),
    },
}


def run(options: argparse.Namespace) -> int:
    """One of chart, read, fit."""
    from halftone.cli.console import our_devices

    our_devices()
    for name in set().union(*_ALLOWED.values()) - _ALLOWED[options.what]:
        given = getattr(options, name)
        if given is not None and given is not False:
            raise UsageError(f"--{'as' if name == 'scale' else name} does not apply to {options.what}")
    if len(options.paths) > 1:
        raise UsageError(f"calibrate {options.what} takes one file, not {len(options.paths)}")
    options.path = options.paths[0] if options.paths else None
    return {"chart": _chart, "read": _read, "fit": _fit}[options.what](options)


def _made(options: argparse.Namespace, steps: int) -> Any:
    """(profile, chart) for the device that was named."""
    from devices.chart import make_chart
    from halftone.cli.console import profile

    if options.device is None:
        raise UsageError("which device? Give --device NAME (halftone list devices)")
    base = profile(options.device)
    return base, make_chart(base, steps, options.method)


def _chart(options: argparse.Namespace) -> int:
    if (options.path is None) == (options.to is None):
        raise UsageError("where does the chart go? Give --to URI or OUT.png, one of both")
    base, chart = _made(options, 9 if options.steps is None else options.steps)
    if options.to is None:
        chart.frame.save(options.path)
    else:
        from devices.registry import open_device

        with open_device(options.to, base) as device:
            device.print(chart.frame)
    _say(
        f"{chart.steps} steps by {chart.method}, row by row from the darkest; then vertical and "
        f"horizontal lines. Next: halftone calibrate fit --device {options.device}"
        + ("" if options.method is None else f" --method {options.method}")
        + " PHOTO.jpg --save NAME"
    )
    return 0


def _read(options: argparse.Namespace) -> int:
    from devices.chart import read_chart

    if options.path is None:
        raise UsageError("calibrate read needs a PHOTO or a scan of the chart")
    reading = read_chart(options.path, options.encoding)
    if options.json:
        _json({"steps": reading.steps, "light": reading.light, "spread": reading.spread})
        return 0
    for k, (light, spread) in enumerate(zip(reading.light, reading.spread, strict=True)):
        place = k - reading.steps
        name = f"step {k + 1}" if place < 0 else ("lines |", "lines -")[place]
        print(f"{name:8} {100 * light:6.2f} %  ± {100 * spread:.2f}")
    return 0


def _fit(options: argparse.Namespace) -> int:
    from devices.calibration import fit, save

    light, steps, source = _readings(options)
    base, chart = _made(options, steps)
    noise = None if options.noise is None else options.noise / 100
    found = fit(chart.patterns[: len(light)], light, noise, steps)
    path = None
    if options.save is not None:
        import datetime

        numbers = ", ".join(f"{100 * v:.1f}" for v in light)
        said = (
            f"Calibrated {datetime.date.today()} from '{base.name}' with {chart.method}, {source}: "
            f"{numbers} % of paper; {found.model}; a reading is off by {100 * found.noise:.1f} %"
        )
        path = save(found, base, options.save, said, overwrite=options.force)
    if options.json:
        _json(
            {
                "dot": [found.dot.across, found.dot.down],
                "black": found.black,
                "measured": found.measured,
                "noise": found.noise,
                "model": found.model,
                "readings": light,
                "residuals": found.residuals,
                "profile": None if path is None else str(path),
            }
        )
        return 0
    across, down = found.dot.across, found.dot.down
    print(f"dot      {across:.3f} × {down:.3f} of the distance between dots")
    print(f"black    {100 * found.black:.1f} % of the paper's light")
    print(f"model    {found.model}")
    print(f"noise    {100 * found.noise:.1f} % of the paper's light (one sigma)")
    if path is not None:
        name = path.stem
        print(f"profile  {path}")
        _say(f"use it: halftone convert IN OUT --device {name}")
    return 0


def _readings(options: argparse.Namespace) -> tuple[Any, int, str]:
    """Light relative to paper, how many of them are steps, and where they are from."""
    from devices.calibration import relative_light
    from devices.chart import STEPS, read_chart

    if (options.path is None) == (options.readings is None):
        raise UsageError("from what? Give a PHOTO or --readings, one of both")
    if options.readings is None:
        for name in ("lines", "scale", "steps"):
            if getattr(options, name) is not None:
                option = "as" if name == "scale" else name
                raise UsageError(f"--{option} is for --readings: a photo says it")
        reading = read_chart(options.path, options.encoding)
        return reading.light, reading.steps, f"read from {os.path.basename(options.path)}"  # noqa: PTH119
    if options.encoding is not None:
        raise UsageError("--encoding is for a photo")
    given = _numbers("--readings", options.readings)
    steps = len(given) if options.steps is None else options.steps
    if steps not in STEPS or len(given) != steps:
        allowed = options.steps if options.steps in STEPS else "9 or 17"
        raise UsageError(f"{len(given)} readings; allowed: one for each of {allowed} steps")
    if options.lines is not None:
        lines = _numbers("--lines", options.lines)
        if len(lines) != 2:
            raise UsageError(f"--lines {options.lines}; allowed: V,H, one of each")
        given += lines
    return relative_light(given, options.scale or "light"), steps, "readings typed in"


def _numbers(option: str, text: str) -> list[float]:
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise UsageError(f"{option} {text}: allowed: numbers with commas between, 3.1,9,27.5") from None


def _json(facts: dict[str, Any]) -> None:
    import json

    rounded = {k: v.round(5).tolist() if hasattr(v, "tolist") else v for k, v in facts.items()}
    print(json.dumps(rounded, indent=1, ensure_ascii=False))


def _say(text: str) -> None:
    print(f"halftone: {text}", file=sys.stderr)
