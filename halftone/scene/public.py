"""``halftone.render``: a scene, or the file of one, to linear radiance."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from halftone._arrays import whole
from halftone.scene.framing import camera_for
from halftone.scene.load import named, read_scene
from halftone.scene.model import Scene
from halftone.scene.render import Picture
from halftone.scene.render import render as render_scene
from halftone.scene.sanitise import Counts

__all__ = ["render"]

MOST = 1 << 17  # pixels along a side


def render(scene: Scene | str | Path, width: int, height: int, **options: Any) -> Picture:
    """*scene* as its camera sees it: float32 linear radiance, with a report.

    The report has ``seconds`` of each stage, ``counts`` of what was mended and dropped, ``notes`` on it
    in words, what was ``left_out`` and why, and the ``plan``.

    scene : a :class:`halftone.scene.model.Scene`, or the path of a ``.toml``, ``.obj`` or ``.ply``
    file. A bare mesh gets a camera and lights, a Scene without a camera gets one.
    width, height : of the picture, in pixels.
    options : those of :meth:`halftone.scene.render.Renderer.render`, such as ``shading="gouraud"``.

    The result goes straight into :func:`halftone.dither` or :func:`halftone.convert`::

        picture = halftone.render("scene.toml", 576, 432)
        frame = halftone.convert(picture.radiance, profile=device)

    Raises :class:`halftone.errors.InputError` and :class:`halftone.errors.UsageError`.
    """
    width, height = whole("width", width, 1, MOST), whole("height", height, 1, MOST)
    if not isinstance(scene, Scene):
        made, notes = read_scene(scene, width / height)
        with named(scene):
            picture = render(made, width, height, **options)
        picture.report["notes"] = [*notes, *picture.report["notes"]]
        return picture
    if scene.camera is None:
        scene = replace(scene, camera=camera_for(scene.meshes, width / height))
    picture = render_scene(scene, width, height, **options)
    counts = picture.report["counts"]
    mended = Counts(**{field.name: counts[field.name] for field in fields(Counts)})
    picture.report["notes"] = mended.notes()
    return picture
