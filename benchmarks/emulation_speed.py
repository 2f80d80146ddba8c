"""What an emulated run costs beside another version of the program, in all and part by part, and that it is the same.

Run with ``python -m benchmarks.emulation_speed --beside FOLDER [--rounds N]``, where FOLDER holds a checkout of the
other version. Versions take turns within every round, each in a process of its own, with one thread, which has emulated
a press before; times are those of the processor. The table gives the least of all rounds, and smallest, median and
largest ratio of a round. Folders of runs are compared file by file, byte for byte. ``--bytes`` compares those of more
worlds and controls instead, once and without times. Parts come from a profile of one more run of each version, which
makes calls of functions dearer than they are: they tell where time went, not how much.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent
WORLDS = (
    "S2 45 high-stiffness viscoelastic", "S1 0 constant-max viscoelastic", "S1 0 modular elastic",
    "S3 30 modular viscoelastic,exact", "S2 30 modular N1", "S2 30 modular P1", "S3 30 modular P4",
    "S5 0 high-stiffness P1", "S1 45 high-stiffness P4",
)  # fmt: skip
"""Compared by their bytes alone: specimen, angle, condition, and world or control; P4 finds S1's schedule right."""
RUNS = (
    "S1 0 modular viscoelastic", "S5 45 modular viscoelastic", "S3 30 high-stiffness elastic",
    "S1 0 high-stiffness viscoelastic", "S3 0 constant-mean viscoelastic", "S3 0 modular viscoelastic,exact",
)  # fmt: skip
CHILD = """
import cProfile, hashlib, json, pstats, sys, time
from datetime import datetime, timezone
from functools import partial
from pathlib import Path
import cv2
from benchmarks.rig.plans import modular_plan, rigid_plan
from emg2vsa.worlds.bench.controls import controlled, effect_of
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.bench.virtual_run import run_virtual
from emg2vsa.rig.rig_settings import RigSettings
specimen, angle, condition, world, presses, profiled, folder = sys.argv[1:]
make = rigid_plan if condition == "high-stiffness" else partial(modular_plan, condition=condition)
plan = make(int(presses), specimen=specimen, angle_deg=float(angle))
world, _, exact = world.partition(",")
if world in ("elastic", "viscoelastic"):
    emulated = EmulatedSettings(world=world, exact=bool(exact))
else:
    emulated = controlled(EmulatedSettings(control=world, control_specimen="S1" if world == "P4" else ""))
effect = effect_of(emulated, plan.schedule, (modular_plan(1, specimen="S1").schedule,))
# as a process that emulates one run after the other: what is loaded for the first does not count
started = datetime(2026, 1, 5, tzinfo=timezone.utc)
run_virtual(make(1), RigSettings(), EmulatedSettings(), Path(folder + "-first"), started=started)
profile = cProfile.Profile(time.process_time)
start_s = time.process_time()
if profiled:
    profile.enable()
ended = run_virtual(plan, RigSettings(), emulated, Path(folder), started=started, effect=effect)
profile.disable()
cost_s = time.process_time() - start_s
assert ended.how == "completed", ended
files = {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
         for path in sorted(Path(folder).rglob("*")) if path.is_file()}
own = {}
if profiled:
    for (file, _, _), (_, _, own_s, _, callers) in pstats.Stats(profile).stats.items():
        # what is written in C counts for its callers
        for name, spent_s in [(file, own_s)] if file != "~" else [(of[0], each[2]) for of, each in callers.items()]:
            own[name] = own.get(name, 0.0) + spent_s
print(json.dumps({"cost_s": cost_s, "rows": ended.rows, "files": files, "own": own}))
"""
PARTS = {
    "contact and shaft": (
        "worlds/contact/",
        "probe.py",
        "actuator_joint.py",
        "/world.py",
        "steps.py",
    ),
    "force sensor": ("netft", "box_", "net_ft.py", "direct_drivers.py"),
    "actuator": ("qbmove", "faults.py"),
    "frames": ("casr/", "camera.py", "press_draws.py", "numpy"),
    "loop and guards": ("executor/", "bench.py", "clock.py", "rig_settings.py", "plan.py"),
    "log and files": ("record/",),
}
"""To ends or pieces of the paths of their modules; the first that fits counts."""


def main() -> None:
    """Measure, compare, and print tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--beside", type=Path, required=True, metavar="FOLDER", help="checkout of the other version")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--presses", type=int, default=10)
    parser.add_argument("--bytes", action="store_true", help="compare the files of more worlds, and no times")
    arguments = parser.parse_args()
    versions = {"before": arguments.beside, "now": ROOT}
    if arguments.bytes:
        for run in WORLDS:
            both = _measured(run, arguments.presses, versions)
            before, now = (each["files"] for each in both.values())
            print(f"{run:<36}{len(now):>4} files {'the same' if before == now else 'DIFFERENT'}", flush=True)
        return
    print(f"{'run':<32}{'rows':>7}{'before, s':>11}{'now, s':>9}{'before / now':>23}  files")
    for run in RUNS:
        found = [_measured(run, arguments.presses, versions) for _ in range(arguments.rounds)]
        ratios = sorted(each["before"]["cost_s"] / each["now"]["cost_s"] for each in found)
        least = {name: min(each[name]["cost_s"] for each in found) for name in versions}
        same = all(each["before"]["files"] == each["now"]["files"] for each in found)
        spread = f"{ratios[0]:.2f} {statistics.median(ratios):.2f} {ratios[-1]:.2f}"
        print(
            f"{run:<32}{found[0]['now']['rows']:>7}{least['before']:>11.2f}{least['now']:>9.2f}{spread:>23}"
            f"  {len(found[0]['now']['files'])} {'the same' if same else 'DIFFERENT'}",
            flush=True,
        )
    run = RUNS[1]
    profiled = _measured(run, arguments.presses, versions, profiled=True)
    parts = {name: _parts(each["own"]) for name, each in profiled.items()}
    print(f"\nparts of {run}, profiled:\n{'part':<24}{'before, s':>11}{'now, s':>9}")
    for part in parts["now"]:
        print(f"{part:<24}{parts['before'][part]:>11.2f}{parts['now'][part]:>9.2f}")


def _measured(
    run: str, presses: int, versions: dict[str, Path], *, profiled: bool = False
) -> dict[str, dict[str, Any]]:
    return {name: _run(run, presses, version, profiled) for name, version in versions.items()}


def _run(run: str, presses: int, version: Path, profiled: bool) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        given = [*run.split(), str(presses), "profiled" if profiled else "", f"{folder}/run"]
        single = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        environment = os.environ | single | {"PYTHONPATH": str(version)}
        command = [sys.executable, "-c", CHILD, *given]
        done = subprocess.run(command, cwd=version, env=environment, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def _parts(own: dict[str, float]) -> dict[str, float]:
    """Processor time of each part, s, of that of modules by their paths."""
    spent = dict.fromkeys([*PARTS, "else"], 0.0)
    for path, own_s in own.items():
        part = next((part for part, pieces in PARTS.items() if any(piece in path for piece in pieces)), "else")
        spent[part] += own_s
    return spent


if __name__ == "__main__":
    main()
