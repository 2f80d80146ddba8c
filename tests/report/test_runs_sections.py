from __future__ import annotations

import csv
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.calibration.runs_calibration import calibrate_runs
from emg2vsa.claims import paper
from emg2vsa.discrimination import discriminate
from emg2vsa.errors import DataError
from emg2vsa.report import study_report
from emg2vsa.report.failures import Failure
from emg2vsa.report.inputs import Runs
from emg2vsa.report.methods import methods
from emg2vsa.report.rig_tests import rig_tests
from emg2vsa.report.section import Content, rendered
from emg2vsa.report.sections.actuators import ACTUATORS
from emg2vsa.report.sections.kappa import holds, span
from emg2vsa.report.sections.profiles import SCHEDULES
from emg2vsa.report.sections.rig_runs import RUNS
from emg2vsa.report.study_report import contents, numbers_and_tables, write_figure_pdfs, write_study_report
from emg2vsa.run_scores.domes import NO_DOMES
from emg2vsa.run_scores.press import Press
from emg2vsa.run_scores.product import WeighedPress
from emg2vsa.run_scores.score_run import score_run
from emg2vsa.schedules.build import build_schedules
from emg2vsa.settings import PAPER, CalibrationSettings, DiscriminationSettings, RunSettings
from emg2vsa.statistics.kruskal import dunn, kruskal
from emg2vsa.worlds.tactile import PressSettings, simulate_press

FEW = DiscriminationSettings()
KNOWN = ("S1", "S3", "S5")
TRUTH = 5.32


@pytest.fixture(scope="module")
def some_runs(runs):
    """Two angles of both actuators, and the lowest constant stiffness."""
    return tuple(r for r in runs if r.angle_deg != 30 and r.condition not in ("constant-mean", "constant-max"))


@pytest.fixture(scope="module")
def tested(some_runs, stiffness_n_per_mm):
    return discriminate(some_runs, stiffness_n_per_mm, "S_new", FEW)


@pytest.fixture(scope="module")
def calibration(some_runs, stiffness_n_per_mm):
    return calibrate_runs(some_runs, stiffness_n_per_mm, "S_new", CalibrationSettings(resamples=100))


@pytest.fixture(scope="module")
def whole(results, some_runs, tested, calibration):
    return replace(results, runs=Runs(some_runs, tested, calibration))


@pytest.fixture(scope="module")
def content(whole) -> Content:
    return contents(whole)


@pytest.fixture(scope="module")
def written(whole, content, tmp_path_factory) -> Path:
    """The report and its PDFs, of drawings that were made once."""
    folder = tmp_path_factory.mktemp("runs")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study_report, "_drawn", lambda results, judged: content.drawings)
        files = write_study_report(whole, folder) + write_figure_pdfs(whole, folder)
    assert set(files) == {path for path in folder.rglob("*") if path.is_file()}
    return folder


@pytest.fixture(scope="module")
def numbers(written):
    return json.loads((written / "results.json").read_text())


@pytest.fixture
def report_of(results, stiffness_n_per_mm):
    """Numbers and tables of some runs that were tested, with drawings if asked for."""

    def made(runs, make=numbers_and_tables):
        found = discriminate(runs, stiffness_n_per_mm, "S_new", FEW)
        return make(replace(results, runs=Runs(tuple(runs), found)))

    return made


SAYS = {"high-stiffness": "rigid motor", "modular": "human-like stiffness"}


def mounted(run, mountings=5):
    """The run with its presses in mountings of their own, which differ as little as presses do, in random order."""
    began = np.random.default_rng([*run.name.encode()]).random(mountings)
    number = np.arange(run.repetitions.size) % mountings
    return replace(run, mounting=1 + number, pressed_at=began[number])


def rows_of(content, table):
    first = content.tables[table].columns[0].key
    return {row[first]: row for row in content.tables[table].rows}


def only(runs, presses):
    """The runs with so many presses each."""

    def cut(scores):
        return {name: np.where(np.arange(10) < presses, each, np.nan) for name, each in scores.items()}

    return [replace(run, casr=cut(run.casr), start_area=cut(run.start_area)) for run in runs]


UNTRIED = "This project has tried no real Dynamixel motor"


