"""A study of eight people with five planted mishaps, from `check` to the report, as a user runs it.

``python -m benchmarks.planted_study [FOLDER]``: a minute; FOLDER keeps the three studies. `clean` is the study as it
was simulated; `planted` has the mishaps; `believed` has them too, but every spoilt recording is accepted by name.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy import signal

from benchmarks.small_study import small_study
from emg2vsa.arrays import Floats, runs_of

PEOPLE, FS_HZ = [f"P{i:02d}" for i in range(1, 9)], 1000.0
HEAD = "time [s],EDC [V],FDS [V],Fz [N]"
Change = Callable[[Floats], Floats]


def artefact(table: Floats) -> Floats:
    """A moving electrode at every contact: half a cycle up to 20 Hz, 60 ms, 150 uV, in both muscles."""
    rng, found = np.random.default_rng(1), table.copy()
    force_n = signal.sosfiltfilt(signal.butter(2, 20, fs=FS_HZ, output="sos"), -table[:, 3])
    starts, _ = runs_of(force_n > np.median(force_n[:500]) + 0.2)
    wave = np.sin(np.pi * np.arange(60) / 60)
    for start in starts[np.diff(starts, prepend=-2000) > 1000]:
        for muscle in (1, 2):
            found[start : start + 60, muscle] += 150e-6 * np.exp(0.4 * rng.standard_normal()) * wave
    return found


def gain(table: Floats) -> Floats:
    return table * np.array([1.0, 10.0, 1.0, 1.0])


def filtered(table: Floats) -> Floats:
    found = table.copy()
    found[:, 1:3] = signal.sosfiltfilt(signal.butter(4, 60, fs=FS_HZ, output="sos"), table[:, 1:3], axis=0)
    return found


def exported(table: Floats) -> Floats:
    """Again, less its first .4 s, with steps of 1 uV and time from 0."""
    found = table[400:].copy()
    found[:, 0] -= found[0, 0]
    found[:, 1:3] = np.round(found[:, 1:3] / 1e-6) * 1e-6
    return found


def drying(table: Floats) -> Floats:
    found = table.copy()
    found[:, 1] *= np.linspace(1, 0.3, len(table))
    return found


MISHAPS: dict[tuple[str, str], tuple[str, str, Change]] = {
    ("P02", "S3"): ("an electrode moves at every contact, 150 uV", "S3", artefact),
    ("P03", "S1"): ("the gain of EDC was 10 times higher", "S1", gain),
    ("P04", "S3"): ("EMG was low-passed at 60 Hz", "S3", filtered),
    ("P05", "S5"): ("S3 exported again as S5, cut by .4 s", "S3", exported),
    ("P06", "S1"): ("the electrode on EDC dries to .3", "S1", drying),
}
"""By participant and specimen: what happened, the specimen whose recording is changed, how."""


def study_text(believed: bool) -> str:
    tables = "[window]\nexpected_trials = 6\n"
    simulation = "seed = 5\nrepetitions = 6\n"
    title = "A study with planted mishaps"
    text = small_study(name="planted", title=title, participants=PEOPLE, simulation=simulation, tables=tables)
    bids = 'layout = "bids"\nroot = "data"\ntask = "palpation"'
    text = text.replace(bids, 'layout = "pattern"\npattern = "data/{participant}_{specimen}.csv"')
    for participant, specimen in MISHAPS if believed else ():
        text += f'[[accept]]\nparticipant = "{participant}"\nspecimen = "{specimen}"\nreason = "it looks fine"\n'
    return text


def command(*arguments: str | Path) -> str:
    """What the command prints; it ends with 1 where a session is bad."""
    done = subprocess.run(
        [sys.executable, "-m", "emg2vsa.cli", *map(str, arguments)], capture_output=True, text=True, check=False
    )
    if done.returncode not in (0, 1) or "Traceback" in done.stderr:
        raise RuntimeError(f"{arguments}: {done.returncode}\n{done.stderr}")
    return done.stdout


def make(folder: Path) -> list[Path]:
    """The three studies; their files."""
    studies = []
    for name in ("clean", "planted", "believed"):
        (folder / name).mkdir(parents=True)
        studies.append(folder / name / "study.toml")
        studies[-1].write_text(study_text(name == "believed"), encoding="utf-8")
    command("tools", "simulate", studies[0], "--format", "csv", "-q")
    data = studies[0].parent / "data"
    shutil.copytree(data, studies[1].parent / "data")
    for (participant, specimen), (_, source, change) in MISHAPS.items():
        table = np.loadtxt(data / f"{participant}_{source}.csv", delimiter=",", skiprows=1)
        path = studies[1].parent / "data" / f"{participant}_{specimen}.csv"
        np.savetxt(path, change(table), "%.9g", ",", header=HEAD, comments="")
    shutil.copytree(studies[1].parent / "data", studies[2].parent / "data")
    return studies


def judged(study: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """`check --json`, and results.json after a run."""
    checked = json.loads(command("check", study, "--json"))
    command("run", study, "-q")
    return checked, json.loads(next(study.parent.glob("reports/*/results.json")).read_text(encoding="utf-8"))


def b_of(checked: dict[str, Any], participant: str, specimen: str) -> str:
    for row in checked[participant]["b"]:
        if row["specimen"] == specimen:
            return f"{1e6 * row['b_v']:.1f} [{1e6 * row['b_lo_v']:.1f}, {1e6 * row['b_hi_v']:.1f}]"
    return "none"


def main() -> None:
    kept = Path(sys.argv[1]) if len(sys.argv) > 1 else None
    folder = kept or Path(tempfile.mkdtemp())
    (clean, good), (planted, found), (believed, wrong) = map(judged, make(folder))
    print("# A study with five planted mishaps, from check to report\n")
    print(
        "`python -m benchmarks.planted_study`: 8 people, 3 specimens, 6 presses; b in uV, mean of presses used, 95 %."
    )
    print("`believed`: every spoilt recording was accepted by name.\n")
    print("| planted | check: session, presses ok | most likely cause, remedy | b before | b used | b believed |")
    print("|---|---|---|---|---|---|")
    for (participant, specimen), (name, _, _) in MISHAPS.items():
        own = next(each for each in planted[participant]["specimens"] if each["specimen"] == specimen)
        told = own["cause"] or own["fault"] or "; ".join(own["problems"])
        said = f"{planted[participant]['verdict'].upper()}, {own['ok']} of {own['found']} | {told}: {own['remedy']}"
        b = " | ".join(b_of(each, participant, specimen) for each in (clean, planted, believed))
        print(f"| {participant} {specimen}: {name} | {said} | {b} |")
    others = [who for who in PEOPLE if who not in {who for who, _ in MISHAPS}]
    print(f"\nThe other {len(others)} people: {', '.join(planted[who]['verdict'].upper() for who in others)}.\n")
    print("| claim of the report | clean | planted | believed |\n|---|---|---|---|")
    for key in sorted(key.removesuffix(".verdict") for key in good if re.fullmatch(r"claims\..*\.verdict", key)):
        if len(set(shown := [_claim(each, key) for each in (good, found, wrong)])) > 1:
            print(f"| {key.removeprefix('claims.')} | {' | '.join(shown)} |")
    if kept is None:
        shutil.rmtree(folder)


def _claim(results: dict[str, Any], key: str) -> str:
    ends = [results.get(f"{key}.{end}") for end in ("ours", "low", "high")]
    if not all(isinstance(end, float) for end in ends):
        return ""
    ours, low, high = ends
    return f"{ours:.3g} [{low:.3g}, {high:.3g}] {results[f'{key}.verdict']}"


if __name__ == "__main__":
    main()
