"""Data term of Horn and Schunck: derivatives of a pair of frames, multiplied and summed over square cells."""

from __future__ import annotations

import numpy as np

from casr.flow.coloured_grid import A11, put_row
from casr.flow.compiled import Floats, Rows, kernel


@kernel
def _add_products(p: Rows, q: Rows, xx: Floats, xy: Floats, yy: Floats, xt: Floats, yt: Floats) -> None:
    """Add Ix Ix, Ix Iy, Iy Iy, Ix It, Iy It of the middle one of five rows p and q of the two frames."""
    p0, p1, p2, p3, p4 = p
    q0, q1, q2, q3, q4 = q
    near, far, zero = p0.dtype.type(8 / 24), p0.dtype.type(-1 / 24), p0.dtype.type(0)
    for x in range(xx.size):
        ix = near * ((p2[x + 3] - p2[x + 1]) + (q2[x + 3] - q2[x + 1])) + far * (
            (p2[x + 4] - p2[x]) + (q2[x + 4] - q2[x])
        )
        iy = near * ((p3[x + 2] - p1[x + 2]) + (q3[x + 2] - q1[x + 2])) + far * (
            (p4[x + 2] - p0[x + 2]) + (q4[x + 2] - q0[x + 2])
        )
        it = q2[x + 2] - p2[x + 2]
        # NaN, out of the frame after warping, in any of the seventeen pixels: no data
        if np.isnan(ix + iy + it):
            ix = iy = it = zero
        xx[x] += ix * ix
        xy[x] += ix * iy
        yy[x] += iy * iy
        xt[x] += ix * it
        yt[x] += iy * it


@kernel
def _five_rows(image: Floats, y: int, margin: int) -> Rows:
    inner = slice(margin - 2, image.shape[1] - margin + 2)
    return image[y - 2, inner], image[y - 1, inner], image[y, inner], image[y + 1, inner], image[y + 2, inner]


@kernel
def _add_pairs(row: Floats, out: Floats) -> None:
    for x in range(out.size // 2):
        out[x] = row[2 * x] + row[2 * x + 1]


@kernel
def _put_cells(row: Floats, spare: Floats, cell_px: int, plane: Floats, y: int) -> None:
    if cell_px == 1:
        put_row(plane, y, row)
        return
    _add_pairs(row, spare)
    if cell_px == 4:
        _add_pairs(spare, row)
        put_row(plane, y, row)
    else:
        put_row(plane, y, spare)


@kernel
def data_term(first: Floats, second: Floats, margin: int, cell_px: int, f: Floats, sums: Floats) -> None:
    """Fill the planes A11 ... B2 of the finest level with the sums over its cells, margin px at the edges left out."""
    rows = f.shape[2] - 2
    inner = slice(margin, max(first.shape[1] - margin, margin))
    for y in range(1, rows + 1):
        sums[:] = 0
        top = (y - 1) * cell_px
        for image_y in range(max(top, margin), min(top + cell_px, first.shape[0] - margin)):
            p, q, out = _five_rows(first, image_y, margin), _five_rows(second, image_y, margin), sums[0]
            _add_products(p, q, out[0, inner], out[1, inner], out[2, inner], out[3, inner], out[4, inner])
        for plane in range(5):
            _put_cells(sums[0, plane], sums[1, plane], cell_px, f[A11 + plane], y)
