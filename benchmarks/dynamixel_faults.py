"""Every fault in every phase of a run with an emulated Dynamixel: what the specimen truly felt, how the run ended and
why, whether what it says is true.

Run with ``python -m benchmarks.dynamixel_faults [FAULT ...] [--phase PHASE ...] [--write FOLDER]``. What FOLDER has of
an earlier call is not done again.
"""

from __future__ import annotations

import argparse
import json
from collections import defaultdict
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from benchmarks.bench.record import keep
from benchmarks.rig.dynamixel_faults import (
    D_GAIN,
    FAULTS,
    FULL,
    GAIN,
    GEAR_MM_PER_DEGREE,
    GOAL_A,
    MOTOR_FAULTS,
    TRUE,
    WRONG_RIGS,
    built,
    cap_n,
    ends_in,
)  # fmt: skip
from benchmarks.rig.fault_bench import SPECIMEN
from benchmarks.rig.fault_case import PHASES, TOP, WHOLE_RUN, Outcome, run_fault, run_rig
from benchmarks.rig.faults import FORCE_FAULTS

PROCESSES = 2
LIMIT_N = TRUE.guards.force_n
WRONG_N = 1.0
"""By so much the largest force that a completed run tells may be off; noise and the camera's turns make less."""
LOWER_A = (0.3, 0.25)
SOFTER = ("S3", "S5")
ALL_PHASES = (*PHASES[:5], TOP, *PHASES[5:])
RESULTS = "dynamixel_fault_cases.json"


class Case(NamedTuple):
    """One row. goal_a : what the motor may draw, which caps its force."""

    fault: str
    phase: str
    goal_a: float = GOAL_A
    specimen: str = SPECIMEN


def cases() -> list[Case]:
    """All of them: with lower caps those that may press harder, and on softer specimens those of the motor, which
    has further to go there."""
    usual = [Case(name, phase) for name in FAULTS for phase in ALL_PHASES] + [Case(n, WHOLE_RUN) for n in WRONG_RIGS]
    harder = [(name, phase) for name in (*MOTOR_FAULTS, *FORCE_FAULTS) for phase in ("load", TOP, "escape")]
    moving = ("load", TOP, "retract")
    softer = [Case(name, phase, GOAL_A, soft) for soft in SOFTER for name in MOTOR_FAULTS for phase in moving]
    return usual + [Case(*each, goal_a) for goal_a in LOWER_A for each in harder] + softer


def carry_out(case: Case) -> dict[str, Any]:
    """One case, in a folder of its own."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        if case.phase == WHOLE_RUN:
            told, ends = WRONG_RIGS[case.fault]
            outcome = run_rig(built(case.goal_a, told), ends, folder, LIMIT_N)
        else:
            fault = FAULTS[case.fault]
            wanted = ends_in(fault, case.phase)
            outcome = run_fault(fault, case.phase, built(case.goal_a, specimen=case.specimen), folder, wanted, LIMIT_N)
    return case._asdict() | _row(outcome)


def _row(outcome: Outcome) -> dict[str, Any]:
    told, wrong = outcome.told, outcome.failures()
    felt_n = outcome.most_felt_n
    if told["how"] == "completed" and (felt_n is None or abs(felt_n - outcome.true_n) > WRONG_N):
        wrong.append("another force told")
    return {
        "ended": told["how"], "cause": told["cause"], "ended_in": told["phase"],
        "peak_n": round(outcome.peak_n, 2), "left_n": round(outcome.left_n, 2), "true_n": round(outcome.true_n, 2),
        "felt_n": None if felt_n is None else round(felt_n, 2),
        "retracted_told": told["retracted"], "retracted": outcome.retracted,
        "off_told": told["deactivated"], "off": outcome.off,
        "safe_ms": None if outcome.safe_s is None else round(1e3 * outcome.safe_s),
        "lost": list(outcome.lost), "next_run": outcome.next_run["how"], "fails": wrong,
    }  # fmt: skip


def main() -> None:
    """Print a line for each case as it ends."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("faults", nargs="*", metavar="FAULT", help=", ".join((*FAULTS, *WRONG_RIGS)).replace("%", "%%"))
    parser.add_argument("--phase", nargs="+", choices=(*ALL_PHASES, WHOLE_RUN), default=(*ALL_PHASES, WHOLE_RUN))
    parser.add_argument("--write", type=Path, metavar="FOLDER", help=f"{RESULTS} and dynamixel_faults.json there")
    parser.add_argument("--again", action="store_true", help="do again what FOLDER has")
    arguments = parser.parse_args()
    wanted = [
        case
        for case in cases()
        if case.fault in (arguments.faults or (*FAULTS, *WRONG_RIGS)) and case.phase in arguments.phase
    ]
    path = arguments.write / RESULTS if arguments.write else None
    rows = {} if path is None else read(path)
    if arguments.again:
        rows = {case: row for case, row in rows.items() if case not in wanted}
    left = [case for case in wanted if case not in rows]
    with ProcessPoolExecutor(PROCESSES) as pool:
        for case, row in zip(left, pool.map(carry_out, left, chunksize=4), strict=True):
            rows[case] = row
            print(_line(row), flush=True)
            if path is not None and len(rows) % 20 == 0:
                write(path, rows)
    print("\n".join(_sums(rows.values())))
    if path is not None:
        write(path, rows)
        keep(arguments.write / "dynamixel_faults.json", "\n".join(_page(list(rows.values()))))


