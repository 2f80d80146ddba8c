"""How every inner loop of the dense flow is compiled.

LLVM vectorises a loop only if it starts at 0, indexes one-dimensional contiguous rows without a sign to check, and
cannot raise; hence rows as arguments and NumPy's division.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from casr.errors import SettingError

try:
    from numba import njit
except ModuleNotFoundError as error:
    raise SettingError(
        "flow engine horn-schunck",
        wanted="the package numba, which compiles this engine",
        found="no such package",
        do="Install it (pip install 'emg2vsa[flow]'), or choose another engine: pin-affine or dis.",
    ) from error

Function = TypeVar("Function", bound=Callable[..., Any])
Floats = NDArray[np.floating[Any]]
Rows = tuple[Floats, ...]

# reordering and contraction, but nothing that may assume there is no NaN
FAST_MATH = {"contract", "reassoc", "nsz", "arcp"}


def kernel(function: Function) -> Function:
    """Compile on first use, for each floating type, and keep the result on disk."""
    return cast(Function, njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)(function))
