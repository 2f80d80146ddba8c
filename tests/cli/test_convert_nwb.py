"""Recordings and runs as NWB: read back by pynwb as they were recorded, presses and phases with them."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import tifffile

from emg2vsa.cli import main
from emg2vsa.devices.protocols import LogColumns
from emg2vsa.readers.roles import read_roles
from emg2vsa.rig.record.run_log import header_of
from emg2vsa.study_file import load_study

PHASES = ("home", "approach", "load", "retract")


def run_folder(folder: Path, *, emulated: bool = False) -> Path:
    """A run of one press: 40 turns of 5 ms, ten a phase, six frames, one of unknown time."""
    press = folder / "press-001"
    press.mkdir(parents=True)
    header = header_of(LogColumns())
    rng = np.random.default_rng(1)
    log = pd.DataFrame({name: rng.normal(size=40).round(6) for name in header})
    log["time_s"] = 0.005 * np.arange(40)
    log["phase"] = np.repeat(PHASES, 10)
    log["repetition"] = 1
    log[header[-1]] = np.nan  # a column that was never measured
    log.to_csv(folder / "log.csv", index=False)
    plan = {"specimen": "S1", "angle_deg": 30, "condition": "modular"}
    clock = {"zero_utc": "2026-05-02T10:00:00+00:00"}
    (folder / "plan.json").write_text(json.dumps({"plan": plan, "clock": clock, "rig": {}, "devices": {}}))
    (folder / "ended.json").write_text('{"how": "completed"}')
    (folder / "presses.csv").write_text("repetition,verdict,why,begun_s,turned_s,peak_force_n\n1,ok,,0.05,0.15,7.5\n")
    if emulated:
        (folder / "emulated.json").write_text("{}")
    frames = rng.integers(0, 255, (6, 8, 10), dtype=np.uint8)
    tifffile.imwrite(press / "frames.tif", frames, photometric="minisblack")
    rows = [f"{0.05 + 0.01 * i:.3f},{i},{i},{'' if i == 2 else f'{0.048 + 0.01 * i:.3f}'}" for i in range(6)]
    (press / "force.csv").write_text("\n".join(["time_s,force_n,frame_index,frame_time_s", *rows]) + "\n")
    return folder


@pytest.fixture(scope="module")
def converted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sample study with people and a run, converted."""
    pytest.importorskip("pynwb", reason="the extra nwb is not installed")
    folder = tmp_path_factory.mktemp("nwb")
    study = folder / "study.toml"
    assert main(["tools", "sample", "study", "--out", str(folder), "--json"]) == 0
    (folder / "people.tsv").write_text("participant_id\tage\tsex\thandedness\nP01\t31\tF\tright\nP02\t\t\t\n")
    text = study.read_text()
    head, _, rest = text.partition("[participants]")
    rest = rest[rest.index("[[specimens]]") :]
    study.write_text(f'{head}[participants]\nfile = "people.tsv"\n\n{rest}\n[runs]\nroot = "runs"\n')
    run_folder(folder / "runs" / "S1_30_modular", emulated=False)
    assert main(["tools", "convert", str(study), "--out", str(folder / "nwb"), "--format", "nwb", "--json"]) == 0
    return folder


def opened(path: Path) -> Any:
    import pynwb

    return pynwb.NWBHDF5IO(path, "r").read()


def test_a_recording_is_read_back_as_it_was_recorded(converted: Path) -> None:
    study = load_study(converted / "study.toml")
    for entry in study.recordings:
        roles = read_roles(entry.emg_file, None, entry.channels)
        stem = f"sub-{entry.participant}_task-palpation_acq-{entry.specimen}"
        file = opened(converted / "nwb" / f"sub-{entry.participant}" / f"{stem}.nwb")
        for name, channel in [*roles.emg.items(), ("pressing_force", roles.force)]:
            series = file.acquisition[name]
            np.testing.assert_array_equal(series.data[:], channel.samples)
            assert (series.rate, series.unit) == (channel.fs_hz, "newtons" if name == "pressing_force" else "volts")
        electrodes = file.acquisition["EDC"].electrodes.to_dataframe()
        assert list(electrodes["location"]) == ["belly of the extensor digitorum communis"]
        assert "does not state when it began" in file.session_description


def test_presses_are_trials_with_their_verdicts(converted: Path) -> None:
    file = opened(converted / "nwb" / "sub-P01" / "sub-P01_task-palpation_acq-S1.nwb")
    trials = file.trials.to_dataframe()
    assert list(trials["repetition"].astype(int)) == [1, 2, 3, 4]
    assert set(trials["verdict"]) <= {"ok", "doubtful", "rejected"}
    assert (trials["stop_time"] > trials["start_time"]).all()
    force = file.acquisition["pressing_force"]
    for trial in trials.itertuples():
        within = force.data[int(trial.start_time * force.rate) : int((trial.stop_time + 0.5) * force.rate)]
        assert np.max(within) == pytest.approx(trial.peak_force, rel=0.05)


