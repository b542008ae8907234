"""Raster error diffusion by a wavefront: 32 rows at once, each a few columns behind the one above.

What a pixel needs from the rows above was found some steps before, so the 32 pixels of a step do not
wait for each other: in step t, lane r works at column t − skew·r of row r. The arithmetic, and the
order of every sum, is that of _diffusion_kernels: so are the bytes.

A block of 32 rows goes in chunks of steps: codes are transposed, so that those of a step lie side by
side; the steps are done; the level indices are transposed back. Lanes beyond the sides of the picture
send no error.

Threads take the blocks in turn. Block g of the picture, counted from 1, writes what it sends down into
slot g modulo *slots* of *history*, and g·span + columns done into the same slot of *reach*, where span
is wider than the picture; a chunk starts when the block above has come far enough. A kernel that would
wait long returns, and goes on where it was (*state*: block of the band, step) when called again.
"""

import numpy as np

from halftone._jit import kernel, part
from halftone._lanes import (
    acquire,
    added,
    as_bytes,
    as_floats,
    as_places,
    copy,
    gather,
    load,
    prefetch,
    release,
    select,
    shifted,
    splat,
    store,
    transpose,
    widened,
)

LANES = 32
CHUNK = 128
PATIENCE = 20_000
SKEW = 3  # of wave_codes
SCANNED = 16  # levels up to which each middle is compared with


@part
def far_enough(reach, slot, need):
    """Whether the block above has done the columns before *need*, now or soon."""
    tries = 0
    while acquire(reach, slot) < need:
        tries += 1
        if tries > PATIENCE:
            return False
    return True


@part
def turn_in(given, turned, skew, start):
    """The codes of the steps from *start* on, step by step."""
    pitch = given.shape[0] // LANES
    margin = CHUNK + skew * LANES
    for r in range(0, LANES, 16):
        for t in range(0, CHUNK, 16):
            at = margin + r * (pitch - skew) + start + t
            transpose(given, at, pitch - skew, turned, t * LANES + r, LANES)


@part
def turn_out(shown, made, skew, start):
    """The indices of the steps from *start* on, row by row."""
    pitch = made.shape[0] // LANES
    margin = CHUNK + skew * LANES
    for r in range(0, LANES, 16):
        for t in range(0, CHUNK, 16):
            at = margin + r * (pitch - skew) + start + t
            transpose(shown, t * LANES + r, LANES, made, at, pitch - skew)


@part
def rows_in(picture, top, count, width, given, skew):
    """Rows of the picture, with room for the lanes beyond its sides."""
    pitch = given.shape[0] // LANES
    margin = CHUNK + skew * LANES
    for r in range(count):
        copy(picture, (top + r) * width, given, margin + r * pitch, width)


@part
def rows_out(made, out, top, count, width, skew):
    pitch = made.shape[0] // LANES
    margin = CHUNK + skew * LANES
    for r in range(count):
        copy(made, margin + r * pitch, out, (top + r) * width, width)


