"""Each fault in each phase: always the same way out, the cause recorded, no row lost, and the next run works."""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest

from benchmarks.rig.fault_bench import FaultBench
from benchmarks.rig.fault_case import read_log
from benchmarks.rig.plans import modular_plan
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.durable.append_file import AppendFile
from emg2vsa.errors import DeviceError
from emg2vsa.rig.executor.control_cycle import _answers_in_s
from emg2vsa.worlds.bench.faults import put

PHASES = ("home", "approach", "contact", "load", "retract", "pause")
FAULTS = {
    "too much": ("guard", "force limit"),
    "jump": ("guard", "force rate"),
    "not a number": ("guard", "untrusted force"),
    "saturated": ("guard", "untrusted force"),
    "stale": ("guard", "stale sensor"),
    "dead sensor": ("guard", "stale sensor"),
    "no frames": ("guard", "lost camera"),
    "dead camera": ("guard", "lost camera"),
    "motors off": ("guard", "lost device"),
    "dead actuator": ("guard", "lost device"),
    "one lost reply": ("guard", "lost device"),
    "held up": ("guard", "overrun"),
    "specimen gone": ("guard", "no contact"),
    "SIGTERM": ("stopped", "SIGTERM"),
    "Ctrl-C": ("interrupted", "Ctrl-C"),
    "disk full": ("guard", "recording"),
}
LATER = {"specimen gone", "no frames", "motors off", "stale"}
"""Faults that show only after a while, perhaps in a later phase."""


@pytest.fixture
def times_s(new_bench: Any) -> dict[str, float]:
    return middle_of_phases(new_bench)


