"""From schedules over an emulated rig to the report, and the same on the runs as if they had been measured."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import tifffile

from casr.frame_files import read_camera
from emg2vsa import artifacts
from emg2vsa.cli import main
from emg2vsa.run_scores import RunScores
from tests.once import Once
from tests.small import run_all, study_of_runs

pytestmark = pytest.mark.usefixtures("blank_drawings")
SPECIMENS = ("S1", "S3", "S5", "S_new")
PARTS = ("people", "rig")
RUNS = [f"{s}_0_{c}" for c in ("high-stiffness", "modular") for s in SPECIMENS]


def run(study: Path, capsys: pytest.CaptureFixture[str], *more: str) -> dict[str, object]:
    capsys.readouterr()
    main(["run", str(study), "--jobs", "1", "--json", *more])
    result: dict[str, object] = json.loads(capsys.readouterr().out)
    return result


def scores(study: Path) -> dict[str, RunScores]:
    store = study.parent / ".emg2vsa" / "small" / "store" / "runs"
    return {path.parent.name: artifacts.load(path) for path in store.glob("*/*.result")}


@pytest.fixture(scope="module")
def pressed(built_once: Once) -> Path:
    """A study whose emulated rig has run, to its report; copied, never changed."""
    return built_once("finished", run_all) / "studies" / "small"


@pytest.fixture
def copy(pressed: Path, tmp_path: Path) -> Path:
    """A copy of it, with its report two levels above."""
    shutil.copytree(pressed.parent.parent, tmp_path / "copy")
    return tmp_path / "copy" / "studies" / "small" / "study.toml"


def test_every_run_is_scored_and_the_softer_spreads_faster(pressed):
    found = scores(pressed / "study.toml")
    assert sorted(found) == sorted(RUNS)
    assert all(one.simulated and set(one.verdicts) == {"ok"} for one in found.values())
    for condition in ("high-stiffness", "modular"):
        rates = [np.mean(found[f"{name}_0_{condition}"].casr["front"]) for name in ("S1", "S3", "S5")]
        cues = [np.mean(found[f"{name}_0_{condition}"].indent_n_per_mm) for name in ("S1", "S3", "S5")]
        assert rates == sorted(rates)
        assert cues == sorted(cues, reverse=True)


def test_the_report_has_section_six_and_says_that_it_is_simulated(pressed):
    reports = pressed.parent.parent / "reports" / "small"
    page = (reports / "index.html").read_text()
    assert "simulated" in page.lower()
    quantities = json.loads((reports / "results.json").read_text())
    text = json.dumps(quantities)
    assert "casr" in text
    assert "kappa" in text


@pytest.mark.slow
def test_paper_mode_ends_with_a_report_that_says_what_ran(copy, capsys):
    """The presses stay; they are scored, tested and calibrated as the paper did."""
    text = copy.read_text()
    copy.write_text(re.sub(r'mode = "default"', 'mode = "paper"', text) if "mode =" in text else
                    text.replace("[study]\n", '[study]\nmode = "paper"\n', 1))  # fmt: skip
    run(copy, capsys)
    reports = copy.parents[2] / "reports" / "small"
    found = json.loads((reports / "results.json").read_text())
    page = (reports / "index.html").read_text()
    assert "settings: paper mode" in page
    assert "(paper algorithm)" in page
    areas = {key: value for key, value in found.items() if key.endswith(".start_area_mm2.mean")}
    assert {key.split(".")[1] for key in areas} == {"high-stiffness", "modular"}
    assert all(0 < area < 1253.6 for area in areas.values() if area is not None)  # at most that of the pin array


def test_nothing_changed_nothing_runs_and_nothing_heavy_is_loaded(copy, capsys):
    run(copy, capsys)
    program = (
        "import sys\nfrom emg2vsa.cli import main\n"
        f"assert main(['run', {str(copy)!r}]) == 0\nprint(*sys.modules, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert "0 steps run" in done.stdout
    assert set(done.stderr.split()) & {"scipy", "pandas", "cv2", "numba", "matplotlib", "tifffile", "jinja2"} == set()


def test_a_setting_of_the_scores_presses_nothing_again(copy, capsys):
    before = {p: p.stat().st_mtime_ns for p in copy.parent.glob("runs-virtual/*/log.csv")}
    copy.write_text(copy.read_text() + "[calibration]\nconfidence = 0.9\n")
    kappa = ["kappa/0_high-stiffness", "kappa/0_modular"]
    assert run(copy, capsys)["ran"] == [*kappa, "calibration/study", "report/study"]
    assert {p: p.stat().st_mtime_ns for p in copy.parent.glob("runs-virtual/*/log.csv")} == before


def test_people_only_and_rig_only_have_reports_of_their_own(copy, capsys):
    """They stand beside the whole report: switching between the three runs no step and removes no file."""
    reports = copy.parents[2] / "reports" / "small"
    people, rig = run(copy, capsys, "--human-only"), run(copy, capsys, "--casr-only")
    assert people["ran"] == ["people_report/study"]
    assert people["report"] == str(reports / "people" / "index.html")
    assert rig["ran"] == ["rig_report/study"]
    assert rig["report"] == str(reports / "rig" / "index.html")
    state = {path: path.stat().st_mtime_ns for path in reports.rglob("*") if path.is_file()}
    assert {reports / name / "results.json" for name in ("", *PARTS)} <= set(state)
    for part in ("--human-only", "--casr-only", "--only=report", "--human-only"):
        assert run(copy, capsys, part)["ran"] == []
    assert main(["tools", "clean", str(copy)]) == 0
    capsys.readouterr()
    assert run(copy, capsys, "--human-only")["ran"] == []
    assert {path: path.stat().st_mtime_ns for path in reports.rglob("*") if path.is_file()} == state
    found = json.loads((reports / "people" / "results.json").read_text())
    assert not any(key.startswith("runs.") for key in found)
    linked = {name: re.findall(r'href="([^"#]+[.]html)', (reports / name / "index.html").read_text()) for name in PARTS}
    assert linked["people"]
    assert all((reports / "people" / page).is_file() for page in linked["people"])
    assert linked["rig"] == []


def test_people_only_and_rig_only_make_what_they_show_and_no_more(copy, capsys):
    """Both parts lack results: the people's pages and tests, the schedules that the rig presses with, the scores."""
    store = copy.parent / ".emg2vsa" / "small" / "store"
    for stage in ("pages", "hypotheses", "schedules", "runs", "calibration"):
        shutil.rmtree(store / stage)
    rig = {str(step).partition("/")[0] for step in run(copy, capsys, "--casr-only")["ran"]}
    assert rig == {"schedules", "runs", "calibration", "rig_report"}
    shutil.rmtree(store / "schedules")
    people = {str(step).partition("/")[0] for step in run(copy, capsys, "--human-only")["ran"]}
    assert people == {"pages", "hypotheses", "schedules", "people_report"}


