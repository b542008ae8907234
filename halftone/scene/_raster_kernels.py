"""Kernels of hidden surfaces: projection, bins of rows, and which face each pixel shows.

Places are fixed point: 256 steps a pixel, pixel (x, y) has its centre at 256·x + 128, 256·y + 128.
A face covers the centres inside it and those on its top and left edges, so that faces that share an
edge leave no gap and share no centre. All tests of coverage are integer arithmetic, exact below 2⁶³.
"""

import math

import numpy as np

from halftone._jit import kernel

__all__ = ["bin_faces", "clear", "cover", "mark", "project", "sort_faces", "turn"]

SURFACE, LAYER, DETAIL = 0, 1, 2
LANES = 8  # pixels of a group
NARROW = 32  # a face up to this wide is tested pixel by pixel, in groups; a wider one row by row


@kernel("f8[:,:]; f8[:]; f8[:,:]; u1; f8; f8; f8; i8; i8; f8[:,:]; i4[:,:]; f8[:]; u1[:]")
def project(
    vertices,
    eye,
    rows,
    perspective,
    half_width,
    half_height,
    guard,
    start,
    stop,
    h,
    snapped,
    key,
    outside,
):
    """Points *start* … *stop* to the picture: homogeneous, snapped, and the key of depth.

    rows : (3, 4), see View.rows. key : larger is nearer, and linear in the picture. outside : 1 where
    a point is before the near plane or beyond *guard* pixels from the middle: its faces are clipped.
    """
    plane = rows[2, 3]
    for i in range(start, stop):
        a = vertices[i, 0] - eye[0]
        b = vertices[i, 1] - eye[1]
        c = vertices[i, 2] - eye[2]
        x = rows[0, 0] * a + rows[0, 1] * b + rows[0, 2] * c
        y = rows[1, 0] * a + rows[1, 1] * b + rows[1, 2] * c
        far = rows[2, 0] * a + rows[2, 1] * b + rows[2, 2] * c
        h[i, 0] = x
        h[i, 1] = y
        w = far if perspective else 1.0
        h[i, 2] = w
        seen = far >= plane and abs(x) <= guard * w and abs(y) <= guard * w
        outside[i] = 0 if seen else 1
        if not seen:
            w = 1.0
            x = 0.0
            y = 0.0
        over = 1.0 / w
        snapped[i, 0] = np.int32(math.floor((x * over + half_width) * 256.0 + 0.5))
        snapped[i, 1] = np.int32(math.floor((y * over + half_height) * 256.0 + 0.5))
        key[i] = over if perspective else -far


@kernel("i4[:,:]; i4[:,:]; u1[:]; i8; i8; i8; i8; i8; i4[:,:]; i4[:]")
def sort_faces(faces, snapped, outside, start, stop, width, height, rows, span, counts):
    """The first and the last band of faces *start* … *stop*: span[f] = (first, last).

    A face that covers no centre of the picture for sure has first > last; one that must be clipped
    has first −1. counts : (bands + 1,), how many of these faces each band has; the last entry counts
    the faces to clip.
    """
    for f in range(start, stop):
        i, j, k = np.uint64(faces[f, 0]), np.uint64(faces[f, 1]), np.uint64(faces[f, 2])
        span[f, 0] = 1
        span[f, 1] = 0
        if outside[i] | outside[j] | outside[k]:
            span[f, 0] = -1
            counts[counts.shape[0] - 1] += 1
            continue
        xi, xj, xk = np.int64(snapped[i, 0]), np.int64(snapped[j, 0]), np.int64(snapped[k, 0])
        yi, yj, yk = np.int64(snapped[i, 1]), np.int64(snapped[j, 1]), np.int64(snapped[k, 1])
        low, high = yi, yi
        low = yj if yj < low else low
        low = yk if yk < low else low
        high = yj if yj > high else high
        high = yk if yk > high else high
        top = (low + 127) >> 8
        bottom = (high - 128) >> 8
        top = 0 if top < 0 else top
        bottom = height - 1 if bottom >= height else bottom
        low, high = xi, xi
        low = xj if xj < low else low
        low = xk if xk < low else low
        high = xj if xj > high else high
        high = xk if xk > high else high
        left = (low + 127) >> 8
        right = (high - 128) >> 8
        left = 0 if left < 0 else left
        right = width - 1 if right >= width else right
        if top > bottom or left > right:
            continue
        if (xj - xi) * (yk - yi) == (yj - yi) * (xk - xi):
            continue
        first = top // rows
        last = bottom // rows
        span[f, 0] = np.int32(first)
        span[f, 1] = np.int32(last)
        for band in range(first, last + 1):
            counts[band] += 1


