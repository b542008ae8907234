"""Illumination of rows of surface samples in float32, each kernel one stage.

A place is homogeneous, (x, y, z, w, scale): the vector from a sample P to it is (x, y, z) − w·P, and
its distance is that vector's length · scale. w = 0 is a direction at infinity. Positions and normals
are rows x, y, z of K samples; normals have length 1 and face the viewer.

A comparison with NaN is false, and every result is the answer to one, so that a sample without a
direction (a light on the surface, a viewer opposite to the light, NaN) gets 0 and never NaN. Loops
have no calls and no branches, and places in arrays are unsigned, so that the compiler turns them into
vectors. *start* is the number of the sample of the whole arrays (those of K samples, of materials and
of results) with which the rows begin, which are short enough to stay in the cache.
"""

import numpy as np

from halftone._jit import kernel

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
HALF = np.float32(0.5)
TWO = np.float32(2.0)
THREE = np.float32(3.0)
LARGE = np.float32(3.4e38)
TINIEST = np.float32(2.0**-126)
DEEPEST = np.float32(-126.0)
# log2(1 + f) = f·(A0 + A1·f + …) for f within √½ − 1 … √2 − 1, and 2^r = 1 + r·(B1 + B2·r + …) for r
# within ±½: least relative error in float64, 2.6e-8 and 2.0e-9.
A0 = np.float32(1.4426950036521387)
A1 = np.float32(-0.7213473468007835)
A2 = np.float32(0.4809106430162682)
A3 = np.float32(-0.3607036830926482)
A4 = np.float32(0.287916245662061)
A5 = np.float32(-0.23894481295734776)
A6 = np.float32(0.215715623843481)
A7 = np.float32(-0.20726981791952753)
A8 = np.float32(0.12583705907448742)
B1 = np.float32(0.6931472028552119)
B2 = np.float32(0.24022647913615663)
B3 = np.float32(0.05550332470782865)
B4 = np.float32(0.009618437358224374)
B5 = np.float32(0.001339887455736566)
B6 = np.float32(0.0001535336206662288)
ROOT_HALF = np.int32(0x3F3504F3)  # √½ as the bits of a float32
BITS = np.int32(23)
BIAS = np.int32(127)
EIGHT = np.float32(8.0)
NINE = np.float32(9.0)
STEPS = np.float32(4096.0)
LAST = np.int32(4095)
WIDTH = np.uint32(4097)
RUN = 128  # samples whose materials are looked at together


@kernel("f4[:]; f4[:]; f4[:]; f4[:]")
def sharpen(incidence, cosine, exponent, row):
    """cosine^exponent; 0 where the cosine or the incidence is not above 0, also for exponent 0.

    x^n = 2^(n·log2 x): off by at most 1e-7 for every n ≥ 0, cosines above 1 counting as 1, and 0 only
    for x up to 2^-126. LARGE stands for an infinite exponent: 1 where the cosine is 1, else 0.
    (tests/scene/test_illumination_kernels.py)
    """
    for k in range(row.shape[0]):
        c = cosine[k] if cosine[k] > ZERO else ZERO
        c = c if c < ONE else ONE
        x = c if c > TINIEST else TINIEST
        bits = np.float32(x).view(np.int32)
        e = np.int32(np.int32(bits - ROOT_HALF) >> BITS)
        f = np.int32(bits - np.int32(e << BITS)).view(np.float32) - ONE
        p = ((((A8 * f + A7) * f + A6) * f + A5) * f + A4) * f + A3
        log2 = np.float32(e) + (((p * f + A2) * f + A1) * f + A0) * f
        log2 = log2 if c > TINIEST else -LARGE
        y = exponent[k] * log2
        seen = y > DEEPEST
        y = y if seen else DEEPEST
        i = np.int32(y - HALF)
        r = y - np.float32(i)
        q = (((((B6 * r + B5) * r + B4) * r + B3) * r + B2) * r + B1) * r + ONE
        scaled = q * np.int32(np.int32(i + BIAS) << BITS).view(np.float32)
        scaled = scaled if seen else ZERO
        scaled = scaled if c > ZERO else ZERO
        row[k] = scaled if incidence[k] > ZERO else ZERO


@kernel("i8; f4[:,:]; f4[:]; f4[:]")
def facing(start, normal, direction, cosine):
    """max(0, N·D) for one D for all samples: direction is x, y, z of any length and 1/length."""
    x, y, z, s = direction[0], direction[1], direction[2], direction[3]
    for k in range(cosine.shape[0]):
        at = np.uint64(start + k)
        c = ((normal[0, at] * x + normal[1, at] * y) + normal[2, at] * z) * s
        c = c if c > ZERO else ZERO
        cosine[k] = c if c < ONE else ONE