@kernel(
    "u1[:]; u1[:]; i8; i8; u1[:]; i8; i8; i2[:]; i8[:]; i8[:];"
    "i2[:]; i2[:]; i2[:]; u1[:]; u1[:]; u1[:]; u1[:]",
    lanes=True,
)
def wave_codes(
    codes, out, rows, width, index, before, threads, history, reach, state,
    kept, places, carries, given, made, turned, shown,
):  # fmt: skip
    """Floyd–Steinberg on 8-bit codes, two levels: the arithmetic of diffuse_codes, in int16.

    before : blocks above the band. threads : that take a block each, in turn. history : flat, in each
    slot the carry of the row below a block. kept : the vectors of a step. places : SKEW·lane.
    """
    dark = index[0]
    bright = index[1]
    white = np.int16(16 * 255)
    half = np.int16(8 * 255)
    span = width + CHUNK
    slots = reach.shape[0]
    size = history.shape[0] // slots
    far = load(places, 0, LANES)
    block = state[0]
    start = state[1]
    while block * LANES < rows:
        top = block * LANES
        count = rows - top if rows - top < LANES else LANES
        slot = (before + block + 1) % slots
        above = (before + block) % slots
        source = above * size
        target = slot * size
        done = (before + block + 1) * span
        if start == 0:
            rows_in(codes, top, count, width, given, SKEW)
        while start < width + 1 + SKEW * (count - 1):
            need = start + CHUNK + 2
            if not far_enough(reach, above, done - span + (need if need < width else width)):
                state[0] = block
                state[1] = start
                return
            if start == 0:
                nothing = splat(np.int16(0), LANES)
                for k in range(3):
                    store(kept, k * LANES, nothing)
                store(kept, 3 * LANES, shifted(nothing, history[source + 1]))
                store(kept, 4 * LANES, shifted(nothing, history[source]))
            turn_in(given, turned, SKEW, start)
            inner = count == LANES and start >= SKEW * (LANES - 1) and start + CHUNK <= width
            e = load(kept, 0, LANES)
            late = load(kept, LANES, LANES)
            early = load(kept, 2 * LANES, LANES)
            next1 = load(kept, 3 * LANES, LANES)
            next2 = load(kept, 4 * LANES, LANES)
            at = np.uint64(source + start + 2)
            for t in range(CHUNK):
                prefetch(codes, (top + LANES) * width + (start + t) * LANES)  # of the block below
                prefetch(out, top * width + (start + t) * LANES)
                light = widened(load(turned, t * LANES, LANES)) << 4
                v = added(light + next2, (e >> 1) - (e >> 4))
                up = v >= half
                e = select(up, v - white, v)
                if not inner:
                    low = start + t - width + 1
                    low = 0 if low < 0 else low
                    high = start + t + 1
                    high = 1000 if high > 1000 else high
                    e = select((far >= low) & (far < high), e, np.int16(0))
                store(shown, t * LANES, select(up, bright, dark))
                # What column x − 1 of the row below gets: 3/16 now, 5/16 and the rest from before.
                three = (e + e + e) >> 4
                five = ((e << 2) + e) >> 4
                carry = early + three
                early = late + five
                late = e - ((e >> 1) - (e >> 4)) - three - five
                store(carries, t * LANES, carry)
                next2 = next1
                next1 = shifted(carry, history[at + np.uint64(t)])
            store(kept, 0, e)
            store(kept, LANES, late)
            store(kept, 2 * LANES, early)
            store(kept, 3 * LANES, next1)
            store(kept, 4 * LANES, next2)
            turn_out(shown, made, SKEW, start)
            behind = start - SKEW * (count - 1) - 1
            first = -behind if behind < 0 else 0
            end = width - behind if width - behind < CHUNK else CHUNK
            for t in range(first, end):
                history[target + behind + t] = carries[t * LANES + count - 1]
            start += CHUNK
            columns = behind + CHUNK
            release(reach, slot, done + (columns if columns > 0 else 0))
        rows_out(made, out, top, count, width, SKEW)
        start = 0
        block += threads
    state[0] = block


