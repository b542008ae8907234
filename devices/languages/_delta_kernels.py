"""PCL's delta rows (compression mode 3): what has changed since the row before.

A command byte holds in its upper three bits how many bytes are replaced, less one, and in its lower
five how many are left as they are before them; 31 says that bytes follow which are added to it, the
last of them being the first below 255.
"""

import numpy as np

from halftone._jit import kernel


@kernel("u1[:,:]; u1[:]; u1[:]; i8[:]")
def delta_rows(rows, seed, out, ends):
    """The commands of every row one after another into *out*; row r ends before ends[r].

    rows : (n, size). seed : (size,), the row before the first. out : n·(size + ⌈size/8⌉) bytes are
    enough: only a command that follows a full one leaves nothing as it is.
    """
    size = rows.shape[1]
    place = 0
    for r in range(rows.shape[0]):
        free = 0  # the first byte that no command has reached
        x = 0
        while x < size:
            before = seed[x] if r == 0 else rows[r - 1, x]
            if rows[r, x] == before:
                x += 1
                continue
            skip = x - free
            command = place
            place += 1
            first = skip
            if skip >= 31:
                first = 31
                skip -= 31
                while skip >= 255:
                    out[place] = 255
                    place += 1
                    skip -= 255
                out[place] = np.uint8(skip)
                place += 1
            count = 0
            while x < size and count < 8:
                before = seed[x] if r == 0 else rows[r - 1, x]
                if rows[r, x] == before:
                    break
                out[place] = rows[r, x]
                place += 1
                count += 1
                x += 1
            out[command] = np.uint8((count - 1) * 32 + first)
            free = x
        ends[r] = place