def test_a_report_on_a_dynamixel_says_that_no_real_one_was_tried(whole, content):
    """In the sections on schedules and on runs, and among the methods."""
    study = whole.study
    settings = replace(study.schedule, actuator="dynamixel", full_stiffness_nm_per_rad=19.7)
    other = replace(
        whole,
        study=replace(study, schedule=settings),
        people=replace(whole.people, schedules=build_schedules(whole.people.profiles, settings, {})),
    )
    for results, times in ((whole, 0), (other, 1)):
        for section in (RUNS, SCHEDULES):
            assert rendered(section, results, content).count(UNTRIED) == times
        assert str(methods(results)).count(UNTRIED) == times


def test_every_figure_of_section_six_is_there_and_the_page_says_that_the_rig_is_simulated(written, content, read_page):
    figures = (
        "fig02_algorithm_1 fig04_cocontraction fig05_schedules fig08_initial_area fig09_first_contact fig10_rigid "
        "fig11_interpolation fig12_human_like fig13_constant fig14_conditions figcal_calibration figkappa_truth "
        "figtable1_errors"
    )
    names = {path.name for path in (written / "figures").iterdir()}
    assert {f"{figure}.{kind}" for figure in figures.split() for kind in ("svg", "pdf")} <= names
    page = read_page(written / "index.html")
    assert {f"{name}.svg" for name in content.drawings} <= names
    assert page.tags.count("svg") == len(content.drawings)
    assert "These runs come from a simulated rig" in page.text
    assert page.text.count("Simulated rig.") >= 7
    for title in ("Presses of the rig", "Initial contact area", "Stiffness of the new specimen"):
        assert title in page.text


def test_the_papers_numbers_lie_beside_ours(numbers, tested, some_runs):
    assert numbers["paper.high-stiffness.30.area.specimens_p"] == 0.74
    assert numbers["paper.high-stiffness.area.angles.worst_p"] == 3.1079e-05
    assert numbers["paper.kappa_error.human_like.45"] == 0.04
    assert numbers["runs.high-stiffness.45.area.specimens_p"] == tested.area.kruskal.p[1]
    assert numbers["runs.modular.0.casr.worst_p"] == tested.spread.worst_p[2]
    assert numbers["runs.constant-min.0.new.stiffer_mean_rank_p"] == tested.new.p_mean_rank[4, 0]
    assert numbers["runs.human_like_against.high-stiffness.45.verdict"] in ("larger", "smaller", "not determined")
    assert numbers["runs.kappa.mounting_sd_percent"] == 4.3
    for condition, angle in (("high-stiffness", 45), ("modular", 0)):
        for algorithm in ("front", "circle"):
            assert abs(numbers[f"runs.{condition}.{angle}.{algorithm}.kappa.error"]) < 1
            assert numbers[f"runs.{condition}.{angle}.{algorithm}.kappa.mounting_sd_percent"] == pytest.approx(4.3)
    rates = next(r for r in some_runs if r.name == "S3_45_modular").casr["front"]
    key = "runs.modular.45.S3.casr_mm2_per_n"
    assert numbers[f"{key}.mean"] == pytest.approx(rates.mean(), rel=1e-12)
    assert numbers[f"{key}.sd"] == pytest.approx(rates.std(ddof=1), rel=1e-12)


@pytest.mark.parametrize("algorithm", ["circle", "paper", "front"])
def test_table_one_has_each_algorithm_with_both_actuators_beside_the_papers_number(algorithm, written, calibration):
    with (written / "tables/table_one.csv").open() as file:
        rows = {(row["angle_deg"], row["algorithm"].split()[0]): row for row in csv.DictReader(file)}
    name = {"paper": "hexagon"}.get(algorithm, algorithm)
    for condition, key in (("high-stiffness", "rigid"), ("modular", "human_like")):
        of = calibration.find(45.0, condition).algorithms[algorithm]
        assert float(rows["45.0", name][key]) == of.chosen.error
        assert float(rows["45.0", name][f"{key}_same"]) == of.paper.error
        assert rows["30.0", name][key] == ""  # not pressed at 30°
    papers = {"circle": ("0.25", ""), "paper": ("0.07", "0.03"), "front": ("", "")}[algorithm]
    assert (rows["30.0", name]["rigid_paper"], rows["30.0", name]["human_like_paper"]) == papers


