"""Pictures by bands: what comes is what a whole frame holds, and nothing whole is held."""

from __future__ import annotations

import io
import os
import resource
import subprocess
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import halftone
from devices import profile
from halftone import Bands, Frame, InputError, InputFileError, UsageError, convert, convert_bands, stages
from halftone._parallel import AHEAD, in_order
from halftone.images import png, tiff
from halftone.packing import Packing
from halftone.tone.levels import Levels
from tests.cli.command import environment, run, script
from tests.cli.files import write_oiio

METHODS = [
    "fs",
    "fs:warm",
    "jjn:raster",
    "bayer8",
    "dots:knuth",
    "threshold:otsu",
    "riemersma",
    "patterns:4",
]


@pytest.fixture(scope="module")
def photo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A gray PNG of 700 rows: more than a window."""
    path = tmp_path_factory.mktemp("bands") / "in.png"
    y, x = np.mgrid[0:700, 0:83]
    noise = np.random.default_rng(3).normal(0, 9, x.shape)
    Image.fromarray((x * 2 + y / 9 + noise).clip(0, 255).astype(np.uint8)).save(path)
    return path


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("options", [{}, {"width": 61}, {"auto_levels": True, "range": "scale"}])
def test_the_parts_are_the_whole(method: str, options: dict, photo: Path) -> None:
    """Of a file and of its pixels, for any number of workers."""
    whole = convert(np.asarray(Image.open(photo)), method=method, **options)
    for workers in (1, 3):
        bands = convert_bands(photo, method=method, workers=workers, **options)
        assert bands.shape == whole.shape
        parts = list(bands)
        assert len(parts) > 1 or "width" in options  # resized, it is in memory: one band may do
        assert all(isinstance(part, Frame) for part in parts)
        assert np.array_equal(np.concatenate([p.indices for p in parts]), whole.indices)
        assert b"".join(p.packed().tobytes() for p in parts) == whole.packed().tobytes()
        assert (bands.method, bands.dpi, bands.packing) == (whole.method, whole.dpi, whole.packing)


@pytest.mark.parametrize("rows", [1, 5, 64, 1000])
@pytest.mark.parametrize("format", ["png", "tiff", "pbm", "pgm", "raw"])
def test_files_do_not_depend_on_the_height_of_bands(
    format: str, rows: int, photo: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    convert(photo).save(tmp_path / "whole", format)
    monkeypatch.setattr(stages, "BAND_ROWS", rows)
    convert_bands(photo).save(tmp_path / "bands", format)
    assert (tmp_path / "bands").read_bytes() == (tmp_path / "whole").read_bytes()


def test_strips_and_chunks_across_bands(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rows of a TIFF strip and bytes of a PNG chunk come from several bands, and end within one."""
    indices = np.random.default_rng(2).integers(0, 4, (301, 3000), np.uint8)
    frame = Frame(indices, Levels.of(4))
    monkeypatch.setattr(png, "_IDAT", 10_000)
    for module in (png, tiff):
        expected = module.encode(frame)
        for rows in (1, 7, 64):
            parts = (indices[y : y + rows] for y in range(0, 301, rows))
            file = io.BytesIO()
            module.write(Bands(frame.shape, parts, frame.levels), file)
            assert file.getvalue() == expected
        with Image.open(io.BytesIO(expected)) as picture:
            assert np.array_equal(np.asarray(picture.convert("L")), frame.preview())
    assert png.encode(frame).count(b"IDAT") > 10


