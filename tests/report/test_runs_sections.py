from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.calibration.runs_calibration import calibrate_runs
from emg2vsa.discrimination import discriminate
from emg2vsa.report import runs_conclusions as conclusions
from emg2vsa.report.failures import Failure
from emg2vsa.report.kappa_conclusion import kappa_conclusion
from emg2vsa.report.kappa_tables import kappa_tables
from emg2vsa.report.runs_section import runs_sections
from emg2vsa.report.study_report import write_figure_pdfs, write_study_report
from emg2vsa.settings import CalibrationSettings, DiscriminationSettings

FEW = DiscriminationSettings(resamples=200)
KNOWN = ("S1", "S3", "S5")


@pytest.fixture(scope="module")
def some_runs(runs):
    """Two angles of both actuators, and the lowest constant stiffness."""
    return tuple(r for r in runs if r.angle_deg != 30 and r.condition not in ("constant-mean", "constant-max"))


@pytest.fixture(scope="module")
def tested(some_runs, stiffness_n_per_mm):
    return discriminate(some_runs, stiffness_n_per_mm, "S_new", FEW)


@pytest.fixture(scope="module")
def whole(results, some_runs, tested, stiffness_n_per_mm):
    calibration = calibrate_runs(some_runs, stiffness_n_per_mm, "S_new", CalibrationSettings(resamples=100))
    return replace(results, runs=some_runs, discrimination=tested, calibration=calibration)


