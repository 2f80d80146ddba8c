"""The linear system of Horn and Schunck: its data term, and full multigrid relaxed by red-black Gauss-Seidel.

The data term is derivatives of a pair of frames, multiplied and summed over square cells. Both components of a cell are
solved at once. In every cell, with n its neighbours left, right, above and below that exist, and
A11 = J11 + lam * their number, A12 = J12, A22 = J22 + lam * their number,

    A11 u + A12 v = lam * sum of u_n - B1
    A12 u + A22 v = lam * sum of v_n - B2

Cells are joined four to one. Data sums and residuals add up; lam stays, for in two dimensions the sum of squared
differences between neighbours does not depend on the cell size. Flow comes back bilinearly between cell centres.
"""

from __future__ import annotations

import numpy as np

from casr.flow.coloured_grid import (
    A11,
    A12,
    A22,
    B1,
    B2,
    PLANES,
    Floats,
    Rows,
    Table,
    U,
    V,
    kernel,
    level,
    neighbours,
    put_row,
    take_row,
)


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
    """Fill the planes A11 ... B2 of the finest level with the sums over its cells, margin px at the edges left out
    (Horn and Schunck 1981, Artificial Intelligence 17, 185).

    first, second : frames (H, W). f : (7, 2, rows + 2, half + 2). sums : (2, 5, W), room to work in.
    """
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


@kernel
def _cells(f: Floats, c: int, y: int) -> Rows:
    return f[A11, c, y], f[A12, c, y], f[A22, c, y], f[B1, c, y], f[B2, c, y]


@kernel
def _relax_row(u: Floats, v: Floats, around: tuple[Rows, Rows], cells: Rows, lam: float, det_floor: float) -> None:
    (up_u, down_u, side_u), (up_v, down_v, side_v) = around
    a11, a12, a22, b1, b2 = cells
    for k in range(u.size - 2):
        su = lam * ((up_u[k + 1] + down_u[k + 1]) + (side_u[k] + side_u[k + 1])) - b1[k + 1]
        sv = lam * ((up_v[k + 1] + down_v[k + 1]) + (side_v[k] + side_v[k + 1])) - b2[k + 1]
        product = a11[k + 1] * a22[k + 1]
        det = max(product - a12[k + 1] * a12[k + 1], det_floor * product)
        u[k + 1] = (a22[k + 1] * su - a12[k + 1] * sv) / det
        v[k + 1] = (a11[k + 1] * sv - a12[k + 1] * su) / det


@kernel
def _relax(f: Floats, lam: float, det_floor: float, sweeps: int) -> None:
    """Sweep over colour 0, then 1; the second follows one row behind, while the rows are still in the cache."""
    rows = f.shape[2] - 2
    for _ in range(sweeps):
        for y in range(1, rows + 2):
            if y <= rows:
                _relax_row(f[U, 0, y], f[V, 0, y], neighbours(f, 0, y), _cells(f, 0, y), lam, det_floor)
            if y >= 2:
                _relax_row(f[U, 1, y - 1], f[V, 1, y - 1], neighbours(f, 1, y - 1), _cells(f, 1, y - 1), lam, det_floor)


@kernel
def _residual_row(
    u: Floats, v: Floats, around: tuple[Rows, Rows], cells: Rows, lam: float, ru: Floats, rv: Floats
) -> None:
    (up_u, down_u, side_u), (up_v, down_v, side_v) = around
    a11, a12, a22, b1, b2 = cells
    for k in range(u.size - 2):
        su = lam * ((up_u[k + 1] + down_u[k + 1]) + (side_u[k] + side_u[k + 1])) - b1[k + 1]
        sv = lam * ((up_v[k + 1] + down_v[k + 1]) + (side_v[k] + side_v[k + 1])) - b2[k + 1]
        ru[k] += a11[k + 1] * u[k + 1] + a12[k + 1] * v[k + 1] - su
        rv[k] += a12[k + 1] * u[k + 1] + a22[k + 1] * v[k + 1] - sv


@kernel
def _add_residual(f: Floats, y: int, lam: float, ru: Floats, rv: Floats) -> None:
    """Add left minus right side of the equations of colour 0 in array row y to ru and rv.

    Colour 1, relaxed last, has no residual.
    """
    _residual_row(f[U, 0, y], f[V, 0, y], neighbours(f, 0, y), _cells(f, 0, y), lam, ru, rv)


COARSEST_SWEEPS = 8