@pytest.mark.parametrize("factor", [1, 2, 7])
def test_upscaled_bands(factor: int, photo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("halftone.frame.UPSCALED", 5000)
    whole = convert(photo).upscaled(factor)
    bands = convert_bands(photo).upscaled(factor)
    assert bands.shape == whole.shape
    assert np.array_equal(np.concatenate([p.indices for p in bands]), whole.indices)


def test_bands_for_a_device(photo: Path) -> None:
    device = profile.load("receipt-80mm")
    whole = convert(photo, profile=device)
    bands = convert_bands(photo, profile=device)
    assert bands.packing == device.packing
    assert b"".join(p.packed().tobytes() for p in bands) == whole.packed().tobytes()
    at_once = convert_bands(photo, profile=device).packed()
    np.testing.assert_array_equal(at_once, whole.packed())
    gray = Packing(4, "lsb")
    np.testing.assert_array_equal(
        convert_bands(photo, levels=5).packed(gray), convert(photo, levels=5).packed(gray)
    )


def test_the_report_is_complete_at_the_end(photo: Path) -> None:
    seen: list[float] = []
    bands = convert_bands(photo, progress=seen.append)
    assert seen == []
    for _ in bands:
        pass
    assert seen == sorted(seen)
    assert seen[-1] == 1
    stages_done = {s["stage"]: s["seconds"] for s in bands.report["stages"]}
    assert list(stages_done) == ["read", "dither"]
    assert all(seconds > 0 for seconds in stages_done.values())


def test_options_are_checked_at_once(photo: Path) -> None:
    with pytest.raises(UsageError, match="sticki"):
        convert_bands(photo, method="sticki")
    with pytest.raises(InputFileError, match="nowhere"):
        convert_bands("nowhere.png")
    with pytest.raises(TypeError):
        convert_bands(photo, metod="fs")


def _cut(path: Path, share: float) -> None:
    data = path.read_bytes()
    path.write_bytes(data[: int(len(data) * share)])


@pytest.mark.parametrize("kind", ["png", "jpg", "tif", "bmp", "pgm"])
def test_damage_far_down_leaves_nothing(kind: str, tmp_path: Path) -> None:
    """Rows are halftoned and written before the damage is reached."""
    path = tmp_path / f"in.{kind}"
    noise = np.random.default_rng(1).integers(0, 256, (2000, 100), np.uint8)
    Image.fromarray(noise).save(path, **({"compression": "tiff_lzw"} if kind == "tif" else {}))
    if kind == "tif":
        data = bytearray(path.read_bytes())
        middle = 3 * len(data) // 4
        data[middle : middle + 2000] = bytes(2000)
        path.write_bytes(data)
    else:
        _cut(path, 0.8)
    for jobs in "12":
        line = run("convert", path, tmp_path / "out.png", "-j", jobs).complaint(3)
        assert str(path) in line
        assert [p.name for p in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("jobs", ["1", "2"])
@pytest.mark.parametrize("method", ["bayer8", "fs", "dots:knuth", "fs:warm"])
def test_nan_far_down_is_named_and_leaves_nothing(method: str, jobs: str, tmp_path: Path) -> None:
    light = np.full((900, 50), 0.5, np.float32)
    light[777, 13] = light[780, 3] = np.nan
    write_oiio(tmp_path / "in.exr", light, "float")
    args = ("convert", tmp_path / "in.exr", tmp_path / "out.png", "-m", method, "-j", jobs)
    assert "row 777, column 13" in run(*args).complaint(3)
    assert [p.name for p in tmp_path.iterdir()] == ["in.exr"]


def test_memory_does_not_grow_with_the_height(tmp_path: Path) -> None:
    """128 megapixels take no more than 8 MiB above 2: the window, and what bands need."""
    row = (np.arange(4096) // 16).astype(np.uint8)
    peaks = []
    for name, height in (("small", 512), ("large", 32_768)):
        with open(tmp_path / f"{name}.pgm", "wb") as file:
            file.write(b"P5\n4096 %d\n255\n" % height)
            for _ in range(height // 64):
                file.write(np.tile(row, (64, 1)).tobytes())
        command = [script(), "convert", tmp_path / f"{name}.pgm", tmp_path / "out.pbm", "-m", "bayer8"]
        process = subprocess.Popen(command, env=environment())
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        assert process.returncode == 0
        peaks.append(usage.ru_maxrss)
        (tmp_path / f"{name}.pgm").unlink()
    assert peaks[1] - peaks[0] < 8 << 10


def test_the_limit_is_on_what_is_held(tmp_path: Path) -> None:
    """A streamed picture of 24 MB goes through 16 MiB, as bands; as a frame it does not."""
    path = tmp_path / "in.pgm"
    path.write_bytes(b"P5\n1000 24000\n255\n" + bytes(24_000_000))
    limit = 16 << 20
    assert sum(len(part.indices) for part in convert_bands(path, max_memory=limit)) == 24_000
    with pytest.raises(InputError, match="1000 × 24000"):
        convert(path, max_memory=limit)
    with pytest.raises(InputError, match="1000 × 24000"):
        halftone.read(path, max_memory=limit)


def test_bands_come_in_order_and_not_too_far_ahead() -> None:
    started: list[int] = []

    def work(start: int, stop: int) -> int:
        started.append(start)
        return start

    for workers in (0, 1, 3):
        started.clear()
        for number, start in enumerate(in_order(work, 100, 3, workers)):
            assert start == 3 * number
            assert len(started) <= number + max(1, workers + AHEAD)
        assert sorted(started) == list(range(0, 100, 3))


@pytest.mark.parametrize("workers", [1, 3])
def test_bands_that_wait_are_told_to_give_up(workers: int) -> None:
    """One raises, or nobody takes the rest: *stop* is called before the others are waited for."""
    from threading import Event

    told = Event()

    def work(start: int, stop: int) -> int:
        if start == 4:
            raise ValueError("band 4")
        if start > 4:
            assert told.wait(20)
        return start

    with pytest.raises(ValueError, match="band 4"):
        for _ in in_order(work, 50, 1, workers, told.set):
            pass
    assert told.is_set()
    told.clear()
    parts = in_order(lambda start, stop: start, 50, 1, workers, told.set)
    assert next(parts) == 0
    parts.close()
    assert told.is_set()


def test_peak_memory_is_measured_in_kib() -> None:
    """As getrusage says on Linux, on which the test above relies."""
    status = Path("/proc/self/status").read_text()
    high = int(status.split("VmHWM:")[1].split()[0])
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss == pytest.approx(high, rel=0.2)
