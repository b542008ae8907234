"""Views: from the scene's space to the picture, perspective or parallel, set up in float64.

A point becomes three homogeneous picture coordinates h = (X·w, Y·w, w), where X and Y are pixels
counted from the middle of the picture, X to the right and Y down. In a perspective view w is the
distance along the axis of view; in a parallel view it is 1. Interpolating by the determinants of h
is therefore perspective-correct in both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halftone.errors import InputError, UsageError, near
from halftone.scene.model import Camera

__all__ = ["NEAR_SHARE", "View", "view_of"]

NEAR_SHARE = 1e-4
"""The near plane's default distance, as a share of the distance from the eye to the target."""


@dataclass(frozen=True, eq=False)
class View:
    """What the camera does to a point.

    eye : float64 (3,). axes : float64 (3, 3), the rows point right, down and forwards. scale : pixels
    per unit at the distance 1 (perspective) or anywhere (parallel). near : distance below which
    nothing is seen, −inf for a parallel view without a near plane. width, height : pixels.
    """

    eye: NDArray[np.float64]
    axes: NDArray[np.float64]
    scale: float
    perspective: bool
    near: float
    width: int
    height: int

    @property
    def rows(self) -> NDArray[np.float64]:
        """(3, 4) float64: rows to h0, h1 and the distance from a point relative to the eye, and near."""
        made = np.zeros((3, 4))
        made[:, :3] = self.axes
        made[:2, :3] *= self.scale
        made[2, 3] = self.near
        return made

    @property
    def forwards(self) -> NDArray[np.float64]:
        """The direction of view, float64 (3,), of length 1."""
        return np.asarray(self.axes[2])

    def homogeneous(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """h of (K, 3) points, with their distances as a fourth column: float64 (K, 4)."""
        moved = (points - self.eye) @ self.axes.T
        out = np.empty((len(points), 4))
        out[:, :2] = moved[:, :2] * self.scale
        out[:, 3] = moved[:, 2]
        out[:, 2] = moved[:, 2] if self.perspective else 1.0
        return out


def view_of(camera: Camera, width: int, height: int) -> View:
    """The view of *camera* in a picture of *width* × *height* square pixels.

    An *up* along the line of sight is replaced by the axis that is farthest from it.
    """
    if camera.projection not in ("perspective", "parallel"):
        raise UsageError(near(camera.projection, ("perspective", "parallel"), "projection"))
    eye = np.array(camera.eye, np.float64)
    forwards = np.array(camera.target, np.float64) - eye
    largest = np.abs(forwards).max()
    if not (np.isfinite(eye).all() and np.isfinite(largest)) or largest == 0:
        raise InputError(
            f"camera: eye {camera.eye} and target {camera.target} give no direction of view; "
            "two finite points that differ are needed"
        )
    distance = float(largest * np.linalg.norm(forwards / largest))
    forwards /= distance
    up = np.array(camera.up, np.float64)
    size = np.abs(up).max()
    up = up / size if np.isfinite(size) and size > 0 else np.zeros(3)
    right = np.cross(forwards, up)
    if np.linalg.norm(right) < 1e-9:
        right = np.cross(forwards, np.eye(3)[np.argmin(np.abs(forwards))])
    right /= np.linalg.norm(right)
    down = np.cross(forwards, right)
    perspective = camera.projection == "perspective"
    if perspective and not 0 < camera.fov < 180:
        raise UsageError(f"camera: fov is {camera.fov}; an angle between 0 and 180 degrees is needed")
    if not perspective and not 0 < camera.height < np.inf:
        raise UsageError(f"camera: height is {camera.height}; a length above 0 is needed")
    if camera.near is not None and not (np.isfinite(camera.near) and camera.near > 0):
        raise UsageError(f"camera: near is {camera.near}; a distance above 0 is needed")
    scale = height / (2 * np.tan(np.radians(camera.fov) / 2)) if perspective else height / camera.height
    plane = camera.near
    if plane is None:
        plane = distance * NEAR_SHARE if perspective else -np.inf
    axes = np.stack([right, down, forwards])
    return View(eye, axes, float(scale), perspective, float(plane), width, height)