@kernel
def _restrict_residual(f: Floats, coarse: Floats, lam: float, rows2: Floats) -> None:
    """Residuals of four cells summed are the right-hand side of one coarser cell, whose flow starts at zero."""
    coarse[U], coarse[V] = 0, 0
    for y in range(1, coarse.shape[2] - 1):
        rows2[:] = 0
        for fine_y in range(2 * y - 1, min(2 * y + 1, f.shape[2] - 1)):
            _add_residual(f, fine_y, lam, rows2[0], rows2[1])
        put_row(coarse[B1], y, rows2[0])
        put_row(coarse[B2], y, rows2[1])


@kernel
def _add_row(out: Floats, row: Floats, side: int) -> None:
    quarter, beside = row.dtype.type(0.25), row[2 * side :]
    for k in range(out.size - 2):
        out[k + 1] += row[k + 1] + quarter * (beside[k] - row[k + 1])


@kernel
def _prolong(coarse: Floats, f: Floats, rows2: Floats) -> None:
    """Add the bilinear flow of the coarser level to the flow of colour 1.

    Colour 0 needs nothing: the sweep that follows computes it from colour 1 alone.
    """
    for y in range(1, f.shape[2] - 1):
        over = (y + 1) // 2
        near = min(max(over - 1 if y % 2 == 1 else over + 1, 1), coarse.shape[2] - 2)
        for p in range(2):
            take_row(coarse[p], over, near, rows2[p])
            _add_row(f[p, 1, y], rows2[p], y % 2)


@kernel
def _v_cycle(work: Floats, table: Table, top: int, lam: float, det_floor: float, sweeps: int, rows2: Floats) -> None:
    last = table.shape[0] - 2
    for i in range(top, last):
        f = level(work, table, i)
        _relax(f, lam, det_floor, sweeps)
        _restrict_residual(f, level(work, table, i + 1), lam, rows2)
    _relax(level(work, table, last), lam, det_floor, COARSEST_SWEEPS * sweeps)
    for i in range(last - 1, top - 1, -1):
        f = level(work, table, i)
        _prolong(level(work, table, i + 1), f, rows2)
        _relax(f, lam, det_floor, sweeps)


@kernel
def _sum_of_four(f: Floats, coarse: Floats, rows2: Floats) -> None:
    for p in range(A11, PLANES):
        for y in range(1, coarse.shape[2] - 1):
            total = rows2[0]
            total[:] = 0
            for fine_y in range(2 * y - 1, min(2 * y + 1, f.shape[2] - 1)):
                zero, one = f[p, 0, fine_y], f[p, 1, fine_y]
                for k in range(zero.size - 2):
                    total[k] += zero[k + 1] + one[k + 1]
            put_row(coarse[p], y, total)


@kernel
def _add_neighbours(f: Floats, lam: float) -> None:
    """Add lam times the number of neighbours to the diagonals."""
    rows, half = f.shape[2] - 2, f.shape[3] - 2
    for p in (A11, A22):
        for c in range(2):
            for y in range(1, rows + 1):
                diagonal, count = f[p, c, y], 2 + (y > 1) + (y < rows)
                for k in range(half):
                    diagonal[k + 1] += lam * count
                # the width is even: one colour holds the row's first cell, the other its last
                diagonal[1 if (y - 1 + c) % 2 == 0 else half] -= lam


@kernel
def solve(work: Floats, table: Table, lam: float, det_floor: float, sweeps: int, cycles: int) -> None:
    """Fill U and V of the finest level from the data sums J11, J12, J22, b1, b2 in its planes A11 ... B2 (used up).

    work, table : the levels; their ring of zeros is never written. lam : weight of smoothness.
    det_floor : smallest determinant of a cell's equations relative to the product of their diagonal.
    sweeps : Gauss-Seidel sweeps before and after each correction.
    cycles : V-cycles on every level, each of which starts from the solution of the coarser one.
    """
    last = table.shape[0] - 2
    rows2 = np.zeros((2, 2 * table[0, 1] + 4), work.dtype)
    for i in range(last):
        _sum_of_four(level(work, table, i), level(work, table, i + 1), rows2)
    for i in range(last + 1):
        _add_neighbours(level(work, table, i), lam)
    coarsest = level(work, table, last)
    coarsest[U], coarsest[V] = 0, 0
    _relax(coarsest, lam, det_floor, COARSEST_SWEEPS * sweeps)
    for top in range(last - 1, -1, -1):
        f = level(work, table, top)
        f[U], f[V] = 0, 0
        _prolong(level(work, table, top + 1), f, rows2)
        for _ in range(cycles):
            _v_cycle(work, table, top, lam, det_floor, sweeps, rows2)
