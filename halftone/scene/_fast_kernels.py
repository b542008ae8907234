"""Kernels of fast Phong shading (Bishop & Weimer, SIGGRAPH 86): N·D as a polynomial of the pixel.

The normal at pixel (x, y), before it is brought to length 1, is linear in x and y (also in
perspective, see _shade_kernels), so that with X, Y counted from the projected centroid

    N·D = (aX + bY + c) / √(dX² + eXY + fY² + gX + hY + i)  ≈  T5X² + T4XY + T3Y² + T2X + T1Y + T0.
"""

import math

import numpy as np

from halftone._jit import kernel, part

__all__ = ["expand", "forward"]


@part
def taylor(a, b, c, d, e, f, g, h, i):
    """T0 … T5 of (aX + bY + c)/√(dX² + eXY + fY² + gX + hY + i) about X = Y = 0."""
    root = 1.0 / math.sqrt(i)
    one = root / i
    t0 = c * root
    t1 = (2.0 * b * i - c * h) * 0.5 * one
    t2 = (2.0 * a * i - c * g) * 0.5 * one
    two = one / i * 0.125
    t3 = (3.0 * c * h * h - 4.0 * c * f * i - 4.0 * b * h * i) * two
    t4 = (3.0 * c * g * h - 2.0 * c * e * i - 2.0 * b * g * i - 2.0 * a * h * i) * (2.0 * two)
    t5 = (3.0 * c * g * g - 4.0 * c * d * i - 4.0 * a * g * i) * two
    return t0, t1, t2, t3, t4, t5


@part
def unit3(x, y, z):
    """x, y, z brought to length 1; (0, 0, 0) stays."""
    over = 1.0 / math.sqrt(x * x + y * y + z * z + 1e-300)
    return x * over, y * over, z * over


@kernel(
    "i4[:]; i8; i8; u1[:]; i4[:,:]; i4[:,:]; f8[:,:]; f4[:,:]; i4[:]; u1[:]; f8[:,:]; f8[:]; u1; f8; f8;"
    "f8[:,:]; f8[:,:,:]; u1[:]"
)
def expand(
    visible, start, stop, seen, faces, corners, h, attributes, materials, two_sided, lights, eye, mirror,
    least, steep, centre, table, exact,
):  # fmt: skip
    """The polynomials of visible[start:stop], at their places in *table*.

    lights : (L, 4), x, y, z, w of each, w = 0 for a direction. eye : likewise. mirror : whether the
    highlight is V·R, else N·H. least : cosine of the largest angle between two normals of a face, and
    steep the largest ratio of the corners' distances, for which it is expanded; exact[s] = 1 for
    others. centre : (S, 2), the projected centroids. table : (L, S, 13): N·L; N·H or N·V; L·V.
    """
    for s in range(start, stop):
        f = visible[s]
        exact[s] = 1
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        wa, wb, wc = h[i, 2], h[j, 2], h[k, 2]
        low = wa if wa < wb else wb
        low = wc if wc < low else low
        high = wa if wa > wb else wb
        high = wc if wc > high else high
        if not (low > 0.0 and high <= steep * low):
            continue
        c0, c1, c2 = corners[f, 0], corners[f, 1], corners[f, 2]
        n0x, n0y, n0z = (
            np.float64(attributes[c0, 3]),
            np.float64(attributes[c0, 4]),
            np.float64(attributes[c0, 5]),
        )
        n1x, n1y, n1z = (
            np.float64(attributes[c1, 3]),
            np.float64(attributes[c1, 4]),
            np.float64(attributes[c1, 5]),
        )
        n2x, n2y, n2z = (
            np.float64(attributes[c2, 3]),
            np.float64(attributes[c2, 4]),
            np.float64(attributes[c2, 5]),
        )
        if not (
            n0x * n1x + n0y * n1y + n0z * n1z >= least
            and n1x * n2x + n1y * n2y + n1z * n2z >= least
            and n2x * n0x + n2y * n0y + n2z * n0z >= least
        ):
            continue
        ax, ay, bx, by, cx, cy = h[i, 0], h[i, 1], h[j, 0], h[j, 1], h[k, 0], h[k, 1]
        w = (wa + wb + wc) / 3.0
        xc = (ax + bx + cx) / 3.0 / w
        yc = (ay + by + cy) / 3.0 / w
        # The weights' slopes in x and y, where each weight is 1 at the centroid.
        ux, uy = by * wc - wb * cy, wb * cx - bx * wc
        vx, vy = cy * wa - wc * ay, wc * ax - cx * wa
        tx, ty = ay * wb - wa * by, wa * bx - ax * wb
        det = ax * ux + ay * uy + wa * (bx * cy - by * cx)
        if det == 0.0:
            continue
        scale = 3.0 * w / det
        side = 1.0
        if seen[f] == 2:
            side = -1.0 if two_sided[materials[f]] else 0.0
        px = side * (n0x + n1x + n2x)
        py = side * (n0y + n1y + n2y)
        pz = side * (n0z + n1z + n2z)
        scale *= side
        qx = scale * (ux * n0x + vx * n1x + tx * n2x)
        qy = scale * (ux * n0y + vx * n1y + tx * n2y)
        qz = scale * (ux * n0z + vx * n1z + tx * n2z)
        rx = scale * (uy * n0x + vy * n1x + ty * n2x)
        ry = scale * (uy * n0y + vy * n1y + ty * n2y)
        rz = scale * (uy * n0z + vy * n1z + ty * n2z)
        ii = px * px + py * py + pz * pz
        if ii == 0.0 and side != 0.0:
            continue
        exact[s] = 0
        centre[s, 0], centre[s, 1] = xc, yc
        if side == 0.0:
            for n in range(lights.shape[0]):
                for m in range(13):
                    table[n, s, m] = 0.0
            continue
        d = qx * qx + qy * qy + qz * qz
        e = 2.0 * (qx * rx + qy * ry + qz * rz)
        ff = rx * rx + ry * ry + rz * rz
        g = 2.0 * (px * qx + py * qy + pz * qz)
        hh = 2.0 * (px * rx + py * ry + pz * rz)
        sx = (
            np.float64(attributes[c0, 0]) + np.float64(attributes[c1, 0]) + np.float64(attributes[c2, 0])
        ) / 3.0
        sy = (
            np.float64(attributes[c0, 1]) + np.float64(attributes[c1, 1]) + np.float64(attributes[c2, 1])
        ) / 3.0
        sz = (
            np.float64(attributes[c0, 2]) + np.float64(attributes[c1, 2]) + np.float64(attributes[c2, 2])
        ) / 3.0
        ex, ey, ez = unit3(eye[0] - eye[3] * sx, eye[1] - eye[3] * sy, eye[2] - eye[3] * sz)
        for n in range(lights.shape[0]):
            lx, ly, lz = unit3(
                lights[n, 0] - lights[n, 3] * sx, lights[n, 1] - lights[n, 3] * sy,
                lights[n, 2] - lights[n, 3] * sz,
            )  # fmt: skip
            t0, t1, t2, t3, t4, t5 = taylor(
                lx * qx + ly * qy + lz * qz, lx * rx + ly * ry + lz * rz, lx * px + ly * py + lz * pz,
                d, e, ff, g, hh, ii,
            )  # fmt: skip
            table[n, s, 0], table[n, s, 1], table[n, s, 2] = t0, t1, t2
            table[n, s, 3], table[n, s, 4], table[n, s, 5] = t3, t4, t5
            table[n, s, 12] = lx * ex + ly * ey + lz * ez
            mx, my, mz = ex, ey, ez
            if not mirror:
                mx, my, mz = unit3(lx + ex, ly + ey, lz + ez)
            t0, t1, t2, t3, t4, t5 = taylor(
                mx * qx + my * qy + mz * qz, mx * rx + my * ry + mz * rz, mx * px + my * py + mz * pz,
                d, e, ff, g, hh, ii,
            )  # fmt: skip
            table[n, s, 6], table[n, s, 7], table[n, s, 8] = t0, t1, t2
            table[n, s, 9], table[n, s, 10], table[n, s, 11] = t3, t4, t5