def stripped(pressed: Path, root: Path) -> None:
    """The runs as somebody else might have them: other names, PNG frames, no log, no plan, no word of an emulation."""
    rows = []
    for number, name in enumerate(RUNS):
        folder = root / f"day-{number}"
        for press in sorted((pressed / "runs-virtual" / name).glob("press-*")):
            frames = folder / press.name / "frames"
            frames.mkdir(parents=True)
            for index, image in enumerate(tifffile.imread(press / "frames.tif")):
                tifffile.imwrite(frames / f"{index:03d}.tif", image)
            shutil.copy(press / "force.csv", folder / press.name)
        specimen, angle, condition = name.rsplit("_", 2)
        rows.append(f"day-{number}\t{specimen}\t{angle}\t{condition}")
    (root / "runs.tsv").write_text("\n".join(["folder\tspecimen\tangle_deg\tcondition", *rows]) + "\n")


def with_runs(study: Path, runs: str) -> Path:
    """The study with these runs in place of its emulated rig."""
    text = study.read_text()
    assert 'rig = "rig.toml"' in text
    study.write_text(text.replace('rig = "rig.toml"', runs))
    return study


def test_measured_runs_without_any_hint_give_the_same_scores(pressed, copy, capsys):
    study = with_runs(copy, 'root = "../../lab"\ncamera = "../../lab/our-camera.toml"')
    shutil.rmtree(study.parent / ".emg2vsa")
    lab = study.parents[2] / "lab"
    stripped(pressed, lab)
    shutil.copy(pressed / "runs-virtual" / RUNS[0] / "camera.toml", lab / "our-camera.toml")
    assert read_camera(lab / "our-camera.toml") is not None
    assert run(study, capsys, "--casr-only")["failures"] == []
    found, emulated = scores(study), scores(pressed / "study.toml")
    assert sorted(found) == sorted(RUNS)
    for name in RUNS:
        assert not found[name].simulated
        np.testing.assert_allclose(found[name].casr["front"], emulated[name].casr["front"], rtol=1e-12)
        assert np.isnan(found[name].indent_n_per_mm).all()
    page = (study.parents[2] / "reports" / "small" / "rig" / "index.html").read_text()
    assert "emulated rig" not in page


