"""Compiled kernels, and grids of cells stored by colour, so that every inner loop of the solver runs on SIMD lanes.

LLVM vectorises a loop only if it starts at 0, indexes one-dimensional contiguous rows without a sign to check, and
cannot raise; hence rows as arguments and NumPy's division.

One level of the multigrid is an array (7, 2, rows + 2, half + 2): the planes U, V, A11, A12, A22, B1, B2; the colour,
0 where row + column is even; a ring of zeros around the cells. Columns 2 k and 2 k + 1 of a row hold one cell of each
colour, both at index k + 1: the four neighbours of a colour's cells lie at unit stride in the other colour.

All levels share one flat array; a table says where each begins.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from casr.errors import SettingError, install_extra

try:
    from numba import njit
except ModuleNotFoundError as error:
    raise SettingError(
        "flow engine horn-schunck", wanted="the package numba, which compiles this engine", found="no such package",
        do=f"Install it ({install_extra('flow')}), or choose another engine: pin-affine or dis.",
    ) from error  # fmt: skip

Function = TypeVar("Function", bound=Callable[..., Any])
Floats = NDArray[np.floating[Any]]
Rows = tuple[Floats, ...]

# reordering and contraction, but nothing that may assume there is no NaN
FAST_MATH = {"contract", "reassoc", "nsz", "arcp"}


def kernel(function: Function) -> Function:
    """Compile on first use, for each floating type, and keep the result on disk."""
    return cast(Function, njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)(function))


U, V, A11, A12, A22, B1, B2 = range(7)
PLANES = 7
COARSEST_CELLS = 4

Table = NDArray[np.int64]


def level_table(rows: int, columns: int) -> Table:
    """Rows, half the columns (rounded up) and offset of every level, finest first; a last row holds the total size.

    A grid of odd width gets one more column, without data; so does every coarser level.
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
def level(work: Floats, table: Table, index: int) -> Floats:
    """Planes of one level of the store (n,): a view (7, 2, rows + 2, half + 2)."""
    rows, half, offset = table[index]
    size = PLANES * 2 * (rows + 2) * (half + 2)
    return work[offset : offset + size].reshape((PLANES, 2, rows + 2, half + 2))


@kernel
def neighbours(f: Floats, c: int, y: int) -> tuple[Rows, Rows]:
    """Flow around colour c in array row y of planes (7, 2, rows + 2, half + 2), u then v: the rows above and below, and
    the row whose [k] and [k + 1] lie beside cell k."""
    u, v, shift = f[U, 1 - c], f[V, 1 - c], (y - 1 + c) % 2
    return (u[y - 1], u[y + 1], u[y, shift:]), (v[y - 1], v[y + 1], v[y, shift:])


@kernel
def put_row(plane: Floats, y: int, row: Floats) -> None:
    """Store a row in column order into array row y of a plane (2, rows + 2, half + 2)."""
    even, odd = plane[(y - 1) % 2, y], plane[y % 2, y]
    for k in range(even.size - 2):
        even[k + 1] = row[2 * k]
        odd[k + 1] = row[2 * k + 1]


@kernel
def take_row(plane: Floats, y: int, near: int, row: Floats) -> None:
    """Three quarters of array row y of a plane and a quarter of its row near; row[j + 1] is column j, ends repeated.

    plane : (2, rows + 2, half + 2). row : (2 half + 2,), is filled.
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
def flow_of_cells(f: Floats, out: Floats) -> None:
    """Copy the flow of a level into out, (rows, 2 half, 2)."""
    for y in range(out.shape[0]):
        u_even, u_odd = f[U, y % 2, y + 1], f[U, 1 - y % 2, y + 1]
        v_even, v_odd = f[V, y % 2, y + 1], f[V, 1 - y % 2, y + 1]
        row = out[y].reshape(-1)
        for k in range(u_even.size - 2):
            row[4 * k] = u_even[k + 1]
            row[4 * k + 1] = v_even[k + 1]
            row[4 * k + 2] = u_odd[k + 1]
            row[4 * k + 3] = v_odd[k + 1]


@kernel
def subtract_from_right(f: Floats, cells: Floats) -> None:
    """Subtract cells, (rows, 2 half, 2), from the right-hand sides B1, B2 of a level."""
    for y in range(cells.shape[0]):
        for p in range(2):
            even, odd, row = f[B1 + p, y % 2, y + 1], f[B1 + p, 1 - y % 2, y + 1], cells[y]
            for k in range(even.size - 2):
                even[k + 1] -= row[2 * k, p]
                odd[k + 1] -= row[2 * k + 1, p]