def test_table_one_shows_no_error_of_what_is_not_determined(whole, calibration):
    def undetermined(of):
        return {
            name: replace(
                each, chosen=replace(each.chosen, determined=False), paper=replace(each.paper, determined=True)
            )
            for name, each in of.items()
        }

    conditions = tuple(replace(each, algorithms=undetermined(each.algorithms)) for each in calibration.conditions)
    changed = replace(calibration, conditions=conditions)
    content = numbers_and_tables(replace(whole, runs=replace(whole.runs, calibration=changed)))
    shown = content.tables["table_one"].shown_rows
    assert {row["rigid"] for row in shown if row["angle_deg"] == 45} == {"not determined"}
    assert {row["rigid"] for row in shown if row["angle_deg"] == 30} == {None}
    by_papers_law = [str(row["rigid_same"]) for row in shown if row["angle_deg"] == 45]
    assert all(re.fullmatch(r"[+−][\d.]+ \[[−\d.]+, [−\d.∞]+[])]", said) for said in by_papers_law), by_papers_law
    assert "new vision" not in content.tables["table_one"].html().lower()


def test_areas_beyond_the_pin_array_stand_in_table_one_in_place_of_an_error(whole, some_runs, stiffness_n_per_mm):
    def beyond(run):
        over = run.over_array | {"circle": np.linspace(2, 7, 10)}
        return replace(run, over_array=over, casr=run.casr | {"circle": np.full(10, np.nan)})

    runs = tuple(beyond(run) for run in some_runs)
    calibration = calibrate_runs(runs, stiffness_n_per_mm, "S_new", CalibrationSettings(resamples=20))
    found = numbers_and_tables(replace(whole, runs=replace(whole.runs, scores=runs, calibration=calibration)))
    shown = {row["algorithm"]: row for row in found.tables["table_one"].shown_rows if row["angle_deg"] == 45}
    told = {name.split()[0].split("\N{NO-BREAK SPACE}")[0]: row["rigid_same"] for name, row in shown.items()}
    assert told["circle"] == "areas up to 7.0 × the pin array"
    assert "array" not in told["front"]
    presses = sum(run.condition in ("high-stiffness", "modular") for run in runs) * 10
    assert f"circle (previous), {presses} of {presses}, up to 7.0 ×" in found.tables["table_one"].caption


def test_the_papers_curves_imply_more_than_contact_mechanics_allows(content, some_runs):
    """Second opinion: what the curves give back at the CASR said to be implied, and the ratio of the presses."""
    rows = rows_of(content, "casr_implied")
    curves = {0.0: (10.21, -1.567), 30.0: (14.76, -23.94), 45.0: (8.639, -58.67)}
    for angle, (level, rate) in curves.items():
        for name, kappa in {"S1": 7.63, "S2": 5.32, "S3": 3.35, "S4": 3.12, "S5": 1.11}.items():
            casr = content.quantities[f"paper.modular.{angle:g}.casr_implied.{name}"]
            assert level * np.exp(rate * casr) == pytest.approx(kappa, rel=1e-12)
            assert rows[angle][f"casr_{name}"] == casr
        assert rows[angle]["ratio"] > rows[angle]["bound"] == content.quantities["paper.casr_ratio_bound"]
    assert content.quantities["paper.casr_ratio_bound"] == pytest.approx(3.615, abs=1e-3)
    assert content.quantities["claims.kappa_curves.verdict"] == "refuted"
    of = {run.specimen: run for run in some_runs if (run.condition, run.angle_deg) == ("modular", 45.0)}
    assert rows[45.0]["here"] == pytest.approx(of["S5"].casr["front"].mean() / of["S1"].casr["front"].mean(), rel=1e-12)
    assert np.isnan(rows[30.0]["here"])


