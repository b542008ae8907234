"""The wavefront against the serial kernels and the slow twins: any size, bands, threads, filters."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halftone import ErrorDiffusion, ErrorFilter
from halftone._arrays import Source
from halftone.dithering import _wave_kernels, diffusion, wave
from halftone.dithering.base import Job
from halftone.dithering.filters import FILTERS
from halftone.tone.levels import Levels
from halftone.tone.range import bring_into_range
from tests.oracle import diffusion as oracle

LADDERS = (2, 3, 16, 17, "uniform-linear:100", "lstar:64", "0.03,0.2,0.5,0.9", "0.1,0.100001,0.9", 256)
LINEAR = (np.arange(256) / 255).astype(np.float32)
WIDE = ErrorFilter("wide", ((0, 2, 1), (1, -8, 2), (2, 8, 1), (8, -8, 1), (8, 8, 1)), 8)


def scan(halftoner, shape, rows=64) -> np.ndarray:
    """Bands from the top."""
    out = np.empty(shape, np.uint8)
    for y in range(0, shape[0], rows):
        halftoner.band(y, min(y + rows, shape[0]), out[y : y + rows])
    return out


def picture(seed: int, shape: tuple[int, int], coded: bool) -> Source:
    random = np.random.default_rng(seed)
    if coded:
        table = LINEAR if seed % 2 else LINEAR ** np.float32(2.2)
        return Source(random.integers(0, 256, shape).astype(np.uint8), table)
    return Source((random.random(shape) * 1.2 - 0.1).astype(np.float32))


def both(method, source, levels, rows=64, workers=1) -> tuple[np.ndarray, np.ndarray]:
    """By the wavefront and by the serial kernel."""
    source = bring_into_range(source, levels.darkest, levels.lightest, "clip")
    job = Job(source, levels, None, workers)
    fast = method.halftoner(job)
    assert isinstance(fast, wave.WaveCodes | wave.WaveLight)
    whole = isinstance(fast, wave.WaveCodes)
    slow = (diffusion._Codes if whole else diffusion._Light)(method, job)
    return scan(fast, source.shape, rows), scan(slow, source.shape)


def test_constants_are_those_of_the_kernels():
    names = ("LANES", "CHUNK", "SCANNED")
    assert [getattr(wave, name) for name in names] == [getattr(_wave_kernels, name) for name in names]


@given(
    st.integers(1, 140),
    st.integers(1, 400),
    st.integers(0, 2**32 - 1),
    st.booleans(),
    st.sampled_from(sorted(FILTERS)),
    st.sampled_from(LADDERS),
    st.sampled_from([1.0, 0.6, 0.0]),
    st.booleans(),
    st.integers(1, 100),
    st.integers(1, 3),
)
def test_any_size_levels_bands_and_workers(
    height, width, seed, coded, name, ladder, strength, right, rows, workers
):
    levels = Levels.of(ladder)
    if not wave.few_rounds(levels):
        levels = Levels.of(17)
    method = ErrorDiffusion(name, False, strength, right)
    fast, slow = both(method, picture(seed, (height, width), coded), levels, rows, workers)
    np.testing.assert_array_equal(fast, slow)


@pytest.mark.parametrize("shape", [(1, 1), (1, 300), (300, 1), (2, 32_800), (3, 70_000), (33, 33_000)])
@pytest.mark.parametrize("coded", [False, True])
@pytest.mark.parametrize("name", ["floyd-steinberg", "jarvis-judice-ninke"])
def test_thin_and_wide(name, coded, shape):
    fast, slow = both(ErrorDiffusion(name, False), picture(1, shape, coded), Levels.of(2), 32, 2)
    np.testing.assert_array_equal(fast, slow)


@given(st.integers(1, 40), st.integers(1, 60), st.integers(0, 99), st.integers(1, 40))
def test_a_filter_that_reaches_as_far_as_any_may(height, width, seed, rows):
    fast, slow = both(
        ErrorDiffusion(WIDE, False), picture(seed, (height, width), False), Levels.of(5), rows, 2
    )
    np.testing.assert_array_equal(fast, slow)


@given(st.integers(1, 40), st.integers(1, 60), st.integers(0, 99), st.sampled_from(["", ":right"]))
@settings(max_examples=10)
def test_against_the_slow_twins(height, width, seed, right):
    codes = np.random.default_rng(seed).integers(0, 256, (height, width)).astype(np.uint8)
    method = ErrorDiffusion("floyd-steinberg", False, 1.0, bool(right))
    job = Job(Source(codes, LINEAR), Levels.of(2))
    np.testing.assert_array_equal(
        scan(method.halftoner(job), codes.shape), oracle.diffuse_codes(codes, False, bool(right))
    )
    job = Job(Source(codes, LINEAR), Levels.of([0.0, 0.3, 1.0]))
    table = FILTERS["stucki"]
    np.testing.assert_array_equal(
        scan(ErrorDiffusion("stucki", False).halftoner(job), codes.shape),
        oracle.diffuse_light(LINEAR[codes], [0, 0.3, 1], table.taps, table.divisor, False),
    )


@pytest.mark.parametrize("width", [1, 40, 700])
@pytest.mark.parametrize("coded", [False, True])
def test_many_threads(coded, width):
    """Blocks wait for each other all the time, and hand on in every order there is."""
    source = picture(3, (230, width), coded)
    for workers in (2, 3, 5, 16):
        for rows in (230, 96, 33):
            for _ in range(3):
                fast, slow = both(ErrorDiffusion(serpentine=False), source, Levels.of(2), rows, workers)
                np.testing.assert_array_equal(fast, slow)


@pytest.mark.parametrize("workers", [1, 2])
def test_threads_that_wait_give_up_when_stopped(workers):
    job = Job(picture(0, (128, 64), True), Levels.of(2), None, workers)
    halftoner = ErrorDiffusion(serpentine=False).halftoner(job)
    halftoner.reach[0] = -1  # what lies above never comes
    out = np.empty((128, 64), np.uint8)
    with ThreadPoolExecutor(1) as pool:
        band = pool.submit(halftoner.band, 0, 128, out)
        threading.Event().wait(0.05)
        assert not band.done()
        halftoner.stop()
        with pytest.raises(InterruptedError):
            band.result(timeout=10)


def test_levels_too_close_for_their_number_take_the_serial_kernel():
    levels = Levels.of([*np.linspace(0.5, 0.5001, 40), 1.0])
    assert not wave.few_rounds(levels)
    job = Job(picture(0, (8, 8), False), levels)
    assert isinstance(ErrorDiffusion(serpentine=False).halftoner(job), diffusion._Light)


@given(
    st.integers(1, 40),
    st.integers(1, 80),
    st.integers(0, 2**32 - 1),
    st.sampled_from(["floyd-steinberg", "false-floyd-steinberg", "sierra-lite"]),
    st.sampled_from([1.0, 0.7]),
    st.booleans(),
    st.booleans(),
    st.integers(1, 50),
)
def test_four_places_in_one_pass(height, width, seed, name, strength, serpentine, right, rows):
    method = ErrorDiffusion(name, serpentine, strength, right)
    levels = Levels.of([0.1, 0.8])
    source = bring_into_range(picture(seed, (height, width), True), 0.1, 0.8, "clip")
    job = Job(source, levels)
    assert diffusion._Four.takes(method, job)
    turned = ErrorFilter("turned", tuple(reversed(FILTERS[name].taps)), FILTERS[name].divisor)
    assert not diffusion._Four.takes(ErrorDiffusion(turned, serpentine), job), "sums in another order"
    fast = scan(diffusion._Four(method, job), source.shape, rows)
    np.testing.assert_array_equal(fast, scan(diffusion._Light(method, job), source.shape))
