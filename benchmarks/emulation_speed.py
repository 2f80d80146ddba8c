"""What an emulated run costs, and what scoring it costs, beside another version of the program.

Run with ``python -m benchmarks.emulation_speed --beside FOLDER [--rounds N]``, where FOLDER holds a checkout of the
other version. Versions take turns within every round, each in a process of its own, and the least processor time of
all rounds counts. Presses are ten; the elastic world is the one that both versions know.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parent.parent
RUNS = ("S1 0 modular", "S5 45 modular")
# what both versions understand: the other one knows no worlds, and no exact mode
CHILD = """
import json, sys, time
from dataclasses import fields, replace
from datetime import datetime, timezone
from functools import partial
from pathlib import Path
from benchmarks.rig.plans import modular_plan, rigid_plan
from emg2vsa.rig.emulated.settings import EmulatedSettings
from emg2vsa.rig.emulated.virtual_run import run_virtual
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.run_folders.presses import read_presses
from emg2vsa.runs.score_run import score_run
from emg2vsa.settings import RunSettings
specimen, angle, condition, presses, world, exact, folder = sys.argv[1:]
make = rigid_plan if condition == "high-stiffness" else partial(modular_plan, condition=condition)
plan = make(int(presses), specimen=specimen, angle_deg=float(angle))
told = {"world": world, "exact": exact == "exact"}
known = {field.name for field in fields(EmulatedSettings)}
emulated = replace(EmulatedSettings(), **{key: value for key, value in told.items() if key in known})
import cv2
times = [time.process_time()]
ended = run_virtual(plan, RigSettings(), emulated, Path(folder), started=datetime.now(timezone.utc))
times.append(time.process_time())
scores = score_run(read_presses([Path(folder)], None), RunSettings(), specimen=specimen, angle_deg=float(angle),
                   condition=condition, simulated=True)
times.append(time.process_time())
assert ended.how == "completed", ended
print(json.dumps({"rows": ended.rows, "emulation_s": times[1] - times[0], "scoring_s": times[2] - times[1]}))
"""


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--beside", type=Path, required=True, metavar="FOLDER", help="checkout of the other version")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--presses", type=int, default=10)
    arguments = parser.parse_args()
    versions = {
        "before": (arguments.beside, "elastic", ""),
        "exact": (ROOT, "elastic", "exact"),
        "now": (ROOT, "elastic", ""),
        "viscoelastic": (ROOT, "viscoelastic", ""),
    }
    print(f"{'run':<22}{'version':<14}{'rows':>7}{'emulation, s':>14}{'scoring, s':>12}{'of before':>11}{'with scoring':>14}")
    for run in RUNS:
        found: dict[str, list[dict[str, float]]] = {name: [] for name in versions}
        for _ in range(arguments.rounds):
            for name, version in versions.items():
                found[name].append(_cost(run, arguments.presses, *version))
        least = {name: {key: min(one[key] for one in costs) for key in costs[0]} for name, costs in found.items()}
        before = least["before"]
        for name, cost in least.items():
            both = (cost["emulation_s"] + cost["scoring_s"]) / (before["emulation_s"] + before["scoring_s"])
            print(
                f"{run:<22}{name:<14}{cost['rows']:>7.0f}{cost['emulation_s']:>14.2f}{cost['scoring_s']:>12.2f}"
                f"{cost['emulation_s'] / before['emulation_s']:>11.2f}{both:>14.2f}",
                flush=True,
            )


def _cost(run: str, presses: int, version: Path, world: str, exact: str) -> dict[str, float]:
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-c", CHILD, *run.split(), str(presses), world, exact, f"{folder}/run"]
        single = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        environment = os.environ | single | {"PYTHONPATH": str(version)}
        done = subprocess.run(command, cwd=version, env=environment, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    measured: dict[str, float] = json.loads(done.stdout)
    return measured


if __name__ == "__main__":
    main()