def test_pins_of_algorithm_1_stand_by_the_force_of_its_first_frame(run_of, report_of):
    def counted(run, pins, first_n):
        return replace(run, pins_selected=np.array(pins), first_n=np.array(first_n))

    forces = np.linspace(0.5, 0.95, 10)
    runs = [run_of(name, 0.0, "modular") for name in KNOWN]
    runs[0] = counted(runs[0], [4, 6, 9, 12, 20, 31, 40, 55, 60, 73], forces)
    runs[1] = counted(runs[1], [-1, -1, 0, 19, 18, 17, 16, 15, 14, 13], forces)
    content = report_of(runs)
    rows = {row["specimen"]: row for row in content.tables["algorithm_1"].rows}
    assert [rows["S1"][key] for key in ("presses", "least", "median", "most")] == [10, 4, 25.5, 73]
    assert rows["S1"]["rank_correlation"] == pytest.approx(1.0)
    assert (rows["S3"]["presses"], rows["S3"]["none"], rows["S1"]["none"]) == (8, 1, 0)
    assert rows["S3"]["first_low_n"] == forces[2]
    assert content.quantities["runs.algorithm_1.pins.max"] == 73
    assert content.quantities["runs.algorithm_1.pins.min"] == content.quantities["runs.algorithm_1.0.S3.pins.min"] == 0
    assert "by the mean force per frame; n = 0 in 1 of 28 presses" in content.tables["algorithm_1"].caption
    still = [counted(run, [7] * 10, forces * factor) for run, factor in zip(runs, (1.0, 1.1, 1.3), strict=True)]
    assert report_of(still).quantities["runs.algorithm_1.pins_per_n.median"] == 0


def test_figure_2_states_its_press_and_is_left_out_without_one(run_of, report_of):
    runs = [run_of(name, angle, c) for name in KNOWN for angle in (0.0, 30.0) for c in ("high-stiffness", "modular")]
    caption = report_of(runs, contents).drawings["fig02_algorithm_1"].caption
    assert "press 1 on S1, high-stiffness, 30°" in caption
    assert "0.61 N" in caption
    assert "fig02_algorithm_1" not in report_of([replace(run, first_contact=None) for run in runs], contents).drawings


@pytest.mark.parametrize(("name", "figure"), [("high-stiffness", 10), ("modular", 12)])
def test_claims_on_the_order_of_the_specimens_follow_the_scores(name, figure, runs, report_of):
    own = [mounted(run) for run in runs if run.condition == name]
    verdict = f"claims.fig{figure}_order.verdict"
    assert report_of(own).quantities[verdict] == "holds"
    swapped = [
        replace(run, specimen={"S3": "S5", "S5": "S3"}.get(run.specimen, run.specimen)) if run.angle_deg == 45 else run
        for run in own
    ]
    assert report_of(swapped).quantities[verdict] == "refuted"
    found = report_of([run for run in own if run.angle_deg == 30])
    assert found.quantities[verdict] == "not determined"
    said = next(row for row in found.tables["claims"].rows if row["says"].endswith(f"in its place, {SAYS[name]}"))
    assert (said["unit"], said["algorithm"]) == ("mountings", "front")
    assert said["why"].startswith("No score: ")
    assert "by front" in said["own_test"]


def test_in_paper_mode_the_fit_is_equation_1_and_what_has_no_score_is_told(whole, some_runs):
    study = replace(
        whole.study, scoring=RunSettings(**PAPER["runs"]), calibration=CalibrationSettings(**PAPER["calibration"])
    )
    runs = [replace(run, algorithm="paper") for run in some_runs if run.angle_deg == 45]
    lost = next(i for i, run in enumerate(runs) if run.name == "S5_45_modular")
    runs[lost] = replace(runs[lost], casr={name: np.full(10, np.nan) for name in runs[lost].casr})
    stiffness = {"S1": 7.63, "S_new": TRUTH, "S3": 3.35, "S5": 1.11}
    tested = discriminate(runs, stiffness, "S_new", FEW)
    calibration = calibrate_runs(runs, stiffness, "S_new", replace(study.calibration, resamples=50))
    content = contents(replace(whole, study=study, runs=Runs(tuple(runs), tested, calibration)))
    drawing = content.drawings["fig12_human_like"]
    assert (
        "algorithm paper: initial area by rule paper, dense Horn–Schunck flow over the contact" in drawing.description
    )
    assert "the derivative of equation (1)" in drawing.description
    assert "No press has a CASR in modular, 45°: S5" in drawing.caption
    assert "No press" not in content.drawings["fig10_rigid"].caption
    # one law, the paper's, so each error stands once
    keys = [column.key for column in content.tables["table_one"].columns]
    assert keys == ["angle_deg", "algorithm", "rigid_paper", "rigid_same", "human_like_paper", "human_like_same"]
    steps = {row["algorithm"].split()[0]: row for row in content.tables["recipes"].rows}
    assert steps["circle"]["law"] == steps["hexagon"]["law"] == "equation (1)"
    assert steps["circle"]["engine"] == "dense, Horn and Schunck"


