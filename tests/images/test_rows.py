"""Files read forward: any rows, in any order, of any number of threads, are those of the whole."""

from __future__ import annotations

import threading
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from halftone.errors import InputFileError
from halftone.images import rows as rows_module
from halftone.images.read import read_picture
from halftone.images.rows import Rows, Window, piece_rows
from tests.cli.files import png_of, write_oiio

HEIGHT, WIDTH = 700, 40
CODES = np.random.default_rng(8).integers(0, 256, (HEIGHT, WIDTH), np.uint8)
RGB = np.random.default_rng(9).integers(0, 256, (HEIGHT, WIDTH, 3), np.uint8)


class _File:
    """Rows in pieces of a given height; counts how often it is read from the top."""

    def __init__(self, piece: int) -> None:
        self.piece, self.opened = piece, 0

    def open(self) -> Iterator[np.ndarray]:
        self.opened += 1
        for top in range(0, HEIGHT, self.piece):
            yield CODES[top : top + self.piece, :, None]


def _rows(file: _File, keep: int) -> Rows:
    return Rows(Window(file.open, HEIGHT, keep), lambda r: r[:, :, 0], CODES.shape, np.uint8)


@given(
    st.integers(1, 200),
    st.integers(0, 800),
    st.lists(st.tuples(st.integers(-5, HEIGHT + 5), st.integers(0, 300)), max_size=12),
)
def test_any_rows_in_any_order(piece: int, keep: int, asked: list[tuple[int, int]]) -> None:
    rows = _rows(_File(piece), keep)
    for start, count in asked:
        top = max(0, start)
        assert np.array_equal(rows[top : top + count], CODES[top : top + count])


@given(st.integers(1, 100), st.integers(1, 90), st.integers(0, 120), st.integers(0, 64))
def test_one_pass_is_enough_within_the_window(piece: int, rows: int, above: int, below: int) -> None:
    """Bands from the top with rows above and below them read the file once."""
    file = _File(piece)
    window = _rows(file, above + rows + below)
    for start in range(0, HEIGHT, rows):
        first, last = max(0, start - above), min(HEIGHT, start + rows + below)
        assert np.array_equal(window[first:last], CODES[first:last])
    assert file.opened == 1


def test_mirrored_rows_before_the_picture_cost_no_second_pass() -> None:
    """As a warm start asks for them: row 175 first, backwards, then the picture."""
    file = _File(64)
    rows = _rows(file, rows_module.LOOK_BACK)
    for y in [*range(175, -1, -1), *range(0, 300)]:
        assert np.array_equal(rows[y : y + 1], CODES[y : y + 1])
    assert file.opened == 1


def test_no_more_is_held_than_the_window() -> None:
    file = _File(16)
    window = Window(file.open, HEIGHT, 50)
    for start in range(0, HEIGHT, 10):
        window.rows(start, start + 10)
        assert sum(len(piece) for _, piece in window._pieces) <= 50 + 2 * 16


def test_several_threads_at_once() -> None:
    rows, wrong = _rows(_File(30), 100), []

    def work(number: int) -> None:
        for start in np.random.default_rng(number).integers(0, HEIGHT - 70, 60).tolist():
            if not np.array_equal(rows[start : start + 70], CODES[start : start + 70]):
                wrong.append(start)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []


def test_a_file_that_ends_too_soon_says_where() -> None:
    window = Window(lambda: iter([CODES[:30, :, None]]), HEIGHT, 10)
    with pytest.raises(InputFileError, match="row 30 of 700"):
        window.rows(20, 40)


def test_damage_is_named_alike_to_every_thread_that_comes_to_it() -> None:
    """The first to reach it is not always the one whose rows are wanted first."""

    def damaged() -> Iterator[np.ndarray]:
        yield CODES[:30, :, None]
        raise InputFileError("'in.png' is damaged or cut off: bad data")

    window = Window(damaged, HEIGHT, 10)
    assert np.array_equal(window.rows(0, 30)[:, :, 0], CODES[:30])
    for start in (30, 20, 100):
        with pytest.raises(InputFileError, match="bad data"):
            window.rows(start, start + 40)


def test_a_file_that_cannot_be_opened_again() -> None:
    """It fails for whoever asks, with the reason."""
    opened = []

    def once() -> Iterator[np.ndarray]:
        if opened:
            raise InputFileError("it is gone")
        opened.append(True)
        return iter([CODES[y : y + 30, :, None] for y in range(0, HEIGHT, 30)])

    window = Window(once, HEIGHT, 10)
    window.rows(600, 640)
    for start in (0, 600):
        with pytest.raises(InputFileError, match="gone"):
            window.rows(start, start + 10)


def test_rows_go_forwards_one_by_one() -> None:
    with pytest.raises(IndexError, match="2"):
        _rows(_File(30), 10)[0:10:2]