@kernel("i4[:,:]; i8; i8; i8[:]; i4[:]")
def bin_faces(span, start, stop, at, bins):
    """Write faces *start* … *stop* into their bands' lists, from at[band] on, in order; the last entry
    of *at* is where the faces to clip go.
    """
    clipped = at.shape[0] - 1
    for f in range(start, stop):
        first = span[f, 0]
        if first < 0:
            bins[at[clipped]] = np.int32(f)
            at[clipped] += 1
            continue
        for band in range(first, span[f, 1] + 1):
            bins[at[band]] = np.int32(f)
            at[band] += 1


@kernel("i4[:,:]; f8[:,:]")
def clear(ids, depth):
    """Nothing is seen anywhere."""
    for y in range(ids.shape[0]):
        for x in range(ids.shape[1]):
            ids[y, x] = -1
            depth[y, x] = -math.inf


@kernel(
    "i8; i4[:]; i8; i8; i4[:,:]; i4[:]; i4[:,:]; f8[:]; i8; i8; i8; i4[:,:]; f8[:,:]; i4[:,:]; f8[:,:];"
    "i4[:,:]; f8[:,:]; i4[:]; i4[:]"
)
def cover(
    mode, bins, start, stop, faces, owner, snapped, key, top, bottom, width, ids, depth, front_ids,
    front_depth, solid_ids, solid_depth, plane, lies_on,
):  # fmt: skip
    """Faces bins[start:stop] into rows *top* … *bottom* of the visibility buffer.

    ids, depth : (rows, N), what is seen so far and how near, by its key. owner : the id of a face.
    mode : SURFACE, the nearest face wins, of equally near ones the lower id. LAYER, the nearest of
    those behind the front buffers and before the solid ones. DETAIL, a face wins where one is seen
    whose *plane* is that of the face it *lies on*, both (F,). Arrays that a mode does not use have
    any content.
    """
    for at in range(start, stop):
        f = np.uint64(bins[at])
        me = owner[f]
        i, j, k = np.uint64(faces[f, 0]), np.uint64(faces[f, 1]), np.uint64(faces[f, 2])
        x0, y0 = np.int64(snapped[i, 0]), np.int64(snapped[i, 1])
        x1, y1 = np.int64(snapped[j, 0]), np.int64(snapped[j, 1])
        x2, y2 = np.int64(snapped[k, 0]), np.int64(snapped[k, 1])
        area = (x1 - x0) * (y2 - y0) - (y1 - y0) * (x2 - x0)
        # One order of the corners for every way to name them, so that equal faces are equally near.
        a, b = (j if area > 0 else k), (k if area > 0 else j)
        j, k = a, b
        area = area if area > 0 else -area
        pi = (np.int64(snapped[i, 1]) << 32) + np.int64(snapped[i, 0])
        pj = (np.int64(snapped[j, 1]) << 32) + np.int64(snapped[j, 0])
        pk = (np.int64(snapped[k, 1]) << 32) + np.int64(snapped[k, 0])
        second = (pj < pi) & (pj < pk)
        third = (pk < pi) & (pk < pj)
        a, b = (j if second else i), (k if second else j)
        c = i if second else k
        i, j, k = (k if third else a), (i if third else b), (j if third else c)
        x0, y0 = np.int64(snapped[i, 0]), np.int64(snapped[i, 1])
        x1, y1 = np.int64(snapped[j, 0]), np.int64(snapped[j, 1])
        x2, y2 = np.int64(snapped[k, 0]), np.int64(snapped[k, 1])
        first = (y0 + 127) >> 8
        last = ((y1 if y1 > y2 else y2) - 128) >> 8
        first = top if first < top else first
        last = bottom - 1 if last >= bottom else last
        low = x1 if x1 < x2 else x2
        low = x0 if x0 < low else low
        left = (low + 127) >> 8 if low > 0 else np.int64(0)
        high = x1 if x1 > x2 else x2
        high = x0 if x0 > high else high
        right = (high - 128) >> 8
        span = (right if right < width else width - 1) - left
        # Edges a: 0→1, b: 1→2, c: 2→0; the inside is where all three are ≥ 0.
        ax, ay = x1 - x0, y1 - y0
        bx, by = x2 - x1, y2 - y1
        cx, cy = x0 - x2, y0 - y2
        # An edge that is neither top nor left must be passed: its limit is 1.
        la = 1 - np.int64((ay < 0) | ((ay == 0) & (ax > 0)))
        lb = 1 - np.int64((by < 0) | ((by == 0) & (bx > 0)))
        lc = 1 - np.int64((cy < 0) | ((cy == 0) & (cx > 0)))
        py = first * 256 + 128
        px = left * 256 + 128
        ea = ax * (py - y0) - ay * (px - x0) - la
        eb = bx * (py - y1) - by * (px - x1) - lb
        ec = cx * (py - y2) - cy * (px - x2) - lc
        ax, ay, bx, by, cx, cy = ax * 256, ay * 256, bx * 256, by * 256, cx * 256, cy * 256
        # Depth: vertex 1 has the weight of edge c, vertex 2 that of edge a.
        k0 = key[i]
        over = 1.0 / np.float64(area)
        d1 = (key[j] - k0) * over
        d2 = (key[k] - k0) * over
        count = (span + LANES) & -LANES
        begin = left if left + count <= width else width - count
        if mode == SURFACE and count <= NARROW and begin >= 0:
            # Whole groups of pixels, without branches, which the compiler turns into vectors.
            ea -= ay * (begin - left)
            eb -= by * (begin - left)
            ec -= cy * (begin - left)
            for y in range(first, last + 1):
                row = np.uint64(y - top)
                for n in range(count):
                    x = np.uint64(begin + n)
                    va, vb, vc = ea - ay * n, eb - by * n, ec - cy * n
                    z = k0 + (np.float64(vc + lc) * d1 + np.float64(va + la) * d2)
                    old, was = depth[row, x], ids[row, x]
                    take = ((va | vb | vc) >= 0) & ((z > old) | ((z == old) & (me < was)))
                    depth[row, x] = z if take else old
                    ids[row, x] = me if take else was
                ea += ax
                eb += bx
                ec += cx
            continue
        step = np.float64(-cy) * d1 + np.float64(-ay) * d2
        ia = 1.0 / np.float64(abs(ay) | 1)
        ib = 1.0 / np.float64(abs(by) | 1)
        ic = 1.0 / np.float64(abs(cy) | 1)
        for y in range(first, last + 1):
            lo, hi = np.int64(0), span
            # A floor of a ratio: an estimate that is then put right, so it is exact.
            if ay != 0:
                m = abs(ay)
                q = np.int64(math.floor(np.float64(ea) * ia))
                r = ea - q * m
                q += np.int64(r >= m) - np.int64(r < 0)
                lo = -q if ay < 0 and -q > lo else lo
                hi = q if ay > 0 and q < hi else hi
            elif ea < 0:
                hi = np.int64(-1)
            if by != 0:
                m = abs(by)
                q = np.int64(math.floor(np.float64(eb) * ib))
                r = eb - q * m
                q += np.int64(r >= m) - np.int64(r < 0)
                lo = -q if by < 0 and -q > lo else lo
                hi = q if by > 0 and q < hi else hi
            elif eb < 0:
                hi = np.int64(-1)
            if cy != 0:
                m = abs(cy)
                q = np.int64(math.floor(np.float64(ec) * ic))
                r = ec - q * m
                q += np.int64(r >= m) - np.int64(r < 0)
                lo = -q if cy < 0 and -q > lo else lo
                hi = q if cy > 0 and q < hi else hi
            elif ec < 0:
                hi = np.int64(-1)
            if lo <= hi:
                wc = np.float64(ec + lc - cy * lo)
                wa = np.float64(ea + la - ay * lo)
                z0 = k0 + (wc * d1 + wa * d2)
                row = np.uint64(y - top)
                for n in range(hi + 1 - lo):
                    x = np.uint64(left + lo + n)
                    z = z0 + np.float64(n) * step
                    old = depth[row, x]
                    take = z > old or (z == old and me < ids[row, x])
                    if mode != SURFACE:
                        if mode == LAYER:
                            u, v = front_depth[row, x], solid_depth[row, x]
                            take = take and (z < u or (z == u and me > front_ids[row, x]))
                            take = take and (z > v or (z == v and me < solid_ids[row, x]))
                        else:
                            shown = ids[row, x]
                            take = shown >= 0 and plane[shown] == plane[lies_on[me]]
                    if take:
                        depth[row, x] = z
                        ids[row, x] = me
            ea += ax
            eb += bx
            ec += cx


@kernel("i4[:,:]; u1[:]")
def mark(ids, seen):
    """seen[id + 1] = 1 for every id in a band of the visibility buffer; seen[0] stands for nothing."""
    for y in range(ids.shape[0]):
        for x in range(ids.shape[1]):
            seen[np.uint32(ids[y, x] + 1)] = 1


@kernel("i8; i8; i4[:,:]; f8[:,:]; u1[:]")
def turn(start, stop, faces, h, seen):
    """Of the faces *start* … *stop* that are seen, those that show their back get 2: seen (F,)."""
    for f in range(start, stop):
        if seen[f]:
            i, j, k = np.uint64(faces[f, 0]), np.uint64(faces[f, 1]), np.uint64(faces[f, 2])
            a = h[j, 1] * h[k, 2] - h[j, 2] * h[k, 1]
            b = h[j, 2] * h[k, 0] - h[j, 0] * h[k, 2]
            c = h[j, 0] * h[k, 1] - h[j, 1] * h[k, 0]
            seen[f] = 1 if h[i, 0] * a + h[i, 1] * b + h[i, 2] * c < 0.0 else 2
