"""``halftone cache``: the compiled kernels kept for this user."""

from __future__ import annotations

import argparse
import time

__all__ = ["arguments", "run"]


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("action", choices=("warm", "info", "clear"), metavar="warm|info|clear")


def run(options: argparse.Namespace) -> int:
    from halftone import _objects

    if options.action == "clear":
        count = _objects.clear()
        print(f"{count} kernels deleted from {_objects.directory()}")
        return 0
    if options.action == "warm":
        return _warm()
    found = _objects.files()
    size = sum(path.stat().st_size for path in found)
    print(f"folder   {_objects.directory()}")
    print(f"kernels  {len(found)} ({size / 1024:.0f} KiB)")
    for path in found:
        print(f"         {path.name}")
    return 0


def _warm() -> int:
    """Compile and keep every kernel that is not kept yet."""
    from importlib import import_module
    from pathlib import Path

    import halftone
    from halftone import _objects
    from halftone._jit import kernels
    from halftone.cli.console import our_devices
    from halftone.errors import OutputError

    our_devices()
    for package in (halftone, import_module("devices")):
        root = Path(str(package.__file__)).parent
        for path in sorted(root.rglob("_*_kernels.py")):  # its kernels register when it is imported
            parts = path.relative_to(root).with_suffix("").parts
            import_module(".".join((package.__name__, *parts)))
    for made in kernels():
        start = time.perf_counter()
        origin = made.prepare()
        kept = _objects.read(made) is not None
        print(f"{made.__name__}: {origin}, {time.perf_counter() - start:.2f} s")
        if not kept and origin == "compiled":
            raise OutputError(
                f"kernels cannot be kept in '{_objects.directory()}'; every run compiles them anew. "
                "Set HALFTONE_CACHE_DIR to a folder you can write"
            )
    return 0