def test_pieces_are_small_but_a_row_at_least() -> None:
    assert piece_rows(100, 64) == 64
    assert piece_rows(32_768, 64) == 64
    assert piece_rows(100_000, 64) == 20
    assert piece_rows(10**9, 64) == 1


FILES = {
    "strips.tif": {"tiff__RowsPerStrip": 7, "compression": "zip"},
    "one-strip.tif": {"tiff__RowsPerStrip": HEIGHT, "compression": "lzw"},
    "apart.tif": {"planarconfig": "separate", "compression": "zip"},
    "tiles.tif": {"tile": 16, "compression": "zip"},
    "a.png": {},
    "a.bmp": {},
    "a.exr": {},
    "tiles.exr": {"tile": 32},
    "a.hdr": {},
    "a.tga": {},
}


def _written(path: Path, gray: bool) -> None:
    """By OpenImageIO, floats where the format wants them."""
    options = dict(FILES[path.name])
    pixels = CODES if gray else RGB
    kind = "uint8"
    if path.suffix in (".exr", ".hdr"):
        pixels, kind = (pixels / 255).astype(np.float32), "float"
    tile = options.pop("tile", 0)
    if not tile:
        write_oiio(path, pixels, kind, **options)
        return
    cube = np.ascontiguousarray(pixels.reshape(HEIGHT, WIDTH, -1))
    spec = oiio.ImageSpec(WIDTH, HEIGHT, cube.shape[2], kind)
    spec.tile_width = spec.tile_height = tile
    for name, value in options.items():
        spec.attribute(name, value)
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), spec), file.geterror()
    assert file.write_image(cube), file.geterror()
    file.close()


@pytest.mark.parametrize("gray", [True, False])
@pytest.mark.parametrize("name", FILES)
def test_every_format_row_by_row(name: str, gray: bool, tmp_path: Path) -> None:
    """What OpenImageIO reads of the whole at once, in bands, twice."""
    if name == "a.hdr" and gray:
        pytest.skip("Radiance HDR holds colours only")
    path = tmp_path / name
    _written(path, gray)
    file = oiio.ImageInput.open(str(path))
    whole = np.asarray(file.read_image(0, 0, 0, file.spec().nchannels, "unknown"))
    whole = whole.reshape(HEIGHT, WIDTH, -1)[:, :, : 1 if gray else 3]
    file.close()
    read = read_picture(path, keep=5)
    for _ in range(2):
        for start in range(0, HEIGHT, 33):
            part = read.pixels[start : start + 33]
            assert np.array_equal(part.reshape(len(part), WIDTH, -1), whole[start : start + 33])
    read.close()


@pytest.mark.parametrize("options", [{}, {"progressive": True}])
def test_jpeg_row_by_row(options: dict[str, bool], tmp_path: Path) -> None:
    Image.fromarray(RGB).save(tmp_path / "a.jpg", **options)
    file = oiio.ImageInput.open(str(tmp_path / "a.jpg"))
    whole = np.asarray(file.read_image(0, 0, 0, 3, "uint8"))
    file.close()
    read = read_picture(tmp_path / "a.jpg", keep=5)
    for start in range(0, HEIGHT, 50):
        assert np.array_equal(read.pixels[start : start + 50], whole[start : start + 50])
    read.close()


def test_what_is_held_whole(tmp_path: Path) -> None:
    """Interlaced, progressive, to be turned: an array; anything else in this list: rows."""
    Image.fromarray(CODES).save(tmp_path / "plain.png")
    Image.fromarray(CODES).save(tmp_path / "plain.jpg")
    Image.fromarray(CODES).save(tmp_path / "progressive.jpg", progressive=True)
    exif = Image.Exif()
    for number in range(1, 9):
        exif[274] = number
        Image.fromarray(CODES).save(tmp_path / f"turned{number}.png", exif=exif)
    data = bytearray(png_of(1, 1, 8, 0, b"\0\7"))  # one pixel is interlaced as it is not
    data[28] = 1
    data[29:33] = zlib.crc32(data[12:29]).to_bytes(4, "big")
    (tmp_path / "interlaced.png").write_bytes(data)
    held = set()
    for path in tmp_path.iterdir():
        read = read_picture(path)
        if isinstance(read.pixels, np.ndarray):
            held.add(path.stem)
        read.close()
    assert held == {"interlaced", "progressive"} | {f"turned{k}" for k in range(3, 9)}


def test_a_file_that_is_let_go(tmp_path: Path) -> None:
    Image.fromarray(CODES).save(tmp_path / "a.png")
    read = read_picture(tmp_path / "a.png")
    read.pixels[0:10]
    read.close()
    with pytest.raises(InputFileError):
        read.pixels[0:10]