@cache
def middle_of_phases(new_bench: Any) -> dict[str, float]:
    """A time in each phase of a run without faults."""
    with TemporaryDirectory() as folder:
        new_bench().run(Path(folder))
        rows = read_log(Path(folder) / "log.csv")
    times = {phase: [row.time_s for row in rows if row.phase == phase and row.repetition < 2] for phase in PHASES}
    return {phase: found[len(found) // 2] - 1e-4 for phase, found in times.items()}


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("fault", FAULTS)
def test_fault(
    fault: str, phase: str, new_bench: Any, times_s: dict[str, float], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench = new_bench(fault=fault, fault_s=times_s[phase])
    if fault == "disk full":
        fill_the_disk(bench, monkeypatch)
    ended = bench.run(tmp_path / "run")
    gives_way = fault == "specimen gone" and phase == "load"
    assert (ended.how, ended.cause) == (("guard", "past contact") if gives_way else FAULTS[fault])
    assert ended.phase == phase or fault in LATER
    assert_safe(bench, ended)
    assert_recorded(bench, ended, tmp_path / "run")


@pytest.mark.parametrize("fault", FAULTS)
def test_the_run_after_a_fault(
    fault: str, new_bench: Any, times_s: dict[str, float], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench = new_bench(fault=fault, fault_s=times_s["load"])
    if fault == "disk full":
        fill_the_disk(bench, monkeypatch)
    assert bench.run(tmp_path / "run").repetitions_done < 2
    monkeypatch.undo()
    bench.fault, bench.sent = "", []
    again = bench.run(tmp_path / "next")
    assert (again.how, again.repetitions_done) == ("completed", 2)


def assert_safe(bench: Any, ended: Any) -> None:
    dead = bench.fault == "dead actuator"
    # a sensor that says it is loaded does not let the probe count as retracted
    loaded = bench.fault in ("too much", "jump")
    assert bench.calls[-1] == "deactivate"
    assert bench.calls[-2] == ("deactivate" if dead else "set")
    # where a force is left the way out looks for where it falls, for 1 mm
    assert bench.sent[-1][0] == (-455 if loaded else 0)
    assert (ended.retracted, ended.deactivated) == (not dead and not loaded, not dead)
    steps = [abs(b[0] - a[0]) for a, b in zip(bench.sent[:-1], bench.sent[1:], strict=True)]
    # ticks: 20 mm/s for 5 ms at 0.2 mm per degree, one for rounding, and a turn of 5 mm/s whose encoders were not read
    assert dead or loaded or max(steps) <= 46 + 12


def assert_recorded(bench: Any, ended: Any, folder: Path) -> None:
    stored = json.loads((folder / "ended.json").read_text())
    assert [stored[key] for key in ("how", "cause", "phase", "rows")] == [
        ended.how, ended.cause, ended.phase, ended.rows,
    ]  # fmt: skip
    rows = read_log(folder / "log.csv")
    assert len(rows) == ended.rows
    logged = [row.force_n for row in rows if row.force_n is not None]
    felt = bench.forces_n[: len(logged)] if bench.fault == "disk full" else bench.forces_n
    assert len(logged) > 3
    assert logged == pytest.approx(felt, abs=1e-6, nan_ok=True)
    if bench.fault == "disk full":
        assert rows[-1].time_s == pytest.approx(bench.fault_s, abs=0.006)


def fill_the_disk(bench: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    append = AppendFile.append

    def full(file: AppendFile, piece: bytes) -> None:
        if bench.on("disk full"):
            raise DeviceError(file.path, wanted="room", found="none", do="Free some.")
        append(file, piece)

    monkeypatch.setattr(AppendFile, "append", full)


@pytest.mark.parametrize("phase", PHASES)
def test_an_error_of_the_program_is_raised_after_the_safe_end(
    phase: str, new_bench: Any, times_s: dict[str, float], tmp_path: Path
) -> None:
    bench = new_bench(fault="bug", fault_s=times_s[phase])
    with pytest.raises(ZeroDivisionError):
        bench.run(tmp_path)
    assert bench.calls[-2:] == ["set", "deactivate"]
    assert bench.sent[-1][0] == 0
    stored = json.loads((tmp_path / "ended.json").read_text())
    assert (stored["how"], stored["cause"], stored["phase"]) == ("failed", "ZeroDivisionError", phase)
    assert stored["rows"] == len(read_log(tmp_path / "log.csv")) == len(bench.forces_n)


def test_a_refused_activation_is_recorded_and_moves_nothing(new_bench: Any, tmp_path: Path) -> None:
    bench = new_bench(fault="refusal", fault_s=0.0)
    ended = bench.run(tmp_path)
    assert (ended.how, ended.cause, ended.phase) == ("guard", "activation", "activation")
    assert "qbmove 1, refusal" in ended.why
    assert bench.calls == ["activate", "deactivate"]


@pytest.mark.parametrize(("line", "refused"), [("late 16", True), ("late 3", True), ("late 2", False)])
def test_a_slow_line_is_refused_before_the_motors_go_on(line: str, refused: bool, tmp_path: Path) -> None:
    bench = FaultBench()
    put(bench.emulated, line)
    ended = bench.run(modular_plan(1, specimen="S1", f_max_n=2.0, pause_s=0.0), tmp_path)
    assert ended is not None
    assert (ended.cause == "slow line") == refused
    if refused:
        assert (ended.how, ended.phase, ended.peak_force_n) == ("guard", "activation", None)
        assert f"answers after {line.split()[1]}.0 ms, more than half a turn" in ended.why
        assert "latency timer of its USB adapter to 1 ms" in ended.why


@pytest.mark.parametrize(("late_of_ten", "slow"), [(7, False), (10, True)])
def test_a_busy_computer_is_no_slow_line(late_of_ten: int, slow: bool) -> None:
    clock, asked = VirtualClock(), iter(range(10**6))

    class Actuator:
        def measurements(self) -> None:
            clock.sleep_until(clock.now_s() + (0.02 if next(asked) % 10 < late_of_ten else 0.001))

    actuator: Any = Actuator()
    assert (_answers_in_s(actuator, clock) > 0.0025) == slow


def test_a_second_ctrl_c_does_not_stop_the_way_out(new_bench: Any, times_s: dict[str, float], tmp_path: Path) -> None:
    bench = new_bench(fault="Ctrl-C", fault_s=times_s["load"])
    sleep, sleeps = bench.clock.sleep_until, iter(range(10**6))

    def impatient(time_s: float) -> None:
        sleep(time_s)
        if bench.fault == "" and next(sleeps) == 2:
            raise KeyboardInterrupt

    bench.clock.sleep_until = impatient
    ended = bench.run(tmp_path)
    assert (ended.how, ended.retracted, ended.deactivated) == ("interrupted", True, True)
    assert ended.notes[0] == "KeyboardInterrupt"
    assert bench.sent[-1][0] == 0
    assert bench.calls[-1] == "deactivate"


def test_motors_that_do_not_go_off_are_told_three_times(
    new_bench: Any, times_s: dict[str, float], tmp_path: Path
) -> None:
    bench = new_bench(fault="dead actuator", fault_s=times_s["load"])
    ended = bench.run(tmp_path)
    assert bench.calls[-3:] == ["deactivate"] * 3
    assert not ended.deactivated
    assert any("qbmove 1" in note for note in ended.notes)


def test_the_row_of_the_fault_is_in_the_log(new_bench: Any, times_s: dict[str, float], tmp_path: Path) -> None:
    bench = new_bench(fault="not a number", fault_s=times_s["load"])
    bench.run(tmp_path)
    rows = [row for row in read_log(tmp_path / "log.csv") if row.phase == "load"]
    assert math.isnan(rows[-1].force_n or 0)
    assert rows[-1].position_deg == rows[-2].position_deg
    assert rows[-1].at is None
