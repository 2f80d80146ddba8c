"""The worst cases of the fault matrix, and a few of the others; and the matrix would see lost data: taken away from a
whole run, it is counted."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from benchmarks.fault_matrix import Case, cases
from benchmarks.rig.fault_bench import FaultBench
from benchmarks.rig.fault_case import PHASES, WHOLE_RUN, Outcome, lost_data, run_case, run_wrong
from benchmarks.rig.faults import FAULTS, SURVIVED
from benchmarks.rig.plans import modular_plan

SEED = 14
WORST = [
    Case("commands ignored 1.5 s", "qbmove", "contact"),
    Case("gear jammed 1 s", "qbmove", "load"),
    Case("24 V lost for 1 s", "rigid", "load"),
    Case("encoder of motor 1 frozen", "qbmove", "contact"),
    Case("motor 1 reads 9000 less", "qbmove", "load"),
    Case("both motors read 4096 less", "qbmove", "load"),
    Case("currents of 6 A", "qbmove", "load"),
    Case("force has the wrong axis", "qbmove", "approach"),
    Case("force axis dead", "qbmove", "load"),
    Case("force a fifth", "qbmove", "approach"),
    Case("force stuck", "qbmove", "load"),
    Case("flood of strange sequences", "qbmove", "load"),
    Case("force jumps", "qbmove", "activation"),
    Case("actuator's line flooded", "qbmove", "load"),
    Case("actuator's line flooded", "qbmove", "activation"),
    Case("force sensor's line flooded", "rigid", "load"),
    Case("program killed, watchdog frame lost", "qbmove", "load"),
    Case("push_axis along x", "qbmove", WHOLE_RUN),
    Case("home 9 mm too deep", "qbmove", WHOLE_RUN),
]
_OTHERS = [case for case in cases() if case not in WORST]
FEW = random.Random(SEED).sample(_OTHERS, 6)
MANY = random.Random(SEED + 1).sample([case for case in _OTHERS if case not in FEW], 150)


def _name(case: Case) -> str:
    return ", ".join(case)


def _check(case: Case, folder: Path) -> None:
    if case.phase == WHOLE_RUN:
        outcome = run_wrong(case.fault, folder)
    else:
        outcome = run_case(case.fault, case.phase, folder, rigid=case.actuator == "rigid")
        _check_phase(case, outcome)
    assert outcome.failures() == [], outcome


def _check_phase(case: Case, outcome: Outcome) -> None:
    how, told = (outcome.told["how"], outcome.told["cause"]), outcome.told["phase"]
    if how == SURVIVED or outcome.told["how"] in ("killed", "rejected") or case.phase == "escape":
        return
    if FAULTS[case.fault].later or (case.phase == "activation" and told != case.phase):
        # a contact that is not felt any more is an approach again
        assert PHASES.index(told) >= PHASES.index("approach" if case.phase == "contact" else case.phase)
    else:
        assert told == case.phase


@pytest.mark.parametrize("case", [*WORST, *FEW], ids=_name)
def test_a_fault_ends_as_it_must(case: Case, tmp_path: Path) -> None:
    _check(case, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("case", MANY, ids=_name)
def test_other_faults_end_as_they_must(case: Case, tmp_path: Path) -> None:
    _check(case, tmp_path)


@pytest.fixture
def whole(tmp_path: Path) -> tuple[Path, float]:
    """A run without a fault, and a time within its loading."""
    bench = FaultBench()
    ended = bench.run(modular_plan(1, specimen="S1", f_max_n=2.0, pause_s=0.0), tmp_path)
    assert ended
    assert ended.how == "completed"
    lines = (tmp_path / "log.csv").read_text().splitlines()
    return tmp_path, float(next(line for line in lines if ",retract," in line).split(",")[0])


def test_a_whole_run_lacks_nothing(whole: tuple[Path, float]) -> None:
    assert lost_data(*whole) == (0, 0, 0)


def test_a_row_taken_from_the_log_is_counted(whole: tuple[Path, float]) -> None:
    _without_line(whole[0] / "log.csv", 30)
    assert lost_data(*whole) == (1, 0, 0)


def test_a_row_taken_from_the_forces_is_counted(whole: tuple[Path, float]) -> None:
    _without_line(whole[0] / "press-001" / "force.csv", 30)
    assert lost_data(*whole) == (0, 1, 0)


def test_a_row_cut_short_is_counted(whole: tuple[Path, float]) -> None:
    log = whole[0] / "log.csv"
    log.write_bytes(log.read_bytes()[:-3])
    assert lost_data(*whole) == (1, 0, 0)


def _without_line(path: Path, number: int) -> None:
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:number] + lines[number + 1 :]))
