"""halftone.images.resize: the sizes that come out, and light that is kept."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halftone._arrays import Source
from halftone.errors import UsageError
from halftone.images import resize as resize_module
from halftone.images.resize import FITS, Cells, LightRows, parse_size, place, resize, target_size

lengths = st.integers(1, 60)
sides = st.one_of(st.none(), st.integers(1, 90))
aspects = st.sampled_from([1.0, 2.0, 0.5, 203 / 96])
fits = st.sampled_from(sorted(FITS))
lights = st.sampled_from([0.0, 1.0, 0.5, 0.18, 7.25])


def _constant(rows: int, columns: int, light: float, rgb: bool) -> np.ndarray:
    return np.full((rows, columns, 3) if rgb else (rows, columns), light, np.float32)


@given(lengths, lengths, sides, sides, fits, aspects, lights, st.booleans())
def test_size_and_constancy(
    rows: int,
    columns: int,
    width: int | None,
    height: int | None,
    fit: str,
    aspect: float,
    light: float,
    rgb: bool,
) -> None:
    """A constant picture over a background of its own light is that light everywhere."""
    size = target_size(rows, columns, width, height, aspect)
    placed = place(_constant(rows, columns, light, rgb), *size, fit, light, aspect)
    assert placed.shape[:2] == size[::-1]
    if width is not None and height is not None:
        expected = (height, width)
    elif width is not None:
        expected = (max(1, round(width * rows / columns / aspect)), width)
    elif height is not None:
        expected = (height, max(1, round(height * columns / rows * aspect)))
    else:
        expected = (max(1, round(rows / aspect)), columns)
    assert np.abs(np.subtract(placed.shape[:2], expected)).max() <= 1  # halves may round either way
    if width is not None and height is not None:
        assert placed.shape[:2] == expected
    assert placed.shape[2:] == ((3,) if rgb else ())
    assert placed.dtype == np.float32
    assert np.abs(placed - np.float32(light)).max() <= 1e-6 * max(1, light)


@given(lengths, lengths, st.integers(1, 90), st.integers(1, 90))
def test_black_and_white_stay_exact(rows: int, columns: int, width: int, height: int) -> None:
    for light in (0.0, 1.0):
        resized = resize(_constant(rows, columns, light, False), width, height)
        assert np.abs(resized - light).max() < 1e-6


@given(lengths, lengths, st.integers(1, 90), st.integers(1, 90), aspects, st.booleans())
def test_contain_shows_all_and_only_the_background_around(
    rows: int, columns: int, width: int, height: int, aspect: float, rgb: bool
) -> None:
    """White over black: one box in the middle, which touches two sides and has the shape."""
    placed = place(_constant(rows, columns, 1.0, rgb), width, height, "contain", 0.0, aspect)
    white = (placed.reshape(height, width, -1) > 0.5).all(axis=2)
    down, across = white.any(axis=1), white.any(axis=0)
    assert np.array_equal(white, np.outer(down, across))
    box = int(down.sum()), int(across.sum())
    assert box[0] == height or box[1] == width
    ratio = min(width / columns, height * aspect / rows)
    assert abs(box[1] - max(1, columns * ratio)) <= 0.5 + 1e-9
    assert abs(box[0] - max(1, rows * ratio / aspect)) <= 0.5 + 1e-9
    assert abs(int(down.argmax()) - int(down[::-1].argmax())) <= 1
    assert abs(int(across.argmax()) - int(across[::-1].argmax())) <= 1


@given(lengths, lengths, st.integers(1, 90), st.integers(1, 90), aspects)
def test_cover_fills_the_size(rows: int, columns: int, width: int, height: int, aspect: float) -> None:
    placed = place(_constant(rows, columns, 1.0, False), width, height, "cover", 0.0, aspect)
    assert placed.shape == (height, width)
    assert placed.min() > 1 - 1e-6


def test_cover_cuts_the_middle() -> None:
    ramp = np.tile(np.linspace(0, 1, 300, dtype=np.float32), (100, 1))
    placed = place(ramp, 50, 50, "cover")
    assert placed[:, 0] == pytest.approx(1 / 3, abs=0.01)
    assert placed[:, -1] == pytest.approx(2 / 3, abs=0.01)


@given(st.integers(2, 60), st.integers(2, 60), st.integers(1, 12), st.integers(0, 2**32 - 1))
def test_smaller_pictures_keep_their_mean(rows: int, columns: int, factor: int, seed: int) -> None:
    """Resizing averages light: a whole factor keeps the mean, but for the lobes at the borders."""
    light = np.random.default_rng(seed).random((rows, columns)).astype(np.float32)
    big = light.repeat(factor, axis=0).repeat(factor, axis=1)
    assert abs(resize(big, columns, rows).mean() - light.mean()) < 0.03


def _by_pillow(light: np.ndarray, width: int, height: int) -> np.ndarray:
    """The definition: all rows, then all columns, by the window that the extremes ask for."""
    from PIL import Image

    in_range = light.max() <= 1 and light.min() >= 0
    filter = Image.Resampling.LANCZOS if in_range else Image.Resampling.HAMMING
    across = Image.fromarray(light).resize((width, light.shape[0]), filter)
    down = np.asarray(across.resize((width, height), filter))
    at_once = np.asarray(Image.fromarray(light).resize((width, height), filter))
    assert np.abs(down - at_once).max() <= 1e-5  # Pillow chooses its own order of the two
    return down


@given(
    lengths, lengths, st.integers(1, 90), st.integers(1, 90), st.integers(1, 700),
    st.sampled_from([0.0, 1.5, -0.5]), st.integers(0, 2**32 - 1),
)  # fmt: skip
def test_bands_are_resized_as_the_whole(
    rows: int, columns: int, width: int, height: int, piece: int, odd: float, seed: int
) -> None:
    """To the last bit, whatever the size of a band; one odd light anywhere chooses the window."""
    random = np.random.default_rng(seed)
    light = random.random((rows, columns)).astype(np.float32)
    light[random.integers(rows), random.integers(columns)] = odd
    expected = _by_pillow(light, width, height)
    kept = resize_module.piece_rows
    try:
        resize_module.piece_rows = lambda of, most: max(1, min(most, piece // of))
        assert np.array_equal(resize(light, width, height), expected)
        placed = place(LightRows(Source(light)), width, height, "stretch")
        assert np.array_equal(placed[0:height], expected)
    finally:
        resize_module.piece_rows = kept


def test_large_pictures_are_resized_as_the_whole() -> None:
    light = np.random.default_rng(4).random((900, 1100)).astype(np.float32)
    for size in ((57, 90), (1100, 300), (200, 900), (1300, 1000)):
        assert np.array_equal(resize(light, *size), _by_pillow(light, *size))


@given(lengths, lengths, st.integers(1, 9), st.integers(0, 70), st.integers(1, 70))
def test_cells_are_means_of_blocks(rows: int, columns: int, n: int, start: int, count: int) -> None:
    light = np.random.default_rng(rows * columns).random((rows, columns)).astype(np.float32)
    cells = Cells(light, n)
    assert cells.shape == (-(-rows // n), -(-columns // n))
    got = cells[start : start + count]
    assert len(got) == max(0, min(start + count, cells.shape[0]) - start)
    wide = np.pad(light, ((0, -rows % n), (0, -columns % n)), mode="edge").astype(np.float64)
    for y, row in enumerate(got, start):
        for x, value in enumerate(row):
            assert value == pytest.approx(wide[y * n : y * n + n, x * n : x * n + n].mean(), abs=1e-7)


def test_highlights_do_not_ring() -> None:
    """Light above 1 must not darken what lies beside it below the picture's own darkest."""
    light = np.full((60, 60), 0.2, np.float32)
    light[20:40, 20:40] = 500
    for size in ((17, 23), (60, 31), (130, 100)):
        resized = resize(light, *size)
        assert resized.min() >= 0.2 - 1e-6
        assert resized.max() <= 500 * (1 + 1e-6)


