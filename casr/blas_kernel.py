"""Which kernel the BLAS of NumPy chose for this processor: with another one, results may differ in their last digits.

OpenBLAS, which comes with NumPy's packages, has kernels for many processors, and takes one when it is loaded;
OPENBLAS_CORETYPE overrules it. See docs/decisions/0031-processors.md.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from functools import cache
from pathlib import Path

UNKNOWN = "unknown"
"Name of the kernel of a BLAS that is no OpenBLAS, or that does not come with NumPy."
_NAMES = tuple(f"{before}openblas_get_corename{after}" for before in ("scipy_", "") for after in ("64_", ""))


@cache
def blas_kernel() -> str:
    """Such as SkylakeX or Haswell; NumPy itself is not loaded for it."""
    import ctypes  # a run that finds everything fresh does without it

    for path in _libraries():
        try:
            library = ctypes.CDLL(str(path))
        except OSError:
            continue
        for name in _NAMES:
            if ask := getattr(library, name, None):
                ask.restype = ctypes.c_char_p
                return str(ask().decode())
    return UNKNOWN


def _libraries() -> Iterator[Path]:
    """The libraries of OpenBLAS in the packages of NumPy for Linux, Windows and macOS."""
    found = importlib.util.find_spec("numpy")
    if found is not None and found.origin is not None:
        package = Path(found.origin).parent
        for folder in (package.parent / "numpy.libs", package / ".dylibs"):
            yield from sorted(folder.glob("*openblas*"))
