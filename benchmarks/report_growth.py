"""How the tests, the report and the participants' pages grow with the number of participants: CPU seconds and memory.

Run with ``python -m benchmarks.report_growth [SIZE ...]``. A few participants of the shipped study are simulated and
fitted once; every larger study repeats them under new names, with slopes that differ from person to person. Each size
runs in a process of its own, on one thread.
"""

from __future__ import annotations

import argparse
import json
import os
import pickle
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import pairwise
from math import log
from pathlib import Path

import numpy as np

from emg2vsa.extraction import Trials
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.fits import Fits, concatenate, fit_trials
from emg2vsa.hypotheses import test_hypotheses as run_hypotheses
from emg2vsa.profiles import build_profiles
from emg2vsa.readers.roles import read_roles
from emg2vsa.report.failures import Failure
from emg2vsa.report.inputs import People, StudyResults, without_samples
from emg2vsa.report.session_page import write_session_page
from emg2vsa.report.study_report import write_study_report
from emg2vsa.schedules.build import build_schedules
from emg2vsa.study import RecordingEntry, Study
from emg2vsa.study_file import load_study
from emg2vsa.synthetic import simulate_study

STUDY = Path(__file__).resolve().parent.parent / "studies" / "palpation" / "study.toml"
SIZES = (50, 200, 1000)
SIMULATED = 4
"""Participants that are made in full."""
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")

Recording = tuple[Trials, Fits]


def make(folder: Path) -> tuple[Study, list[Recording]]:
    """The study with few participants, and its recordings' trials and fits."""
    study = load_study(STUDY)
    few = study.participants[:SIMULATED]
    study = replace(study, participants=few, recordings=tuple(e for e in study.recordings if e.participant in few))
    simulated = simulate_study(study, folder)
    recordings = []
    for entry, file in zip(study.recordings, simulated.recordings, strict=True):
        roles = read_roles(file, None, entry.channels)
        trials = extract_trials(
            roles.emg, roles.force, participant=entry.participant, specimen=entry.specimen, filters=entry.filters,
            cocontraction=study.cocontraction, window=entry.window, force_channel=entry.channels.force,
            notes=roles.notes,
        )  # fmt: skip
        recordings.append((trials, fit_trials(trials, study.fit, entry.window)))
    return study, recordings


def repeated(study: Study, recordings: list[Recording], size: int) -> tuple[Study, Iterator[Recording]]:
    """The same with ``size`` participants, P0001 and so on; each recording is a copy of its own."""
    names = tuple(f"P{i:04}" for i in range(1, size + 1))
    own: dict[str, list[int]] = {}
    for i, entry in enumerate(study.recordings):
        own.setdefault(entry.participant, []).append(i)
    places = [(name, i) for place, name in enumerate(names) for i in own[study.participants[place % SIMULATED]]]
    entries = tuple(
        replace(study.recordings[i], participant=name, emg_file=study.data / f"sub-{name}" / "emg" / f"{i}.bdf")
        for name, i in places
    )
    rng = np.random.default_rng(1)

    def made() -> Iterator[Recording]:
        for name, i in places:
            trials, fits = pickle.loads(pickle.dumps(recordings[i]))
            factor = 1 + 0.05 * float(rng.standard_normal())
            trials = replace(trials, participant=name)
            yield trials, replace(fits, participant=np.full(fits.b_v.size, name), b_v=factor * fits.b_v)

    return replace(study, participants=names, recordings=entries), made()


def measure(made: Path, size: int) -> dict[str, float]:
    """CPU seconds of each part at ``size`` participants, the size of the page in MB, and the peak memory in MB."""
    study, parts = repeated(*pickle.loads(made.read_bytes()), size)
    found: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        trials, fits = [], []
        with timed(found, "pages"):
            for whose in by_participant(study):
                own, fitted = zip(*(next(parts) for _ in whose.recordings), strict=True)
                write_session_page(whose, whose.participants[0], own, concatenate(fitted), (), out)
                trials += map(without_samples, own)
                fits.append(concatenate(fitted))
        whole = concatenate(fits)
        with timed(found, "tests"):
            hypotheses = run_hypotheses(whole, study.hypotheses)
        profile = replace(study.profile, participant=study.participants[0])
        profiles = build_profiles(whole, study.stiffness_n_per_mm, profile, study.window, study.hypotheses.use)
        schedules = build_schedules(profiles, study.schedule, {})
        failures = tuple(Failure(entry.key, "trials", f"{entry.emg_file}: cut") for entry in study.recordings[::100])
        with timed(found, "report"):
            people = People(whole, tuple(trials), hypotheses, profiles, schedules)
            results = StudyResults(study, people, failures=failures)
            write_study_report(results, out)
        found["index MB"] = (out / "index.html").stat().st_size / 1e6
    found["peak MB"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return found


def by_participant(study: Study) -> Iterator[Study]:
    """The study as the page of each participant is handed it."""
    own: dict[str, list[RecordingEntry]] = {}
    for entry in study.recordings:
        own.setdefault(entry.participant, []).append(entry)
    for name, entries in own.items():
        yield replace(study, participants=(name,), recordings=tuple(entries))


@contextmanager
def timed(found: dict[str, float], name: str) -> Iterator[None]:
    start = time.process_time()
    yield
    found[name] = time.process_time() - start


def table(measured: dict[int, dict[str, float]]) -> Iterator[str]:
    """One row a quantity; growth: the exponent between neighbouring sizes."""
    sizes = list(measured)
    yield "participants".ljust(14) + "".join(f"{size:>10}" for size in sizes) + "   exponents"
    for name in measured[sizes[0]]:
        values = [measured[size][name] for size in sizes]
        steps = zip(pairwise(values), pairwise(sizes), strict=True)
        exponents = [log(after / before) / log(large / small) for (before, after), (small, large) in steps]
        yield name.ljust(14) + "".join(f"{v:>10.2f}" for v in values) + "   " + ", ".join(f"{e:.2f}" for e in exponents)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sizes", nargs="*", type=int, default=SIZES, metavar="SIZE", help="numbers of participants")
    parser.add_argument("--of", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.of:
        print(json.dumps(measure(arguments.of, arguments.sizes[0])))
        return
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "made.pickle"
        made.write_bytes(pickle.dumps(make(Path(folder) / "data")))
        environment = os.environ | dict.fromkeys(THREADS, "1")
        measured = {}
        for size in arguments.sizes:
            command = [sys.executable, "-m", "benchmarks.report_growth", "--of", str(made), str(size)]
            done = subprocess.run(command, env=environment, check=True, stdout=subprocess.PIPE, text=True)
            measured[size] = json.loads(done.stdout)
    print("CPU seconds, one process, one thread:", *table(measured), sep="\n")


if __name__ == "__main__":
    main()
