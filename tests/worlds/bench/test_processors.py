"""The closed loop of the emulated rig gives the same bytes on a processor without AVX2 and FMA, and the same scores."""

from __future__ import annotations

import json
import platform
import re
from pathlib import Path
from typing import Any

import pytest

from benchmarks.processors import OLDEST, PRESS, under

FRAMES = "frames.tif"
"""Rendered in single precision: a grey level may round the other way."""
PLAN = "plan.json"
"""Logarithms of NumPy with AVX-512 differ in the last digit, and with them the numbers that a plan is made from."""
RELATIVE = 1e-5
"""Of A_c0 and CASR; measured: see docs/decisions/0031-processors.md."""


def has_avx2() -> bool:
    from numpy._core._multiarray_umath import __cpu_features__  # NumPy tells it nowhere else

    return bool(__cpu_features__.get("AVX2"))


@pytest.mark.slow
@pytest.mark.skipif(
    platform.machine() not in ("x86_64", "AMD64") or not has_avx2(), reason="this processor has no AVX2 to hide"
)
def test_a_press_of_the_closed_loop(tmp_path: Path) -> None:
    native, oldest = (_press(tmp_path / name, baseline) for name, baseline in (("native", {}), ("oldest", OLDEST)))
    assert any(name.endswith("presses.csv") for name in native["files"])
    assert {name for name in native["files"] if native["files"][name] != oldest["files"].get(name)} <= {
        name for name in native["files"] if name.endswith((FRAMES, PLAN))
    }
    (words, numbers), (words_2, numbers_2) = (_taken_apart(tmp_path / name / PLAN) for name in ("native", "oldest"))
    assert words == words_2
    assert numbers == pytest.approx(numbers_2, rel=1e-13)
    assert native["files"].keys() == oldest["files"].keys()
    assert native["scores"] == pytest.approx(oldest["scores"], rel=RELATIVE, nan_ok=True)


@pytest.mark.slow
@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="these are kernels of x86-64")
def test_another_kernel_of_blas_moves_no_score_of_a_press(tmp_path: Path) -> None:
    kernels = {}
    for kernel in ("Haswell", "Nehalem"):
        (tmp_path / kernel).mkdir()
        kernels[kernel] = _press(tmp_path / kernel, {"OPENBLAS_CORETYPE": kernel})
    one, other = kernels.values()
    assert one["files"] == other["files"]
    assert one["scores"] == pytest.approx(other["scores"], rel=1e-10, nan_ok=True)


def _press(folder: Path, baseline: dict[str, str]) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(under(baseline, "-c", PRESS, str(folder)))
    assert len(found["scores"]) >= 8
    return found


def _taken_apart(plan: Path) -> tuple[str, list[float]]:
    """What stands around the numbers, and the numbers."""
    text, number = plan.read_text(), r"-?\d+\.\d+(?:e-?\d+)?"
    return re.sub(number, "", text), [float(found) for found in re.findall(number, text)]
