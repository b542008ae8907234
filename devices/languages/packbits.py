"""PackBits, the run-length code of TIFF, as Brother's printers and PCL's mode 2 take it.

Source: TIFF revision 6.0, section 9.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from devices.languages.reader import Reader

__all__ = ["packed_rows", "unpacked"]


def packed_rows(rows: NDArray[np.uint8], *, trim: bool = False) -> tuple[bytes, list[int]]:
    """The packets of all rows (n, size), and where those of each row begin and the last end: n + 1.

    trim : leave out the zeros at the end of a row. At most size + ⌈size/128⌉ bytes a row.
    """
    from devices.languages._packbits_kernels import pack_rows

    n, size = rows.shape
    out = np.empty(n * (size + (size + 127) // 128), np.uint8)
    ends = np.zeros(n + 1, np.int64)
    pack_rows(np.ascontiguousarray(rows), out, ends[1:], int(trim))
    return out[: ends[-1]].tobytes(), ends.tolist()


def unpacked(reader: Reader, size: int, most: int) -> bytes:
    """The row in the next *size* bytes of the reader, of at most *most* bytes.

    A control byte of 128 stands for nothing. Fails at the packet that has too few or makes too many
    bytes.
    """
    start = reader.place
    packed = reader.take(size, "a PackBits row")
    row, place = bytearray(), 0
    while place < size:
        control = packed[place]
        place += 1
        if control == 128:
            continue
        count = control + 1 if control < 128 else 257 - control
        step = count if control < 128 else 1
        if place + step > size:
            reader.fail(f"a PackBits packet of {step} bytes with {size - place} left", start + place - 1)
        if len(row) + count > most:
            reader.fail(f"a PackBits row of more than {most} bytes", start + place - 1)
        row += packed[place : place + step] * (count // step)
        place += step
    return bytes(row)
