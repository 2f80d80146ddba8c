"""One thread for linear algebra, which must be asked for before NumPy is loaded.

BLAS shares large products among threads. Their number then shows in the last digits of a result, and threads that wait
for the next product take a core from another process: with two, scoring took half as much CPU time again, and no less
time.
"""

from __future__ import annotations

import os

VARIABLES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def one_thread() -> None:
    """In this process and those that it starts, unless its user asked for more.

    To OpenBLAS only OPENBLAS_NUM_THREADS says so: OMP_NUM_THREADS, which batch systems set for every job, is no wish.
    """
    for name in VARIABLES:
        os.environ.setdefault(name, "1")