@kernel("i8; f4[:,:]; f4[:,:]; f4[:]; f4[:]")
def incidence(start, position, normal, light, cosine):
    """max(0, N·L) of a light at a place."""
    lx, ly, lz, lw = light[0], light[1], light[2], light[3]
    for k in range(cosine.shape[0]):
        at = np.uint64(start + k)
        x = lx - lw * position[0, at]
        y = ly - lw * position[1, at]
        z = lz - lw * position[2, at]
        s = ONE / np.sqrt((x * x + y * y) + z * z)
        c = ((normal[0, at] * x + normal[1, at] * y) + normal[2, at] * z) * s
        c = c if c > ZERO else ZERO
        cosine[k] = c if c < ONE else ONE


@kernel("i8; f4[:,:]; f4[:,:]; f4[:]; f4[:]; f4[:]")
def halfway(start, position, normal, light, eye, cosine):
    """max(0, N·H), H half-way between light and viewer (Blinn)."""
    lx, ly, lz, lw = light[0], light[1], light[2], light[3]
    ex, ey, ez, ew = eye[0], eye[1], eye[2], eye[3]
    for k in range(cosine.shape[0]):
        at = np.uint64(start + k)
        px, py, pz = position[0, at], position[1, at], position[2, at]
        x, y, z = lx - lw * px, ly - lw * py, lz - lw * pz
        u, v, w = ex - ew * px, ey - ew * py, ez - ew * pz
        t = np.sqrt(((x * x + y * y) + z * z) / ((u * u + v * v) + w * w))
        x, y, z = x + u * t, y + v * t, z + w * t
        s = ONE / np.sqrt((x * x + y * y) + z * z)
        c = ((normal[0, at] * x + normal[1, at] * y) + normal[2, at] * z) * s
        c = c if c > ZERO else ZERO
        cosine[k] = c if c < ONE else ONE


@kernel("i8; f4[:,:]; f4[:,:]; f4[:]; f4[:]; f4[:]")
def mirrored(start, position, normal, light, eye, cosine):
    """max(0, V·R) with R = 2(N·L)N − L (Phong)."""
    lx, ly, lz, lw = light[0], light[1], light[2], light[3]
    ex, ey, ez, ew = eye[0], eye[1], eye[2], eye[3]
    for k in range(cosine.shape[0]):
        at = np.uint64(start + k)
        px, py, pz = position[0, at], position[1, at], position[2, at]
        nx, ny, nz = normal[0, at], normal[1, at], normal[2, at]
        x, y, z = lx - lw * px, ly - lw * py, lz - lw * pz
        u, v, w = ex - ew * px, ey - ew * py, ez - ew * pz
        s = ONE / np.sqrt(((x * x + y * y) + z * z) * ((u * u + v * v) + w * w))
        two = TWO * ((nx * x + ny * y) + nz * z)
        c = (((two * nx - x) * u + (two * ny - y) * v) + (two * nz - z) * w) * s
        c = c if c > ZERO else ZERO
        cosine[k] = c if c < ONE else ONE


@kernel("i8; f4[:]; i4[:]; f4[:]; f4[:]")
def reflect(start, incidence, material, share, row):
    """row · W(θ) in place. share : STEPS + 1 numbers a material, W at 9c/(8c + 1) = i/STEPS, c = cos θ.

    Its steps are 81 times as fine at grazing light, where W is steep, as at upright light.
    """
    for k in range(row.shape[0]):
        c = incidence[k]
        u = (NINE * c) / (EIGHT * c + ONE) * STEPS
        i = np.int32(u)
        i = i if i < LAST else LAST
        at = np.uint32(material[np.uint64(start + k)]) * WIDTH + np.uint32(i)
        w = share[at]
        w += (u - np.float32(i)) * (share[at + np.uint32(1)] - w)
        w = w if w > ZERO else ZERO
        row[k] *= w if w < ONE else ONE


@kernel("i8; f4[:,:]; f4[:]; f4[:]; f4[:]")
def attenuate(start, position, light, a, factor):
    """factor · min(1, 1/(a0 + a1·d + a2·d²)) in place; 1/0 and NaN count as 1."""
    lx, ly, lz, lw, scale = light[0], light[1], light[2], light[3], light[4]
    a0, a1, a2 = a[0], a[1], a[2]
    for k in range(factor.shape[0]):
        at = np.uint64(start + k)
        x = lx - lw * position[0, at]
        y = ly - lw * position[1, at]
        z = lz - lw * position[2, at]
        d = np.sqrt((x * x + y * y) + z * z) * scale
        f = ONE / ((a2 * d + a1) * d + a0)
        factor[k] *= f if f < ONE else ONE