def test_the_steps_of_every_algorithm_stand_by_table_one_and_in_captions(content):
    steps = {row["algorithm"].split()[0]: row for row in content.tables["recipes"].rows}
    assert list(steps) == ["circle", "hexagon", "front"]
    assert (steps["hexagon"]["force_rule"], steps["hexagon"]["rate"]) == ("mean of its rows", "equation (2)")
    assert (steps["circle"]["engine"], steps["circle"]["law"]) == ("motion of the pins", "A_c0 exp(Σ growth)")
    assert steps["front"]["law"] == "–"
    assert {(row["force_low_n"], row["force_high_n"]) for row in steps.values()} == {(0.5, 7.0)}
    for figure in ("fig10_rigid", "fig12_human_like", "fig13_constant"):
        told = content.drawings[figure].description
        assert "All panels by algorithm front: force at exposure, CASR by a power law." in told
        assert "the derivative of a power law" in told


def test_what_the_paper_prints_stands_beside_the_same_test_and_nowhere_else(whole, content, tested):
    row = rows_of(content, "new_specimen")["constant-min, 0°"]
    place = [*zip(tested.table.conditions, tested.table.angles_deg, strict=True)].index(("constant-min", 0.0))
    assert row["paper"] == "not told apart, p = .3799"
    assert row["p_rank_stiffer"] == tested.new.p_mean_rank[place, 0]
    heads = {column.key: column.head for column in content.tables["new_specimen"].columns}
    assert "Dunn" in heads["paper"]
    assert "Dunn" in heads["p_rank_stiffer"]
    casr, area = rows_of(content, "casr_by_specimen"), rows_of(content, "area_by_specimen")
    assert (casr["modular, 0°"]["worst_paper"], casr["modular, 0°"]["worst_dunn"]) == (".0034", ".033")
    assert casr["constant-min, 0°"]["worst_paper"] == ".0037"
    assert (area["high-stiffness, 0°"]["p_paper"], area["modular, 0°"]["p_paper"]) == (0.51, None)
    for name in ("area_by_specimen", "area_by_angle", "casr_by_specimen", "new_specimen"):
        assert content.tables[name].caption.endswith("take presses of one mounting as independent")
    r2 = {design: row["paper_adj_r2"] for design, row in rows_of(content, "kappa_by_casr").items()}
    assert r2 | {"high-stiffness, 0°": None, "high-stiffness, 45°": 0.8963, "modular, 0°": 0.9753} == r2
    assert set(paper.WORST_ADJ_R2) < {condition for condition, _ in paper.DESIGNS}
    own = rig_tests(whole, content.quantities)
    assert own["new_specimen_at_minimum"].here.startswith("Dunn, p\N{NO-BREAK SPACE}")
    assert own["new_specimen_at_minimum"].here.endswith(", by front")
    assert own["casr_rigid"].here == "–"  # 30 degrees were not pressed
    assert own["casr_human_like"].printed == "worst p = .0034, .0018"


def test_the_smallest_p_of_the_papers_test_stands_beside_its_p(content):
    assert "gives neighbours no p below .033 here" in content.tables["casr_by_specimen"].caption
    untied = np.arange(30.0).reshape(1, 3, 10)
    assert dunn(kruskal(untied)).p.max() == pytest.approx(0.033, abs=5e-4)


def test_every_estimate_is_drawn_and_what_determines_nothing_is_hollow_and_called_so(whole, calibration):
    sure = replace(calibration.conditions[0].algorithms["front"].chosen, kappa=5.0, low=4.0, high=6.0, determined=True)
    first = replace(calibration.conditions[0], algorithms={
        name: replace(of, chosen=sure) for name, of in calibration.conditions[0].algorithms.items()
    })  # fmt: skip
    unsure = [
        replace(each, algorithms={
            name: replace(of, chosen=replace(of.chosen, determined=False)) for name, of in each.algorithms.items()
        })
        for each in calibration.conditions[1:]
    ]  # fmt: skip
    changed = replace(whole, runs=replace(whole.runs, calibration=replace(calibration, conditions=(first, *unsure))))
    drawings = contents(changed).drawings
    (axes,) = drawings["figkappa_truth"].figure.axes
    assert [text.get_text() for text in axes.texts] == ["not determined"] * len(unsure)
    faces = [line.get_markerfacecolor() for line in axes.lines if line.get_marker() == "X"]
    assert faces.count("white") == len(unsure)
    assert "5.00 [4.00, 6.00] N/mm" in drawings["figkappa_truth"].description
    angles = drawings["figtable1_errors"].figure.axes
    assert [axes.get_title(loc="center") for axes in angles] == ["0°", "30°", "45°"]
    assert not angles[1].texts  # not pressed, but the paper's errors are there
    assert [line.get_xdata()[1] for line in angles[1].lines[1:]] == pytest.approx([25, 7, 3])


