"""Results that another kernel of BLAS made are fresh, and ``status`` says which kernel that was."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.small_study import small_study
from casr.blas_kernel import UNKNOWN, blas_kernel
from emg2vsa.cli import main
from tests.small import simulated

OTHER = "Nehalem"

pytestmark = [
    pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="this is a kernel of x86-64"),
    pytest.mark.skipif(blas_kernel() in (UNKNOWN, OTHER), reason="no other kernel is known here"),
]


def test_status_names_the_kernel_that_made_results(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    study = simulated(tmp_path, small_study(participants=("P01",), specimens=("S1", "S3")))
    run = [sys.executable, "-m", "emg2vsa.cli", "run", str(study), "--only", "trials", "--jobs", "1"]
    subprocess.run(run, env=os.environ | {"OPENBLAS_CORETYPE": OTHER}, check=True, capture_output=True)
    capsys.readouterr()
    assert main(["status", str(study)]) == 0
    said = f"Fresh, but made with the BLAS kernel {OTHER}: 2. This computer has {blas_kernel()}: if made here, they may"
    assert said in capsys.readouterr().out
    assert told(study, capsys)["made with other kernels of BLAS"] == {OTHER: 2}

    next((tmp_path / "studies").rglob(".emg2vsa/small/store/trials/P01/S3/*.result")).unlink()
    assert main(["run", str(study), "--only", "trials", "--jobs", "1", "--json"]) == 0
    capsys.readouterr()
    assert told(study, capsys)["made with other kernels of BLAS"] == {OTHER: 1}


def test_results_of_this_computer_need_no_word(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    study = simulated(tmp_path, small_study(participants=("P01",), specimens=("S1",)))
    assert main(["run", str(study), "--only", "trials", "--jobs", "1", "--json"]) == 0
    capsys.readouterr()
    assert main(["status", str(study)]) == 0
    assert "kernel" not in capsys.readouterr().out


def told(study: Path, capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    assert main(["status", str(study), "--json"]) == 0
    found: dict[str, object] = json.loads(capsys.readouterr().out)
    return found