@kernel("i8; f4[:,:]; f4[:]; f4[:]; f4[:]")
def cone(start, position, light, axis, factor):
    """factor · 0 outside the cone … 1 inside, in place.

    axis : unit vector from the light, cosines of the outer and the inner half-angle. Between the two
    t²(3 − 2t), with t linear in the cosine; where they are the same, the edge is sharp and lit.
    """
    lx, ly, lz, lw = light[0], light[1], light[2], light[3]
    ax, ay, az, outer, inner = axis[0], axis[1], axis[2], axis[3], axis[4]
    for k in range(factor.shape[0]):
        at = np.uint64(start + k)
        x = lw * position[0, at] - lx
        y = lw * position[1, at] - ly
        z = lw * position[2, at] - lz
        c = ((x * ax + y * ay) + z * az) / np.sqrt((x * x + y * y) + z * z)
        t = (c - outer) / (inner - outer)
        t = t if t > ZERO else ZERO
        t = t if t < ONE else ONE
        t = (t * t) * (THREE - TWO * t)
        f = t if c < inner else ONE
        factor[k] *= ZERO if c < outer else f


@kernel("i8; f4[:,:]; f4[:]; f4[:]; f4[:]")
def off_axis(start, position, light, axis, cosine):
    """max(0, cos γ), γ off the axis of the light (Warn); 1 where the exponent about it is 0."""
    lx, ly, lz, lw = light[0], light[1], light[2], light[3]
    ax, ay, az, n = axis[0], axis[1], axis[2], axis[5]
    for k in range(cosine.shape[0]):
        at = np.uint64(start + k)
        x = lw * position[0, at] - lx
        y = lw * position[1, at] - ly
        z = lw * position[2, at] - lz
        c = ((x * ax + y * ay) + z * az) / np.sqrt((x * x + y * y) + z * z)
        c = c if c > ZERO else ZERO
        c = c if c < ONE else ONE
        cosine[k] = c if n > ZERO else ONE


@kernel("i8; f4[:,:]; f4[:,:]; f4[:]")
def flaps(start, position, limits, factor):
    """factor · 1 within the box *limits*, its faces included, else 0, in place (Warn)."""
    x0, x1 = limits[0, 0], limits[0, 1]
    y0, y1 = limits[1, 0], limits[1, 1]
    z0, z1 = limits[2, 0], limits[2, 1]
    for k in range(factor.shape[0]):
        at = np.uint64(start + k)
        x, y, z = position[0, at], position[1, at], position[2, at]
        f = ONE if x >= x0 else ZERO
        f = f if x <= x1 else ZERO
        f = f if y >= y0 else ZERO
        f = f if y <= y1 else ZERO
        f = f if z >= z0 else ZERO
        factor[k] *= f if z <= z1 else ZERO


@kernel("i8; i4[:]; f4[:,:]; f4[:]; f4[:,:]")
def add(start, material, colour, row, out):
    """out + colour · row, in place: a term of one light. colour : (C, materials), out : (C, K)."""
    count = row.shape[0]
    for run in range(0, count, RUN):
        width = count - run if count - run < RUN else RUN
        first = material[np.uint64(start + run)]
        other = np.int32(0)
        for j in range(width):
            other |= np.int32(material[np.uint64(start + run + j)] ^ first)
        for c in range(out.shape[0]):
            value = colour[np.uint64(c), np.uint32(first)]
            if other == np.int32(0):
                for j in range(width):
                    k, at = np.uint64(run + j), np.uint64(start + run + j)
                    out[np.uint64(c), at] += value * row[k]
            else:
                for j in range(width):
                    k, at = np.uint64(run + j), np.uint64(start + run + j)
                    t = colour[np.uint64(c), np.uint32(material[at])] * row[k]
                    out[np.uint64(c), at] += t


@kernel("i8; i4[:]; f4[:,:]; f4[:]; f4[:,:]")
def add_clamped(start, material, colour, row, out):
    """out + min(1, colour · row), in place; otherwise as :func:`add`."""
    for c in range(out.shape[0]):
        for k in range(row.shape[0]):
            at = np.uint64(start + k)
            t = colour[np.uint64(c), np.uint32(material[at])] * row[k]
            out[np.uint64(c), at] += t if t < ONE else ONE


@kernel("i8; i4[:]; f4[:]; f4[:]; f4[:]")
def largest(start, material, peak, row, top):
    """The larger of top and peak · row, in place; *peak* is the largest channel of each material."""
    for k in range(row.shape[0]):
        t = peak[np.uint32(material[np.uint64(start + k)])] * row[k]
        top[k] = t if t > top[k] else top[k]
