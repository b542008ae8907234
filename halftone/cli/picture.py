"""The options that say how a picture is halftoned, for every command that takes pictures."""

from __future__ import annotations

import argparse
import os
from typing import Any

__all__ = ["recipe", "recipe_arguments", "same_file", "size_in_bytes"]


def recipe_arguments(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("what the device can show")
    add = group.add_argument
    add(
        "-d",
        "--device",
        metavar="NAME",
        help="a device profile (halftone list devices) or .toml file",
    )
    add("-l", "--levels", help="N, uniform-linear:N, lstar:N, log:I0:N, or luminances Y0,Y1,…")
    add("--gamma", help="response of the device, for a count of levels: 2.2, srgb, … (default srgb)")
    add("--size", metavar="WxH", help="size in dots; Wx or xH keeps the shape")
    add("--width", type=int, metavar="W", help="width in dots; the height follows")
    add("--fit", choices=("contain", "cover", "stretch"), help="with --size WxH")
    group = parser.add_argument_group("how it is halftoned")
    add = group.add_argument
    add("-m", "--method", help="a method (halftone list methods); default floyd-steinberg")
    add("--content", metavar="C", help="text, graphic or photo: the method that suits it")
    add("--strength", type=float, metavar="S", help="0 (nearest level) … 1 (full)")
    add("--serpentine", action="store_true", default=None, help="scan odd rows backwards")
    add("--raster", dest="serpentine", action="store_false", help="scan all rows forwards")
    add("--seed", type=int, metavar="N", help="for methods that draw random numbers")
    add(
        "--range",
        default="clip",
        metavar="RULE",
        help="light beyond the levels: clip, scale, compress",
    )
    add(
        "--dot-gain",
        choices=("correct", "keep"),
        default="correct",
        help="correct for printed dots that are larger than their cells, or keep them dark "
        "(default correct, where the device's dots are known)",
    )
    group = parser.add_argument_group("the picture")
    add = group.add_argument
    add("--encoding", metavar="E", help="what its codes mean: srgb, bt709, gamma:G, linear")
    add("--brightness", type=float, default=0.0, metavar="B", help="-1 … 1")
    add("--contrast", type=float, default=0.0, metavar="C", help="-1 … 1")
    add("--auto-levels", action="store_true", help="darkest and lightest 0.5 %% to black and white")
    add("--invert", action="store_true", help="white less the light")
    add(
        "--background",
        default="white",
        help="under transparent pixels: white, black, or light 0 … 1",
    )
    add("--nonfinite", default="error", metavar="P", help="NaN and infinity: error, or clip")
    add(
        "--max-memory",
        type=size_in_bytes,
        metavar="SIZE",
        help="refuse what takes more: 500M, 8G (default 4G)",
    )


def recipe(options: argparse.Namespace, *, sources: int) -> Any:
    """Everything but the picture, checked. sources : pictures that are converted at a time."""
    from halftone.cli.console import profile
    from halftone.errors import UsageError
    from halftone.recipe import Recipe

    width, height = options.width, None
    if options.size is not None:
        from halftone.images.resize import parse_size

        if width is not None:
            raise UsageError("both --size and --width were given; give one")
        width, height = parse_size(options.size)
    given: dict[str, Any] = {}
    if options.max_memory is not None:
        given["max_memory"] = options.max_memory
    return Recipe(
        profile=profile(options.device),
        method=options.method,
        content=options.content,
        levels=options.levels,
        width=width,
        height=height,
        fit=options.fit,
        encoding=options.encoding,
        gamma=options.gamma,
        brightness=options.brightness,
        contrast=options.contrast,
        auto_levels=options.auto_levels,
        invert=options.invert,
        background=options.background,
        range=options.range,
        dot_gain=options.dot_gain,
        nonfinite=options.nonfinite,
        serpentine=options.serpentine,
        strength=options.strength,
        seed=options.seed,
        workers=options.jobs if sources == 1 else 1,
        **given,
    )


def size_in_bytes(text: str) -> int:
    """A size as 500M or 8G; plain numbers are MiB."""
    units = {"K": 10, "M": 20, "G": 30}
    number, unit = (text[:-1], text[-1].upper()) if text[-1:].isalpha() else (text, "M")
    try:
        size = int(float(number) * (1 << units[unit]))
    except (ValueError, KeyError, OverflowError):
        raise argparse.ArgumentTypeError(f"'{text}' is not a size; allowed: 500M, 8G") from None
    if size < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is not above 0")
    return size


def same_file(first: str, second: str) -> bool:
    """Whether both names are of one file that is there."""
    try:
        return os.path.samefile(first, second)  # noqa: PTH121 (pathlib takes 4 ms to import)
    except OSError:
        return False
