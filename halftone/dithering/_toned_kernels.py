"""Error diffusion whose weights follow the tone of the sender, and whose thresholds may vary.

In gather form, as _diffusion_kernels: the carry of a row is the sum of what the finished rows above
send to it, row after row from the top, tap after tap in table order; a pixel's value is light +
carry, then what the left tap two back sends, then what the left tap one back sends.

A pixel whose light lies on step i, between the levels i and i + 1, shows level i + 1 where its value
is above its threshold, if the value is within least … most of its step; else the nearest level.

The next pixel waits for value, comparison, choice of the error, and product, and for nothing else.
Both errors are ready before the choice. ``-(high - v)`` is v − high, written so that the compiler
does not choose the level first and subtract afterwards, which takes longer, as does a comparison that
anything else waits for: levels are found in a second pass. ``np.uint64`` spares the test for negative
indices.
"""

import numpy as np

from halftone._jit import kernel


@kernel("i8[:]; f4[:,:]")
def draw_noise(key, noise):
    """The numbers of noise.uniform_noise, from the keys of its rows."""
    golden = np.uint64(0x9E3779B97F4A7C15)
    first = np.uint64(0xBF58476D1CE4E5B9)
    second = np.uint64(0x94D049BB133111EB)
    rows, width = noise.shape
    for r in range(rows):
        row = np.uint64(key[r])
        for x in range(width):
            z = row + np.uint64(x + 1) * golden
            z = (z ^ (z >> np.uint64(30))) * first
            z = (z ^ (z >> np.uint64(27))) * second
            top = np.float32(np.int64(z >> np.uint64(42)))
            noise[r, x] = (top + np.float32(0.5)) * np.float32(2.0**-22)


@kernel("f4[:,:]; f4[:,:]; u1[:,:]; u1[:,:]; f4[:,:]; f4[:]; f4[:]; f8[:]; f8")
def decide(light, noise, low, tone, threshold, level, fixed, wide, edges):
    """Step, tone within it (0 … 255, rounded) and threshold of each pixel.

    fixed : the threshold of each step, or empty where they are modulated (modulation.py): by
    *noise*, (0, 0) if there is none, with the width *wide* of every tone, and by *edges*.
    """
    rows, width = light.shape
    n = level.shape[0]
    # Adding and taking away 2⁵² rounds to the nearest whole number, halves to the even one.
    whole = np.float64(4503599627370496.0)
    half = np.float64(0.5)
    zero = np.float64(0.0)
    one = np.float64(1.0)
    for r in range(rows):
        for x in range(width):
            v = light[r, x]
            first = 0  # the number of inner levels at or below v, by bisection
            last = n - 2
            while first < last:
                middle = (first + last) // 2
                passed = v >= level[middle + 1]
                first = middle + 1 if passed else first
                last = last if passed else middle
            base = np.float64(level[first])
            step = np.float64(level[first + 1]) - base
            share = (np.float64(v) - base) / step
            share = zero if share < zero else share
            share = one if share > one else share
            t = np.int64((share * np.float64(255.0) + whole) - whole)
            low[r, x] = first
            tone[r, x] = t
            if fixed.shape[0] > 0:
                threshold[r, x] = fixed[first]
            else:
                shift = -edges * (share - half)
                if noise.shape[0] > 0:
                    shift = shift + (np.float64(noise[r, x]) - half) * wide[t]
                # A pixel exactly on a level keeps it.
                shift = zero if share == zero and shift < zero else shift
                shift = zero if share == one and shift > zero else shift
                threshold[r, x] = np.float32(base + (half + shift) * step)


@kernel(
    "f4[:,:]; u1[:,:]; u1[:,:]; f4[:,:]; u1[:,:]; f4[:,:]; f4[:]; u1[:];"
    "i8[:]; i8[:]; f4[:,:]; f4[:,:]; f4[:]; f4[:]; u1[:]; f4[:]; f4[:]; i8; i8; i8"
)
def diffuse_toned(
    light, low, tone, threshold, out, carry, error, sender,
    dy, dx, weight, left, level, middle, index, least, most, y0, serpentine, from_right,
):  # fmt: skip
    """Rows of *light* to level indices.

    weight[k, t] and left[0 … 1, t] are the shares that a pixel of tone t sends to tap k, and one and
    two columns ahead; with one column only, they are the same for all tones. *sender* holds the
    tones of the row beside its errors. least, most : by step.
    """
    rows, width = light.shape
    ring = carry.shape[0]
    margin = (error.shape[0] - width) // 2
    n = level.shape[0]
    toned = weight.shape[1] > 1
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
        along = -1 if backward else 1
        x = width - 1 if backward else 0
        for _ in range(width):
            at = np.uint64(x)
            v = (carry[slot, at] + two) + one
            carry[slot, at] = v
            i = np.int64(low[r, at])
            t = np.int64(tone[r, at]) if toned else 0
            limit = threshold[r, at]
            minus = -level[i]
            over = level[i + 1]
            ahead = left[0, t]
            two = next_two
            if v < least[i] or v > most[i]:
                # the nearest level, from the one below the light on
                while i < n - 1 and v >= middle[i]:
                    i += 1
                while i > 0 and v < middle[i - 1]:
                    i -= 1
                out[r, at] = index[i]
                e = v - level[i]
                one = ahead * e
            else:
                below = v + minus
                above = -(over - v)
                e = above if v > limit else below
                one = ahead * e
            error[np.uint64(margin + x)] = e
            next_two = left[1, t] * e
            x += along
        if n == 2:
            black = index[0]
            white = index[1]
            for x in range(width):
                out[r, x] = white if carry[slot, x] > threshold[r, x] else black
        else:
            for x in range(width):
                i = np.int64(low[r, x])
                if least[i] <= carry[slot, x] <= most[i]:
                    out[r, x] = index[i + 1] if carry[slot, x] > threshold[r, x] else index[i]
        for x in range(width):
            carry[slot, x] = np.float32(0.0)
        for k in range(dy.shape[0]):
            target = (y + dy[k]) % ring
            shift = margin + (dx[k] if backward else -dx[k])
            if toned:
                for x in range(width):
                    s = np.uint64(shift + x)
                    carry[target, x] += weight[k, sender[s]] * error[s]
            else:
                w = weight[k, 0]
                for x in range(width):
                    carry[target, x] += w * error[np.uint64(shift + x)]


