"""Kappa while the finger presses: how soon the answer is there, and what the control loop feels of it.

One emulated rig in real time behind ports, in a process of its own. ``emg2vsa rig run`` presses a specimen, in turn
without and with ``--calibration``, so that whatever else the computer does meets both alike. Period errors are those of
ended.json; rows that are missing those of presses.csv; latencies, from the exposure of a frame to its row in
kappa.csv, those of kappa.csv.

    python -m benchmarks.live_kappa benchmarks/results/live_kappa.json --pairs 6
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.bench.record import keep
from benchmarks.online_kappa import calibrated

RIG = """\
[rig.guards]
late_s = 0.1
stale_s = 0.1
camera_s = 5

[actuator]
port = "/dev/none"
watchdog_s = 5
reply_s = 2

[motor]
port = "/dev/none-either"
watchdog_s = 5
reply_s = 2

[force]
kind = "net-ft"
host = "127.0.0.1"

[camera]
source = "none"

[experiment]
specimens = ["S3"]
angles_deg = { high-stiffness = [0] }
repetitions = 5
ramp_mm_per_s = 2
pause_s = 0.5
schedules = "schedules"

[emulated]
"""
COMMAND = (sys.executable, "-m", "emg2vsa.cli", "rig")
LIMIT_S, RATIO = 0.1, 1.2
"""Targets: of the latency, and of the 99.9 % period error with over without."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--pairs", type=int, default=6)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary, served(Path(temporary)) as rig:
        (by_pins := Path(temporary) / "known").mkdir()
        calibration = calibrated(1, by_pins)
        runs = [
            (one_run(rig, number, None), one_run(rig, number, calibration)) for number in range(1, arguments.pairs + 1)
        ]
    keep(arguments.out, report(runs))
    print(arguments.out.read_text(encoding="utf-8"))


@contextmanager
def served(folder: Path) -> Iterator[Path]:
    """The rig file that leads to an emulated rig."""
    (folder / "schedules").mkdir()
    (folder / "rig.toml").write_text(RIG)
    command = [*COMMAND, "emulate", "rig.toml", "--rigid", "--write", "served.toml"]
    with subprocess.Popen(command, cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL) as process:
        try:
            while not (folder / "served.toml").exists():
                assert process.poll() is None, "the emulation has ended"
                time.sleep(0.05)
            yield folder / "served.toml"
        finally:
            process.kill()


def one_run(rig: Path, number: int, calibration: Path | None) -> dict[str, Any]:
    """Numbers of one run."""
    out = rig.parent / f"{'with' if calibration else 'without'}-{number}"
    command = [*COMMAND, "run", str(rig), "--specimen", "S3", "--out", str(out)]
    command += ["--calibration", str(calibration)] if calibration else []
    subprocess.run(command, check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    folder = out / "S3_0_high-stiffness"
    ended = json.loads((folder / "ended.json").read_text())
    presses = list(csv.DictReader((folder / "presses.csv").read_text().splitlines()))
    found = {
        "how": ended["how"],
        "turns": ended["timing"]["turns"],
        **{key: 1e3 * ended["timing"][f"{key}_s"] for key in ("p99", "p999", "largest")},
        "missing": sum(int(press["missing_turns"]) for press in presses),
        "frames_missing": sum(int(press["frames_missing"]) for press in presses),
        "load": os.getloadavg()[0],
    }
    if calibration:
        rows = list(csv.DictReader((folder / "kappa.csv").read_text().splitlines()))
        about = json.loads((folder / "kappa.json").read_text())
        found |= {
            "dropped": about["dropped"],
            "trouble": about["trouble"],
            "latency_s": [float(row["latency_s"]) for row in rows],
            "contact_s": [float(row["latency_s"]) for row in rows if float(row["force_n"] or 0) >= 0.5],
        }
    return found


def report(runs: list[tuple[dict[str, Any], dict[str, Any]]]) -> str:
    """Markdown."""
    without, beside = zip(*runs, strict=True)
    ratios = [b["p999"] / a["p999"] for a, b in runs]
    pooled = np.concatenate([run["latency_s"] for run in beside]) * 1e3
    contact = np.concatenate([run["contact_s"] for run in beside]) * 1e3
    quantiles = [np.percentile(each, (50, 95, 100)) for each in (pooled, contact)]
    lost = sum(run["missing"] for run in beside), sum(run["missing"] for run in without)
    lines = [
        "# Kappa while the finger presses: latency, and the control loop beside it",
        "",
        f"Written by `python -m benchmarks.live_kappa`. {platform.machine()}, {os.cpu_count()} cores, load average "
        f"{np.mean([run['load'] for pair in runs for run in pair]):.1f} meanwhile. {len(runs)} pairs of runs of 5 "
        "presses at 200 turns and 20 frames a second, in turn without and with the estimator.",
        "",
        "| run | estimator | ended | turns | 99 %, ms | 99.9 %, ms | largest, ms | rows missing | frames missing "
        "| dropped | load |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
        *(
            f"| {number} | {name} | {run['how']} | {run['turns']} | {run['p99']:.3f} | {run['p999']:.3f} | "
            f"{run['largest']:.3f} | {run['missing']} | {run['frames_missing']} | {run.get('dropped', '')} | "
            f"{run['load']:.1f} |"
            for number, pair in enumerate(runs, 1)
            for name, run in zip(("without", "beside"), pair, strict=True)
        ),
        "",
        f"**99.9 % period error, beside over without**: median {np.median(ratios):.2f}, "
        f"{min(ratios):.2f} to {max(ratios):.2f} in {len(ratios)} pairs; target {RATIO}: "
        f"{'met' if np.median(ratios) <= RATIO else 'missed'} by the median.",
        "",
        f"**Rows missing** in the loadings: {lost[0]} beside, {lost[1]} without.",
        "",
        "| latency, ms | frames | median | 95 % | largest | share within 100 ms |",
        "|---|---|---|---|---|---|",
        *(
            f"| {name} | {each.size} | {q[0]:.0f} | {q[1]:.0f} | {q[2]:.0f} | {np.mean(each <= 1e3 * LIMIT_S):.1%} |"
            for name, each, q in zip(("all frames", "in contact"), (pooled, contact), quantiles, strict=True)
        ),
        "",
        "The latency holds 12.5 ms for which a frame waits for the readings after its exposure that tell its force, "
        "the way through shared memory, the areas and kappa. What makes it long on a busy computer is the estimator's "
        "share of a core.",
        "",
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    main()
