"""A study of any number of people, run to its report: CPU seconds and peak memory of each stage, size of the report.

Fourteen participants are simulated and their trials made once. Everybody else is one of them under another name, with
activity that differs by 5 % (SD) from person to person: the recordings are links, and the trials are stored as the
pipeline stores them. Everything after the trials is computed. Each recording is conditioned alone.
"""

from __future__ import annotations

import json
import os
import re
import resource
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emg2vsa import artifacts
from emg2vsa.extraction import Trials
from emg2vsa.pipeline.lock import study_lock
from emg2vsa.pipeline.plan import open_step_plan
from emg2vsa.study_file import load_study

ROOT = Path(__file__).resolve().parent.parent.parent
TEMPLATE = ROOT / "studies" / "palpation" / "study.toml"
N_MEASURED = 14
BETWEEN_PEOPLE = 0.05
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
MEMORY = """
import resource, sys
from emg2vsa.cli import main
status = main(sys.argv[1:])
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, file=sys.stderr)
sys.exit(status)
"""


def measured(folder: Path) -> tuple[Path, dict[str, Any]]:
    """The study file of the palpation study without a rig, run to its trials; and what each trials step took."""
    study = folder / "studies" / "palpation" / "study.toml"
    study.parent.mkdir(parents=True)
    study.write_text(re.sub(r"\[runs\]\n(.+\n)*", "", TEMPLATE.read_text()))
    run("tools simulate", study)
    _, _, out = run("run", study, "--only", "trials", "--jobs", "1", "--profile")
    return study, next(own for own in out["profile"] if own["stage"] == "trials")


def replicated(one: Path, folder: Path, count: int) -> Path:
    """The study file of a study of ``count`` participants whose trials are stored."""
    study = folder / "studies" / "palpation" / "study.toml"
    study.parent.mkdir(parents=True)
    names = [f"P{number:04d}" for number in range(1, count + 1)]
    listed = ", ".join(f'"{name}"' for name in names)
    study.write_text(re.sub(r"ids = \[.*?\]", f"ids = [{listed}]", one.read_text(), flags=re.S))
    data = study.parent / "data"
    shutil.copytree(one.parent / "data" / "derivatives", data / "derivatives")
    shutil.copy(one.parent / "data" / "dataset_description.json", data)
    for number, name in enumerate(names):
        own = _own(number)
        for path in (one.parent / "data" / f"sub-{own}" / "emg").iterdir():
            there = data / f"sub-{name}" / "emg" / path.name.replace(own, name)
            there.parent.mkdir(parents=True, exist_ok=True)
            os.symlink(path, there)
    loaded = load_study(study)
    stored = {step.id: step for step in open_step_plan(load_study(one), ("trials",), print).add_stage("trials")}
    rng = np.random.default_rng(1)
    factors = 1 + BETWEEN_PEOPLE * rng.standard_normal(count)
    with study_lock(loaded.results, wait=False, say=print):
        plan = open_step_plan(loaded, ("trials",), print)
        for step in plan.add_stage("trials"):
            name, _, specimen = step.item.partition("/")
            number = int(name[1:]) - 1
            made = stored[f"trials/{_own(number)}/{specimen}"]
            assert made.at is not None
            trials = artifacts.load(made.at)
            product = _other_person(
                trials, name, float(factors[number]), rng.permutation(trials.traits.fingerprints.shape[2])
            )
            artifacts.save(plan.store.unfinished(step.id, step.key), product)
            plan.end(step, "done", "", final=False, loaded=made.loaded)
        plan.prints.save()
    return study


def _own(number: int) -> str:
    return f"P{number % N_MEASURED + 1:02d}"


def _other_person(trials: Trials, name: str, factor: float, order: NDArray[np.int64]) -> Trials:
    """The same, louder by a factor; what tells its presses from copies is in another order."""
    traits = replace(
        trials.traits, fingerprints=trials.traits.fingerprints[:, :, order], press_v=factor * trials.traits.press_v
    )
    return replace(
        trials, participant=name, activity=factor * trials.activity, envelopes_v=factor * trials.envelopes_v,
        rest_envelope_v=factor * trials.rest_envelope_v, traits=traits,
    )  # fmt: skip


def measure(study: Path) -> dict[str, Any]:
    """What the whole run took, by stage, and what a warm ``status`` and a warm run take after it."""
    cpu_s, peak_mb, out = run("run", study, "--jobs", "1", "--profile")
    reports = load_study(study).reports
    pages = [path.stat().st_size for path in sorted((reports / "participants").rglob("*.html"))]
    return {
        "cpu_s": cpu_s,
        "peak_mb": peak_mb,
        "stages": {
            own["stage"]: {"cpu_s": own["cpu_s"], "peak_mb": own["peak_mb"], "computed": own["computed"]}
            for own in out["profile"]
            if own["computed"]
        },
        "failures": len(out["failures"]),
        "status_cpu_s": min(run("status", study)[0] for _ in range(3)),
        "status_peak_mb": run("status", study)[1],
        "warm_cpu_s": min(run("run", study)[0] for _ in range(3)),
        "index_mb": (reports / "index.html").stat().st_size / 1e6,
        "largest_page_mb": max(pages, default=0) / 1e6,
        "reports_mb": _size_mb(reports),
        "store_mb": _size_mb(load_study(study).results),
    }


def environment() -> dict[str, str]:
    """One thread a process."""
    return os.environ | dict.fromkeys(THREADS, "1")


def _size_mb(folder: Path) -> float:
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) / 1e6


def run(command: str, study: Path, *more: str) -> tuple[float, float, dict[str, Any]]:
    """CPU seconds of the whole process and its children, its largest memory in MB, and what it printed."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    script = [sys.executable, "-c", MEMORY, *command.split(), str(study), "--json", *more]
    done = subprocess.run(script, capture_output=True, text=True, check=False, cwd=ROOT, env=environment())
    if done.returncode:
        raise RuntimeError(f"{command} {study} ended with {done.returncode}: {done.stderr[-2000:]}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return seconds, int(done.stderr.split()[-1]) * 1024 / 1e6, json.loads(done.stdout)
