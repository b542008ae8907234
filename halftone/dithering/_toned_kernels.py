"""Error diffusion whose weights follow the tone of the sender, and whose thresholds are given.

In gather form, as _diffusion_kernels: the carry of a row is the sum of what the finished rows above
send to it, row after row from the top, tap after tap in table order; a pixel's value is light +
carry, then what the left tap two back sends, then what the left tap one back sends.
"""

import numpy as np

from halftone._jit import kernel


@kernel(
    "f4[:,:]; u1[:,:]; u1[:,:]; f4[:,:]; u1[:,:]; f4[:,:]; f4[:]; u1[:];"
    "i8[:]; i8[:]; f4[:,:]; f4[:,:]; f4[:]; f4[:]; u1[:]; f4; i8; i8; i8"
)
def diffuse_toned(
    light, low, tone, threshold, out, carry, error, sender,
    dy, dx, weight, left, level, middle, index, reach, y0, serpentine, from_right,
):  # fmt: skip
    """Rows of *light* to level indices.

    weight[t, k] and left[t, 0 … 1] are the shares that a pixel of tone t sends to tap k, and one and
    two columns ahead; *sender* holds the tones of the row beside its errors.
    """
    rows, width = light.shape
    ring = carry.shape[0]
    margin = (error.shape[0] - width) // 2
    n = level.shape[0]
    for r in range(rows):
        y = y0 + r
        slot = y % ring
        backward = (from_right ^ (serpentine & y)) & 1
        for x in range(width):
            v = light[r, x]
            v = level[0] if v < level[0] else v
            v = level[n - 1] if v > level[n - 1] else v
            carry[slot, x] += v
            sender[margin + x] = tone[r, x]
        one = np.float32(0.0)  # on its way from the pixel before, one column ahead
        two = np.float32(0.0)  # on its way from the pixel before that, two columns ahead
        next_two = np.float32(0.0)
        for k in range(width):
            x = width - 1 - k if backward else k
            v = (carry[slot, x] + two) + one
            i = np.int64(low[r, x])
            step = level[i + 1] - level[i]
            if level[i] - reach * step <= v <= level[i + 1] + reach * step:
                if v > threshold[r, x]:
                    i += 1
            else:
                # the nearest level, from the one below the light on
                while i < n - 1 and v >= middle[i]:
                    i += 1
                while i > 0 and v < middle[i - 1]:
                    i -= 1
            e = v - level[i]
            out[r, x] = index[i]
            error[margin + x] = e
            t = tone[r, x]
            two = next_two
            next_two = left[t, 1] * e
            one = left[t, 0] * e
        for x in range(width):
            carry[slot, x] = np.float32(0.0)
        for t in range(dy.shape[0]):
            target = (y + dy[t]) % ring
            shift = margin + (dx[t] if backward else -dx[t])
            for x in range(width):
                carry[target, x] += weight[sender[shift + x], t] * error[shift + x]
