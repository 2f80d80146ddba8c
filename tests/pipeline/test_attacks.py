"""What a hostile laboratory found: runs that were cut short, folders that changed unseen, reports of others."""

import json
import os
import time
from dataclasses import dataclass
from pathlib import Path

import pytest

from emg2vsa import artifacts
from emg2vsa.cli import main
from emg2vsa.errors import SettingError
from emg2vsa.pipeline import fingerprint, shared_settings, tasks
from emg2vsa.pipeline.campaign import campaign
from emg2vsa.pipeline.fingerprint import Fingerprints, Values
from emg2vsa.pipeline.stage import Given, Stage
from emg2vsa.pipeline.stages import emulation, runs
from emg2vsa.pipeline.store import WrittenFiles, remove_left_files
from emg2vsa.rig.executor.guards import GUARDS
from emg2vsa.rig.experiment import ExperimentSettings, Run
from emg2vsa.rig.record.ended import Ended
from emg2vsa.study_file import load_study
from emg2vsa.worlds.bench import virtual_run
from emg2vsa.worlds.bench.settings import EmulatedSettings
from tests.small import study_of_files, study_of_runs

PEOPLE = study_of_files(name="b", emg='[channels.emg.EDC]\nname = "EDC"\nunit = "V"\n').replace(
    "[participants]", 'reports = "out"\n[participants]'
)


