"""Kernels of the shading passes: from the visibility buffer to rows of samples, and back to pixels.

A run is a stretch of one row that shows one face. Along it the three weights of the face's corners,
the determinants det(d, h_j, h_k) of the pixel's homogeneous place d = (x, y, 1), are linear; they are
taken at both ends, in float64, kept from falling below 0 (a snapped face may reach 1/512 pixel
beyond the true one) and scaled; what lies between is linear, and a division by the sum of the
weights makes it correct in perspective.
"""

import math

import numpy as np

from halftone._jit import kernel, part
from halftone._lanes import load, splat, store

__all__ = ["blend", "gather_samples", "paint_corners", "paint_faces", "sample_faces", "scatter"]

WIDE = 8  # numbers of a corner: position, normal, 1, 0
ZERO = np.float32(0.0)
ONE = np.float32(1.0)


@part
def edge_weights(h, i, j, k, x, y, step):
    """Weights of the corners i, j, k at (x, y) and at (x + step, y), all ≥ 0, and whether the front
    is seen: (w0, w1, w2, v0, v1, v2, front).
    """
    ax, ay, az = h[i, 0], h[i, 1], h[i, 2]
    bx, by, bz = h[j, 0], h[j, 1], h[j, 2]
    cx, cy, cz = h[k, 0], h[k, 1], h[k, 2]
    ux = by * cz - bz * cy
    vx = cy * az - cz * ay
    wx = ay * bz - az * by
    w0 = x * ux + (y * (bz * cx - bx * cz) + (bx * cy - by * cx))
    w1 = x * vx + (y * (cz * ax - cx * az) + (cx * ay - cy * ax))
    w2 = x * wx + (y * (az * bx - ax * bz) + (ax * by - ay * bx))
    v0 = w0 + step * ux
    v1 = w1 + step * vx
    v2 = w2 + step * wx
    front = w0 + w1 + w2 + (v0 + v1 + v2) < 0.0
    if front:
        w0, w1, w2, v0, v1, v2 = -w0, -w1, -w2, -v0, -v1, -v2
    w0 = w0 if w0 > 0.0 else 0.0
    w1 = w1 if w1 > 0.0 else 0.0
    w2 = w2 if w2 > 0.0 else 0.0
    v0 = v0 if v0 > 0.0 else 0.0
    v1 = v1 if v1 > 0.0 else 0.0
    v2 = v2 if v2 > 0.0 else 0.0
    if not w0 + w1 + w2 > 0.0:
        w0, w1, w2 = 1.0, 1.0, 1.0
    if not v0 + v1 + v2 > 0.0:
        v0, v1, v2 = w0, w1, w2
    s = w0 + w1 + w2
    t = v0 + v1 + v2
    over = 1.0 / (s if s > t else t)
    return w0 * over, w1 * over, w2 * over, v0 * over, v1 * over, v2 * over, front


