"""Error diffusion along a curve."""

import numpy as np

from halftone._jit import kernel


@kernel("f4[:,:]; u1[:,:]; u1[:]; u1[:]; f4[:]; f4[:]; f4[:]; f4[:]; u1[:]")
def diffuse_along(light, out, curve_y, curve_x, recent, weight, level, middle, index):
    """A strip, block by block from the left, each along the curve; *recent* are the last errors.

    A pixel's value is its light, then the errors on the way from the oldest to the newest.
    """
    rows, width = light.shape
    side = 256
    length = weight.shape[0]
    last_weight = weight[length - 1]
    n = level.shape[0]
    newest = 0
    e = np.float32(0.0)  # the newest error: the next pixel waits for it, and not for memory
    for block in range((width + side - 1) // side):
        for k in range(side * side):
            y = np.int64(curve_y[k])
            x = np.int64(curve_x[k]) + block * side
            if y >= rows or x >= width:
                continue
            v = light[y, x]
            v = level[0] if v < level[0] else v
            v = level[n - 1] if v > level[n - 1] else v
            place = newest
            for j in range(length - 1):
                place = place + 1 if place + 1 < length else 0
                v += weight[j] * recent[np.uint64(place)]
            v += last_weight * e
            if n == 2:
                i = 1 if v >= middle[0] else 0
                below = v - level[0]
                above = v - level[1]
                e = above if i else below
            else:
                i = 0  # the nearest level: the number of middles at or below v, by bisection
                last = n - 1
                while i < last:
                    half = (i + last) // 2
                    if v >= middle[half]:
                        i = half + 1
                    else:
                        last = half
                e = v - level[i]
            newest = newest + 1 if newest + 1 < length else 0
            recent[np.uint64(newest)] = e
            out[y, x] = index[i]
