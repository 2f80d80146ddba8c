"""Products of matrices that give the same bytes on any number of cores: none is shared among the threads of BLAS.

Threads share large products, and kernels of some processors round otherwise at the edge of a share. So a product is
made in parts, each too small to be shared; whole parts also stay in the processor's cache.
"""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats

OF_MATRICES = 2**18
"Multiplications up to which OpenBLAS leaves matrix times matrix to one thread: 65 536 x GEMM_MULTITHREAD_THRESHOLD, 4."
OF_A_VECTOR = 9216
"The same of matrix times vector, which the last row of a product may be: 2304 x that."
LONGEST = 4096
"Products of two vectors beyond 10 000 are shared."


def times(rows: Floats, matrix: Floats) -> Floats:
    """rows (m, n, p) times matrix (p, q)."""
    (m, n, p), q = rows.shape, matrix.shape[1]
    if p > LONGEST:
        return times(rows[..., :LONGEST], matrix[:LONGEST]) + times(rows[..., LONGEST:], matrix[LONGEST:])
    product = np.empty((m, n, q))
    width = OF_A_VECTOR // max(p, 1)
    if q <= width:
        _fill(product, rows, matrix)
        return product
    for left in range(0, q, width):
        columns = slice(left, left + width)
        _fill(product[..., columns], rows, matrix[:, columns])
    return product


def _fill(product: Floats, rows: Floats, matrix: Floats) -> None:
    """All of it, some rows at a time: a multiple of 16, what BLAS computes at once, where they are more."""
    (m, n, p), q = rows.shape, matrix.shape[1]
    at_once = max(1, (OF_A_VECTOR if q == 1 else OF_MATRICES) // max(matrix.size, 1))
    if at_once > 16:
        at_once -= at_once % 16
    whole = n - n % at_once
    if whole:
        parts = rows[:, :whole].reshape(m, -1, at_once, p)
        np.matmul(parts, matrix, out=product[:, :whole].reshape(m, -1, at_once, q))
    if whole < n:
        np.matmul(rows[:, whole:], matrix, out=product[:, whole:])