@kernel(
    "i4[:,:]; f8; f8; f8; i4[:,:]; i4[:,:]; f8[:,:]; f4[:]; f4[:]; i4[:]; u1[:];"
    "f4[:]; f4[:]; f4[:]; f4[:,:]; f4[:,:]; i4[:]",
    lanes=True,
)
def gather_samples(
    ids, x0, y0, pitch, faces, corners, h, table, sides, materials, two_sided, edge, row_of, scale,
    position, normal, material,
):  # fmt: skip
    """What the covered pixels of a band show, row by row, for shading pixel by pixel (Phong).

    ids : (rows, N). x0, y0 : place of the first pixel's centre, from the middle of the picture, and
    pitch, the distance to the next, in pixels of h.
    corners : (F, 3) into table (A · WIDE,): position, normal, 1 and 0 of each. sides : (4 · WIDE,),
    what these are multiplied by on the front, on the back of a two-sided material and on other backs,
    then 0, 1, 2, …: a normal turns to the viewer, or is 0, which shows ambient light only.
    Scratch: edge (2 · WIDE,), row_of (WIDE · (N + WIDE),), scale (N,).
    position, normal : (3, K), of length 1; material : (K + WIDE,), of which the last are scratch.
    """
    done = 0
    width = ids.shape[1]
    pace = width + WIDE
    ramp = load(sides, 3 * WIDE, WIDE)
    for row in range(ids.shape[0]):
        begun = done
        y = y0 + pitch * np.float64(row)
        x = 0
        while x < width:
            f = ids[row, np.uint64(x)]
            if f < 0:
                x += 1
                continue
            end = x + 1
            while end < width and ids[row, np.uint64(end)] == f:
                end += 1
            count = end - x
            g = np.uint64(f)
            w0, w1, w2, v0, v1, v2, front = edge_weights(
                h, np.uint64(faces[g, 0]), np.uint64(faces[g, 1]), np.uint64(faces[g, 2]),
                x0 + pitch * np.float64(x), y, pitch * np.float64(count - 1),
            )  # fmt: skip
            share = np.float32(1.0) / np.float32(count - 1 if count > 1 else 1)
            a0, a1, a2 = np.float32(w0), np.float32(w1), np.float32(w2)
            s0 = (np.float32(v0) - a0) * share
            s1 = (np.float32(v1) - a1) * share
            s2 = (np.float32(v2) - a2) * share
            m = materials[g]
            t0 = load(table, np.int64(corners[g, 0]) * WIDE, WIDE)
            t1 = load(table, np.int64(corners[g, 1]) * WIDE, WIDE)
            t2 = load(table, np.int64(corners[g, 2]) * WIDE, WIDE)
            here = splat(a0, WIDE) * t0 + splat(a1, WIDE) * t1 + splat(a2, WIDE) * t2
            step = splat(s0, WIDE) * t0 + splat(s1, WIDE) * t1 + splat(s2, WIDE) * t2
            if not front:
                side = load(sides, WIDE if two_sided[np.uint64(m)] else 2 * WIDE, WIDE)
                here, step = here * side, step * side
            store(edge, 0, here)
            store(edge, WIDE, step)
            for i in range(0, count, WIDE):  # what is written too much is written over
                store(material, done + i, splat(m, WIDE))
                t = splat(np.float32(i), WIDE) + ramp
                for c in range(7):
                    value = splat(edge[np.uint64(c)], WIDE) + t * splat(edge[np.uint64(WIDE + c)], WIDE)
                    store(row_of, c * pace + done - begun + i, value)
            done += count
            x = end
        # One result a loop, which the compiler then turns into vectors.
        for n in range(done - begun):
            scale[n] = np.float32(1.0) / row_of[np.uint64(6 * pace + n)]
        for axis in range(3):
            for n in range(done - begun):
                position[axis, np.uint64(begun + n)] = row_of[np.uint64(axis * pace + n)] * scale[n]
        for n in range(done - begun):
            a = row_of[np.uint64(3 * pace + n)]
            b = row_of[np.uint64(4 * pace + n)]
            c = row_of[np.uint64(5 * pace + n)]
            square = a * a + b * b + c * c
            scale[n] = np.float32(1.0) / np.sqrt(square if square > ZERO else ONE)
        for axis in range(3):
            for n in range(done - begun):
                normal[axis, np.uint64(begun + n)] = row_of[np.uint64((3 + axis) * pace + n)] * scale[n]


@kernel("i4[:,:]; f4[:,:]; f4[:]; u1; f4[:,:,:]")
def scatter(ids, colours, background, fill, out):
    """Colours (C, K) of the covered pixels, in their order, to out (rows, N, C); the others get the
    background if *fill*, else nothing.
    """
    at = 0
    three = out.shape[2] == 3
    for y in range(ids.shape[0]):
        for x in range(ids.shape[1]):
            if ids[y, x] >= 0:
                k = np.uint64(at)
                if three:
                    out[y, x, 0] = colours[0, k]
                    out[y, x, 1] = colours[1, k]
                    out[y, x, 2] = colours[2, k]
                else:
                    for c in range(out.shape[2]):
                        out[y, x, c] = colours[c, k]
                at += 1
            elif fill:
                for c in range(out.shape[2]):
                    out[y, x, c] = background[c]


@kernel("i4[:,:]; f4[:,:,:]; f4[:]; f4[:,:,:]")
def blend(ids, layer, share, out):
    """I = (1 − k_t)·I_refl + k_t·I_trans for a *layer* before *out*, both (rows, N, C); k_t is the share
    (K,) of its covered pixels.
    """
    at = 0
    one = np.float32(1.0)
    for y in range(ids.shape[0]):
        for x in range(ids.shape[1]):
            if ids[y, x] >= 0:
                k = share[at]
                for c in range(out.shape[2]):
                    out[y, x, c] = (one - k) * layer[y, x, c] + k * out[y, x, c]
                at += 1


@kernel("i4[:]; i8; u1[:]; i4[:,:]; f8[:,:]; i4[:]; u1[:]; f4[:,:]; f4[:,:]; i4[:]")
def sample_faces(
    visible, start, seen, faces, vertices, materials, two_sided, position, normal, material
):
    """Centres and normals of visible[start : start + K], for shading face by face (flat).

    seen : (F,), 2 where the back is seen, see _raster_kernels.
    """
    for at in range(material.shape[0]):
        f = visible[start + at]
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        ux = vertices[j, 0] - vertices[i, 0]
        uy = vertices[j, 1] - vertices[i, 1]
        uz = vertices[j, 2] - vertices[i, 2]
        vx = vertices[k, 0] - vertices[i, 0]
        vy = vertices[k, 1] - vertices[i, 1]
        vz = vertices[k, 2] - vertices[i, 2]
        a = uy * vz - uz * vy
        b = uz * vx - ux * vz
        c = ux * vy - uy * vx
        square = a * a + b * b + c * c
        length = 1.0 / math.sqrt(square) if square > 0.0 else 0.0
        m = materials[f]
        if seen[f] == 2:
            length = -length if two_sided[m] else 0.0
        position[0, at] = np.float32(vertices[i, 0] + (ux + vx) / 3.0)
        position[1, at] = np.float32(vertices[i, 1] + (uy + vy) / 3.0)
        position[2, at] = np.float32(vertices[i, 2] + (uz + vz) / 3.0)
        normal[0, at] = np.float32(a * length)
        normal[1, at] = np.float32(b * length)
        normal[2, at] = np.float32(c * length)
        material[at] = m


