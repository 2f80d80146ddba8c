"""How status, pages and report grow with the number of participants: CPU seconds, memory, and the exponent of growth.

Run with ``python -m benchmarks.scale [--participants 50 200 1000] [--report]``. Fourteen simulated participants are
measured once; all others are theirs under other names: recordings linked, results stored as the pipeline stores them.
"""

from __future__ import annotations

import argparse
import itertools
import math
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from emg2vsa import artifacts
from emg2vsa.cli import main as emg2vsa
from emg2vsa.pipeline.lock import study_lock
from emg2vsa.pipeline.plan import open_board
from emg2vsa.study_file import load_study

ROOT = Path(__file__).resolve().parent.parent
TEMPLATE = ROOT / "studies" / "palpation" / "study.toml"
N_MEASURED = 14


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--participants", type=int, nargs="+", default=[50, 200, 1000])
    parser.add_argument("--report", action="store_true", help="pages, tests and report too: minutes at 1000")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        measured = _measured(folder / "measured")
        print("| participants x 5 | first status s | status s | pages s | to the report s | status MB | report MB |")
        print("|---:|---:|---:|---:|---:|---:|---:|")
        rows = []
        for count in arguments.participants:
            study = _replicated(measured, folder / str(count), count)
            first, _ = _cpu("status", study)
            warm, memory = min(_cpu("status", study) for _ in range(3))
            pages = report = report_memory = math.nan
            if arguments.report:
                pages, _ = _cpu("run", study, "--only", "pages", "--jobs", "1")
                report, report_memory = _cpu("run", study, "--jobs", "1")
            rows.append((count, first, warm, pages, report))
            print(
                f"| {count} | {first:.2f} | {warm:.2f} | {pages:.1f} | {report:.1f} | {memory:.0f} "
                f"| {report_memory:.0f} |",
                flush=True,
            )
            shutil.rmtree(folder / str(count))
        start = _start_up()
        print(f"\nstart-up of Python and the command line: {start:.2f} s, taken off before the exponents below")
        for column, what in ((2, "status"), (3, "pages"), (4, "report")):
            _exponents(what, [(row[0], row[column] - start) for row in rows])


def _measured(folder: Path) -> Path:
    """The palpation study without a rig, measured to the fits."""
    study = folder / "studies" / "palpation" / "study.toml"
    study.parent.mkdir(parents=True)
    text = re.sub(r"\[runs\]\n(.+\n)*", "", TEMPLATE.read_text())
    study.write_text(text)
    _quietly("simulate", study)
    _quietly("run", study, "--only", "fits")
    return study


def _replicated(measured: Path, folder: Path, count: int) -> Path:
    """A study of ``count`` participants whose trials and fits are stored."""
    study = folder / "studies" / "palpation" / "study.toml"
    study.parent.mkdir(parents=True)
    names = [f"P{number:04d}" for number in range(1, count + 1)]
    listed = ", ".join(f'"{name}"' for name in names)
    text = re.sub(r"ids = \[.*?\]", f"ids = [{listed}]", measured.read_text(), flags=re.S)
    study.write_text(text.replace('participant = "P07"', 'participant = "P0007"'))
    data = study.parent / "data"
    shutil.copytree(measured.parent / "data" / "derivatives", data / "derivatives")
    shutil.copy(measured.parent / "data" / "dataset_description.json", data)
    for number, name in enumerate(names):
        own = f"P{number % N_MEASURED + 1:02d}"
        for path in (measured.parent / "data" / f"sub-{own}" / "emg").iterdir():
            there = data / f"sub-{name}" / "emg" / path.name.replace(own, name)
            there.parent.mkdir(parents=True, exist_ok=True)
            os.symlink(path, there)
    loaded = load_study(study)
    before = open_board(load_study(measured), ("trials", "fits"), print)
    products = {}
    for stage in ("trials", "fits"):
        for step in before.add_stage(stage):
            products[step.id] = artifacts.load(step.at)
    with study_lock(loaded.results, wait=False, say=print):
        board = open_board(loaded, ("trials", "fits"), print)
        for stage in ("trials", "fits"):
            for step in board.add_stage(stage):
                name, _, specimen = step.item.partition("/")
                own = f"P{(int(name[1:]) - 1) % N_MEASURED + 1:02d}"
                product = _renamed(products[f"{stage}/{own}/{specimen}"], name)
                artifacts.save(board.store.unfinished(step.id, step.key), product)
                board.end(step, "done", "", final=False)
        board.prints.save()
    return study


def _renamed(product: Any, name: str) -> Any:
    """The product as another participant's; trials name theirs once, fits in every row."""
    own = product.participant
    return replace(product, participant=name if isinstance(own, str) else np.full(own.shape, name))


def _cpu(command: str, study: Path, *more: str) -> tuple[float, float]:
    """CPU seconds of the whole process and its children, and its largest memory in MB."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    program = "import resource, sys; from emg2vsa.cli import main; main(sys.argv[1:])\n"
    program += "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, file=sys.stderr)"
    script = [sys.executable, "-c", program, command, str(study), *more]
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(script, capture_output=True, text=True, check=True, cwd=ROOT, env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return seconds, int(done.stderr.split()[-1]) / 1024


def _start_up() -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", "import emg2vsa.study_file, emg2vsa.pipeline.plan"], check=True, cwd=ROOT)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def _exponents(what: str, points: list[tuple[int, float]]) -> None:
    known = [(count, seconds) for count, seconds in points if seconds > 0]
    for (few, fast), (many, slow) in itertools.pairwise(known):
        print(f"{what}: exponent {math.log(slow / fast) / math.log(many / few):.2f} from {few} to {many}")


def _quietly(command: str, study: Path, *more: str) -> None:
    with open(os.devnull, "w") as quiet:
        before, sys.stdout = sys.stdout, quiet
        try:
            assert emg2vsa([command, str(study), *more]) == 0
        finally:
            sys.stdout = before


if __name__ == "__main__":
    main()
