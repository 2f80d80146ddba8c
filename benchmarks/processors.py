"""What other instruction sets change: a small study with an emulated rig, run from recordings to report under each.

Run with ``python -m benchmarks.processors``: a table as in decision 31. Libraries choose their
arithmetic by the processor they find; each baseline hides some of it from one of them, or from all, in a process of its
own. Numbers are compared with those of the processor as it is.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.small_study import WITH_A_RIG, small_rig, small_study
from emg2vsa.deposit.agreement import relative_difference

ROOT = Path(__file__).parent.parent
_NUMPY = {"NPY_DISABLE_CPU_FEATURES": "X86_V3"}
_BLAS = {"OPENBLAS_CORETYPE": "Nehalem"}
_OPENCV = {"OPENCV_CPU_DISABLE": "AVX2,AVX,FP16,SSE4.2,SSE4.1"}
_LIBM = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX"}
BASELINES: dict[str, dict[str, str]] = {
    "the same once more": {},
    "NumPy without AVX-512": {"NPY_DISABLE_CPU_FEATURES": "X86_V4"},
    "NumPy without AVX2 and FMA3": _NUMPY,
    "OpenBLAS for Haswell": {"OPENBLAS_CORETYPE": "Haswell"},
    "OpenBLAS for Sandybridge": {"OPENBLAS_CORETYPE": "Sandybridge"},
    "OpenBLAS for Nehalem": _BLAS,
    "OpenCV without SSE4 and AVX": _OPENCV,
    "libm without AVX2 and FMA": _LIBM,
    "all of them without": {**_NUMPY, **_BLAS, **_OPENCV, **_LIBM},
    "two threads": {"OMP_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2"},
}
OLDEST = BASELINES["all of them without"]

PRESS = """
import hashlib, json, sys, warnings
from datetime import datetime, timezone
from pathlib import Path
from benchmarks.rig.plans import modular_plan
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.bench.virtual_run import run_virtual
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.run_folders.presses import read_presses
from emg2vsa.run_scores.score_run import score_run
from emg2vsa.settings import RunSettings
folder = Path(sys.argv[1])
run_virtual(modular_plan(1, specimen="S3"), RigSettings(), EmulatedSettings(), folder,
            started=datetime(2026, 1, 5, tzinfo=timezone.utc))
files = {path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
         for path in sorted(folder.rglob("*")) if path.is_file()}
scores = score_run(read_presses([folder], None), RunSettings(), specimen="S3", angle_deg=0.0, condition="modular",
                   simulated=True, notes=())
found = {f"casr.{name}": rates[0] for name, rates in scores.casr.items()}
print(json.dumps({"files": files, "scores": found | {f"a_c0.{name}": of[0] for name, of in scores.a_c0.items()}}))
"""
"""A child: one press of the emulated rig, the digests of its files and its scores."""


def under(baseline: Mapping[str, str], *words: str) -> str:
    """What Python prints with ``words`` on a processor like that."""
    before = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1", **baseline}
    done = subprocess.run([sys.executable, *words], env=before, capture_output=True, text=True, check=True, cwd=ROOT)
    return done.stdout


def _by(baseline: Mapping[str, str]) -> Callable[..., str]:
    return partial(under, baseline, "-m", "emg2vsa.cli")


def results(run: Callable[..., str]) -> dict[str, Any]:
    """results.json of the small study. run : carries out a command of emg2vsa."""
    with tempfile.TemporaryDirectory() as folder:
        study = Path(folder) / "studies" / "small" / "study.toml"
        study.parent.mkdir(parents=True)
        study.write_text(small_study(tables=WITH_A_RIG))
        (study.parent / "rig.toml").write_text(small_rig())
        for command in (["tools", "simulate", str(study)], ["run", str(study), "--jobs", "1"]):
            run(*command, "--json")
        found: dict[str, Any] = json.loads((Path(folder) / "reports" / "small" / "results.json").read_text())
        return found


def largest(ours: Mapping[str, Any], theirs: Mapping[str, Any]) -> dict[str, tuple[int, float]]:
    """First word of the keys to the numbers that differ, and the largest relative difference; inf where words do."""
    found: dict[str, tuple[int, float]] = {}
    for key in sorted(ours.keys() | theirs.keys()):
        one, other = ours.get(key, "absent"), theirs.get(key, "absent")
        if one != other:
            relative = relative_difference(one, other)
            count, most = found.get(key.partition(".")[0], (0, 0.0))
            found[key.partition(".")[0]] = count + 1, max(most, float("inf") if relative is None else relative)
    return found


def main() -> None:
    """Print the table."""
    reference = results(_by({}))
    print(f"{len(reference)} numbers. Numbers that differ, and the largest relative difference.\n")
    print("| processor | " + " | ".join(groups := sorted({key.partition(".")[0] for key in reference})) + " |")
    print("|---" * (len(groups) + 1) + "|")
    for name, baseline in BASELINES.items():
        found = largest(reference, results(_by(baseline)))
        cells = [f"{found[group][0]}: {found[group][1]:.0e}" if group in found else "0" for group in groups]
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