def read(path: Path) -> dict[Case, dict[str, Any]]:
    """Rows of before; none without a file."""
    rows = json.loads(path.read_text(encoding="utf-8")) if path.exists() else []
    return {Case(row["fault"], row["phase"], row["goal_a"], row["specimen"]): row for row in rows}


def write(path: Path, rows: dict[Case, dict[str, Any]]) -> None:
    """A row a line, in the order of `cases`."""
    ordered = [json.dumps(rows[case]) for case in cases() if case in rows]
    path.write_text("[\n" + ",\n".join(ordered) + "\n]\n", encoding="utf-8")


def _line(row: dict[str, Any]) -> str:
    ended = f"{row['ended']} {row['cause']}"
    fails = f"FAILS: {'; '.join(row['fails'])}" if row["fails"] else ""
    place = f"{row['fault']:<36}{row['phase']:<11}{row['goal_a']:>5} A {row['specimen']}"
    return f"{place}{row['peak_n']:>6.1f} N  {ended:<30}{fails}"


def _sums(rows: Iterable[dict[str, Any]]) -> Iterator[str]:
    for (goal_a, specimen), own in _groups(rows).items():
        worst = max(own, key=lambda row: float(row["peak_n"]))
        hard = sum(row["peak_n"] > LIMIT_N for row in own)
        passed = sum(not row["fails"] for row in own)
        yield (
            f"{specimen}, goal_current_a = {goal_a:g}, at most {cap_n(goal_a):.1f} N by the motor: "
            f"{len({row['fault'] for row in own})} faults, {len(own)} cases, {passed} passed; largest force "
            f"{worst['peak_n']:.1f} N ({worst['fault']}, {worst['phase']}), {hard} above {LIMIT_N:g} N; "
            f"{sum(any(row['lost']) for row in own)} lost data; "
            f"{sum(row['next_run'] == 'completed' for row in own)} next runs completed"
        )


def _groups(rows: Iterable[dict[str, Any]]) -> dict[tuple[float, str], list[dict[str, Any]]]:
    groups = defaultdict(list)
    for row in rows:
        groups[row["goal_a"], row["specimen"]].append(row)
    return groups


def _page(rows: list[dict[str, Any]]) -> Iterator[str]:
    yield "# Fault matrix of the Dynamixel"
    yield ""
    yield "Made by `python -m benchmarks.dynamixel_faults --write benchmarks/results`; all cases stand in"
    yield f"{RESULTS}. **No real motor was tried.** An XM430-W350 is emulated from its e-Manual: P gain {GAIN}, D gain"
    yield f"{D_GAIN}, {FULL:.1f} N m/rad at the full gain, {GEAR_MM_PER_DEGREE} mm/degree, max_mm_per_s ="
    yield f"{TRUE.max_mm_per_s:g}. One press to 7 N; the limit is guards.force_n = {LIMIT_N:g} N; force is the"
    yield "world's own, every 5 ms, not the sensor's. A press without a fault makes 7.7 N on S1. A case fails"
    yield "when the force is above the limit; when what ended.json says of the probe, of the torque or (completed"
    yield "runs) of the largest force is not true; when the cause is not one that fits; when data from before the fault"
    yield "are lost; when the motor goes on;"
    yield "or when the next run does not work, after a power cycle where the motor asks for one."
    yield ""
    yield "**What it means.** The goal current caps the force, whatever fails, as long as the motor keeps to it: F_max"
    yield "and the overshoot need 8 N here, so that 0.25 A leave room for 2 N. The watchdog stops a motor where it is"
    yield "and keeps its torque on: after a host that dies, or a cable that is pulled, the probe stays on the specimen"
    yield "with the force that it had (column left), until the next run or a hand at the power switch. A force that"
    yield "lags by 100 ms is told by nothing: the press goes on for so long, and its record shows the force that came."
    yield ""
    yield from (f"- {line}" for line in _sums(rows))
    for (goal_a, specimen), group in _groups(rows).items():
        own: dict[str, list[dict[str, Any]]] = defaultdict(list)
        for row in group:
            own[row["fault"]].append(row)
        yield f"\n## {specimen}, goal_current_a = {goal_a:g}\n"
        yield "| fault | cases | largest force N | in | most left N | ended by | torque left on | fails |"
        yield "|---|---|---|---|---|---|---|---|"
        yield from (_summary(fault, each) for fault, each in own.items())


def _summary(fault: str, rows: list[dict[str, Any]]) -> str:
    worst = max(rows, key=lambda row: float(row["peak_n"]))
    causes = dict.fromkeys(row["cause"] or row["ended"] for row in rows)
    held = sum(not row["off"] for row in rows)
    left_n = max(row["left_n"] for row in rows)
    fails = "; ".join(f"{row['phase']}: {', '.join(row['fails'])}" for row in rows if row["fails"])
    return (
        f"| {fault} | {len(rows)} | {worst['peak_n']:.1f} | {worst['phase']} | {left_n:.1f} "
        f"| {', '.join(causes)} | {held or ''} | {fails} |"
    )


if __name__ == "__main__":
    main()
