"""``emg2vsa.rig`` as a program or a notebook uses it."""

from __future__ import annotations

import ast
import importlib
import os
from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from pathlib import Path

import pytest

from benchmarks.rig.plans import known_calibration
from emg2vsa import rig
from emg2vsa.calibration_file import write_calibration
from emg2vsa.errors import DataError, DeviceError, SettingError
from emg2vsa.lab.rig_lock import rig_lock
from emg2vsa.lab.sequence import DONE_BEFORE
from emg2vsa.rig.executor.guards import GUARDS, Moment
from emg2vsa.rig.rig_settings import GuardSettings
from emg2vsa.rig_file import RigFile


def test_every_public_name_is_there_and_typed() -> None:
    stub = ast.parse(Path(rig.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    imported = {name.name: node.module for node in stub.body if isinstance(node, ast.ImportFrom) for name in node.names}
    assert set(imported) == set(rig.__all__) <= set(dir(rig))
    for name, module in imported.items():
        assert getattr(rig, name) is getattr(importlib.import_module(str(module)), name)
        assert getattr(rig, name).__doc__
    with pytest.raises(AttributeError, match="has no attribute 'fly'"):
        rig.fly  # type: ignore[attr-defined]  # noqa: B018
    assert importlib.import_module("emg2vsa.rig.plan").RunPlan


def test_a_virtual_press_has_a_log_of_force_over_depth(
    file: RigFile, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = rig.press(file, "S3", 0, "high-stiffness", folder=tmp_path / "mine", virtual=True)
    assert (run.folder, run.completed, run.left_safe) == (tmp_path / "mine" / "S3_0_high-stiffness", True, True)
    log = run.log
    loading = log[log["phase"] == "load"]
    assert loading["depth_mm"].is_monotonic_increasing
    assert 3 < loading["depth_mm"].iloc[-1] < 8
    assert loading["force_n"].iloc[-1] == pytest.approx(4, abs=0.7)
    with pytest.raises(DataError, match="expected a run that is still to do"):
        rig.press(file, "S3", 0, "high-stiffness", folder=tmp_path / "mine", virtual=True)
    assert capsys.readouterr() == ("", "")
    with pytest.raises(SettingError, match="specimen: expected S1, S3, but found S9"):
        rig.press(file, "S9", virtual=True)


def test_a_sequence_goes_on_where_it_was_stopped(file: RigFile) -> None:
    heard: list[str] = []
    (run,) = rig.sequence(file, file.experiment.all_runs()[1:], virtual=True, jobs=1).runs
    done = rig.sequence(file, virtual=True, jobs=1, person=rig.Person(note=heard.append))
    assert [each.specimen for each, _ in done.pressed] == ["S1"]
    assert (done.not_pressed, done.left, done.good) == ({run: DONE_BEFORE}, 0, True)
    assert len(heard) == 1
    assert heard[0].startswith("2/2 S1_0_high-stiffness: completed: 1 of 1 presses, ")
    with pytest.raises(DataError, match="expected order listed"):
        rig.sequence(file, virtual=True, order="listed")


def test_a_guard_of_the_program_is_asked_however_many_processes_are_wanted(
    file: RigFile, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = GUARDS["force limit"]
    limit_n = 0.5

    @wraps(own)
    def stricter(moment: Moment, limits: GuardSettings) -> str | None:
        return own(moment, limits) or ("our own" if moment.force_n > limit_n else None)

    monkeypatch.setitem(GUARDS, "force limit", stricter)
    done = rig.sequence(file, virtual=True, jobs=2)
    assert [(one.ended.cause, one.ended.why) for _, one in done.pressed] == [("force limit", "our own")] * 2
    assert not done.good


def test_a_plate_is_pressed_once(file: RigFile) -> None:
    heard: list[str] = []
    (plate,) = rig.plates(file, ["S3"], virtual=True)
    assert plate.completed
    assert plate.folder == file.path.parent / "runs-virtual-plate" / "S3"
    assert not list(plate.folder.glob("press-*"))
    assert rig.plates(file, ["S3"], virtual=True, person=rig.Person(warn=heard.append)) == ()
    assert heard == ["S3: done before"]


def test_an_unknown_specimen_is_pressed_until_it_is_known(file: RigFile, tmp_path: Path) -> None:
    slow = replace(file, experiment=replace(file.experiment, ramp_mm_per_s=2.0))
    judging = rig.Judging((write_calibration(tmp_path / "known.json", known_calibration()),), stop_at=0.6)
    told: list[str] = []
    found = rig.adaptive(slow, "S3", judging, presses=3, virtual=True, person=rig.Person(say=told.append))
    assert found.completed
    assert found.belief.low_n_per_mm < 3.35 < found.belief.high_n_per_mm
    assert told[1].startswith("next: presses: ")
    chosen = rig.next_presses(judging.calibrations, [one.folder for _, one in found.pressed], stop_at=0.6)
    assert chosen.belief == found.belief
    assert (chosen.chosen is None) is (found.left > 0)


def test_a_dry_run_tells_what_would_be_sent_or_why_not(file: RigFile) -> None:
    told = rig.dry_run(file)
    assert {run.specimen for run in told} == {"S1", "S3"}
    assert all(not isinstance(found, str) and found.repetitions == 1 for found in told.values())
    strong = replace(file, experiment=replace(file.experiment, f_max_n=40.0))
    assert all(isinstance(found, str) and "40" in found for found in rig.dry_run(strong).values())


USES = {
    "press": lambda file: rig.press(file, "S3", 0, "high-stiffness"),
    "jog": lambda file: rig.jog(file, mm=1.0),
    "proven_watchdog": lambda file: rig.proven_watchdog(file, person=rig.Person(yes=True)),
    **{name: getattr(rig, name) for name in ("home", "tare", "zero", "parameters", "info", "scan")},
}


@pytest.mark.parametrize("name", USES)
def test_a_rig_that_another_uses_is_left_alone(name: str, file: RigFile) -> None:
    found = f"no other process uses, but found process {os.getpid()}"
    with rig_lock(file.path), pytest.raises(DeviceError, match=found):
        USES[name](file)
    assert not file.runs.exists()


def test_nothing_is_opened_where_the_answer_is_no(file: RigFile) -> None:
    asked: list[str] = []

    def no(question: str) -> str:
        asked.append(question)
        return "q" if "stop" in question else "n"

    person = rig.Person(ask=no)
    assert rig.check_settings(file, person=person) is None
    assert rig.proven_watchdog(file, person=person) is None
    assert asked[:2] == ["Ready? [y/N] ", "Is the probe free, with 1 mm of way on both sides? [y/N] "]
    done = rig.sequence(file, order="listed", person=person)
    assert (done.pressed, done.left, done.good) == ((), 2, False)
    assert asked[2].startswith("1/2: put S1 at 0 degrees under the rigid motor, 1 presses. ")


def test_nothing_moves_where_nobody_answers(file: RigFile) -> None:
    for asks in (rig.check_settings, rig.proven_watchdog, rig.sequence, lambda file: rig.plates(file, ["S3"])):
        with pytest.raises(SettingError, match=r"person: expected an answer to '.*', but found nobody who is asked"):
            asks(file)
    assert not list(file.runs.glob("*/*"))


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda file: rig.press(file, "S3", 0, "high-stiffness", virtual=True, presses=1.5), "presses: .* found 1.5"),
        (lambda file: rig.press(file, "S3", 0, "high-stiffness", virtual=True, presses=0), "presses: .* found 0"),
        (lambda file: rig.sequence(file, virtual=True, jobs=-1), "jobs: expected a whole number from 1"),
        (lambda file: rig.sequence(file, virtual=True, order="bogus"), "order: expected random or listed"),
        (lambda file: rig.sequence(file, virtual=True, seed="x"), "seed: expected a whole number"),
        (lambda file: rig.sequence(file, ["S1_0"], virtual=True), "runs: expected runs of the rig file"),
        (lambda file: rig.sequence(file, presses=2), "presses: expected a virtual sequence"),
        (lambda file: rig.adaptive(file, "S3", rig.Judging(), virtual=True), "judging: expected calibrations"),
        (lambda file: rig.camera_delay([]), "paths: expected folders of runs"),
    ],
)
def test_what_cannot_be_is_refused_before_anything_moves(
    call: Callable[[RigFile], object], said: str, file: RigFile
) -> None:
    with pytest.raises(SettingError, match=said):
        call(file)
    assert not list(file.path.parent.glob("runs*"))


def test_one_of_two_ways_is_wanted_of_a_jog(file: RigFile) -> None:
    with pytest.raises(SettingError, match="jog: expected mm or deg, but found both or neither"):
        rig.jog(file)


def test_a_device_that_is_not_there_is_told(file: RigFile) -> None:
    heard: list[str] = []
    states = rig.info(file, rig.Person(say=heard.append))
    assert [(state.device.split()[0], state.usable) for state in states] == [
        ("[actuator]", False), ("[motor]", False), ("[force]", False),
    ]  # fmt: skip
    assert heard[1] == f"  not usable: {states[0].problem}"
    assert [(one.device, one.at) for one in rig.off(file.path)] == [("actuator", None), ("motor", None)]
