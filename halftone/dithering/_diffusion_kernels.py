"""Error diffusion: float32 light for any levels, and integer codes for two.

All work in gather form, so that the order of the sums is fixed: the carry of a row is the sum of
what the finished rows above send to it (row after row from the top, tap after tap in table order);
a pixel's value is light + carry, then the left tap two back, then the left tap one back. The slow
twins in tests/oracle say the same in plain Python.
"""

import numpy as np

from halftone._jit import kernel


@kernel(
    "f4[:,:]; u1[:,:]; f4[:,:]; f4[:]; i8[:]; i8[:]; f4[:]; f4; f4;"
    "f4[:]; f4[:]; u1[:]; u1[:]; f4; i8; i8; i8"
)
def diffuse_light(
    light, out, carry, error, dy, dx, weight, left1, left2,
    level, middle, index, bucket, scale, y0, serpentine, from_right,
):  # fmt: skip
    """Rows of *light* to level indices; *carry* (ring of rows) goes on into the next band."""
    rows, width = light.shape
    ring = carry.shape[0]
    margin = (error.shape[0] - width) // 2
    n = level.shape[0]
    darkest = level[0]
    lightest = level[n - 1]
    last = bucket.shape[0] - 1
    for r in range(rows):
        y = y0 + r
        slot = y % ring
        backward = (from_right ^ (serpentine & y)) & 1
        for x in range(width):
            v = light[r, x]
            v = darkest if v < darkest else v
            v = lightest if v > lightest else v
            carry[slot, x] += v
        e1 = np.float32(0.0)
        e2 = np.float32(0.0)
        if n == 2:
            half = middle[0]
            ahead = np.float32(0.0)  # left1 * e1: of both errors there may be, then the one there is
            for k in range(width):
                x = width - 1 - k if backward else k
                v = (carry[slot, x] + left2 * e2) + ahead
                e2 = e1
                below = v - darkest
                above = v - lightest
                up = v >= half
                ahead = left1 * above if up else left1 * below
                e1 = above if up else below
                out[r, x] = index[1] if up else index[0]
                error[margin + x] = e1
        else:
            for k in range(width):
                x = width - 1 - k if backward else k
                v = (carry[slot, x] + left2 * e2) + left1 * e1
                e2 = e1
                b = np.int64((v - darkest) * scale)
                b = 0 if b < 0 else b
                b = last if b > last else b
                i = np.int64(bucket[b])
                while i < n - 1 and v >= middle[i]:
                    i += 1
                e1 = v - level[i]
                out[r, x] = index[i]
                error[margin + x] = e1
        for x in range(width):
            carry[slot, x] = np.float32(0.0)
        for t in range(dy.shape[0]):
            target = (y + dy[t]) % ring
            shift = margin + (dx[t] if backward else -dx[t])
            w = weight[t]
            for x in range(width):
                carry[target, x] += w * error[shift + x]


@kernel("u1[:,:]; f4[:]; u1[:,:]; f4[:]; f4[:]; f4[:]; f4; u1[:]; i8; i8; i8")
def diffuse_four(codes, table, out, carry, weight, level, half, index, y0, serpentine, from_right):
    """Two levels and Floyd and Steinberg's four places, from 8-bit codes with the light of each.

    The sums are those of diffuse_light. weight : ahead, down-back, down, down-ahead. carry : width + 2.
    All that a pixel needs fits beside the wait for the one before it, so one pass does it.
    """
    rows, width = codes.shape
    dark = index[0]
    bright = index[1]
    darkest = level[0]
    lightest = level[1]
    forth = weight[0]
    back = weight[1]
    down = weight[2]
    last = weight[3]
    for r in range(rows):
        ahead = np.float32(0.0)
        e1 = np.float32(0.0)
        e2 = np.float32(0.0)
        if (from_right ^ (serpentine & (y0 + r))) & 1:
            for k in range(width):
                x = width - k
                v = (carry[x] + table[codes[r, x - 1]]) + ahead
                below = v - darkest
                above = v - lightest
                up = v >= half
                ahead = forth * above if up else forth * below
                e = above if up else below
                out[r, x - 1] = bright if up else dark
                carry[x + 1] = (back * e + down * e1) + last * e2
                e2 = e1
                e1 = e
            carry[1] = down * e1 + last * e2
        else:
            for x in range(width):
                v = (carry[x + 1] + table[codes[r, x]]) + ahead
                below = v - darkest
                above = v - lightest
                up = v >= half
                ahead = forth * above if up else forth * below
                e = above if up else below
                out[r, x] = bright if up else dark
                carry[x] = (back * e + down * e1) + last * e2
                e2 = e1
                e1 = e
            carry[width] = down * e1 + last * e2


@kernel("u1[:,:]; u1[:,:]; i4[:]; i4[:]; u1[:]; i8; i8; i8")
def diffuse_codes(codes, out, carry, error, index, y0, serpentine, from_right):
    """Floyd–Steinberg on 8-bit codes, two levels 0 and 255, in units of 1/16 code.

    An error e is sent on in whole units: ⌊e/2⌋ − ⌊e/16⌋ ahead (7/16), ⌊3e/16⌋ and ⌊5e/16⌋ to the
    row below, and all that remains (1/16) to the pixel below and ahead: nothing is lost.
    """
    rows, width = codes.shape
    dark = index[0]
    bright = index[1]
    white = np.int32(16 * 255)
    half = np.int32(8 * 255)
    share = (white >> 1) - (white >> 4)
    for r in range(rows):
        backward = (from_right ^ (serpentine & (y0 + r))) & 1
        for x in range(width):
            carry[x] += np.int32(codes[r, x]) << 4
        # Only what the next pixel waits for: white is a multiple of 16, so its share comes off
        # after the shifts, and the comparison runs beside them.
        ahead = np.int32(0)
        if backward:
            for k in range(width):
                v = carry[width - 1 - k] + ahead
                error[width - k] = v
                ahead = (v >> 1) - (v >> 4)
                ahead = ahead - share if v >= half else ahead
        else:
            for x in range(width):
                v = carry[x] + ahead
                error[1 + x] = v
                ahead = (v >> 1) - (v >> 4)
                ahead = ahead - share if v >= half else ahead
        for x in range(width):
            v = error[1 + x]
            up = v >= half
            out[r, x] = bright if up else dark
            error[1 + x] = v - white if up else v
        step = -1 if backward else 1
        for x in range(width):
            e = error[1 + x]
            behind = error[1 + x + step]
            before = error[1 + x - step]
            rest = before - ((before >> 1) - (before >> 4))
            rest = rest - ((3 * before) >> 4) - ((5 * before) >> 4)
            carry[x] = ((3 * behind) >> 4) + ((5 * e) >> 4) + rest
