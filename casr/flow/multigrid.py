"""Full multigrid for the linear system of Horn and Schunck, stored by colour so that every inner loop runs on SIMD lanes.

The unknown is one flow vector (u, v) per square cell. In every cell c, with n its neighbours left, right, above and below,

    lam * sum_n (u_n - u_c) = J11 u_c + J12 v_c + b1
    lam * sum_n (v_n - v_c) = J12 u_c + J22 v_c + b2

which is the Euler-Lagrange equation of Horn & Schunck (Artificial Intelligence 17, 1981, section 9) with the five-point
Laplacian; cells beyond the grid do not exist, so the flow's normal derivative is zero there.

A level is one array (7, 2, rows + 2, half + 2): the planes U, V, A11, A12, A22, B1, B2; the colour (0 where row + column is
even); a ring of zeros around the cells. A pair of neighbouring columns 2k, 2k + 1 holds one cell of each colour, both at
index k + 1, so the four neighbours of a cell of one colour lie at unit stride in the other.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from casr.flow.compiled import Floats, Rows, kernel

U, V, A11, A12, A22, B1, B2 = range(7)
PLANES = 7
COARSEST_CELLS = 4
COARSEST_SWEEPS = 16


def level_table(rows: int, columns: int) -> NDArray[np.int64]:
    """Rows, half the columns (rounded up) and offset of every level, finest first; a last row with the total size.

    A grid of odd width gets one more column, without data; the same holds at every coarser level.
    """
    table, offset = [], 0
    while True:
        half = (columns + 1) // 2
        table.append((rows, half, offset))
        offset += PLANES * 2 * (rows + 2) * (half + 2)
        if max(rows, columns) <= COARSEST_CELLS:
            return np.array([*table, (0, 0, offset)], dtype=np.int64)
        rows, columns = (rows + 1) // 2, half


@kernel
def level(work: Floats, table: NDArray[np.int64], index: int) -> Floats:
    rows, half, offset = table[index]
    shape = (PLANES, 2, rows + 2, half + 2)
    return work[offset : offset + PLANES * 2 * (rows + 2) * (half + 2)].reshape(shape)


@kernel
def _rows(f: Floats, c: int, y: int) -> tuple[Rows, Rows]:
    """Flow of the other colour above, below and on either side of row y (side[k] and side[k + 1]), u then v."""
    u, v, shift = f[U, 1 - c], f[V, 1 - c], (y - 1 + c) % 2
    return (u[y - 1], u[y + 1], u[y, shift:]), (v[y - 1], v[y + 1], v[y, shift:])


@kernel
def _cells(f: Floats, c: int, y: int) -> Rows:
    return f[A11, c, y], f[A12, c, y], f[A22, c, y], f[B1, c, y], f[B2, c, y]


@kernel
def _relax_row(
    half: int, u: Floats, v: Floats, around_u: Rows, around_v: Rows, cells: Rows, lam: float, rank_one: float
) -> None:
    up_u, down_u, side_u = around_u
    up_v, down_v, side_v = around_v
    a11, a12, a22, b1, b2 = cells
    for k in range(half):
        su = lam * ((up_u[k + 1] + down_u[k + 1]) + (side_u[k] + side_u[k + 1])) - b1[k + 1]
        sv = lam * ((up_v[k + 1] + down_v[k + 1]) + (side_v[k] + side_v[k + 1])) - b2[k + 1]
        product = a11[k + 1] * a22[k + 1]
        det = max(product - a12[k + 1] * a12[k + 1], rank_one * product)
        u[k + 1] = (a22[k + 1] * su - a12[k + 1] * sv) / det
        v[k + 1] = (a11[k + 1] * sv - a12[k + 1] * su) / det


@kernel
def _relax_colour(f: Floats, c: int, y: int, lam: float, rank_one: float) -> None:
    """Solve the two equations of every cell of colour c in row y for its (u, v), its neighbours held."""
    around_u, around_v = _rows(f, c, y)
    _relax_row(f.shape[3] - 2, f[U, c, y], f[V, c, y], around_u, around_v, _cells(f, c, y), lam, rank_one)


@kernel
def relax(f: Floats, lam: float, rank_one: float, sweeps: int) -> None:
    """Red-black Gauss-Seidel; the second colour follows one row behind, while its rows are still in the cache."""
    rows = f.shape[2] - 2
    for _ in range(sweeps):
        for y in range(1, rows + 2):
            if y <= rows:
                _relax_colour(f, 0, y, lam, rank_one)
            if y >= 2:
                _relax_colour(f, 1, y - 1, lam, rank_one)


@kernel
def _residual_row(
    half: int, u: Floats, v: Floats, around_u: Rows, around_v: Rows, cells: Rows, lam: float, ru: Floats, rv: Floats
) -> None:
    up_u, down_u, side_u = around_u
    up_v, down_v, side_v = around_v
    a11, a12, a22, b1, b2 = cells
    for k in range(half):
        su = lam * ((up_u[k + 1] + down_u[k + 1]) + (side_u[k] + side_u[k + 1])) - b1[k + 1]
        sv = lam * ((up_v[k + 1] + down_v[k + 1]) + (side_v[k] + side_v[k + 1])) - b2[k + 1]
        ru[k] += a11[k + 1] * u[k + 1] + a12[k + 1] * v[k + 1] - su
        rv[k] += a12[k + 1] * u[k + 1] + a22[k + 1] * v[k + 1] - sv


@kernel
def _add_residual(f: Floats, y: int, lam: float, ru: Floats, rv: Floats) -> None:
    """Add the residual of colour 0 in row y, negative, to ru and rv; colour 1, relaxed last, has none."""
    around_u, around_v = _rows(f, 0, y)
    _residual_row(f.shape[3] - 2, f[U, 0, y], f[V, 0, y], around_u, around_v, _cells(f, 0, y), lam, ru, rv)


@kernel
def put_row(plane: Floats, y: int, row: Floats) -> None:
    """Store a row in column order into row y of a plane (2, rows + 2, half + 2), by colour."""
    even, odd = plane[(y - 1) % 2, y], plane[y % 2, y]
    for k in range(even.size - 2):
        even[k + 1] = row[2 * k]
        odd[k + 1] = row[2 * k + 1]


@kernel
def restrict_residual(f: Floats, coarse: Floats, lam: float, rows2: Floats) -> None:
    """Residuals of four cells summed are the right-hand side of one coarser cell, whose flow starts at zero."""
    coarse[U], coarse[V] = 0, 0
    for y in range(1, coarse.shape[2] - 1):
        rows2[:] = 0
        for fine_y in range(2 * y - 1, min(2 * y + 1, f.shape[2] - 1)):
            _add_residual(f, fine_y, lam, rows2[0], rows2[1])
        put_row(coarse[B1], y, rows2[0])
        put_row(coarse[B2], y, rows2[1])


@kernel
def take_row(plane: Floats, y: int, near: int, row: Floats) -> None:
    """Three quarters of row y of a plane and a quarter of its row near, in column order, ends repeated.

    row[j + 1] is column j.
    """
    quarter = row.dtype.type(0.25)
    even, odd = plane[(y - 1) % 2, y], plane[y % 2, y]
    near_even, near_odd = plane[(near - 1) % 2, near], plane[near % 2, near]
    half = even.size - 2
    for k in range(half):
        row[2 * k + 1] = even[k + 1] + quarter * (near_even[k + 1] - even[k + 1])
        row[2 * k + 2] = odd[k + 1] + quarter * (near_odd[k + 1] - odd[k + 1])
    row[0], row[2 * half + 1] = row[1], row[2 * half]


@kernel
def near_row(y: int, coarse_rows: int) -> tuple[int, int]:
    """Coarse row over fine row y and the next nearest one that exists (array rows, from 1)."""
    over = (y + 1) // 2
    near = over - 1 if y % 2 == 1 else over + 1
    return over, min(max(near, 1), coarse_rows)


@kernel
def _add_row(out: Floats, row: Floats, side: int) -> None:
    quarter = row.dtype.type(0.25)
    next_over = row[2 * side :]
    for k in range(out.size - 2):
        out[k + 1] += row[k + 1] + quarter * (next_over[k] - row[k + 1])


@kernel
def prolong(coarse: Floats, f: Floats, rows2: Floats) -> None:
    """Add the bilinear flow of the coarser level to the flow of colour 1.

    Colour 0 needs nothing: the sweep that follows computes it from colour 1 alone.
    """
    for y in range(1, f.shape[2] - 1):
        over, near = near_row(y, coarse.shape[2] - 2)
        for p in range(2):
            take_row(coarse[p], over, near, rows2[p])
            _add_row(f[p, 1, y], rows2[p], y % 2)


@kernel
def _v_cycle(
    work: Floats, table: NDArray[np.int64], top: int, lam: float, rank_one: float, sweeps: int, rows2: Floats
) -> None:
    last = table.shape[0] - 2
    for i in range(top, last):
        f = level(work, table, i)
        relax(f, lam, rank_one, sweeps)
        restrict_residual(f, level(work, table, i + 1), lam, rows2)
    relax(level(work, table, last), lam, rank_one, COARSEST_SWEEPS)
    for i in range(last - 1, top - 1, -1):
        f = level(work, table, i)
        prolong(level(work, table, i + 1), f, rows2)
        relax(f, lam, rank_one, sweeps)


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
    """lam times the number of neighbours joins the diagonal."""
    rows, half = f.shape[2] - 2, f.shape[3] - 2
    for p in (A11, A22):
        for c in range(2):
            plane = f[p, c]
            for y in range(1, rows + 1):
                count = 2 + (y > 1) + (y < rows)
                diagonal = plane[y]
                for k in range(half):
                    diagonal[k + 1] += lam * count
                # a row's first cell is of the colour of its number, its last (the width is even) of the other
                if (y - 1 + c) % 2 == 0:
                    plane[y, 1] -= lam
                else:
                    plane[y, half] -= lam


@kernel
def solve(work: Floats, table: NDArray[np.int64], lam: float, rank_one: float, sweeps: int, cycles: int) -> None:
    """Fill U and V of the finest level from the data sums J11, J12, J22, b1, b2 in its planes A11 ... B2.

    Full multigrid: every level starts from the coarser level's solution. The planes A and B are used up.

    Parameters
    ----------
    work, table : the levels and :func:`level_table`.
    lam : weight of smoothness, alpha^2 / 3.
    rank_one : smallest determinant of a cell's 2 x 2 system, relative to its diagonal (rounding can lose it).
    sweeps : Gauss-Seidel sweeps before and after each correction.
    cycles : V-cycles per level.
    """
    last = table.shape[0] - 2
    rows2 = np.zeros((2, 2 * table[0, 1] + 4), work.dtype)
    for i in range(last):
        _sum_of_four(level(work, table, i), level(work, table, i + 1), rows2)
    for i in range(last + 1):
        _add_neighbours(level(work, table, i), lam)
    coarsest = level(work, table, last)
    coarsest[U], coarsest[V] = 0, 0
    relax(coarsest, lam, rank_one, COARSEST_SWEEPS)
    for top in range(last - 1, -1, -1):
        f = level(work, table, top)
        f[U], f[V] = 0, 0
        prolong(level(work, table, top + 1), f, rows2)
        for _ in range(cycles):
            _v_cycle(work, table, top, lam, rank_one, sweeps, rows2)