def test_without_a_known_stiffness_no_error_is_stated(whole, calibration):
    unknown = replace(calibration, known_kappa_new=float("nan"))
    content = numbers_and_tables(replace(whole, runs=replace(whole.runs, calibration=unknown)))
    assert {row["holds"] for row in content.tables["kappa_new"].rows} == {None}


@pytest.mark.parametrize(
    ("low", "high", "determined", "held"),
    [(5.0, 6.0, True, True), (6.0, 7.0, True, False), (5.0, np.inf, False, None), (1e-14, 3e16, False, None),
     (np.nan, np.nan, False, None)],
)  # fmt: skip
def test_an_interval_that_determines_nothing_does_not_count_as_holding(calibration, low, high, determined, held):
    of = calibration.conditions[0].algorithms["front"]
    changed = replace(of, chosen=replace(of.chosen, low=low, high=high, determined=determined))
    assert holds(changed.chosen, TRUTH) is held
    assert ("not determined" in span(changed.chosen)) is not determined
    assert span(replace(of.chosen, kappa=np.nan)).startswith("none: CASR does not follow")


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


def test_runs_that_could_not_be_tested_are_shown_with_the_reason_and_claim_nothing(
    results, some_runs, tmp_path, read_page
):
    failures = (*results.failures, Failure("study", "discrimination", "S9 has no stiffness"))
    write_study_report(replace(results, runs=Runs(some_runs), failures=failures), tmp_path)
    text = read_page(tmp_path / "index.html").text
    assert "S9 has no stiffness" in text
    assert "Presses of every condition and angle" in text
    found = json.loads((tmp_path / "results.json").read_text())
    assert not [key for key in found if key.startswith(("claims.casr", "claims.reduction"))]


def test_a_stiffness_stays_where_the_tests_of_runs_failed(whole, tmp_path):
    failed = (*whole.failures, Failure("study", "discrimination", "S9 has no stiffness"))
    write_study_report(replace(whole, runs=replace(whole.runs, discrimination=None), failures=failed), tmp_path)
    found = json.loads((tmp_path / "results.json").read_text())
    assert found["runs.high-stiffness.0.kappa.n_per_mm"] == pytest.approx(
        whole.runs.calibration.headline("high-stiffness", 0.0, "front").kappa
    )
    assert (tmp_path / "tables" / "kappa_new.csv").is_file()


def test_without_an_estimate_the_reason_is_told(whole, calibration, content):
    nothing = replace(calibration, conditions=(), notes=("No stiffness was estimated: no new specimen.",))
    results = replace(whole, runs=replace(whole.runs, calibration=nothing))
    assert "No stiffness was estimated: no new specimen." in rendered(RUNS, results, content)


def test_runs_without_bytes_are_counted(run_of, report_of, results):
    runs = [replace(run_of(name, 0.0, "high-stiffness"), over_bytes=name != "S1") for name in KNOWN]
    body = rendered(RUNS, replace(results, runs=Runs(tuple(runs))), report_of(runs, contents))
    assert "come from a simulated rig (1 run emulated, not over bytes).</strong>" in body


def test_measured_runs_are_not_called_simulated_and_a_rejected_press_is_counted_with_its_reason(
    run_of, report_of, results
):
    runs = [replace(run_of(name, 0.0, "high-stiffness"), simulated=False) for name in KNOWN]
    content = report_of(runs, contents)
    assert content.quantities["runs.simulated"] is False
    assert set(content.drawings) >= {"fig08_initial_area", "fig09_first_contact", "fig10_rigid"}
    assert not any("Simulated rig" in drawing.caption for drawing in content.drawings.values())
    body = rendered(RUNS, replace(results, runs=Runs(tuple(runs))), content)
    assert "were measured" in body
    assert "simulated" not in body
    runs[0] = replace(runs[0], verdicts=("rejected", *("ok",) * 9), reasons=("lost <contact>", *("",) * 9))
    content = report_of(runs)
    assert content.quantities["runs.rejected"] == 1
    assert "lost &lt;contact&gt; (1)" in content.tables["runs"].html()


