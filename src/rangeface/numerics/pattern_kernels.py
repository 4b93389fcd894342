"""Kernels of the local binary patterns: any circle, and the eight neighbours at distance 1.

The second is the paper's operator. Its diagonal neighbours are interpolated between pixels that
are neighbours themselves, so one pass over three rows has all eight.
"""

from __future__ import annotations

import numpy as np
from numba import njit

SIDE = np.float32(0.70711 * (1.0 - 0.70711))
CORNER = np.float32(0.70711 * 0.70711)
"""Bilinear weights of a diagonal neighbour at distance 1, coordinates rounded as for any circle."""


@njit(cache=True, nogil=True)
def label(code, points, method):  # type: ignore[no-untyped-def]
    """Label of one code: 0 basic, 1 u2, 2 ri, 3 riu2."""
    if method == 0:
        return code
    everything = (1 << points) - 1
    if method == 2:
        smallest, turned = code, code
        for _ in range(points - 1):
            turned = (turned >> 1) | ((turned & 1) << (points - 1))
            smallest = min(smallest, turned)
        return smallest
    # bit k of `starts`: the run of ones begins at neighbour k
    starts = code & ~((code << 1) | (code >> (points - 1))) & everything
    ones = 0
    for k in range(points):
        ones += (code >> k) & 1
    uniform = (starts & (starts - 1)) == 0
    if method == 3:
        return ones if uniform else points + 1
    if not uniform:
        return points * (points - 1) + 2
    if ones == 0:
        return 0
    if ones == points:
        return points * (points - 1) + 1
    rotation = 0
    while (starts >> rotation) & 1 == 0:
        rotation += 1
    return 1 + (ones - 1) * points + rotation


@njit(cache=True, nogil=True)
def fill_labels(table, points, method):  # type: ignore[no-untyped-def]
    """Label of every code, one after the other."""
    for code in range(table.size):
        table[code] = label(code, points, method)


@njit(cache=True, nogil=True)
def _place(image, margin, framed):  # type: ignore[no-untyped-def]
    """Copy the image into its frame of NaN: beyond the edge everything is missing."""
    for v in range(len(image)):
        source, target = image[v], framed[margin + v, margin:]
        for u in range(source.size):
            target[u] = source[u]


@njit(cache=True, nogil=True)
def _difference(framed, margin, offsets, weights, d):  # type: ignore[no-untyped-def]
    """Interpolated differences between one neighbour and the centre, over the whole image."""
    stride, flat, length = framed.shape[1], framed.ravel(), d.size
    first = margin * (stride + 1)
    shift = first + offsets[:, 0] * stride + offsets[:, 1]
    centre = flat[first : first + length]
    tap0, tap1 = flat[shift[0] : shift[0] + length], flat[shift[1] : shift[1] + length]
    tap2, tap3 = flat[shift[2] : shift[2] + length], flat[shift[3] : shift[3] + length]
    w0, w1, w2, w3 = weights
    if max(w0, w1, w2, w3) == 1:
        for x in range(length):
            d[x] = tap0[x] - centre[x]
    else:
        for x in range(length):
            c = centre[x]
            # row by row, so that rows which cancel do so exactly: a tie stays a tie
            upper = w0 * (tap0[x] - c) + w1 * (tap1[x] - c)
            lower = w2 * (tap2[x] - c) + w3 * (tap3[x] - c)
            d[x] = upper + lower


@njit(cache=True, nogil=True)
def lbp(images, offsets, weights, table, method, labels):  # type: ignore[no-untyped-def]
    """Labels on any circle, one pass over the image a neighbour."""
    n, height, width = images.shape
    points = len(offsets)
    margin = np.abs(offsets).max()
    framed = np.full((height + 2 * margin, width + 2 * margin), np.float32(np.nan))
    stride = framed.shape[1]
    d = np.empty((height - 1) * stride + width, np.float32)
    codes = np.empty(d.size, np.int32)
    for i in range(n):
        _place(images[i], margin, framed)
        codes[:] = 0
        for k in range(points):
            _difference(framed, margin, offsets[k], weights[k], d)
            bit = np.int32(1 << k)
            for x in range(d.size):
                # not (d < 0) is also true of NaN: missing is level
                codes[x] |= np.int32(0) if d[x] < 0 else bit
        for v in range(height):
            row, target = codes[v * stride : v * stride + width], labels[i, v]
            if table.size:
                for u in range(width):
                    target[u] = table[row[u]]
            else:
                for u in range(width):
                    target[u] = label(np.int64(row[u]), points, method)


@njit(cache=True, nogil=True)
def tdlbp(images, offsets, weights, per_unit, layers):  # type: ignore[no-untyped-def]
    """The four layers on any circle of eight neighbours."""
    n, height, width = images.shape
    margin = np.abs(offsets).max()
    framed = np.full((height + 2 * margin, width + 2 * margin), np.float32(np.nan))
    stride = framed.shape[1]
    d = np.empty((height - 1) * stride + width, np.float32)
    codes = np.empty(d.size, np.uint32)  # four bytes: the codes of the four layers
    for i in range(n):
        _place(images[i], margin, framed)
        codes[:] = 0
        for k in range(8):
            _difference(framed, margin, offsets[k], weights[k], d)
            for x in range(d.size):
                codes[x] |= _digits(d[x], per_unit, 0) << np.uint32(k)
        _unpack(codes, stride, layers[i])


# ── the eight neighbours at distance 1 ───────────────────────────────────────────────────


