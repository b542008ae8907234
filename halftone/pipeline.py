"""What users call: a picture file, an array or linear light to a frame."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halftone._arrays import BAND_ROWS, Light, as_pixels, check_finite
from halftone._parallel import bands
from halftone.dithering.base import Method
from halftone.dithering.registry import method as find_method
from halftone.errors import UsageError
from halftone.frame import Bands, Frame
from halftone.images.read import DEFAULT_LIMIT, read_picture
from halftone.recipe import DEFAULT_METHOD, Profile, Recipe, configured, response
from halftone.stages import Halftoning, Report, background_light, check_memory, decoded, light_of
from halftone.tone.levels import Levels

__all__ = ["check_method", "convert", "convert_bands", "dither", "read"]

Progress = Callable[[float], None]


def read(
    path: str | Path,
    *,
    encoding: str | None = None,
    background: str | float = "white",
    max_memory: int = DEFAULT_LIMIT,
) -> Light:
    """Read a picture file as linear light: float32, (M, N) or (M, N, 3), 1 = white.

    path : a file that OpenImageIO reads, or ``-`` for stdin. EXIF orientation is applied.
    encoding : what the file's codes mean (:data:`halftone.tone.transfer.ENCODINGS`); None takes
    what the file says: sRGB for integers, light for floats.
    background : the light under transparent pixels, ``white``, ``black`` or 0 … 1.
    max_memory : bytes; a larger picture is refused before it is read.

    Raises :class:`halftone.errors.InputFileError`.
    """
    paper = background_light(background)
    with closing(read_picture(path, max_memory)) as picture:
        source = light_of(picture, encoding, paper, Report())
        shape = source.pixels.shape
        need = source.pixels.nbytes + 4 * math.prod(shape)
        check_memory(need, max_memory, f"the light of {picture.name}, {shape[1]} × {shape[0]},")
        light = np.empty(shape, np.float32)
        for start, stop in bands(shape[0], BAND_ROWS):
            light[start:stop] = source.colours(start, stop)
    return light


def dither(
    image: Any,
    method: str | Method = DEFAULT_METHOD,
    *,
    levels: Any = 2,
    encoding: str | None = None,
    gamma: str | float | None = None,
    range: str = "clip",
    nonfinite: str = "error",
    serpentine: bool | None = None,
    strength: float | None = None,
    seed: int | None = None,
    regions: Sequence[tuple[ArrayLike, str | Method]] = (),
    workers: int = 1,
    progress: Progress | None = None,
) -> Frame:
    """Halftone an array: the level index of every pixel, for any levels.

    image : (M, N) gray or (M, N, 3) RGB, of which the luminance is taken; an array, nested lists of
    floats, or a PIL image. Integers are sRGB codes over the full range of their type, floats are
    linear light with 1 = white. The input is never changed.
    method : a name or a method (``halftone list methods``, :mod:`halftone.dithering`).
    levels : a count n, for the luminances of the n codes k/(n−1); a named ladder
    (``uniform-linear:N``, ``lstar:N``, ``log:I0:N``); or measured luminances, darkest first.
    encoding : what the image's codes mean, ``srgb``, ``bt709``, ``gamma:G`` or ``linear``.
    gamma : the response of the device under which a count of levels is meant; None is sRGB.
    range : how light beyond the levels is brought in: ``clip``, ``scale`` or ``compress``.
    nonfinite : ``error``, or ``clip`` to show NaN as black and ±inf as white and black.
    serpentine, strength, seed : set the method's option of that name; an error where it has none.
    None leaves it as the method has it: serpentine, strength 1, seed 0.
    regions : (mask, method) pairs; where a boolean mask (M, N) is true, the picture is halftoned by
    that method instead, a later pair over an earlier one. ``[(text, "threshold")]`` keeps text and
    barcodes free of dots.
    workers : threads; 0 is one per processor. The result does not depend on it.
    progress : called with the share done, 0 … 1.

    Raises :class:`halftone.errors.UsageError` and :class:`halftone.errors.InputError`.
    """
    chosen = configured(method, serpentine, strength, seed)
    ladder = Levels.of(levels, response(gamma))
    chosen.check(ladder)
    source = check_finite(decoded(as_pixels(image), encoding), nonfinite)
    others = [(_mask(mask, source.shape), find_method(spec)) for mask, spec in regions]
    for _, other in others:
        other.check(ladder)
        if other.scale != chosen.scale:
            raise UsageError(f"'{other.text()}' and '{chosen.text()}' give pictures of other sizes")
    frame = Halftoning(source, chosen, ladder, range, workers, Report()).frame(progress)
    for mask, other in others:
        part = Halftoning(source, other, ladder, range, workers, Report()).frame()
        where = mask.repeat(chosen.scale, axis=0).repeat(chosen.scale, axis=1)
        np.copyto(frame.indices, part.indices, where=where)
        frame.report["notes"].append(f"{int(mask.sum())} pixels in a region by '{other.text()}'")
    return frame


def _mask(mask: ArrayLike, shape: tuple[int, int]) -> NDArray[np.bool_]:
    array = np.asarray(mask)
    if array.dtype != np.bool_ or array.shape != shape:
        raise UsageError(
            f"a region's mask is {array.dtype} of shape {array.shape}; allowed: bool of shape {shape}"
        )
    return array


def convert(
    picture: str | Path | Any,
    *,
    profile: Profile | None = None,
    method: str | Method | None = None,
    content: str | None = None,
    levels: Any = None,
    width: int | None = None,
    height: int | None = None,
    fit: str | None = None,
    encoding: str | None = None,
    gamma: str | float | None = None,
    brightness: float = 0.0,
    contrast: float = 0.0,
    auto_levels: bool = False,
    invert: bool = False,
    background: str | float = "white",
    range: str = "clip",
    dot_gain: str = "correct",
    nonfinite: str = "error",
    serpentine: bool | None = None,
    strength: float | None = None,
    seed: int | None = None,
    workers: int = 1,
    max_memory: int = DEFAULT_LIMIT,
    progress: Progress | None = None,
) -> Frame:
    """A picture file or array to the frame that a device shows.

    picture : a path, ``-`` for stdin, or an image as :func:`dither` takes it.
    profile : a device (:func:`devices.profile.load`); gives levels, size, dpi, packing and method
    where they are not given here.
    content : ``text``, ``graphic`` or ``photo`` instead of a method: what suits it.
    width, height, fit : the size in dots. With both, ``contain`` (over the background), ``cover``
    or ``stretch``; with one, the other follows; with neither, the device's, or the picture's own.
    brightness, contrast : −1 … 1. auto_levels : darkest and lightest 0.5 % to black and white.
    invert : white less the light.
    dot_gain : ``correct`` asks the method for the light whose print has the luminance meant, by the
    profile's dot model (:mod:`halftone.flatfield`); ``keep`` prints darker, as dots are larger than
    their cells. All other parameters are those of :func:`dither`.

    Everything is done in linear light: decode, alpha over the background, luminance, resize,
    auto-levels, brightness, contrast, invert, range, dot gain, dither. To convert many pictures
    alike, make a :class:`Recipe` once.
    """
    recipe = Recipe(
        profile=profile,
        method=method,
        content=content,
        levels=levels,
        width=width,
        height=height,
        fit=fit,
        encoding=encoding,
        gamma=gamma,
        brightness=brightness,
        contrast=contrast,
        auto_levels=auto_levels,
        invert=invert,
        background=background,
        range=range,
        dot_gain=dot_gain,
        nonfinite=nonfinite,
        serpentine=serpentine,
        strength=strength,
        seed=seed,
        workers=workers,
        max_memory=max_memory,
    )
    return recipe.convert(picture, progress)


def convert_bands(
    picture: str | Path | Any, *, progress: Progress | None = None, **options: Any
) -> Bands:
    """What :func:`convert` gives, by bands of rows from the top, for pictures larger than memory.

    options : those of :func:`convert`. A driver sends each band as it comes::

        for part in halftone.convert_bands("poster.tif", profile=device):
            port.write(part.packed())

    Each part is a :class:`halftone.Frame` of some consecutive rows; their bytes are
    those of the whole frame. ``.shape`` is known at once, and ``.save()`` writes a file.
    """
    return Recipe(**options).bands(picture, progress)


def check_method(text: str) -> None:
    """UsageError if *text* names no method."""
    configured(text, None, None, None)
