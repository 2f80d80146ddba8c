"""The people of the demo study from files: cold runs, nothing changed, one session changed, and reading alone.

Run with ``python -m benchmarks.whole_run [--repeats N]``. Every figure is a whole process, interpreter start included.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
STUDY = ROOT / "studies" / "palpation"
PEOPLE = ("--human-only",)
HEAVY = ("numpy", "scipy", "pandas", "cv2", "matplotlib", "numba")

READ_ALONE = """
import sys
from concurrent.futures import ProcessPoolExecutor
from emg2vsa.study_file import load_study
from emg2vsa.readers.roles import read_roles

def read(entry):
    roles = read_roles(entry.emg_file, entry.force_file, entry.channels)
    return sum(channel.samples.size for channel in (*roles.emg.values(), roles.force))

if __name__ == "__main__":
    entries = load_study(sys.argv[1]).recordings
    jobs = int(sys.argv[2])
    if jobs == 1:
        print(sum(map(read, entries)))
    else:
        with ProcessPoolExecutor(jobs) as pool:
            print(sum(pool.map(read, entries, chunksize=5)))
"""
WARM = """
import sys, time
from emg2vsa.fits import fit_trials
from emg2vsa.pipeline.campaign import Campaign
from emg2vsa.pipeline.stage import Given, value_of
from emg2vsa.pipeline.stages import trials
from emg2vsa.readers.roles import read_roles
from emg2vsa.study_file import load_study
study = load_study(sys.argv[1])
whole = Campaign(study)
def trials_of(key):
    settings = {name: value_of(each) for name, each in trials.settings(whole, key).items()}
    return trials.run(Given(key, settings, trials.files(whole, key)))
fit_trials(trials_of(next(iter(whole.recordings))), study.fit, study.window)
start = time.process_time()
for entry in study.recordings:
    read_roles(entry.emg_file, entry.force_file, entry.channels)
middle = time.process_time()
for entry in study.recordings:
    fit_trials(trials_of(entry.key), study.fit, entry.window)
print(middle - start, time.process_time() - middle)
"""
LOADED = "import sys; from emg2vsa.cli import main; main(sys.argv[1:]); print(*sys.modules, file=sys.stderr)"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=3)
    repeats = parser.parse_args().repeats
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "studies" / "palpation"
        folder.mkdir(parents=True)
        study = folder / "study.toml"
        for name_of_file in ("study.toml", "rig.toml"):
            shutil.copy(STUDY / name_of_file, folder)
        _python("-m", "emg2vsa.cli", "simulate", str(study))
        script = Path(name) / "read_alone.py"
        script.write_text(READ_ALONE)
        times: dict[str, list[float]] = {}
        for _ in range(repeats):
            for jobs in (1, 2):
                _timed(times, f"reading alone, {jobs} process{'es' * (jobs > 1)}", str(script), str(study), str(jobs))
            for what, only in (("to schedules", ["--only", "schedules"]), ("to the report", PEOPLE)):
                shutil.rmtree(folder / ".emg2vsa", ignore_errors=True)
                shutil.rmtree(Path(name) / "reports", ignore_errors=True)
                for jobs in (2, 1):
                    shutil.rmtree(folder / ".emg2vsa", ignore_errors=True)
                    cold = f"cold run {what}, {jobs} process{'es' * (jobs > 1)}"
                    _timed(times, cold, "-m", "emg2vsa.cli", "run", str(study), "--jobs", str(jobs), *only)
            _timed(times, "nothing changed", "-m", "emg2vsa.cli", "run", str(study), *PEOPLE)
            changed = _touch_one_recording(folder)
            ran = json.loads(
                _timed(times, "one recording changed", "-m", "emg2vsa.cli", "run", str(study), *PEOPLE, "--json")
            )
        reading = {jobs: min(times[f"reading alone, {jobs} process{'es' * (jobs > 1)}"]) for jobs in (1, 2)}
        print(f"{'whole process':<38}{'best s':>8}{'median s':>10}{'x reading':>11}")
        for what, seconds in times.items():
            best = min(seconds)
            ratio = best / reading[1 if "1 process" in what else 2]
            print(f"{what:<38}{best:>8.2f}{statistics.median(seconds):>10.2f}{ratio:>11.2f}")
        _in_process(study)
        print(f"after a change of {changed}: {', '.join(ran['ran'])}; {ran['fresh']} steps fresh")
        done = subprocess.run(
            [sys.executable, "-c", LOADED, "run", str(study), *PEOPLE], capture_output=True, text=True, check=True
        )
        loaded = [module for module in HEAVY if module in done.stderr.split()]
        print(f"loaded when nothing changed: {', '.join(loaded) or 'none of ' + ', '.join(HEAVY)}")


def _in_process(study: Path) -> None:
    """CPU time of the same without imports: reading, and reading to fits, in one warm process."""
    done = _python("-c", WARM, str(study)).split()
    reading, fits = float(done[0]), float(done[1])
    print(f"without imports, CPU s: reading {reading:.2f}, reading to fits {fits:.2f} ({fits / reading:.1f} x reading)")


def _timed(times: dict[str, list[float]], what: str, *arguments: str) -> str:
    start = time.perf_counter()
    output = _python(*arguments)
    times.setdefault(what, []).append(time.perf_counter() - start)
    return output


def _python(*arguments: str) -> str:
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, *arguments], check=True, capture_output=True, text=True, cwd=ROOT, env=environment
    )
    return done.stdout


def _touch_one_recording(folder: Path) -> str:
    """Flip the last bit of one sample of one recording."""
    path = next(folder.glob("data/sub-P03/emg/*acq-S2_emg.bdf"))
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    return "P03/S2"


if __name__ == "__main__":
    main()