@pytest.mark.parametrize(
    ("how", "cause", "on_disk", "error"),
    [
        ("interrupted", "Ctrl-C", "interrupted", KeyboardInterrupt),
        ("guard", "recording", "guard", OSError),
        ("completed", "", "killed", OSError),
        ("guard", "force", "guard", None),
    ],
)
def test_an_emulated_run_that_the_computer_cut_short_is_no_result(
    how: str,
    cause: str,
    on_disk: str,
    error: type[BaseException] | None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def cut_short(*given: object, started: object, effect: object, actuator: object) -> Ended:
        folder = given[3]
        folder.mkdir()
        (folder / "ended.json").write_text(json.dumps({"how": on_disk}))
        return Ended(how, cause, "no room", "load", 1, 1.0, "")

    monkeypatch.setattr(virtual_run, "run_virtual", cut_short)
    experiment, of = ExperimentSettings(specimens=("S1",)), Run("S1", 0.0, "high-stiffness")
    used = {"run": of, "experiment": experiment, "rig": None, "emulated": EmulatedSettings(), "order": None}
    given = Given(of.name, used, inputs={"schedules": []}, folder=tmp_path)
    if error is None:
        assert [path.name for path in emulation.run(given)] == ["ended.json"]
        return
    with pytest.raises(error):
        emulation.run(given)
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_is_said_plainly_and_the_step_is_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(given: Given) -> None:
        raise OSError(28, "No space left on device", "x.svg")

    monkeypatch.setattr(tasks, "stage", lambda name: Stage(per="study", of="people", run=full))
    ended = tasks.Task("fits/study", Given("study", {}), tmp_path / "u", tmp_path / "c")()
    assert (ended.status, ended.final) == ("failed", False)
    assert ended.message == "x.svg: No space left on device. Mend that, and run the study again."


@dataclass
class _Lab:
    folder: Path

    def key(self) -> tuple[str, list[str]]:
        """What a change of the measured run changes."""
        found = campaign(load_study(self.folder / "study.toml"))
        (item,) = found.runs
        prints = Fingerprints(self.folder / "memory")
        files = [f"{path} {prints.file(path)}" for of in runs.files(found, item).values() for path in of]
        return Values().part(runs.settings(found, item))[0].digest, files


@pytest.fixture
def lab(tmp_path: Path) -> _Lab:
    (tmp_path / "study.toml").write_text(study_of_runs("lab", "runs", ["S1"]))
    press = tmp_path / "runs" / "monday" / "press-001"
    press.mkdir(parents=True)
    (press / "force.csv").write_text("time_s,force_n\n")
    (tmp_path / "runs" / "runs.tsv").write_text("folder\tspecimen\tangle_deg\tcondition\nmonday\tS1\t0\tmodular\n")
    return _Lab(tmp_path)


def test_a_press_folder_without_files_makes_a_measured_run_stale(lab: _Lab) -> None:
    before = lab.key()
    (lab.folder / "runs" / "monday" / "press-002").mkdir()
    assert lab.key() != before


def test_frames_behind_a_link_belong_to_the_run(lab: _Lab) -> None:
    archive = lab.folder / "archive"
    archive.mkdir()
    (archive / "0.png").write_bytes(b"0")
    (lab.folder / "runs" / "monday" / "press-001" / "frames").symlink_to(archive, target_is_directory=True)
    before = lab.key()
    (archive / "0.png").write_bytes(b"1")
    assert lab.key() != before


def test_a_file_dated_in_the_future_that_changed_just_now_is_read_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "recording"
    path.write_bytes(b"a")
    now = time.time_ns()
    state = (1, now + 10**15, now, 7)  # both changes within one tick of the file system's clock
    monkeypatch.setattr(fingerprint, "state_of", lambda path: state)
    prints = Fingerprints(tmp_path / "memory")
    before = prints.file(path)
    path.write_bytes(b"b")
    assert prints.file(path) != before


def test_schedules_do_not_go_into_the_report_of_another_study(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.toml").touch()
    (tmp_path / "b.toml").write_text(PEOPLE)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / ".study.json").write_text(json.dumps({"study": "a", "file": "../a.toml"}))
    assert main(["schedule", str(tmp_path / "b.toml")]) == 2
    assert "found the report of the study 'a'" in capsys.readouterr().err
    assert sorted(os.listdir(tmp_path)) == ["a.toml", "b.toml", "out"]


def test_a_moved_project_names_its_own_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    old, new = tmp_path / "old", tmp_path / "new"
    old.mkdir()
    (old / "b.toml").write_text(PEOPLE)
    (old / "P01_S1.csv").write_text("nothing of use\n")
    for folder in (old, new):
        main(["run", str(folder / "b.toml"), "--only", "trials", "--jobs", "1"])
        told = capsys.readouterr().err
        assert f"{folder}{os.sep}P01_S1.csv: expected" in told
        if folder == old:
            old.rename(new)
            ledger = (new / ".emg2vsa" / "b" / "ledger.jsonl").read_bytes()
    assert (new / ".emg2vsa" / "b" / "ledger.jsonl").read_bytes() == ledger  # not run again


def test_a_result_of_another_stage_among_those_of_a_page_removes_nothing(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    page.touch()
    artifacts.save(tmp_path / "foreign.result", Ended("completed", "", "", "done", 1, 1.0, ""))
    artifacts.save(tmp_path / "own.result", WrittenFiles(("left.html",), ("0",)))
    (tmp_path / "left.html").touch()
    remove_left_files(tmp_path, sorted(tmp_path.glob("*.result")), WrittenFiles(("page.html",), ("0",)))
    assert page.exists()
    assert not (tmp_path / "left.html").exists()


def test_a_press_that_the_emulated_rig_did_not_make_is_noticed(tmp_path: Path) -> None:
    run, written = tmp_path / "S1_0_modular", WrittenFiles(("S1_0_modular/press-001/frames.tif",), ("0",))
    for press in ("press-001", "press-002"):
        (run / press).mkdir(parents=True)
        (run / press / ".DS_Store").touch()
    (run / "press-001" / "frames.tif").touch()
    assert written.besides(tmp_path, run) == ""
    (run / "press-002" / "frames.tif").touch()
    assert written.besides(tmp_path, run) == "S1_0_modular/press-002/frames.tif"
    assert emulation.STAGE.alone_in is not None


def test_a_study_does_not_press_with_guards_that_its_store_cannot_know(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert shared_settings._changed_guards() == ()
    monkeypatch.setitem(GUARDS, "our own", lambda moment, limits: None)
    monkeypatch.delitem(GUARDS, "torque")
    changed = shared_settings._changed_guards()
    assert changed == ("our own", "torque")
    given = Given("S1_0_high-stiffness", {"changed_guards": changed}, inputs={}, folder=tmp_path)
    with pytest.raises(SettingError, match="found our own, torque changed by this program"):
        emulation.run(given)