ALONE = study_of_runs("small", "lab", SPECIMENS)
NEW = """
[profile]
new_specimen = "S_new"
new_stiffness_n_per_mm = 5.32
"""


@pytest.fixture
def alone(pressed: Path, tmp_path: Path) -> Path:
    """A study of measured runs, without people and without a new specimen."""
    study = tmp_path / "studies" / "small" / "study.toml"
    stripped(pressed, study.parent / "lab")
    study.write_text(ALONE)
    return study


@pytest.mark.parametrize("more", [[], pytest.param(["--casr-only"], marks=pytest.mark.slow)])
def test_measured_runs_alone_end_with_a_report_of_section_six(alone, capsys, more):
    text = alone.read_text()
    alone.write_text(text[: text.rindex("[[specimens]]")] + text[text.index("[runs]") :] + NEW)
    result = run(alone, capsys, *more)
    assert result["failures"] == result["rejected_presses"] == []
    contrast, kappa = result["notes"]
    assert kappa.startswith("kappa of S_new, N/mm: ")
    assert contrast.startswith("Whether human-like stiffness raises the contrast S5 : S1 of CASR by slope")
    reports = alone.parents[2] / "reports" / "small"
    page = (reports / "index.html").read_text()
    assert 'id="casr"' in page
    assert 'id="kappa"' in page
    assert 'id="fits"' not in page
    assert "runs.kappa.new_specimen" in json.loads((reports / "results.json").read_text())
    assert main(["run", str(alone), "--jobs", "1"]) == 0
    assert "0 steps run" in capsys.readouterr().out
    assert main(["run", str(alone), "--human-only"]) == 2
    assert main(["report", str(alone), "--paper", "--jobs", "1"]) == 0
    about = (reports / "paper" / "README.txt").read_text()
    assert "taken as measured on a rig" in about
    assert "people" not in about


@pytest.mark.slow
def test_without_a_new_specimen_the_report_says_that_nothing_was_estimated(alone, capsys):
    assert main(["run", str(alone), "--jobs", "1"]) == 0
    assert "note: No stiffness was estimated" in capsys.readouterr().out
    page = (alone.parents[2] / "reports" / "small" / "index.html").read_text()
    assert "No stiffness was estimated" in page
    assert 'id="casr"' in page


def test_rejected_presses_and_folders_left_out_are_said_aloud(alone, capsys):
    lab = alone.parent / "lab"
    table = (lab / "runs.tsv").read_text().splitlines()
    (lab / "runs.tsv").write_text("\n".join(table[:4]))  # days 0 to 2
    for day in range(3, 7):
        shutil.rmtree(lab / f"day-{day}")
    shutil.rmtree(lab / "day-0" / "press-002" / "frames")
    (lab / "day-1" / "press-001" / "force.csv").unlink()
    for _ in range(2):  # the second time nothing runs, and all is said again
        assert main(["run", str(alone), "--jobs", "1"]) == 0
        said = capsys.readouterr().out
        assert f"note: {lab / 'day-7'} holds frames but is no run: add it to {lab / 'runs.tsv'}" in said
        assert f"{RUNS[0]}: 1 of 2 presses rejected: {lab / 'day-0' / 'press-002'}: expected images" in said
        assert f"{RUNS[1]}: 1 of 2 presses rejected: day-1/press-001: expected a force for every frame" in said
    (of, _) = run(alone, capsys)["rejected_presses"]
    assert of["run"] == RUNS[0]
    assert of["message"].startswith("1 of 2 presses rejected: ")


