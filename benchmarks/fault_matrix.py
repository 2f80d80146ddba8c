"""Every fault in every phase of a run on the emulated rig, under the qbmove and under the rigid motor: what the
specimen felt, how the run ended and why, whether what it says is true, what was lost.

Run with ``python -m benchmarks.fault_matrix [FAULT ...] [--phase PHASE ...] [--write FOLDER]``. The tests carry out
some of these cases.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from itertools import groupby
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from benchmarks.bench.record import keep
from benchmarks.rig.fault_case import MOST_N, PHASES, WHOLE_RUN, Outcome, run_case, run_wrong
from benchmarks.rig.faults import FAULTS, FORCE_FAULTS, MOTOR_FAULTS, WRONG_RIGS

PROCESSES = 2
OF_THE_ACTUATOR = (*MOTOR_FAULTS, *FORCE_FAULTS)
"""What may end differently under the rigid motor; of all else one phase shows that it does not."""
ONCE = ("load",)
BEFORE = Path(__file__).parent / "results" / "fault_matrix_before.csv"
HEAD = (
    "fault,actuator,phase,ended,cause,peak_n,left_n,retracted_told,retracted_true,off_told,off_true,retreat_after_ms,"
    "lost_rows,lost_forces,lost_frames,next_run,failures"
)


class Case(NamedTuple):
    """One row of the matrix."""

    fault: str
    actuator: str
    phase: str


def main() -> None:
    """Print a line for each case as it ends."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("faults", nargs="*", metavar="FAULT", help=", ".join((*FAULTS, *WRONG_RIGS)).replace("%", "%%"))
    parser.add_argument("--phase", nargs="+", choices=(*PHASES, WHOLE_RUN), default=(*PHASES, WHOLE_RUN))
    parser.add_argument("--actuator", nargs="+", choices=("qbmove", "rigid"), default=("qbmove", "rigid"))
    parser.add_argument("--write", type=Path, metavar="FOLDER", help="fault_matrix.csv and fault_matrix.json there")
    arguments = parser.parse_args()
    wanted = [
        case
        for case in cases()
        if case.fault in (arguments.faults or (*FAULTS, *WRONG_RIGS))
        and case.phase in arguments.phase
        and case.actuator in arguments.actuator
    ]
    rows: list[tuple[Case, Outcome]] = []
    with ProcessPoolExecutor(PROCESSES) as pool:
        for case, outcome in zip(wanted, pool.map(carry_out, wanted, chunksize=4), strict=True):
            rows.append((case, outcome))
            print(_line(case, outcome), flush=True)
    print("\n".join(_sums(rows)))
    if arguments.write:
        with (arguments.write / "fault_matrix.csv").open("w", encoding="utf-8", newline="") as table:
            writer = csv.writer(table, lineterminator="\n")
            writer.writerow(HEAD.split(","))
            writer.writerows(_cells(case, outcome) for case, outcome in rows)
        keep(arguments.write / "fault_matrix.json", "\n".join(_page(rows)))


def cases() -> list[Case]:
    """All of them."""
    under = [
        Case(name, actuator, phase)
        for actuator in ("qbmove", "rigid")
        for name, fault in FAULTS.items()
        if actuator == "qbmove" or not fault.springs_only
        for phase in (PHASES if actuator == "qbmove" or name in OF_THE_ACTUATOR else ONCE)
    ]
    wrong = [Case(name, "rigid" if built.rigid else "qbmove", WHOLE_RUN) for name, (built, _) in WRONG_RIGS.items()]
    return under + wrong


def carry_out(case: Case) -> Outcome:
    """One case, in a folder of its own."""
    with TemporaryDirectory() as folder:
        if case.phase == WHOLE_RUN:
            return run_wrong(case.fault, Path(folder))
        return run_case(case.fault, case.phase, Path(folder), rigid=case.actuator == "rigid")


def _cells(case: Case, outcome: Outcome) -> list[str]:
    told = outcome.told
    after_ms = "" if outcome.retreat_s is None else f"{1e3 * outcome.retreat_s:.0f}"
    truths = (told["retracted"], outcome.retracted, told["deactivated"], outcome.off)
    return [
        *case, told["how"], told["cause"], f"{outcome.peak_n:.1f}", f"{outcome.left_n:.1f}",
        *("yes" if each else "no" for each in truths), after_ms, *map(str, outcome.lost),
        outcome.next_run["how"], "; ".join(outcome.failures()),
    ]  # fmt: skip


