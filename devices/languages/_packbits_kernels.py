"""PackBits of many rows in one call.

A packet is a control byte c and data: 0 … 127 says that c + 1 bytes follow as they are, 129 … 255
that the byte which follows stands 257 − c times.
"""

import numpy as np

from halftone._jit import kernel


@kernel("u1[:,:]; u1[:]; i8[:]; i8")
def pack_rows(rows, out, ends, trim):
    """The packets of every row one after another into *out*; row r ends before ends[r].

    rows : (n, size). out : n·(size + ⌈size/128⌉) bytes are enough, since a run is made only of two
    equal bytes where no packet is open, and of three or more elsewhere. trim : 1 leaves out the
    zeros at the end of a row.
    """
    size = rows.shape[1]
    place = 0
    for r in range(rows.shape[0]):
        stop = size
        if trim == 1:
            while stop > 0 and rows[r, stop - 1] == 0:
                stop -= 1
        x = 0
        opened = np.int64(-1)  # where the control byte of the open packet of single bytes lies
        count = 0
        while x < stop:
            value = rows[r, x]
            run = 1
            while x + run < stop and run < 128 and rows[r, x + run] == value:
                run += 1
            if run > 2 or (run == 2 and opened < 0):
                out[place] = np.uint8(257 - run)
                out[place + 1] = value
                place += 2
                opened = -1
                x += run
                continue
            for _ in range(run):
                if opened < 0 or count == 128:
                    opened = place
                    place += 1
                    count = 0
                out[place] = value
                place += 1
                count += 1
                out[opened] = np.uint8(count - 1)
            x += run
        ends[r] = place