@kernel(
    "f4[:]; u1[:]; f4[:]; f4; u1[:]; i8; i8; f4[:]; f4[:]; f4[:]; u1[:]; i4[:]; i4[:]; f4; i8; f4;"
    "i8[:]; f4[:]; f4; f4; i8; i8; i8; i8; f4[:]; i8[:]; i8[:];"
    "f4[:]; i4[:]; f4[:]; f4[:]; u1[:]; u1[:]; u1[:]; u1[:]",
    lanes=True,
)
def wave_light(
    light, codes, table, white, out, rows, width,
    level, middle, beyond, index, bucket, wide, scale, rounds, even,
    place, weight, left1, left2, skew, depth, blocks, threads, history, reach, state,
    kept, places, errors, lit, given, made, turned, shown,
):  # fmt: skip
    """Any filter and any levels in float32: the arithmetic of diffuse_light.

    light : rows of light, or empty where *codes* and the light of each in *table* are given; white is
    255 where that light is code/255, else 0.
    even : n − 1 where level k is k/(n − 1), else 0. beyond : *middle* and then infinity; bucket, scale :
    as in diffuse_light, and *rounds* how often a bucket's level may have to be raised; wide : *index*
    as int32.
    place, weight : taps below, in the order of their sums: where a tap's errors lie from the place of
    the step's own. skew : of the lanes; depth : rows that errors reach down.
    blocks : above the band. threads : that take a block each, in turn. history : flat, in each slot the
    errors of the last *depth* rows of a block and those above it, the lowest first.
    """
    n = level.shape[0]
    darkest = level[0]
    lightest = level[n - 1]
    half = middle[0]
    zero = np.float32(0.0)
    one = np.float32(1.0)
    top_bucket = np.float32(bucket.shape[0] - 1)
    coded = table.shape[0] > 0
    pitch = (depth + 1) * LANES
    before = errors.shape[0] // pitch - CHUNK
    span = width + CHUNK
    slots = reach.shape[0]
    size = history.shape[0] // slots // depth
    far = load(places, 0, LANES)
    block = state[0]
    start = state[1]
    while block * LANES < rows:
        top = block * LANES
        count = rows - top if rows - top < LANES else LANES
        slot = (blocks + block + 1) % slots
        above = (blocks + block) % slots
        source = above * depth * size
        target = slot * depth * size
        done = (blocks + block + 1) * span
        if start == 0:
            if coded:
                rows_in(codes, top, count, width, given, skew)
            for k in range(2 * LANES):
                kept[k] = zero
        while start < width + skew * (count - 1):
            need = start + CHUNK + skew * depth
            if not far_enough(reach, above, done - span + (need if need < width else width)):
                state[0] = block
                state[1] = start
                return
            if coded:
                turn_in(given, turned, skew, start)
                if white > zero:  # the codes are shares of white: quicker than to look them up
                    for t in range(0, CHUNK * LANES, LANES):
                        store(lit, t, as_floats(load(turned, t, LANES)) / white)
                else:
                    for k in range(CHUNK * LANES):
                        lit[k] = table[turned[k]]
            else:
                for r in range(count):
                    behind = start - skew * r
                    first = -behind if behind < 0 else 0
                    end = width - behind if width - behind < CHUNK else CHUNK
                    at = (top + r) * width + behind
                    for t in range(first, end):
                        v = light[at + t]
                        v = darkest if v < darkest else v
                        v = lightest if v > lightest else v
                        lit[t * LANES + r] = v
            if start == 0:  # what the rows above sent before the first step
                for k in range(before * pitch):
                    errors[k] = zero
                for t in range(before):
                    for d in range(1, depth + 1):
                        for r in range(d):
                            far_above = d - r
                            at = source + (far_above - 1) * size + t + skew * far_above
                            errors[t * pitch + d * LANES + r] = history[at]
            inner = count == LANES and start >= skew * (LANES - 1) and start + CHUNK <= width
            e1 = load(kept, 0, LANES)
            e2 = load(kept, LANES, LANES)
            for t in range(CHUNK):
                if coded:
                    prefetch(codes, (top + LANES) * width + (start + t) * LANES)  # of the block below
                prefetch(out, top * width + (start + t) * LANES)
                own = (before + t) * pitch
                carry = load(errors, own + place[0], LANES) * weight[0]
                for k in range(1, place.shape[0]):
                    carry = carry + load(errors, own + place[k], LANES) * weight[k]
                v = carry + load(lit, t * LANES, LANES)
                v = (v + e2 * left2) + e1 * left1
                e2 = e1
                if n == 2:
                    up = v >= half
                    e1 = select(up, v - lightest, v - darkest)
                    chosen = select(up, index[1], index[0])
                elif even > zero:
                    b = v * even
                    b = select(b >= zero, b, zero)
                    i = as_places(select(b < even - one, b, even - one))
                    below_v = as_floats(i) / even
                    above_v = as_floats(i + 1) / even
                    up = v >= (below_v + above_v) * np.float32(0.5)
                    e1 = v - select(up, above_v, below_v)
                    chosen = as_bytes(select(up, i + 1, i))
                elif n <= SCANNED:
                    nearest = splat(darkest, LANES)
                    chosen = splat(index[0], LANES)
                    for k in range(n - 1):
                        up = v >= middle[k]
                        nearest = select(up, level[k + 1], nearest)
                        chosen = select(up, index[k + 1], chosen)
                    e1 = v - nearest
                else:
                    b = (v - darkest) * scale
                    b = select(b >= zero, b, zero)
                    i = gather(bucket, as_places(select(b < top_bucket, b, top_bucket)))
                    for _ in range(rounds):
                        i = select(v >= gather(beyond, i), i + 1, i)
                    e1 = v - gather(level, i)
                    chosen = as_bytes(gather(wide, i))
                if not inner:
                    low = start + t - width + 1
                    e1 = select((far >= low) & (far < start + t + 1), e1, zero)
                store(errors, own, e1)
                above_me = e1
                for d in range(1, depth + 1):
                    at = source + before + start + (d - 1) * size + skew * d
                    above_me = shifted(above_me, history[np.uint64(at + t)])
                    store(errors, own + d * LANES, above_me)
                store(shown, t * LANES, chosen)
            store(kept, 0, e1)
            store(kept, LANES, e2)
            turn_out(shown, made, skew, start)
            for d in range(1, depth + 1):
                behind = start - skew * (count - d)
                first = -behind if behind < 0 else 0
                end = width - behind if width - behind < CHUNK else CHUNK
                at = target + (d - 1) * size + before + behind
                if d <= count:
                    for t in range(first, end):
                        history[at + t] = errors[(before + t) * pitch + count - d]
            copy(errors, CHUNK * pitch, errors, 0, before * pitch)
            start += CHUNK
            columns = start - skew * (count - 1)
            if count >= depth:
                release(reach, slot, done + (columns if columns > 0 else 0))
        for d in range(count + 1, depth + 1):
            copy(history, source + (d - count - 1) * size, history, target + (d - 1) * size, size)
        release(reach, slot, done + width)
        rows_out(made, out, top, count, width, skew)
        start = 0
        block += threads
    state[0] = block
