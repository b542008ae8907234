"""Kernel of shadows: what a light's map says of samples."""

import math

import numpy as np

from halftone._jit import kernel

__all__ = ["ask_map"]


@kernel("f4[:,:]; f4[:,:]; f8[:]; f8[:,:]; u1; f8; f8; f8; f8; f8[:,:]; u1[:]")
def ask_map(position, normal, eye, rows, perspective, half, pixel, offset, bias, depth, lit):
    """lit[k] = 0 where the map shows something nearer to the light than sample k.

    eye, rows, perspective : of the map's view. half : half its width, in pixels. pixel : the size of
    one, at distance 1 in perspective. offset, bias : in pixels. depth : keys of depth, larger is nearer.
    """
    size = depth.shape[0]
    for k in range(lit.shape[0]):
        a = np.float64(position[0, k]) - eye[0]
        b = np.float64(position[1, k]) - eye[1]
        c = np.float64(position[2, k]) - eye[2]
        u, v, w = np.float64(normal[0, k]), np.float64(normal[1, k]), np.float64(normal[2, k])
        far = rows[2, 0] * a + rows[2, 1] * b + rows[2, 2] * c
        unit = pixel * far if perspective else pixel
        a += u * (offset * unit)
        b += v * (offset * unit)
        c += w * (offset * unit)
        far = rows[2, 0] * a + rows[2, 1] * b + rows[2, 2] * c
        over = 1.0 / far if perspective else 1.0
        x = (rows[0, 0] * a + rows[0, 1] * b + rows[0, 2] * c) * over + half
        y = (rows[1, 0] * a + rows[1, 1] * b + rows[1, 2] * c) * over + half
        limit = far - bias * unit
        inside = x >= 0.0 and y >= 0.0 and x < np.float64(size) and y < np.float64(size)
        if inside and far > 0.0 and limit > 0.0:
            key = depth[np.uint64(math.floor(y)), np.uint64(math.floor(x))]
            if key > (1.0 / limit if perspective else -limit):
                lit[k] = 0
