"""The compression of PWG raster, CUPS raster (version 2) and URF: many lines in one call.

A line: how often it is repeated, less 1; then packets that fill it exactly. A packet: 0 … 127, and
one unit that is laid 1 … 128 times; 129 … 255, and 128 … 2 units as they are; 128, the rest is
paper. A unit is a pixel, or a byte where pixels are smaller.
"""

import numpy as np

from halftone._jit import kernel, part

FULL, MORE, LONG, LINES = 0, 1, 2, 3
"""Why :func:`unpack_lines` stopped: every row is laid; the data ends within a line (or before one); a
packet goes beyond the end of the line; a line is repeated beyond the end of the page."""


@part
def write_line(line, out, place):
    """The packets of *line*, in units of a byte, into *out* from *place* on; returns their end.

    Literals go on until three equal bytes come, since two save nothing: a line of n bytes takes
    at most n + n/128 + 1.
    """
    n = line.shape[0]
    i = 0
    while i < n:
        stop = i + 128 if i + 128 < n else n
        value = line[np.uint64(i)]
        j = i + 1
        while j < stop and line[np.uint64(j)] == value:
            j += 1
        if j == i + 1:
            while j < stop and not (
                j + 2 < n
                and line[np.uint64(j)] == line[np.uint64(j + 1)]
                and line[np.uint64(j)] == line[np.uint64(j + 2)]
            ):
                j += 1
            if j > i + 1:
                out[np.uint64(place)] = 257 - (j - i)
                for k in range(j - i):
                    out[np.uint64(place + 1 + k)] = line[np.uint64(i + k)]
                place += 1 + j - i
                i = j
                continue
        out[np.uint64(place)] = j - i - 1
        out[np.uint64(place + 1)] = value
        place += 2
        i = j
    return place


@kernel("u1[:,:]; u1[:]; u1[:]; i8[:]; i8")
def pack_lines(rows, last, out, state, finish):
    """Lines of *rows* into *out*; the last of them waits for more that are like it, unless *finish*.

    last : the line that waits. state : how often it came (in and out), then the bytes and the lines
    that were written (out). out : (1 + rows) · (n + n/128 + 2) bytes are always enough.
    """
    n = rows.shape[1]
    waiting = state[0]
    place = 0
    lines = 0
    for r in range(rows.shape[0]):
        same = 0 < waiting < 256
        x = 0
        while same and x < n:
            stop = x + 64 if x + 64 < n else n
            other = np.uint8(0)
            for k in range(x, stop):
                other |= rows[r, np.uint64(k)] ^ last[np.uint64(k)]
            same = other == 0
            x = stop
        if same:
            waiting += 1
            continue
        if waiting > 0:
            out[np.uint64(place)] = waiting - 1
            place = write_line(last, out, place + 1)
            lines += waiting
        for k in range(n):
            last[k] = rows[r, k]
        waiting = 1
    if finish != 0 and waiting > 0:
        out[np.uint64(place)] = waiting - 1
        place = write_line(last, out, place + 1)
        lines += waiting
        waiting = 0
    state[0] = waiting
    state[1] = place
    state[2] = lines


@kernel("u1[:]; u1[:,:]; u1[:]; i8[:]; i8; i8; i8")
def unpack_lines(data, rows, line, state, unit, paper, left):
    """Lines of *data* into *rows*, as many as are wanted and there as a whole.

    state, in and out: where the next line lies in *data*; rows that are laid; how often *line* is
    still to be laid; then, out: why it stopped, and where in *data* the fault is.
    unit : bytes of a unit; *line* has a multiple of it. paper : the byte that packet 128 lays.
    left : lines that the page has from the first of *rows* on. Nothing outside *data* is read
    and nothing outside *rows* and *line* written, whatever the bytes are.
    """
    size = line.shape[0]
    end = data.shape[0]
    place = state[0]
    row = state[1]
    again = state[2]
    why = FULL
    fault = 0
    while row < rows.shape[0]:
        if again > 0:
            for k in range(size):
                rows[row, k] = line[k]
            row += 1
            again -= 1
            continue
        if place >= end:
            why = MORE
            break
        count = np.int64(data[np.uint64(place)]) + 1
        if count > left - row:
            why = LINES
            fault = place
            break
        p = place + 1
        x = 0
        while x < size:
            if p >= end:
                why = MORE
                break
            packet = np.int64(data[np.uint64(p)])
            if packet == 128:
                for k in range(x, size):
                    line[np.uint64(k)] = paper
                p += 1
                x = size
                continue
            length = unit * (packet + 1 if packet < 128 else 257 - packet)
            given = unit if packet < 128 else length
            if length > size - x:
                why = LONG
                fault = p
                break
            p += 1
            if given > end - p:
                why = MORE
                break
            if packet > 128:
                for k in range(length):
                    line[np.uint64(x + k)] = data[np.uint64(p + k)]
            elif unit == 1:
                value = data[np.uint64(p)]
                for k in range(length):
                    line[np.uint64(x + k)] = value
            else:
                for k in range(unit):
                    line[np.uint64(x + k)] = data[np.uint64(p + k)]
                for k in range(unit, length):
                    line[np.uint64(x + k)] = line[np.uint64(x + k - unit)]
            p += given
            x += length
        if why != FULL:
            break
        place = p
        again = count
    state[0] = place
    state[1] = row
    state[2] = again
    state[3] = why
    state[4] = fault