@kernel("i4[:,:]; i4[:]; f4[:,:]; f4[:]; u1; f4[:,:,:]")
def paint_faces(ids, slot, colours, background, fill, out):
    """The colours of whole faces to out (rows, N, C): colours (S, C), slot (F,) the row of a face;
    background and fill as for :func:`scatter`.
    """
    three = out.shape[2] == 3
    for y in range(ids.shape[0]):
        for x in range(ids.shape[1]):
            f = ids[y, x]
            if f >= 0:
                s = np.uint64(slot[np.uint64(f)])
                if three:
                    out[y, x, 0] = colours[s, 0]
                    out[y, x, 1] = colours[s, 1]
                    out[y, x, 2] = colours[s, 2]
                else:
                    for c in range(out.shape[2]):
                        out[y, x, c] = colours[s, c]
            elif fill:
                for c in range(out.shape[2]):
                    out[y, x, c] = background[c]


@kernel("i4[:,:]; f8; f8; f8; i4[:,:]; i4[:,:]; f8[:,:]; f4[:,:]; f4[:,:]; f4[:]; u1; f4[:,:,:]")
def paint_corners(ids, x0, y0, pitch, faces, corners, h, fronts, backs, background, fill, out):
    """Colours of corners, (A, C) for fronts and for backs, over the pixels of their faces (Gouraud) to
    out (rows, N, C); background and fill as for :func:`scatter`.
    """
    width = ids.shape[1]
    for row in range(ids.shape[0]):
        y = y0 + pitch * np.float64(row)
        x = 0
        while x < width:
            f = ids[row, np.uint64(x)]
            if f < 0:
                if fill:
                    for c in range(out.shape[2]):
                        out[row, np.uint64(x), c] = background[c]
                x += 1
                continue
            end = x + 1
            while end < width and ids[row, np.uint64(end)] == f:
                end += 1
            count = end - x
            g = np.uint64(f)
            w0, w1, w2, v0, v1, v2, front = edge_weights(
                h, np.uint64(faces[g, 0]), np.uint64(faces[g, 1]), np.uint64(faces[g, 2]),
                x0 + pitch * np.float64(x), y, pitch * np.float64(count - 1),
            )  # fmt: skip
            share = np.float32(1.0) / np.float32(count - 1 if count > 1 else 1)
            a0, a1, a2 = np.float32(w0), np.float32(w1), np.float32(w2)
            s0 = (np.float32(v0) - a0) * share
            s1 = (np.float32(v1) - a1) * share
            s2 = (np.float32(v2) - a2) * share
            base = a0 + a1 + a2
            rise = s0 + s1 + s2
            c0, c1, c2 = np.uint64(corners[g, 0]), np.uint64(corners[g, 1]), np.uint64(corners[g, 2])
            table = fronts if front else backs
            if out.shape[2] == 3:
                b0 = a0 * table[c0, 0] + a1 * table[c1, 0] + a2 * table[c2, 0]
                b1 = a0 * table[c0, 1] + a1 * table[c1, 1] + a2 * table[c2, 1]
                b2 = a0 * table[c0, 2] + a1 * table[c1, 2] + a2 * table[c2, 2]
                d0 = s0 * table[c0, 0] + s1 * table[c1, 0] + s2 * table[c2, 0]
                d1 = s0 * table[c0, 1] + s1 * table[c1, 1] + s2 * table[c2, 1]
                d2 = s0 * table[c0, 2] + s1 * table[c1, 2] + s2 * table[c2, 2]
                for i in range(count):
                    at, t = np.uint64(x + i), np.float32(i)
                    over = np.float32(1.0) / (base + t * rise)
                    out[row, at, 0] = (b0 + t * d0) * over
                    out[row, at, 1] = (b1 + t * d1) * over
                    out[row, at, 2] = (b2 + t * d2) * over
            else:
                for c in range(out.shape[2]):
                    b0 = a0 * table[c0, c] + a1 * table[c1, c] + a2 * table[c2, c]
                    d0 = s0 * table[c0, c] + s1 * table[c1, c] + s2 * table[c2, c]
                    for i in range(count):
                        t = np.float32(i)
                        out[row, np.uint64(x + i), c] = (b0 + t * d0) / (base + t * rise)
            x = end