@kernel(
    "u1[:,:]; f4[:,:]; u1[:,:]; f4[:]; f4[:]; f4[:]; f4[:]; f8[:]; u1[:]; f4[:]; f4[:]; u1[:];i8; i8; i8"
)
def diffuse_toned_codes(
    codes, noise, out, carry, value, threshold, known, drawn, low,
    level, middle, index, y0, serpentine, from_right,
):  # fmt: skip
    """Rows of 8-bit *codes* to level indices, with three taps: ahead, down-back and down.

    known : for each code 16 places: light, minus the level below, the level above, least, most,
    threshold, shares ahead, down-back and down. low : its step.
    noise : (0, 0), or the random numbers of the rows, and *drawn* for each code 8 places: step's base
    and height, shift without noise, width of the noise, the least and the most shift.
    carry : for every column what the row above sends, with a place more at either end.
    value, threshold : work space for a row.
    """
    rows, width = codes.shape
    n = level.shape[0]
    half = np.float64(0.5)
    for r in range(rows):
        backward = (from_right ^ (serpentine & (y0 + r))) & 1
        if noise.shape[0] > 0:
            for x in range(width):
                c = np.int64(codes[r, x]) * 8
                shift = drawn[c + 2] + (np.float64(noise[r, x]) - half) * drawn[c + 3]
                shift = drawn[c + 4] if shift < drawn[c + 4] else shift
                shift = drawn[c + 5] if shift > drawn[c + 5] else shift
                threshold[x] = np.float32(drawn[c] + (half + shift) * drawn[c + 1])
        else:
            for x in range(width):
                threshold[x] = known[np.int64(codes[r, x]) * 16 + 5]
        one = np.float32(0.0)  # on its way from the pixel before to this one
        down = np.float32(0.0)  # on its way from the pixel before to the one below it
        along = -1 if backward else 1
        x = width - 1 if backward else 0
        if n == 2:  # the loop below, with one step and nothing beyond its reach
            dark = -level[0]
            bright = level[1]
            for _ in range(width):
                at = np.uint64(x)
                c = np.int64(codes[r, at]) * 16
                v = (carry[np.uint64(x + 1)] + known[c]) + one
                value[at] = v
                limit = threshold[at]
                below = v + dark
                above = -(bright - v)
                e = above if v > limit else below
                one = known[c + 6] * e
                carry[np.uint64(x + 1 - along)] = known[c + 7] * e + down
                down = known[c + 8] * e
                x += along
        else:
            for _ in range(width):
                at = np.uint64(x)
                c = np.int64(codes[r, at]) * 16
                v = (carry[np.uint64(x + 1)] + known[c]) + one
                value[at] = v
                limit = threshold[at]
                minus = known[c + 1]
                over = known[c + 2]
                ahead = known[c + 6]
                if v < known[c + 3] or v > known[c + 4]:
                    i = np.int64(low[codes[r, at]])
                    while i < n - 1 and v >= middle[i]:
                        i += 1
                    while i > 0 and v < middle[i - 1]:
                        i -= 1
                    out[r, at] = index[i]
                    e = v - level[i]
                    one = ahead * e
                else:
                    below = v + minus
                    above = -(over - v)
                    e = above if v > limit else below
                    one = ahead * e
                carry[np.uint64(x + 1 - along)] = known[c + 7] * e + down
                down = known[c + 8] * e
                x += along
        carry[np.uint64(x + 1 - along)] = down
        if n == 2:
            black = index[0]
            white = index[1]
            for x in range(width):
                out[r, x] = white if value[x] > threshold[x] else black
        else:
            for x in range(width):
                c = np.int64(codes[r, x]) * 16
                if known[c + 3] <= value[x] <= known[c + 4]:
                    i = np.int64(low[codes[r, x]])
                    out[r, x] = index[i + 1] if value[x] > threshold[x] else index[i]
