"""One thread for everybody: processor time adds threads up, so a threaded way would look slower than it is."""

from __future__ import annotations

import os
import sys

VARIABLES = (
    "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS", "NUMEXPR_NUM_THREADS",
    "NUMBA_NUM_THREADS", "POLARS_MAX_THREADS",
)  # fmt: skip


def one_thread_environment() -> dict[str, str]:
    """The environment of a child process whose libraries take one thread."""
    return os.environ | dict.fromkeys(VARIABLES, "1")


def pin_loaded() -> None:
    """One thread for the libraries that count threads of their own and are already loaded."""
    if "cv2" in sys.modules:
        sys.modules["cv2"].setNumThreads(1)
    if "torch" in sys.modules:
        sys.modules["torch"].set_num_threads(1)