@njit(cache=True, nogil=True, inline="always")
def _eight(above, here, below, x):  # type: ignore[no-untyped-def]
    """Differences to the neighbours 0 … 7 of pixel x + 1 of the row `here`.

    The two sides of a corner are summed first, so that sides which cancel do so exactly: a tie
    stays a tie.
    """
    c = here[x + 1]
    e, w, n, s = here[x + 2] - c, here[x] - c, above[x + 1] - c, below[x + 1] - c
    se, sw = SIDE * (e + s) + CORNER * (below[x + 2] - c), SIDE * (w + s) + CORNER * (below[x] - c)
    nw, ne = SIDE * (w + n) + CORNER * (above[x] - c), SIDE * (e + n) + CORNER * (above[x + 2] - c)
    return e, se, s, sw, w, nw, n, ne


@njit(cache=True, nogil=True, inline="always")
def _sign(d, bit):  # type: ignore[no-untyped-def]
    """The bit, unless d < 0; NaN is not: missing is level."""
    return np.uint32(0) if d < 0 else np.uint32(bit)


@njit(cache=True, nogil=True, inline="always")
def _digits(d, per_unit, k):  # type: ignore[no-untyped-def]
    """Sign and the three digits of the size, each bit k of a byte of its own."""
    units = abs(d) * per_unit
    units = units if units < np.float32(6.5) else np.float32(6.5)
    # three shifted copies at once; of each, one bit is kept, and of a missing difference none
    copies = np.uint32(np.int32(units + np.float32(0.5))) * np.uint32(0x01008040 << k)
    kept = np.uint32(0x01010100 << k) if d == d else np.uint32(0)
    return copies & kept | _sign(d, 1 << k)


@njit(cache=True, nogil=True)
def _frame_for(height, width):  # type: ignore[no-untyped-def]
    """Room for an image in a frame of NaN, one pixel wide."""
    framed = np.empty((height + 2, width + 2), np.float32)
    framed[0] = framed[-1] = np.nan
    for v in range(1, height + 1):
        framed[v, 0] = framed[v, -1] = np.nan
    return framed


@njit(cache=True, nogil=True)
def _signs_of_eight(flat, stride, codes):  # type: ignore[no-untyped-def]
    """Codes of a framed image; 32 bits wide like the differences, which keeps the loop fast."""
    above, here, below = flat, flat[stride:], flat[2 * stride :]
    for x in range(codes.size):
        e, se, s, sw, w, nw, n, ne = _eight(above, here, below, x)
        half = _sign(e, 1) | _sign(se, 2) | _sign(s, 4) | _sign(sw, 8)
        codes[x] = half | _sign(w, 16) | _sign(nw, 32) | _sign(n, 64) | _sign(ne, 128)


@njit(cache=True, nogil=True)
def _digits_of_eight(flat, stride, per_unit, codes):  # type: ignore[no-untyped-def]
    """Codes of the four layers of a framed image, each in a byte."""
    above, here, below = flat, flat[stride:], flat[2 * stride :]
    for x in range(codes.size):
        e, se, s, sw, w, nw, n, ne = _eight(above, here, below, x)
        first = _digits(e, per_unit, 0) | _digits(se, per_unit, 1)
        second = _digits(s, per_unit, 2) | _digits(sw, per_unit, 3)
        third = _digits(w, per_unit, 4) | _digits(nw, per_unit, 5)
        fourth = _digits(n, per_unit, 6) | _digits(ne, per_unit, 7)
        codes[x] = first | second | third | fourth


@njit(cache=True, nogil=True)
def _look_up(codes, stride, table, labels):  # type: ignore[no-untyped-def]
    """Labels of the codes in the lowest byte."""
    height, width = labels.shape
    for v in range(height):
        row, target = codes[v * stride : v * stride + width], labels[v]
        for u in range(width):
            target[u] = table[row[u] & np.uint32(255)]


@njit(cache=True, nogil=True)
def lbp_eight(images, table, labels):  # type: ignore[no-untyped-def]
    """Labels of the 8-neighbour code, R = 1, by table."""
    n, height, width = images.shape
    framed, stride = _frame_for(height, width), width + 2
    codes = np.empty((height - 1) * stride + width, np.uint32)
    for i in range(n):
        _place(images[i], 1, framed)
        _signs_of_eight(framed.ravel(), stride, codes)
        _look_up(codes, stride, table, labels[i])


@njit(cache=True, nogil=True)
def tdlbp_eight(images, per_unit, table, labels, layers):  # type: ignore[no-untyped-def]
    """The four layers of the 8-neighbour codes, R = 1; of the first also the labels, if asked."""
    n, height, width = images.shape
    framed, stride = _frame_for(height, width), width + 2
    codes = np.empty((height - 1) * stride + width, np.uint32)
    for i in range(n):
        _place(images[i], 1, framed)
        _digits_of_eight(framed.ravel(), stride, per_unit, codes)
        _unpack(codes, stride, layers[i])
        if labels.size:
            _look_up(codes, stride, table, labels[i])


@njit(cache=True, nogil=True, inline="always")
def _byte(code, shift):  # type: ignore[no-untyped-def]
    """One byte of a code; signed on its way, for which the processor has an instruction."""
    return np.float32(np.int32((code >> np.uint32(shift)) & np.uint32(255)))


@njit(cache=True, nogil=True)
def _unpack(codes, stride, layers):  # type: ignore[no-untyped-def]
    """The four bytes of the codes as four images."""
    _, height, width = layers.shape
    for v in range(height):
        row = codes[v * stride : v * stride + width]
        one, two, three, four = layers[0, v], layers[1, v], layers[2, v], layers[3, v]
        for u in range(width):
            one[u] = _byte(row[u], 0)
            two[u] = _byte(row[u], 8)
            three[u] = _byte(row[u], 16)
            four[u] = _byte(row[u], 24)
