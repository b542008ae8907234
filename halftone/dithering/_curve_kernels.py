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
    n = level.shape[0]
    newest = 0
    for block in range((width + side - 1) // side):
        for k in range(side * side):
            y = np.int64(curve_y[k])
            x = np.int64(curve_x[k]) + block * side
            if y >= rows or x >= width:
                continue
            v = light[y, x]
            v = level[0] if v < level[0] else v
            v = level[n - 1] if v > level[n - 1] else v
            for j in range(length):
                place = newest + 1 + j
                place = place - length if place >= length else place
                v += weight[j] * recent[place]
            first = 0
            last = n - 1
            while first < last:  # the nearest level: the number of middles at or below v
                half = (first + last) // 2
                if v >= middle[half]:
                    first = half + 1
                else:
                    last = half
            newest = newest + 1 if newest + 1 < length else 0
            recent[newest] = v - level[first]
            out[y, x] = index[first]