def test_a_specimen_that_the_study_does_not_know_is_found_before_anything_runs(alone, copy, capsys):
    alone.write_text(alone.read_text().replace('"S5"', '"S4"'))
    assert main(["run", str(alone)]) == 2
    assert "runs.tsv, line 4, specimen: expected a specimen whose stiffness" in capsys.readouterr().err
    assert not (alone.parent / ".emg2vsa" / "small" / "store").exists()
    rig = copy.parent / "rig.toml"
    rig.write_text(rig.read_text().replace('"S_new"]', '"S_new", "S9"]').replace("S_new = 5.32", "S_new = 5, S9 = 6"))
    assert main(["run", str(copy)]) == 2
    assert "experiment.specimens: expected specimens whose stiffness" in capsys.readouterr().err


def test_a_folder_of_runs_that_holds_none(alone, simulated, capsys):
    shutil.rmtree(alone.parent / "lab")
    assert main(["run", str(alone)]) == 2
    assert "lab: expected one run or more, but found none" in capsys.readouterr().err
    shutil.copytree(simulated, alone.parent, dirs_exist_ok=True)
    alone.write_text(alone.read_text() + '\n[runs]\nroot = "lab"\n')
    assert main(["run", str(alone), "--only", "runs", "--jobs", "1"]) == 0
    assert f"note: no runs in {alone.parent / 'lab'}" in capsys.readouterr().out


def test_what_is_wrong_with_the_runs_stops_no_session_check(copy, capsys):
    study = with_runs(copy, 'root = "lab"')
    (study.parent / "lab").mkdir()
    (study.parent / "lab" / "runs.tsv").write_text("nonsense\n")
    assert main(["check", str(study), "P01"]) == 0
    assert main(["run", str(study), "--human-only", "--jobs", "1"]) == 0
    assert main(["run", str(study)]) == 2
    assert "runs.tsv: expected tab-separated columns" in capsys.readouterr().err


@pytest.mark.slow
def test_a_measured_run_is_never_overwritten(copy, capsys):
    (copy.parent / "runs-virtual" / "S1_0_modular" / "emulated.json").unlink()
    shutil.rmtree(copy.parent / ".emg2vsa")
    (failure,) = [f for f in run(copy, capsys, "--casr-only")["failures"] if f["item"] == "S1_0_modular"]
    assert "expected a free folder for an emulated run, but found a measured run" in failure["message"]
    assert (copy.parent / "runs-virtual" / "S1_0_modular" / "log.csv").is_file()


@pytest.mark.slow
def test_killed_halfway_and_run_again(pressed, copy, capsys):
    """Four runs of the eight, after the people's steps."""
    rig = copy.with_name("rig.toml")
    rig.write_text(rig.read_text().replace("high-stiffness = [0]\n", ""))
    shutil.rmtree(copy.parent / "runs-virtual")
    for stage in ("emulation", "runs"):
        shutil.rmtree(copy.parent / ".emg2vsa" / "small" / "store" / stage)
    program = [sys.executable, "-m", "emg2vsa.cli", "run", str(copy), "--only", "runs", "--jobs", "1"]
    running = subprocess.Popen(program, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while len(list(copy.parent.glob("runs-virtual/S*"))) < 2:
        assert running.poll() is None
        time.sleep(0.02)
    os.killpg(running.pid, signal.SIGKILL)
    running.wait()
    modular = [name for name in RUNS if name.endswith("modular")]
    assert len(list(copy.parent.glob("runs-virtual/S*"))) < len(modular)
    assert run(copy, capsys, "--only", "runs")["failures"] == []
    assert sorted(p.name for p in copy.parent.glob("runs-virtual/[!.]*")) == sorted(modular)
    again, whole = scores(copy), scores(pressed / "study.toml")
    assert sorted(again) == sorted(modular)
    for name, found in again.items():
        np.testing.assert_array_equal(found.casr["front"], whole[name].casr["front"])
