"""How well the control loop keeps its beat: executor and drivers here, the emulated rig in another process.

Run with ``python -m benchmarks.rig_loop [--minutes M] [--hogs N ...] [--ordinary] [--json]``. Beside each run, at the
same time and scheduled alike, a loop with nothing to do shows what the machine itself misses.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict

import numpy as np

from benchmarks.rig.loop_run import LoopReport, run_loop
from emg2vsa.devices.clock import LoopTiming

MOST_P999, MOST_P99, MOST_P99_MS = 2.0, 3.0, 1.0
"""Period errors of the loop over those of one with nothing to do; or those of 99 % of turns in ms."""


def main() -> None:
    """Run, and print a table for each number of programs beside it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--hogs", type=int, nargs="+", default=[0, 1], help="programs beside it that only take time")
    parser.add_argument("--ordinary", action="store_true", help="scheduled as any other program")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    for hogs in arguments.hogs:
        report = run_loop(60 * arguments.minutes, hogs, steady=not arguments.ordinary)
        print(json.dumps(asdict(report)) if arguments.json else _table(report), flush=True)


def _table(report: LoopReport) -> str:
    real_time = "real-time" if report.real_time else "ordinary"
    steps = report.steps
    lines = [
        f"{report.hogs} programs beside it, {real_time} scheduling, load average {report.load_average:.1f}",
        f"ended: {report.how} {report.why}",
        f"{'period error, ms':<24}{'turns':>8}{'median':>9}{'p99':>9}{'p99.9':>9}{'largest':>9}{'overruns':>10}",
        _timing("control loop", report.loop),
        _timing("nothing to do", report.bare),
        _beside_bare(report),
        f"rows {report.rows}, turns without a row {report.rows_lost}",
        f"frames kept {report.frames_kept}, missing {report.frames_dropped}; force records lost {report.force_lost}; "
        f"replies lost {report.replies_lost}",
        f"{'stiffness step, ms':<24}{'steps':>8}{'median':>9}{'p95':>9}",
        _latency("command sent", steps.command_s),
        _latency("motors moving (10 %)", steps.moving_s),
        _latency("motors there (90 %)", steps.settled_s),
        f"processor: loop {report.cpu_share:.0%}, emulators {report.emulator_cpu_share:.0%}; "
        f"memory {report.memory_mb[0]:.0f} to {report.memory_mb[1]:.0f} MB",
    ]
    return "\n".join(lines) + "\n"


def _beside_bare(report: LoopReport) -> str:
    p99, p999 = report.loop.p99_s / report.bare.p99_s, report.loop.p999_s / report.bare.p999_s
    met = p999 <= MOST_P999 and (p99 <= MOST_P99 or 1e3 * report.loop.p99_s <= MOST_P99_MS)
    wanted = f"expected p99.9 at most {MOST_P999:g}, and p99 at most {MOST_P99:g} or {MOST_P99_MS:g} ms"
    said = f"loop over nothing to do: p99 {p99:.1f}, p99.9 {p999:.1f}; {wanted}: {'met' if met else 'missed'}"
    return said if report.real_time else f"{said}. Real-time priority was not granted, so that this says little."


def _timing(name: str, timing: LoopTiming) -> str:
    errors = (timing.median_s, timing.p99_s, timing.p999_s, timing.largest_s)
    return f"{name:<24}{timing.turns:>8}" + "".join(f"{1e3 * e:>9.3f}" for e in errors) + f"{timing.overruns:>10}"


def _latency(name: str, seconds: list[float]) -> str:
    known = 1e3 * np.array([value for value in seconds if np.isfinite(value)])
    if not known.size:
        return f"{name:<24}{0:>8}"
    return f"{name:<24}{known.size:>8}{np.median(known):>9.2f}{np.quantile(known, 0.95):>9.2f}"


if __name__ == "__main__":
    main()
