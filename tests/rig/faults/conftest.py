"""What holds after every fault, whichever it was."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from benchmarks.rig.fault_case import PHASES, Outcome, run_case
from benchmarks.rig.faults import FAULTS, KILLED, STOPPED, SURVIVED

UNHEARD = ("every answer corrupt", "actuator mute", "actuator deaf", "serial line gone")
"""Nothing comes back, so nothing confirms that the motors are off."""
LEFT_S = 0.5
"""Watchdog of a device that cannot be told anything."""
THERE_MM = 0.2


@pytest.fixture
def check(tmp_path: Path) -> Callable[[str, str], None]:
    """Carry out the case of a fault and a phase, and look at everything."""

    def look(name: str, phase: str) -> None:
        outcome = run_case(name, phase, tmp_path)
        assert (outcome.told["how"], outcome.told["cause"]) == outcome.wanted
        _check_phase(name, phase, outcome)
        _check_safe(name, outcome)
        assert outcome.lost == (0, 0, 0)
        assert (outcome.next_run.how, outcome.next_run.repetitions_done) == ("completed", 1)
        assert outcome.next_run.retracted
        assert outcome.next_run.deactivated

    return look


def _check_phase(name: str, phase: str, outcome: Outcome) -> None:
    told = outcome.told["phase"]
    if outcome.wanted in (SURVIVED, KILLED) or phase == "escape":
        return
    if FAULTS[name].later or (phase == "activation" and told != phase):
        assert PHASES.index(told) >= PHASES.index(phase)
    else:
        assert told == phase


def _check_safe(name: str, outcome: Outcome) -> None:
    told, probe = outcome.told, FAULTS[name].probe
    assert outcome.safe_s is not None
    there = abs(outcome.probe_mm) <= THERE_MM
    if outcome.wanted == KILLED:
        # nothing more could be written, but all was done
        assert there
        return
    assert told["deactivated"] == (name not in UNHEARD)
    assert there or not told["retracted"]
    if probe == "left" and outcome.wanted != SURVIVED:
        assert outcome.safe_s <= LEFT_S
    elif told["phase"] != "activation":
        assert there
        assert told["retracted"] == (probe != "unsure")
    if outcome.wanted == STOPPED:
        assert told["why"] == "asked to stop"