def _line(case: Case, outcome: Outcome) -> str:
    told, failures = outcome.told, outcome.failures()
    return (
        f"{case.fault:<36}{case.actuator:<8}{case.phase:<11}{outcome.peak_n:>6.1f} N  "
        f"{told['how'] + ' ' + told['cause']:<30}{'FAILS: ' + '; '.join(failures) if failures else ''}"
    )


def _sums(rows: list[tuple[Case, Outcome]]) -> Iterator[str]:
    for actuator in ("qbmove", "rigid"):
        outcomes = [outcome for case, outcome in rows if case.actuator == actuator]
        if not outcomes:
            continue
        passed = sum(not outcome.failures() for outcome in outcomes)
        worst = max(outcome.peak_n for outcome in outcomes)
        # a log that cannot be written does not tell of the way out
        logged = [o for o in outcomes if o.movable and o.told["cause"] != "recording"]
        retreats_s = [o.guard_s for o in logged if o.guard_s is not None]
        latest_ms = 1e3 * max(retreats_s, default=0.0)
        next_whole = sum(o.next_run["how"] == "completed" for o in outcomes)
        hard = sum(outcome.peak_n > outcome.most_n for outcome in outcomes)
        yield (
            f"{actuator}: {len(outcomes)} cases, {passed} passed; "
            f"largest force {worst:.1f} N, {hard} above what is allowed; "
            f"{sum(any(o.lost) for o in outcomes)} lost data; "
            f"{next_whole} next runs completed; where the probe could be moved, the first command of the way out "
            f"came at most {latest_ms:.1f} ms after the guard (virtual time: waiting counts, computing does not)"
        )


def _page(rows: list[tuple[Case, Outcome]]) -> Iterator[str]:
    yield "# Fault matrix"
    yield ""
    yield "Made by `python -m benchmarks.fault_matrix --write benchmarks/results`; all cases stand in fault_matrix.csv."
    yield f"One press on S1 to 7 N, limit 10 N; no fault may put more than {MOST_N:g} N on the specimen. Force is the"
    yield "world's own, not the sensor's. A case fails also when what ended.json says of the probe or the motors is not"
    yield "true, when a completed run has not retracted, when the cause is not one that fits, when data from before the"
    yield "fault are lost, or when the next run does not work. Before is what the same fault did to version 0.1.0,"
    yield "where that was more than 10 N (fault_matrix_before.csv)."
    yield ""
    yield from _sums(rows)
    with BEFORE.open(encoding="utf-8") as table:
        before = {(row["fault"], row["actuator"]): row["peak_n"] for row in csv.DictReader(table)}
    for actuator in ("qbmove", "rigid"):
        of_it = [row for row in rows if row[0].actuator == actuator]
        if not of_it:
            continue
        yield f"\n## Under the {'rigid motor' if actuator == 'rigid' else 'qbmove'}\n"
        yield "| fault | before N | largest force N | in | ended by | latest retreat after ms | fails |"
        yield "|---|---|---|---|---|---|---|"
        for fault, group in groupby(of_it, key=lambda row: row[0].fault):
            yield _summary(fault, before.get((fault, actuator), ""), list(group))


def _summary(fault: str, before_n: str, rows: list[tuple[Case, Outcome]]) -> str:
    worst_case, worst = max(rows, key=lambda row: row[1].peak_n)
    causes = dict.fromkeys(outcome.told["cause"] or outcome.told["how"] for _, outcome in rows)
    retreats = [outcome.retreat_s for _, outcome in rows if outcome.retreat_s is not None]
    latest = f"{1e3 * max(retreats):.0f}" if retreats else ""
    fails = "; ".join(f"{case.phase}: {', '.join(o.failures())}" for case, o in rows if o.failures())
    return (
        f"| {fault} | {before_n} | {worst.peak_n:.1f} | {worst_case.phase} | {', '.join(causes)} | {latest} | {fails} |"
    )


if __name__ == "__main__":
    main()