@kernel("i4[:,:]; f8; f8; f8; i4[:]; f8[:,:]; f8[:,:]; u1; f4[:]; f4[:]")
def forward(ids, x0, y0, pitch, slot, centre, table, mirror, incidence, highlight):
    """The polynomials of one light along the rows of a band, by forward differences: two additions a
    pixel each. incidence, highlight : (K,), N·L and N·H (or V·R = 2(N·L)(N·V) − L·V).
    """
    width = ids.shape[1]
    done = 0
    for row in range(ids.shape[0]):
        y = y0 + pitch * np.float64(row)
        x = 0
        while x < width:
            f = ids[row, x]
            if f < 0:
                x += 1
                continue
            end = x + 1
            while end < width and ids[row, end] == f:
                end += 1
            s = slot[f]
            u = x0 + pitch * np.float64(x) - centre[s, 0]
            v = y - centre[s, 1]
            a = ((table[s, 5] * u + table[s, 4] * v) + table[s, 2]) * u + (
                (table[s, 3] * v + table[s, 1]) * v + table[s, 0]
            )
            da = (table[s, 5] * (2.0 * u + pitch) + (table[s, 4] * v + table[s, 2])) * pitch
            dda = 2.0 * table[s, 5] * pitch * pitch
            b = ((table[s, 11] * u + table[s, 10] * v) + table[s, 8]) * u + (
                (table[s, 9] * v + table[s, 7]) * v + table[s, 6]
            )
            db = (table[s, 11] * (2.0 * u + pitch) + (table[s, 10] * v + table[s, 8])) * pitch
            ddb = 2.0 * table[s, 11] * pitch * pitch
            both = table[s, 12]
            for n in range(end - x):
                at = np.uint64(done + n)
                incidence[at] = np.float32(a)
                highlight[at] = np.float32(2.0 * a * b - both if mirror else b)
                a += da
                da += dda
                b += db
                db += ddb
            done += end - x
            x = end