def test_presses_that_all_end_early_are_rejected_in_a_report_that_says_why(
    results, stiffness_n_per_mm, tmp_path, read_page
):
    frames = simulate_press(PressSettings()).sequence()
    frames = replace(frames, force_n=frames.force_n * 4.9 / np.nanmax(frames.force_n))
    presses = [Press(r, frames, "", np.linspace(0, 4.9, 40), np.linspace(5, 7, 40)) for r in (1, 2)]
    design = {"angle_deg": 0.0, "condition": "high-stiffness", "simulated": False, "domes": NO_DOMES}
    runs = tuple(score_run(presses, RunSettings(), specimen=name, **design) for name in KNOWN)
    with pytest.raises(DataError) as none:
        discriminate(runs, stiffness_n_per_mm, "S_new", FEW)
    failures = (Failure("study", "discrimination", str(none.value)),)
    write_study_report(replace(results, runs=Runs(runs), failures=failures), tmp_path)
    found = json.loads((tmp_path / "results.json").read_text())
    assert (found["runs.presses"], found["runs.rejected"]) == (6, 6)
    text = read_page(tmp_path / "index.html").text
    assert "expected a press that counts and has a score, but found none" in text
    assert "found at most 4.9 N (6)" in text


def test_areas_are_called_the_same_only_where_an_interval_says_so(run_of, report_of):
    def equal(run):
        rng = np.random.default_rng([*run.name.encode()])
        return replace(run, start_area={name: 40 * (1 + 0.01 * rng.standard_normal(10)) for name in run.start_area})

    different = [mounted(run_of(name, angle, "high-stiffness")) for name in KNOWN for angle in (0.0, 30.0, 45.0)]
    alike = [equal(run) for run in different]
    for runs, verdict, why in (
        (different, "refuted", ""),
        (alike, "holds", ""),
        (alike[1:], "not determined", "No score: S1 high-stiffness 0°."),
        (only(alike, 1), "not determined", "Nothing tells the scatter."),
    ):
        content = report_of(runs)
        told = next(row for row in content.tables["claims"].rows if row["says"].startswith("Initial area is the same"))
        assert told["verdict"] == verdict
        assert told["why"].startswith(why)


@pytest.mark.parametrize(("noise", "verdict"), [(0.2, "larger"), (1.0, "not determined"), (3.0, "smaller")])
def test_how_far_conditions_set_specimens_apart_is_computed(noise, verdict, run_of, report_of):
    rigid = [mounted(run_of(name, 0.0, "high-stiffness")) for name in KNOWN]
    human = [mounted(replace(run, condition="modular")) for run in rigid]
    human = [replace(run, casr={n: c.mean() + noise * (c - c.mean()) for n, c in run.casr.items()}) for run in human]
    content, name = report_of([*rigid, *human]), "runs.human_like_against.high-stiffness.0"
    assert content.quantities[f"{name}.verdict"] == verdict
    assert report_of(only([*rigid, *human], 1)).quantities[f"{name}.verdict"] == "not determined"
    level = content.tables["conditions_compared"].rows[0]["level_change_percent"]
    assert level.startswith(f"{100 * (content.quantities[f'{name}.level_ratio'] - 1):+.2f} [")


