"""ZPL's alternative data compression ("ACS"): rows of dots as text, many rows a call.

Source: ZPL II Programming Guide, "Alternative Data Compression Scheme".
"""

from halftone._jit import kernel


@kernel("u1[:,:]; u1[:]; i8[:]")
def acs(rows, out, ends):
    """*rows* (n, bytes a row) as text into *out*; where the text of each row ends into *ends* (n).

    out : 2 bytes for every byte of the rows; a row never takes more.

    Each row is coded for itself, and the first row without the one before it:

    1. whole bytes of paper at its end are one ``,``;
    2. if that is not all, and the row is the same as the one above, it is one ``:``;
    3. what is left are runs of hexadecimal digits. One or two are written out; more are a count and
       the digit: ``z`` for each 400, then ``g`` … ``y`` for 20 … 380, then ``G`` … ``Y`` for 1 … 19.

    No shorter text of the row is safe. ``!`` fills a row "with ones (1)": some readers take that as
    ink, others as hexadecimal digits 1. Counts that go on into the next row are not in the guide.
    """
    count, size = rows.shape
    at = 0
    for r in range(count):
        last = size
        while last > 0 and rows[r, last - 1] == 0:
            last -= 1
        paper = last < size
        same = r > 0 and last > 0
        b = 0
        while same and b < size:
            same = rows[r, b] == rows[r - 1, b]
            b += 1
        if same:
            out[at] = 58  # :
            at += 1
            last = 0
            paper = False
        i = 0
        while i < 2 * last:
            digit = rows[r, i >> 1] & 15 if i & 1 else rows[r, i >> 1] >> 4
            run = 1
            i += 1
            while i < 2 * last and digit == (rows[r, i >> 1] & 15 if i & 1 else rows[r, i >> 1] >> 4):
                run += 1
                i += 1
            code = digit + 48 if digit < 10 else digit + 55
            if run == 2:
                out[at] = code
                at += 1
            elif run > 2:
                while run >= 400:
                    out[at] = 122  # z
                    at += 1
                    run -= 400
                if run >= 20:
                    out[at] = 102 + run // 20
                    at += 1
                if run % 20:
                    out[at] = 70 + run % 20
                    at += 1
            out[at] = code
            at += 1
        if paper:
            out[at] = 44  # ,
            at += 1
        ends[r] = at
