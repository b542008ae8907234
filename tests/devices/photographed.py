"""A printed chart, and a photo of it: dots as shapes, blur, tilt, uneven light, noise, gamma, JPEG."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Light = NDArray[np.float32]


def printed(indices: NDArray[np.uint8], dot: tuple[float, float], black: float, fine: int = 12) -> Light:
    """Light of paper with a dot drawn for every 0, in 3 × 3 samples a dot; made of *fine* × *fine*."""
    ink = indices == 0
    rows, columns = ink.shape
    reach = 2 * fine
    covered = np.zeros((rows * fine + 2 * reach, columns * fine + 2 * reach), bool)
    at = np.arange(-reach, reach + fine) + 0.5 - fine / 2
    shape = (at / (dot[0] * fine / 2)) ** 2 + ((at / (dot[1] * fine / 2)) ** 2)[:, None] <= 1
    for y, x in np.argwhere(shape):
        covered[y : y + rows * fine : fine, x : x + columns * fine : fine] |= ink
    inside = covered[reach:-reach, reach:-reach].astype(np.float32)
    parts = inside.reshape(rows * 3, fine // 3, columns * 3, fine // 3)
    return 1 - (1 - np.float32(black)) * parts.mean(axis=(1, 3))


def photo(
    paper: Light,
    turn: float = 3.0,
    tilt: float = 0.08,
    exposure: float = 0.8,
    vignette: float = 0.3,
    noise: float = 0.01,
    size: tuple[int, int] = (1500, 1300),
    blur: float = 1.5,
    table: float = 0.05,
    seed: int = 0,
) -> bytes:
    """A JPEG of *paper* on a dark table. turn : degrees. tilt : how much the far side is smaller.
    exposure : light of the paper in the middle. vignette : light lost in the corners. blur : pixels."""
    wide, high = size
    rows, columns = paper.shape
    margin = 30
    whole = np.ones((rows + 2 * margin, columns + 2 * margin), np.float32)
    whole[margin:-margin, margin:-margin] = paper
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], float)
    angle = np.deg2rad(turn)
    ways = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    share = whole.shape[1] / whole.shape[0]
    half = corners * [share, 1] @ ways
    fit = 0.92 * min(wide / 2 / np.abs(half[:, 0]).max(), high / 2 / np.abs(half[:, 1]).max())
    seen = half * fit * (1 + tilt * corners[:, 1:] * [1, 0.3])  # the lower side is nearer
    seen *= min(1, *(0.97 * np.array([wide, high]) / 2 / np.abs(seen).max(axis=0)))
    seen += [wide / 2, high / 2]
    edge = [(0, 0), (whole.shape[1], 0), (whole.shape[1], whole.shape[0]), (0, whole.shape[0])]
    matrix, right = [], []
    for (x, y), (u, v) in zip(seen, edge, strict=True):
        matrix += [[x, y, 1, 0, 0, 0, -u * x, -u * y], [0, 0, 0, x, y, 1, -v * x, -v * y]]
        right += [u, v]
    way = np.linalg.solve(np.array(matrix), np.array(right))
    shrink = max(1, round(whole.shape[1] / np.hypot(*(seen[1] - seen[0]))))
    if shrink > 1:
        small = Image.fromarray(whole).reduce(shrink)
        way[[0, 1, 2, 3, 4, 5]] /= shrink
        whole = np.asarray(small)
    image = Image.fromarray(whole).transform(
        size, Image.Transform.PERSPECTIVE, list(way), Image.Resampling.BILINEAR, fillcolor=table
    )
    light = _blurred(np.asarray(image, np.float32), blur)
    y, x = np.mgrid[-1 : 1 : high * 1j, -1 : 1 : wide * 1j]
    light = light * exposure * (1 - vignette * (x * x + y * y) / 2 + 0.1 * x)
    rng = np.random.default_rng(seed)
    light = light + noise * np.sqrt(np.maximum(light, 0.01)) * rng.normal(size=light.shape)
    light = np.clip(light, 0, 1)
    code = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    file = io.BytesIO()
    Image.fromarray(np.rint(code * 255).astype(np.uint8)).save(file, "JPEG", quality=90)
    return file.getvalue()


def pattern(indices: NDArray[np.uint8]) -> NDArray[np.float64]:
    """How often each 3 × 3 neighbourhood of ink occurs, float64 (512,), pixel by pixel."""
    found = np.zeros(512)
    windows = np.lib.stride_tricks.sliding_window_view(indices == 0, (3, 3)).reshape(-1, 9)
    np.add.at(found, windows @ (1 << np.arange(9)), 1)
    return found / found.sum()


def _blurred(light: Light, sigma: float) -> Light:
    """A Gaussian along both axes."""
    reach = int(4 * sigma) + 1
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / max(sigma, 1e-3)) ** 2)
    kernel /= kernel.sum()
    for axis in (0, 1):
        padded = np.pad(light, [(reach, reach) if a == axis else (0, 0) for a in (0, 1)], "edge")
        count = light.shape[axis]
        parts = (k * padded.take(range(i, i + count), axis) for i, k in enumerate(kernel))
        light = np.asarray(sum(parts), np.float32)
    return light
