"""Every fault in every phase of a run with an emulated Dynamixel: what the specimen truly felt, how the run ended and
why, whether what it says is true.

Run with ``python -m benchmarks.dynamixel_faults [FAULT ...] [--phase PHASE ...] [--write FOLDER]``. What FOLDER has of
an earlier call is not done again.

A motor that gives way itself has no place where it ought to be: what the guard of the motors' way tells of a qbmove,
here the springs tell, or the current, or a depth, or an encoder that stays the same while the force grows.
"""

from __future__ import annotations

import argparse
import json
from collections import defaultdict
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from benchmarks.bench.record import keep
from benchmarks.rig.fault_bench import SPECIMEN, Built
from benchmarks.rig.fault_case import PHASES, TOP, WHOLE_RUN, Outcome, run_fault, run_rig
from benchmarks.rig.faults import (
    BLIND,
    CAMERA_FAULTS,
    CURRENT,
    DISK_FAULTS,
    ENDINGS,
    FOLLOWING,
    FORCE_FAULTS,
    LINE_FAULTS,
    LOOP_FAULTS,
    LOST_ACTUATOR,
    NO_CONTACT,
    PAST_CONTACT,
    PRELOAD,
    RATE,
    REFUSED,
    REFUSED_FILE,
    REFUSED_SCHEDULE,
    REJECTED,
    SPRINGS,
    SURVIVED,
    TRAVEL,
    UNTRUSTED,
    WAY_HOME,
    End,
    Fault,
    actuator_fault,
    words,
)
from emg2vsa.devices.dynamixel import DynamixelSettings
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.far_ends.dynamixel.table import XM430_W350

GAIN, D_GAIN, GEAR_MM_PER_DEGREE, GOAL_A = 800, 1500, 0.8, 0.4
FULL = XM430_W350.stiffness_nm_per_rad(GAIN)
TRUE = RigSettings(gear_mm_per_degree=GEAR_MM_PER_DEGREE, full_preset=FULL, max_mm_per_s=20.0)
"""Faster, the motor's damping alone looks like a force of more than the guard allows between joint and sensor."""
AT_REST = End("guard", "springs at rest")


def built(goal_current_a: float = GOAL_A, told: RigSettings | None = None, specimen: str = SPECIMEN) -> Built:
    """The bench with a Dynamixel; what it may draw caps the force."""
    motor = DynamixelSettings(
        kind="dynamixel", full_gain=GAIN, d_gain=D_GAIN, full_stiffness_nm_per_rad=FULL, goal_current_a=goal_current_a
    )
    return Built(actuator=motor, true=TRUE, told=told, specimen=specimen)


def cap_n(goal_current_a: float) -> float:
    """Largest force of a motor that draws so much, N."""
    return XM430_W350.torque_constant_nm_per_a * goal_current_a / TRUE.lever_m


STANDS = (FOLLOWING, SPRINGS, AT_REST, UNTRUSTED, CURRENT, NO_CONTACT, PAST_CONTACT, PRELOAD, TRAVEL, WAY_HOME)
"""How a shaft is seen that does not go where it is told, or an encoder that does not tell where it is."""


def _motor(line: str, *ends: End, **more: object) -> Fault:
    return actuator_fault(line, *ends, **more)


