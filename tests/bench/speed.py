"""The benchmark: ``python -m tests.bench.speed`` prints the table of README's figures as Markdown.

Every job runs in process on one picture, ours and all installed peers in turns in one run; the
results of ours are compared with the slow twins, those of the peers with ours.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tests.bench import machine
from tests.bench.jobs import JOBS, PAIRS, Job, Pair, checked
from tests.bench.largest import SIDE, run, write_pgm
from tests.bench.peers import UNPACKAGED, installed
from tests.bench.peers.base import Bytes, Peer, Timed
from tests.bench.picture import picture
from tests.bench.startup import start_up
from tests.bench.table import markdown
from tests.bench.timing import Seconds, best_and_median, compare, rate

__all__ = ["Settings", "main", "report"]

OURS = "ours"
FULL, QUICK, SMALL = (4000, 6000), (1000, 1504), (512, 512)


@dataclass(frozen=True)
class Settings:
    """only : part of the name of a job. largest : side of the largest picture, 0 leaves it out."""

    shape: tuple[int, int] = FULL
    runs: int = 9
    budget: float = 4.0  # seconds a candidate may take for its runs; then three must do
    only: str = ""
    largest: int = 0
    seconds_of_largest: float = 600

    def wants(self, *names: str) -> bool:
        return any(self.only.lower() in name.lower() for name in names)


@dataclass
class Notes:
    """What goes below the table, found out on the way."""

    same: dict[str, dict[str, float]] = field(default_factory=dict)
    """Peer → job → share of the pixels of its result that equal ours."""
    failed: list[str] = field(default_factory=list)
    pixels: int = 0


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.bench.speed", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="smaller pictures and fewer runs")
    parser.add_argument("--only", default="", metavar="NAME", help="jobs with this in their name")
    parser.add_argument("--md", type=Path, metavar="FILE", help="write the Markdown there, too")
    parser.add_argument("--largest", action="store_true", help=f"also {SIDE:,} × {SIDE:,} pixels")
    given = parser.parse_args(argv)
    settings = Settings(only=given.only, largest=SIDE if given.largest else 0)
    if given.quick:
        settings = Settings(
            QUICK, runs=3, budget=0.5, only=given.only, largest=4096 if given.largest else 0
        )
    text = report(settings)
    print(text)
    if given.md:
        given.md.write_text(text + "\n")
    return 0


def report(settings: Settings) -> str:
    """The whole text. AssertionError where a result of ours is not what its slow twin gives."""
    peers, missing = installed()
    notes = Notes()
    before = machine.clock()
    parts = [*_jobs(settings, peers, notes), *_pairs(settings), *_generation(settings)]
    with tempfile.TemporaryDirectory() as folder:
        parts += [*_start_up(settings, Path(folder)), *_largest(settings, Path(folder))]
    if not parts:
        names = [job.key for job in JOBS] + ["two threads", "void-and-cluster", "start-up", "largest"]
        raise SystemExit(f"no job has '{settings.only}' in its name; there are: {', '.join(names)}")
    head = (
        f"{machine.described()}. Clock, by a chain of dependent additions: {before:.2f} GHz before "
        f"the run, {machine.clock():.2f} after. One thread unless said; best / median of up to "
        f"{settings.runs} runs in turns; MP/s = 10⁶ pixels a second; the output array's allocation "
        "is in everybody's time. Ratios: best of ours / best of the peer; at last the fastest peer's."
    )
    return "\n\n".join([head, *parts, *_footer(peers, missing, notes)])


def _progress(what: str) -> None:
    print(f"… {what}", file=sys.stderr, flush=True)


def _jobs(settings: Settings, peers: list[Peer], notes: Notes) -> Iterator[str]:
    rows = []
    for job in JOBS:
        if not settings.wants(job.key, job.title, job.method):
            continue
        for shape in (settings.shape, SMALL) if job.small else (settings.shape,):
            _progress(f"{job.key} {shape[1]} × {shape[0]}")
            rows.append(_row(job, picture(*shape), settings, peers, notes))
    if rows:
        heads = ("job", "picture", "output", "arithmetic", "ours, MP/s", "peers, MP/s", "ratio")
        yield markdown(heads, rows)


def _row(job: Job, codes: Bytes, settings: Settings, peers: list[Peer], notes: Notes) -> list[str]:
    work: dict[str, Timed] = {OURS: job.ours(codes)}
    shown = work[OURS].indices(work[OURS].call())
    notes.pixels += checked(job, codes, shown)
    for peer in peers:
        if job.key in peer.jobs and (codes.shape == SMALL or not peer.slow):
            try:
                timed = peer.jobs[job.key](codes)
                same = _same(timed.indices(timed.call()), shown)
            except RuntimeError as error:
                notes.failed.append(f"{peer.name}, {job.key}: {error}")
                continue
            work[peer.name] = timed
            shares = notes.same.setdefault(peer.name, {})
            shares[job.key] = min(same, shares.get(job.key, 1))
    runs = settings.runs if codes.shape != SMALL else 3 * settings.runs
    times = compare({name: timed.call for name, timed in work.items()}, runs, settings.budget)
    ours = times.pop(OURS)
    ranked = sorted(times, key=lambda name: min(times[name]))
    ratio = {name: f"{min(times[name]) / min(ours):.2f} ×" for name in ranked}
    return [
        job.title,
        _size(codes.shape),
        job.output,
        job.arithmetic,
        rate(ours, codes.size),
        "; ".join(f"{name} {rate(times[name], codes.size)} ({ratio[name]})" for name in ranked)
        or "none",
        f"{ratio[ranked[0]]} {ranked[0]}" if ranked else "—",
    ]


def _same(theirs: Bytes, ours: Bytes) -> float:
    """The share of pixels that a peer has in common with ours; one of another tone does another job."""
    if theirs.shape != ours.shape:
        raise RuntimeError(f"gives shape {theirs.shape} instead of {ours.shape}")
    if abs(theirs.mean() - ours.mean()) > 0.02 * ours.max():
        raise RuntimeError(f"gives a mean of {theirs.mean():.4f} instead of {ours.mean():.4f}")
    return float((theirs == ours).mean())


def _size(shape: tuple[int, ...]) -> str:
    return "512²" if shape == SMALL else f"{shape[0] * shape[1] / 1e6:.3g} MP"


def _pairs(settings: Settings) -> Iterator[str]:
    rows = []
    for pair in PAIRS:
        if settings.wants(pair.title):
            _progress(pair.title)
            rows.append(_pair(pair, picture(*settings.shape), settings))
    if rows:
        yield "Ours beside ours, the same bytes:"
        yield markdown(("", "first, MP/s", "second, MP/s", "time, second / first", "speed"), rows)


def _pair(pair: Pair, codes: Bytes, settings: Settings) -> list[str]:
    first, second = pair.first(codes), pair.second(codes)
    expected = first.indices(first.call())
    for _ in range(settings.runs):  # more than once: threads that race are wrong only now and then
        np.testing.assert_array_equal(second.indices(second.call()), expected)
    times = compare({"first": first.call, "second": second.call}, settings.runs, settings.budget)
    share = min(times["second"]) / min(times["first"])
    rates = [rate(times[name], codes.size) for name in ("first", "second")]
    return [pair.title, *rates, f"{share:.2f}", f"{1 / share:.2f} ×"]


def _generation(settings: Settings) -> Iterator[str]:
    if not settings.wants("void-and-cluster"):
        return
    from halftone.screens.bluenoise import blue_noise_ranks, shipped

    _progress("void-and-cluster")
    seeds = iter(range(1, 1000))  # another mask each time: nothing can be remembered
    side = 256
    np.testing.assert_array_equal(blue_noise_ranks(side, side, seed=0), shipped())
    (times,) = compare(
        {"ranks": lambda: blue_noise_ranks(side, side, seed=next(seeds))}, min(settings.runs, 5)
    ).values()
    best, median = best_and_median(times)
    yield f"Void-and-cluster mask, 256 × 256, int64 energies: {best:.2f} s best, {median:.2f} s median."


def _start_up(settings: Settings, folder: Path) -> Iterator[str]:
    if not settings.wants("start-up"):
        return
    _progress("start-up")
    times: dict[str, Seconds] = start_up(folder, settings.runs)
    yield "Whole processes on a 576 × 576 PNG, reading and writing included:"
    rows = [[name, *(f"{1e3 * s:.0f}" for s in best_and_median(t))] for name, t in times.items()]
    yield markdown(("process", "ms, best", "median"), rows)


def _largest(settings: Settings, folder: Path) -> Iterator[str]:
    side = settings.largest
    if not side or not settings.wants("largest"):
        return
    _progress(f"largest picture, {side:,} × {side:,}")
    source = folder / "largest.pgm"
    write_pgm(source, side)
    rows = []
    for format in ("pbm", "tiff"):
        done = run(source, format, settings.seconds_of_largest)
        speed = f"{side * side / done.seconds / 1e6:,.0f}"
        figures = [f"{done.seconds:.1f}", speed, f"{done.peak:.0f}"]
        rows.append([format.upper(), *(["—"] * 3 if done.refused else figures), done.refused or "done"])
    yield (
        f"Largest picture: gray PGM of {side:,} × {side:,} pixels through "
        "`halftone convert -m fs:raster`, sRGB codes, float32, as a process:"
    )
    yield markdown(("to", "seconds", "MP/s", "peak memory, MB", ""), rows)


def _footer(peers: list[Peer], missing: list[str], notes: Notes) -> Iterator[str]:
    if notes.pixels:
        yield (
            f"{notes.pixels:,} pixels of the timed results of ours were compared with the slow twins "
            "in plain Python: all equal."
        )
    used = [peer for peer in peers if peer.name in notes.same]
    if used:
        yield (
            "Peers, and the share of pixels in which their result equals ours (two error diffusions "
            "that round or clamp differently have the same tone, but part ways pixel by pixel):"
        )
        yield "\n".join(
            f"- {peer.name} {peer.version}: {peer.arithmetic}. Equal: {_shares(notes.same[peer.name])}."
            for peer in used
        )
    idle = [peer.name for peer in peers if peer not in used]
    if idle:
        yield f"Installed, but without a job in this run: {', '.join(idle)}."
    if notes.failed:
        yield "Peers that failed here: " + "; ".join(notes.failed) + "."
    yield "Peers not installed here: " + ("; ".join(missing) or "none") + "."
    yield "Peers that no package gives, not timed: " + "; ".join(UNPACKAGED) + "."


def _shares(same: dict[str, float]) -> str:
    """'all in a, b; 61 … 80 % in c, d'."""
    equal = [key for key, share in same.items() if share == 1]
    others = {key: 100 * share for key, share in same.items() if share < 1}
    said = [f"all in {', '.join(equal)}"] if equal else []
    if others:
        ends = dict.fromkeys(f"{end(others.values()):.1f}" for end in (min, max))
        said.append(f"{' … '.join(ends)} % in {', '.join(others)}")
    return "; ".join(said)


if __name__ == "__main__":
    sys.exit(main())