def test_nothing_is_done_for_the_same_size() -> None:
    light = np.random.default_rng(1).random((5, 7)).astype(np.float32)
    assert resize(light, 7, 5) is light
    assert target_size(5, 7, None, None) == (7, 5)
    for fit in FITS:
        assert np.array_equal(place(light, 7, 5, fit), light)


def test_the_input_is_never_changed() -> None:
    light = np.random.default_rng(1).random((5, 7, 3)).astype(np.float32)
    before = light.copy()
    for fit in FITS:
        place(light, 4, 9, fit)
    assert np.array_equal(light, before)


def test_an_unknown_fit_is_refused() -> None:
    with pytest.raises(UsageError, match="contain, cover, stretch"):
        place(np.ones((2, 2), np.float32), 1, 1, "crop")


@given(st.integers(1, 10**6), st.integers(1, 10**6), st.sampled_from("xX×"))
def test_parse_size(width: int, height: int, cross: str) -> None:
    assert parse_size(f"{width}{cross}{height}") == (width, height)
    assert parse_size(f"{width}{cross}") == (width, None)
    assert parse_size(f"{cross}{height}") == (None, height)


@pytest.mark.parametrize(
    "text", ["", "x", "×", "5", "0x5", "5x0", "0x", "x0", "-5x5", "5x-5", "axb", "5xb", "1.5x2",
             "5x5x5", "5;5", "5 5", "1e3x5", "nanx5", "infx", "0x10x2"]
)  # fmt: skip
def test_sizes_that_are_none(text: str) -> None:
    with pytest.raises(UsageError) as caught:
        parse_size(text)
    assert f"'{text}'" in str(caught.value)
    assert "WxH" in str(caught.value)
