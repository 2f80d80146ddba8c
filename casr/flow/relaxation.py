"""Red-black Gauss-Seidel for the equations of Horn and Schunck, both components of a cell at once, and its residual.

In every cell, with n its neighbours left, right, above and below that exist, and A11 = J11 + lam * their number,
A12 = J12, A22 = J22 + lam * their number,

    A11 u + A12 v = lam * sum of u_n - B1
    A12 u + A22 v = lam * sum of v_n - B2
"""

from __future__ import annotations

from casr.flow.coloured_grid import A11, A12, A22, B1, B2, U, V, neighbours
from casr.flow.compiled import Floats, Rows, kernel


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
def relax(f: Floats, lam: float, det_floor: float, sweeps: int) -> None:
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
def add_residual(f: Floats, y: int, lam: float, ru: Floats, rv: Floats) -> None:
    """Add left minus right side of the equations of colour 0 in array row y to ru and rv.

    Colour 1, relaxed last, has no residual.
    """
    _residual_row(f[U, 0, y], f[V, 0, y], neighbours(f, 0, y), _cells(f, 0, y), lam, ru, rv)