def test_age_and_sex_are_those_of_the_table(converted: Path) -> None:
    one, other = (
        opened(converted / "nwb" / f"sub-{who}" / f"sub-{who}_task-palpation_acq-S1.nwb").subject
        for who in ("P01", "P02")
    )
    assert (one.subject_id, one.age, one.sex, one.species) == ("P01", "P31Y", "F", "Homo sapiens")
    assert one.description == "handedness: right"
    assert (other.age, other.sex) == (None, "U")


def test_a_run_is_read_back_column_by_column_and_frame_by_frame(converted: Path) -> None:
    folder = converted / "runs" / "S1_30_modular"
    file = opened(converted / "nwb" / "runs" / "S1_30_modular.nwb")
    log = pd.read_csv(folder / "log.csv")
    series = {**file.acquisition, **file.stimulus}
    numbers = [name for name in log.columns if name not in ("time_s", "phase") and log[name].notna().any()]
    assert set(numbers) <= set(series)
    for name in numbers:
        np.testing.assert_array_equal(series[name].data[:], log[name])
        np.testing.assert_array_equal(series[name].timestamps[:], log["time_s"])
    assert (series["force_n"].unit, series["shaft_deg"].unit) == ("newtons", "degrees")
    assert {"position_deg", "preset"} <= set(file.stimulus)
    frames = file.acquisition["press-001"]
    np.testing.assert_array_equal(frames.data[:], tifffile.imread(folder / "press-001" / "frames.tif"))
    np.testing.assert_allclose(frames.timestamps[:], 0.048 + 0.01 * np.arange(6), atol=1e-9)
    assert "Times of 1 frames lay between their neighbours" in frames.description
    phases = file.intervals["phases"].to_dataframe()
    assert list(phases["phase"]) == list(PHASES)
    np.testing.assert_allclose(phases["start_time"], [0, 0.05, 0.1, 0.15])
    assert list(file.trials.to_dataframe()["verdict"]) == ["ok"]
    assert json.loads(file.notes)["plan"]["condition"] == "modular"
    assert file.session_start_time.isoformat() == "2026-05-02T10:00:00+00:00"
    assert file.session_description.startswith("A variable stiffness actuator")


def test_one_run_by_its_folder_says_that_it_was_emulated(tmp_path: Path) -> None:
    pytest.importorskip("pynwb", reason="the extra nwb is not installed")
    folder = run_folder(tmp_path / "S1_30_modular", emulated=True)
    assert main(["tools", "convert", str(folder), "--format", "nwb", "--out", str(tmp_path / "nwb"), "--json"]) == 0
    file = opened(tmp_path / "nwb" / "runs" / "S1_30_modular.nwb")
    assert file.session_description.startswith("An emulated rig")
    assert not (tmp_path / "nwb" / ".unfinished").exists()


@pytest.mark.parametrize("spoilt", ["log.csv", "plan.json", "press-001/frames.tif", "press-001/force.csv"])
def test_a_damaged_run_is_named_and_leaves_nothing(
    tmp_path: Path, spoilt: str, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("pynwb", reason="the extra nwb is not installed")
    folder = run_folder(tmp_path / "S1_30_modular")
    (folder / spoilt).write_text("not this")
    assert main(["tools", "convert", str(folder), "--format", "nwb", "--out", str(tmp_path / "nwb")]) == 1
    assert "not converted: S1_30_modular: " in capsys.readouterr().err
    assert not list((tmp_path / "nwb").rglob("*.nwb"))


def test_without_pynwb_the_extra_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = run_folder(tmp_path / "S1_30_modular")
    for name in [name for name in sys.modules if name.partition(".")[0] in ("pynwb", "hdmf")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.delitem(sys.modules, "emg2vsa.pipeline.nwb_export", raising=False)
    for name in ("pynwb", "hdmf"):
        monkeypatch.setitem(sys.modules, name, None)
    assert main(["tools", "convert", str(folder), "--format", "nwb", "--out", str(tmp_path / "nwb")]) == 2
    assert "expected the library hdmf, but found none" in (said := capsys.readouterr().err)
    assert '".[nwb]"' in said


def test_the_inspector_finds_nothing_critical_but_what_is_not_known(converted: Path) -> None:
    """An age that nobody stated, a run that has no subject, and images with fewer frames than rows."""
    program = shutil.which("nwbinspector", path=str(Path(sys.executable).parent))
    if program is None:
        pytest.skip("nwbinspector is not installed")
    report = converted / "report.json"
    subprocess.run([program, str(converted / "nwb"), "--json-file-path", str(report)], check=True, timeout=300)
    messages = json.loads(report.read_text())["messages"]
    critical = {each["check_function_name"] for each in messages if each["importance"] == "CRITICAL"}
    assert critical <= {"check_subject_age", "check_subject_exists", "check_data_orientation"}
    turned = [each for each in messages if each["check_function_name"] == "check_data_orientation"]
    assert {each["object_type"] for each in turned} <= {"ImageSeries"}