@pytest.fixture(scope="module")
def written(whole, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("runs")
    files = write_study_report(whole, folder) + write_figure_pdfs(whole, folder)
    assert set(files) == {path for path in folder.rglob("*") if path.is_file()}
    return folder


@pytest.fixture(scope="module")
def numbers(written):
    return json.loads((written / "results.json").read_text())


def test_every_figure_of_section_six_is_there(written):
    names = {path.name for path in (written / "figures").iterdir()}
    for figure in (
        "fig04_cocontraction", "fig05_schedules", "fig08_initial_area", "fig09_first_contact", "fig10_rigid",
        "fig11_interpolation", "fig12_human_like", "fig13_constant", "fig14_conditions", "figcal_calibration",
    ):  # fmt: skip
        assert {f"{figure}.svg", f"{figure}.pdf"} <= names


def test_the_page_is_whole_and_says_that_the_rig_is_simulated(written, read_page):
    page = read_page(written / "index.html")
    assert page.tags.count("svg") == 10
    assert "These runs come from a simulated rig." in page.text
    assert page.text.count("Simulated rig.") >= 7
    for title in ("Runs", "Initial contact area", "Stiffness of the new specimen"):
        assert title in page.text


def test_the_papers_numbers_lie_beside_ours(numbers, tested):
    assert numbers["paper.high-stiffness.30.area.specimens_p"] == 0.74
    assert numbers["paper.high-stiffness.area.angles.worst_p"] == 3.1079e-05
    assert numbers["paper.kappa_error.human_like.45"] == 0.04
    assert numbers["runs.high-stiffness.45.area.specimens_p"] == tested.area.groups.kruskal.p[1]
    assert numbers["runs.modular.0.casr.worst_p"] == tested.spread.worst_p[2]
    assert numbers["runs.constant-min.0.new.stiffer_p"] == tested.new.p[4, 0]
    assert numbers["runs.human_like_against.high-stiffness.45.verdict"] in ("better", "worse", "undecided")
    for condition, angle in (("high-stiffness", 45), ("modular", 0)):
        for algorithm in ("front", "circle"):
            assert abs(numbers[f"runs.{condition}.{angle}.{algorithm}.kappa.error"]) < 1


def test_means_and_spreads_are_those_of_the_presses(numbers, some_runs):
    run = next(r for r in some_runs if r.name == "S3_45_modular")
    key = "runs.modular.45.S3.casr_mm2_per_n"
    assert numbers[f"{key}.mean"] == pytest.approx(run.casr["front"].mean(), rel=1e-12)
    assert numbers[f"{key}.sd"] == pytest.approx(run.casr["front"].std(ddof=1), rel=1e-12)


def test_table_one_has_the_errors_of_the_right_algorithm_and_actuator(written, whole):
    with (written / "tables/table_one.csv").open() as file:
        rows = {row["angle_deg"]: row for row in csv.DictReader(file)}
    of = {c: whole.calibration.find(45.0, c).algorithms for c in ("high-stiffness", "modular")}
    assert float(rows["45.0"]["old_vision"]) == of["high-stiffness"]["circle"].chosen.error
    assert float(rows["45.0"]["new_vision"]) == of["high-stiffness"]["front"].chosen.error
    assert float(rows["45.0"]["human_like"]) == of["modular"]["front"].chosen.error
    assert rows["30.0"]["human_like_paper"] == "0.03"
    assert rows["30.0"]["human_like"] == rows["0.0"]["new_vision_paper"] == ""


def test_steps_of_table_one_are_counted_and_intervals_held_against_the_truth(whole):
    found = whole.calibration
    said = kappa_conclusion(found, "front", "circle")
    errors = {a: [abs(found.find(x, "high-stiffness").algorithms[a].chosen.error) for x in (0.0, 45.0)]
              for a in ("front", "circle")}  # fmt: skip
    better = sum(new < old for new, old in zip(errors["front"], errors["circle"], strict=True))
    assert f"The new vision algorithm has the smaller error at {better} of 2 angles" in said
    truth = 5.32
    inside = [each.algorithms["front"].chosen for each in found.conditions]
    held = sum(law.low <= truth <= law.high for law in inside)
    assert f"holds the known stiffness in {held} of 5 designs" in said


def test_without_a_known_stiffness_no_error_is_stated(whole):
    unknown = replace(whole.calibration, known_kappa_new=float("nan"))
    assert "no error can be stated" in kappa_conclusion(unknown, "front", "circle")
    rows = kappa_tables(unknown, "front", "circle")["kappa_new"].rows
    assert {row[5] for row in rows} == {None}


@pytest.mark.slow
def test_writing_twice_gives_the_same_bytes(whole, written, tmp_path):
    write_study_report(whole, tmp_path)
    write_figure_pdfs(whole, tmp_path)
    for path in written.rglob("*.*"):
        assert path.read_bytes() == (tmp_path / path.relative_to(written)).read_bytes()


def test_a_study_without_runs_is_as_before(results, tmp_path, read_page):
    write_study_report(results, tmp_path)
    found = json.loads((tmp_path / "results.json").read_text())
    assert not [key for key in found if key.startswith(("runs.", "paper."))]
    assert "simulated rig" not in read_page(tmp_path / "index.html").text
    assert not list(tmp_path.glob("figures/fig08*"))


def test_runs_that_could_not_be_tested_are_shown_with_the_reason(results, some_runs, tmp_path, read_page):
    failures = (*results.failures, Failure("study", "discrimination", "S9 has no stiffness"))
    write_study_report(replace(results, runs=some_runs, failures=failures), tmp_path)
    text = read_page(tmp_path / "index.html").text
    assert "S9 has no stiffness" in text
    assert "Presses of every condition and angle" in text


def test_measured_runs_are_not_called_simulated(run_of, stiffness_n_per_mm):
    runs = [replace(run_of(name, 0.0, "high-stiffness"), simulated=False) for name in KNOWN]
    report = runs_sections(runs, discriminate(runs, stiffness_n_per_mm, "S_new", FEW), None, KNOWN)
    assert "simulated" not in report.body.lower()
    assert "were measured" in report.body
    assert report.quantities["runs.simulated"] is False
    assert set(report.drawings) == {"fig08_initial_area", "fig09_first_contact", "fig10_rigid"}


def test_a_rejected_press_is_counted_with_its_reason(run_of, stiffness_n_per_mm):
    runs = [run_of(name, 0.0, "modular") for name in KNOWN]
    runs[0] = replace(runs[0], verdicts=("rejected", *("ok",) * 9), reasons=("lost <contact>", *("",) * 9))
    report = runs_sections(runs, discriminate(runs, stiffness_n_per_mm, "S_new", FEW), None, KNOWN)
    assert report.quantities["runs.rejected"] == 1
    assert "lost &lt;contact&gt; (1)" in report.body


def equal_areas(run):
    rng = np.random.default_rng([*run.name.encode()])
    return replace(run, start_area={name: 40 * (1 + 0.01 * rng.standard_normal(10)) for name in run.start_area})


def told(runs, stiffness_n_per_mm, **settings):
    return discriminate(runs, stiffness_n_per_mm, "S_new", replace(FEW, **settings))


def test_areas_are_called_the_same_only_where_that_is_shown(run_of, stiffness_n_per_mm):
    different = [run_of(name, 0.0, "modular") for name in KNOWN]
    assert "does not hold here" in conclusions.area_and_specimens(told(different, stiffness_n_per_mm))
    same = [equal_areas(run) for run in different]
    assert "is the same on all specimens" in conclusions.area_and_specimens(told(same, stiffness_n_per_mm))
    narrow = told(same, stiffness_n_per_mm, equivalence_margin=0.001)
    assert "equality within ± 0.100\N{NO-BREAK SPACE}% is shown in 0 only" in conclusions.area_and_specimens(narrow)


def louder(run, noise):
    rates = {name: casr.mean() + noise * (casr - casr.mean()) for name, casr in run.casr.items()}
    return replace(run, condition="modular", casr=rates)


@pytest.mark.parametrize(
    ("noise", "says"), [(0.2, "further apart than the rigid motor at 1 of 1 angle"), (1.0, "does not win here"),
                        (3.0, "at 0 of 1 angle and less far at 1")],
)  # fmt: skip
def test_who_wins_is_computed(noise, says, run_of, stiffness_n_per_mm):
    rigid = [run_of(name, 0.0, "high-stiffness") for name in KNOWN]
    found = told([*rigid, *(louder(run, noise) for run in rigid)], stiffness_n_per_mm)
    assert says in conclusions.actuators(found)
    why = conclusions.why(found, simulated=True)
    assert "within ± 5.00\N{NO-BREAK SPACE}% of the rigid motor's" in why
    assert "does not change CASR" not in why
    assert "presses within one mounting" in why
    assert "In the simulated world" in why
    assert "In the simulated world" not in conclusions.why(found, simulated=False)
    assert ("scatter alike" in why) is (noise == 1.0)


def test_an_actuator_that_changes_the_rate_is_said_to(run_of, stiffness_n_per_mm):
    rigid = [run_of(name, 0.0, "high-stiffness") for name in KNOWN]
    human = [replace(r, condition="modular", casr={n: 2 * c for n, c in r.casr.items()}) for r in rigid]
    why = conclusions.why(told([*rigid, *human], stiffness_n_per_mm), simulated=True)
    assert "a larger difference at 1" in why
    assert "follows from force alone" not in why


def test_the_new_specimen_that_is_not_told_apart_is_named(tested):
    said = conclusions.new_specimen(tested)
    assert "4 of 5 designs" in said
    assert "constant-min, 0° (not told from S1" in said
    # 4 groups of 10 in a row: z = 10 / sqrt(40 * 41 / 12 / 5), six pairs
    assert "p = .335 or more" in conclusions.mean_rank_bound(tested)


def test_the_old_algorithm_is_held_against_the_truth(tested):
    said = conclusions.vision(tested)
    assert said.startswith("Front (new) sets the specimens further apart than circle (old) at 2 of 2 angles")
    assert "of the true area" in said
