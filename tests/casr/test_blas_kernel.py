"""The kernel of BLAS is the one that works in NumPy, as another library tells it, whichever is asked for."""

from __future__ import annotations

import os
import platform
import subprocess
import sys

import pytest

from casr.blas_kernel import UNKNOWN, blas_kernel

ASK = """
import sys
from casr.blas_kernel import blas_kernel
print(blas_kernel(), "numpy" in sys.modules)
import numpy, threadpoolctl
print({each.get("architecture") for each in threadpoolctl.threadpool_info() if "numpy" in each["filepath"]})
"""


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="these are kernels of x86-64")
@pytest.mark.skipif(blas_kernel() == UNKNOWN, reason="this NumPy has another BLAS")
def test_as_threadpoolctl_tells_it() -> None:
    told = set()
    for asked in ("", "Haswell", "Nehalem"):
        before = {key: value for key, value in os.environ.items() if key != "OPENBLAS_CORETYPE"}
        before |= {"OPENBLAS_CORETYPE": asked} if asked else {}
        done = subprocess.run([sys.executable, "-c", ASK], env=before, capture_output=True, text=True, check=True)
        kernel, loaded, other = done.stdout.split()
        assert (loaded, other) == ("False", f"{{'{kernel}'}}")
        told.add(kernel)
    assert len(told) >= 2


def test_a_numpy_without_openblas_has_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert blas_kernel.__wrapped__() == UNKNOWN
