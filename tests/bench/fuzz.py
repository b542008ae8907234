"""Damaged streams through the decoders: an error with an offset or a right picture, nothing else.

``python -m tests.bench.fuzz [--count 1000000] [--language escpos] [--seed 1]``. Every stream is a
small job with one to three of: a byte changed, a bit turned, an end cut off, bytes taken out, put in
or doubled. For each language: how many were refused with an offset within the stream, how many gave
pictures (of at most 2²⁰ pixels), the longest time one took, and the peak of memory. Anything else is
printed with the stream that did it, and the exit code is 1.
"""

from __future__ import annotations

import argparse
import sys
import time
import traceback
import tracemalloc

import numpy as np

from devices.languages import language, languages
from tests.bench.printing import VARIANTS, name_of
from tests.devices.languages import contract

SLOW = 0.5
"""Seconds that no stream of this size may take, on a machine that does other things too."""


def streams(made, rng) -> list[bytes]:
    """Small jobs: noise, blank rows, repeated rows, two pages where the language has pages."""
    sizes = [(1, 1), (5, 13), (24, 40), (48, 16), (17, 65)]
    pictures = [
        (rng.random(size) < share).astype(np.uint8) for size in sizes for share in (0.5, 0.97, 1)
    ]
    repeated = [np.repeat(p, 3, axis=0) for p in pictures[:4]]
    single = [contract.stream(made, p, dpi=(300.0, 300.0)) for p in [*pictures, *repeated]]
    if made.name == "png":
        return single
    return [*single, contract.stream(made, *pictures[3:5], dpi=(300.0, 300.0))]


def fuzz(name: str, options: dict, count: int, seed: int) -> bool:
    """Whether all is well with *count* damaged streams of one language."""
    made, rng = language(name, **options), np.random.default_rng(seed)
    whole = streams(made, rng)
    pictures, slowest, bad = 0, 0.0, 0
    start = time.monotonic()
    for number in range(count):
        state = rng.bit_generator.state
        begun = time.monotonic()
        try:
            pictures += contract.check_damaged(made, whole[number % len(whole)], rng)
        except Exception:
            bad += 1
            rng.bit_generator.state = state
            stream = contract.damaged(whole[number % len(whole)], rng)
            print(f"{name}: {stream.hex()}\n{traceback.format_exc()}", flush=True)
            if bad >= 5:
                break
        took = time.monotonic() - begun
        if took > max(slowest, SLOW):
            print(f"{name}: stream {number} took {took:.2f} s", flush=True)
        slowest = max(slowest, took)
    spent = time.monotonic() - start
    tracemalloc.start()
    for number in range(min(count, 2000)):
        contract.check_damaged(made, whole[number % len(whole)], rng)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    print(
        f"| {name_of(name, options)} | {count:,} | {count - pictures - bad:,} | {pictures:,} | {bad} "
        f"| {slowest * 1e3:.0f} | {peak / 1e6:.1f} | {spent:.0f} |",
        flush=True,
    )
    return bad == 0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1_000_000, help="streams a language")
    parser.add_argument("--language", choices=languages(), action="append")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    print(
        "| language | streams | refused with an offset | pictures | anything else | slowest, ms ", end=""
    )
    print("| peak, MB | seconds |\n|---|---|---|---|---|---|---|---|", flush=True)
    chosen = [v for v in VARIANTS if options.language is None or v[0] in options.language]
    variants: dict[str, int] = {}
    for name, _ in chosen:
        variants[name] = variants.get(name, 0) + 1
    good = [fuzz(name, given, options.count // variants[name], options.seed) for name, given in chosen]
    sys.exit(0 if all(good) else 1)


if __name__ == "__main__":
    main()