def test_figure_14_says_what_its_boxes_are_and_the_text_which_cells_differ(
    run_of, report_of, results, stiffness_n_per_mm
):
    runs = [run_of(name, 0.0, c) for name in KNOWN for c in ("high-stiffness", "modular")]
    lower = [
        replace(run, casr={n: 0.85 * c for n, c in run.casr.items()}) if run.name == "S3_0_modular" else run
        for run in runs
    ]
    content = report_of(lower, contents)
    assert "each box holds the presses of one mounting." in content.drawings["fig14_conditions"].caption
    assert "S3 at 0° (-15.9 %)" in content.drawings["fig14_conditions"].description
    found = discriminate(lower, stiffness_n_per_mm, "S_new", FEW, mounting_sd=0.043)
    said = " ".join(rendered(ACTUATORS, replace(results, runs=Runs(tuple(lower), found)), content).split())
    assert "% (SD, from conditions of the same specimen and angle); 4.3" in said
    assert re.search(r"two means for .*S3 at 0° .*; chance alone is expected to make 0.1 of 3 do so", said)
    thrice = report_of([mounted(run, 3) for run in runs], contents)
    assert "each box holds the presses of 3 mountings." in thrice.drawings["fig14_conditions"].caption


def test_a_specimen_without_scores_has_no_verdict(run_of, report_of):
    runs = [run_of(name, 0.0, "modular") for name in ("S1", "S3", "S5", "S_new")]
    runs[0] = replace(runs[0], casr={name: np.full(10, np.nan) for name in runs[0].casr})
    content = report_of(runs)
    assert [row["rises"] for row in content.tables["casr_by_specimen"].rows] == [None]
    assert [row["between"] for row in content.tables["new_specimen"].rows] == [None]
    assert "runs.modular.0.casr.rises" not in content.quantities


def test_areas_in_pixels_are_not_called_mm2(run_of, report_of):
    content = report_of([replace(run_of(name, 0.0, "modular"), area_unit="px2") for name in KNOWN])
    heads = "".join(c.head for name in ("area_by_specimen", "casr_by_specimen") for c in content.tables[name].columns)
    assert "px²" in heads
    assert "mm²" not in heads


def test_which_specimen_each_press_tells_stands_in_the_report_those_that_are_not_ok_first(run_of, report_of, results):
    plain = run_of("S1", 0.0, "modular")
    good = WeighedPress("S1_0_modular", 1, "S1", 7.63, 7.5, 6.5, np.inf, "ok", "")
    other = replace(good, press=2, kappa_n_per_mm=3.4, verdict="doubtful", why="this presses like S3, not S1")
    runs = (replace(plain, weighed=(good, other)), run_of("S3", 0.0, "modular"), run_of("S5", 0.0, "modular"))
    content = report_of(runs)
    (table,) = [each for name, each in content.tables.items() if name == "runs_weighed"]
    assert [(row["press"], row["verdict"], row["said"]) for row in table.rows] == [
        (2, "doubtful", "this presses like S3, not S1"), (1, "ok", "presses like S1"),
    ]  # fmt: skip
    assert (content.quantities["runs.weighed"], content.quantities["runs.weighed_not_ok"]) == (2, 1)
    page = rendered(RUNS, replace(results, runs=Runs(runs)), content)
    assert "<strong>1</strong> of them is\ndoubtful" in page
    assert "∞" in page
    without = report_of([replace(run, weighed=()) for run in runs])
    assert "runs.weighed" not in without.quantities
    assert "which specimen lay there" not in rendered(RUNS, replace(results, runs=Runs(runs)), without)


def test_notes_that_differ_by_numbers_are_one_kind(run_of, results):
    runs = [run_of(name, 0.0, "modular") for name in ("S1", "S3", "S5", "S_new")]
    shift = "press {}: the camera is {:.1f} ms late"
    runs = [replace(run, notes=tuple(shift.format(r, i - r) for r in range(2))) for i, run in enumerate(runs)]
    runs[3] = replace(runs[3], notes=(*runs[3].notes, "no edge <seen>"))
    of_runs = replace(results, runs=Runs(tuple(runs)))
    body = rendered(RUNS, of_runs, contents(of_runs))
    assert "2 kinds of notes about the runs" in body
    assert "(8 such notes with other numbers, 4 runs: " in body
    assert f"no edge &lt;seen&gt; (1 run: {runs[3].name})" in body


def test_the_name_of_the_papers_algorithm_is_that_of_its_area_rule(whole):
    for rule, name in ((None, "hexagon (paper)"), ("circle", "circle (paper)"), ("edge", "edge (paper)")):
        study = replace(whole.study, scoring=RunSettings(algorithm="paper", area_rule=rule))
        names = {row["algorithm"] for row in numbers_and_tables(replace(whole, study=study)).tables["recipes"].rows}
        assert name in names
        assert ("hexagon (paper)" in names) is (rule is None)
