"""Data term of Horn and Schunck: derivatives of a pair of frames, multiplied and summed over square cells."""

from __future__ import annotations

from numba import njit

from casr.flow.multigrid import A11, FAST, PLANES, put_row


@njit(cache=True, nogil=True, fastmath=FAST)
def _add_products(first, second, y, sums):  # type: ignore[no-untyped-def]
    """Add Ix Ix, Ix Iy, Iy Iy, Ix It, Iy It of pixel row y to the five rows of sums."""
    kind = first.dtype.type
    near, far = kind(8 / 24), kind(-1 / 24)
    xx, xy, yy, xt, yt = sums[0], sums[1], sums[2], sums[3], sums[4]
    for x in range(2, first.shape[1] - 2):
        ix = near * ((first[y, x + 1] - first[y, x - 1]) + (second[y, x + 1] - second[y, x - 1])) + far * (
            (first[y, x + 2] - first[y, x - 2]) + (second[y, x + 2] - second[y, x - 2])
        )
        iy = near * ((first[y + 1, x] - first[y - 1, x]) + (second[y + 1, x] - second[y - 1, x])) + far * (
            (first[y + 2, x] - first[y - 2, x]) + (second[y + 2, x] - second[y - 2, x])
        )
        it = second[y, x] - first[y, x]
        xx[x] += ix * ix
        xy[x] += ix * iy
        yy[x] += iy * iy
        xt[x] += ix * it
        yt[x] += iy * it


@njit(cache=True, nogil=True)
def _add_pairs(row, out):  # type: ignore[no-untyped-def]
    for x in range(out.size // 2):
        out[x] = row[2 * x] + row[2 * x + 1]


@njit(cache=True, nogil=True)
def data_term(first, second, cell_px, f, sums):  # type: ignore[no-untyped-def]
    rows = f.shape[2] - 2
    last = first.shape[0] - 3
    for y in range(1, rows + 1):
        sums[:] = 0
        top = (y - 1) * cell_px
        for image_y in range(max(top, 2), min(top + cell_px - 1, last) + 1):
            _add_products(first, second, image_y, sums[0])
        for p in range(5):
            if cell_px == 1:
                put_row(f[A11 + p], y, sums[0, p])
            elif cell_px == 2:
                _add_pairs(sums[0, p], sums[1, p])
                put_row(f[A11 + p], y, sums[1, p])
            else:
                _add_pairs(sums[0, p], sums[1, p])
                _add_pairs(sums[1, p], sums[0, p])
                put_row(f[A11 + p], y, sums[0, p])
