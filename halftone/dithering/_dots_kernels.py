"""Dot diffusion: class by class, each pixel gathers what its neighbours of lower class send it.

Rows are kept apart by column of the tile: the shares of the pixels (y, cx), (y, cx + w),
(y, cx + 2w) … lie side by side with an empty place at either end, so that all pixels of one class
in a row are one contiguous run, and so are those of each of its neighbours. Indices as ``np.uint64``
are not tested for being negative; only without that test do these runs become vector code.
"""

import numpy as np

from halftone._jit import kernel


@kernel("f4[:,:]; f4[:]; i8")
def part_light(light, share, w):
    """*light* into *share*, row by row and column by column of the tile."""
    rows, width = light.shape
    span = (width + w - 1) // w + 2
    for r in range(rows):
        for cx in range(w if w < width else width):
            base = ((r + 1) * w + cx) * span + 1
            for t in range((width - cx + w - 1) // w):
                share[np.uint64(base + t)] = light[r, np.uint64(cx + t * w)]


@kernel("u1[:,:]; f4[:]; f4[:]; i8")
def part_codes(codes, known, share, w):
    """The same for 8-bit *codes* with the light *known* of each."""
    rows, width = codes.shape
    span = (width + w - 1) // w + 2
    for r in range(rows):
        for cx in range(w if w < width else width):
            base = ((r + 1) * w + cx) * span + 1
            for t in range((width - cx + w - 1) // w):
                share[np.uint64(base + t)] = known[codes[r, np.uint64(cx + t * w)]]


@kernel(
    "u1[:,:]; f4[:]; f4[:]; u1[:]; i8[:,:]; i8[:,:]; f4[:,:]; f4[:,:];"
    "f4[:]; f4[:]; u1[:]; u1[:]; f4; i8; i8; i8; i8; i8; i8"
)
def diffuse_dots(
    out, share, value, shown, cell, link, weight, rim,
    level, middle, index, bucket, scale, h, w, first, start, stop, height,
):  # fmt: skip
    """Level indices of rows *start* … *stop*−1 into *out*.

    share : the light of rows *first* … of height; there a pixel's light gives way to the share that
    each of its neighbours takes. Zeros around: (rows + 2)·w·(⌈width/w⌉ + 2).
    cell : for each class its row and column in the tile (h × w), the rows that an ascending chain
    from it reaches down and up, and how many neighbours are of lower class.
    link, weight : where in *share* those neighbours lie, counted from the pixel, and their weights,
    2 or 1, in raster order.
    rim : strength over the weights of the neighbours of higher class, in the columns of 1·(first
    row) + 2·(last row) + 4·(first column) + 8·(last column) of the picture.
    value, shown : ⌈width/w⌉ and (stop − start)·w·⌈width/w⌉ of work space.
    """
    width = out.shape[1]
    most = (width + w - 1) // w
    span = most + 2
    n = level.shape[0]
    darkest = level[0]
    lightest = level[n - 1]
    half = middle[0]
    dark = index[0]
    bright = index[n - 1]
    last = bucket.shape[0] - 1
    for c in range(cell.shape[0]):
        cy = cell[c, 0]
        cx = cell[c, 1]
        if cx >= width:
            continue
        count = (width - cx + w - 1) // w
        right = cx + (count - 1) * w == width - 1
        top = start - cell[c, 2]
        top = 0 if top < 0 else top
        bottom = stop + cell[c, 3]
        bottom = height if bottom > height else bottom
        y = top + (cy - top) % h
        while y < bottom:
            base = ((y - first + 1) * w + cx) * span + 1
            for t in range(count):
                value[t] = share[np.uint64(base + t)]
            for j in range(cell[c, 4]):
                place = base + link[c, j]
                part = weight[c, j]
                for t in range(count):
                    value[t] += part * share[np.uint64(place + t)]
            inside = start <= y and y < stop
            place = ((y - start) * w + cx) * most if inside else 0
            if n == 2:
                if inside:
                    for t in range(count):
                        shown[np.uint64(place + t)] = bright if value[t] >= half else dark
                for t in range(count):
                    v = value[t]
                    value[t] = v - lightest if v >= half else v - darkest
            else:
                for t in range(count):
                    v = value[t]
                    b = np.int64((v - darkest) * scale)
                    b = 0 if b < 0 else b
                    b = last if b > last else b
                    i = np.int64(bucket[b])
                    while i < n - 1 and v >= middle[i]:
                        i += 1
                    value[t] = v - level[i]
                    if inside:
                        shown[np.uint64(place + t)] = index[i]
            edge = (1 if y == 0 else 0) + (2 if y == height - 1 else 0)
            part = rim[c, edge]
            for t in range(count):
                share[np.uint64(base + t)] = value[t] * part
            left = 4 if cx == 0 else 0
            if left:
                share[base] = value[0] * rim[c, edge + 4]
            if right:
                both = left if count == 1 else 0
                share[base + count - 1] = value[count - 1] * rim[c, edge + 8 + both]
            y += h
    for r in range(stop - start):
        for cx in range(w if w < width else width):
            place = (r * w + cx) * most
            for t in range((width - cx + w - 1) // w):
                out[r, np.uint64(cx + t * w)] = shown[np.uint64(place + t)]


@kernel("i8[:]; i8[:]; i8[:,:]; f4[:]; f4[:,:]; u1[:,:]")
def diffuse_flats(order, rank, near, light, share, lit):
    """Dot diffusion of one tile that goes on for ever, to levels 0 and 1, for many flat tones at once.

    order : places by class; rank : its inverse; near : the eight neighbours of each place, in
    raster order. light : one tone for each column of *share* (work space) and *lit* (the result).
    """
    tones = light.shape[0]
    half = np.float32(0.5)
    one = np.float32(1.0)
    zero = np.float32(0.0)
    for k in range(order.shape[0]):
        c = order[k]
        total = np.int64(0)
        for t in range(tones):
            share[c, t] = light[t]
        for j in range(8):
            q = near[c, j]
            corner = j == 0 or j == 2 or j == 5 or j == 7
            if rank[q] < k:
                part = one if corner else one + one
                for t in range(tones):
                    share[c, t] += part * share[q, t]
            elif rank[q] > k:
                total += 1 if corner else 2
        rest = np.float32(1.0 / total) if total > 0 else zero
        for t in range(tones):
            v = share[c, t]
            up = v >= half
            lit[c, t] = 1 if up else 0
            share[c, t] = (v - one if up else v) * rest