MOTOR_FAULTS: dict[str, Fault] = {
    "commands ignored 0.5 s": _motor("ignore for 0.5 s", *STANDS, LOST_ACTUATOR, SURVIVED, probe="left"),
    "commands ignored 1.5 s": _motor("ignore for 1.5 s", *STANDS, LOST_ACTUATOR, probe="left"),
    "commands ignored for ever": _motor("ignore", *STANDS, LOST_ACTUATOR, probe="left"),
    "gear jammed": _motor("jam", *STANDS, probe="left"),
    "gear jammed 1 s": _motor("jam for 1 s", *STANDS, probe="left"),
    "supply broken down": _motor("brown-out", LOST_ACTUATOR, REFUSED, probe="left"),
    "supply broken down for 1 s": _motor("brown-out for 1 s", LOST_ACTUATOR, REFUSED, probe="left"),
    "supply of 17 V": _motor("supply 17", LOST_ACTUATOR, REFUSED, probe="left"),
    "motor weak": _motor("weak 0.02", *STANDS, probe="left"),
    "encoder frozen": _motor("frozen-shaft", *STANDS, probe="left"),
    "encoder reads 90 degrees more": _motor("jumped-shaft 90", *STANDS, LOST_ACTUATOR, probe="left"),
    "encoder reads 90 degrees less": _motor("jumped-shaft -90", *STANDS, LOST_ACTUATOR, probe="left"),
    "encoder reads 20 degrees less": _motor("jumped-shaft -20", *STANDS, probe="left"),
    "encoder reads 5 degrees more": _motor("jumped-shaft 5", *STANDS, probe="left"),
    "encoder reads 5 degrees less": _motor("jumped-shaft -5", *STANDS, probe="left"),
    "encoder reads 1 degree less": _motor("jumped-shaft -1", *STANDS, SURVIVED, REJECTED, probe="left"),
    "current reads 2 A more": Fault(words("current"), (CURRENT,), later=True),
    "motor of 90 degrees C": _motor("hot 90", LOST_ACTUATOR, REFUSED, probe="left"),
    "overload told": _motor("overload", LOST_ACTUATOR, REFUSED, probe="left"),
    "electrical shock told": _motor("shock", LOST_ACTUATOR, REFUSED, probe="left"),
    "broken encoder told": _motor("broken-encoder", LOST_ACTUATOR, REFUSED, probe="left"),
    "watchdog forgotten": Fault(words("no-watchdog"), (SURVIVED,), REFUSED),
    "watchdog says so only": Fault(words("flag-only"), (SURVIVED,)),
}
FAULTS = LINE_FAULTS | MOTOR_FAULTS | LOOP_FAULTS | FORCE_FAULTS | CAMERA_FAULTS | DISK_FAULTS | ENDINGS
FAULTS["force jumps"] = replace(FAULTS["force jumps"], ends=(RATE, UNTRUSTED))  # the springs tell it, too
del FAULTS["program killed, watchdog frame lost"]  # the motor reads it back, and a frame that is lost is sent again

WRONG_RIGS: dict[str, tuple[RigSettings, tuple[End, ...]]] = {
    "push_axis along x": (replace(TRUE, push_axis=(1.0, 0.0, 0.0)), BLIND),
    "push_axis upside down": (replace(TRUE, push_axis=(0.0, 0.0, -1.0)), BLIND),
    "push_sign upside down": (replace(TRUE, push_sign=-1), (TRAVEL, NO_CONTACT, SPRINGS)),
    "home 9 mm too deep": (replace(TRUE, home_deg=11.25), (WAY_HOME, PRELOAD, SPRINGS)),
    "home 4 mm too deep": (replace(TRUE, home_deg=5.0), (WAY_HOME, PRELOAD, SPRINGS)),
    "gear of 0.4 for 0.8": (replace(TRUE, gear_mm_per_degree=0.4), (REFUSED_FILE, REFUSED_SCHEDULE)),
    "gear of 1.6 for 0.8": (replace(TRUE, gear_mm_per_degree=1.6), (REFUSED_FILE, REFUSED_SCHEDULE)),
    "filter of 2000 samples": (replace(TRUE, filter_samples=2000), (REFUSED_FILE, SPRINGS)),
    "loop at 1000 Hz": (replace(TRUE, rate_hz=1000.0), (SURVIVED, REFUSED_FILE)),
}


def ends_in(fault: Fault, phase: str) -> tuple[End, ...]:
    """How the run may end: its activation takes no time on this bench, and near the end of the load much is too
    late to show."""
    if phase == "activation":
        return (*fault.ends, *((fault.activation,) if fault.activation else ()), *((REFUSED,) if fault.later else ()))
    if phase == TOP:
        late = fault.harmless_in or fault.unseen_in or fault.later
        return (*fault.ends, SURVIVED) if late else fault.ends
    return fault.ends_in(phase)


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
