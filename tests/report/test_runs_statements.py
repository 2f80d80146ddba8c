"""Sentences and tables of section VI where runs are odd, intervals have no end, or two laws disagree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.calibration.runs_calibration import calibrate_runs
from emg2vsa.discrimination import discriminate
from emg2vsa.report import paper_comparison as paper
from emg2vsa.report import runs_conclusions as conclusions
from emg2vsa.report.kappa_conclusion import holds, kappa_conclusion
from emg2vsa.report.kappa_tables import kappa_tables
from emg2vsa.report.methods import runs_methods
from emg2vsa.report.runs_section import runs_sections
from emg2vsa.report.wording import NO_BREAK
from emg2vsa.settings import CalibrationSettings, DiscriminationSettings

FEW = DiscriminationSettings(resamples=200)
ALL = ("S1", "S_new", "S3", "S5")
TRUTH = 5.32
NAN, INF = float("nan"), float("inf")


def compared(runs, stiffness, **changed):
    return discriminate(runs, stiffness | changed, "S_new", FEW)


@pytest.fixture(scope="module")
def calibration(runs, stiffness_n_per_mm):
    return calibrate_runs(runs, stiffness_n_per_mm, "S_new", CalibrationSettings(resamples=20))


def test_a_specimen_without_scores_leaves_its_design_untested(runs, stiffness_n_per_mm):
    rejected = [replace(run, verdicts=("rejected",) * 10) if run.name == "S1_30_modular" else run for run in runs]
    found = compared(rejected, stiffness_n_per_mm)
    said = conclusions.specimens(found)
    assert "in all of 8 designs" in said or "of 8 designs; it does not in" in said
    assert said.endswith("Not tested: modular, 30° (no scored press of S1).")
    assert "modular, 30°" not in said.partition(" Not tested")[0]


def with_law(calibration, angle_deg, condition, algorithm, paper_error, **changed):
    """One calibration with other numbers by the law chosen, and another error by the paper's."""
    conditions = []
    for each in calibration.conditions:
        if (each.angle_deg, each.condition) == (angle_deg, condition):
            of = each.algorithms[algorithm]
            new = replace(of, chosen=replace(of.chosen, **changed), paper=replace(of.paper, error=paper_error))
            each = replace(each, algorithms=each.algorithms | {algorithm: new})
        conditions.append(each)
    return replace(calibration, conditions=tuple(conditions))


@pytest.fixture(scope="module")
def one_angle(calibration):
    """Rigid at 30° only: edge 1 % off by its law, 9 % by the paper's, and its interval 4 % wide."""
    rigid = [each for each in calibration.conditions if (each.angle_deg, each.condition) == (30.0, "high-stiffness")]
    alone = replace(calibration, conditions=tuple(rigid))
    return with_law(alone, 30.0, "high-stiffness", "edge", 0.09, error=0.01, kappa=5.37, low=5.27, high=5.48)


def old(one_angle, paper_error, **changed):
    return with_law(one_angle, 30.0, "high-stiffness", "circle", paper_error, **changed)


def test_an_old_interval_without_an_end_and_a_law_that_turns_the_order_settle_nothing(one_angle):
    found = old(one_angle, 0.02, error=0.2, kappa=6.4, low=1.2, high=INF)
    said = kappa_conclusion(found, "edge", "circle")
    assert "smaller error at 1 of 1 angle (median 1.00\N{NO-BREAK SPACE}% against 20.0\N{NO-BREAK SPACE}% with" in said
    assert f"by the paper's law at 0 of 1 angle (median 9.00{NO_BREAK}% against 2.00{NO_BREAK}%)" in said
    assert "The order is settled at 0 of 1 angle: the old one leaves κ undetermined at 30°" in said
    assert "the two laws disagree at 30°" in said
    assert "By circle, the interval holds the known stiffness in 1 of 1 design (1 without an upper end)." in said


def test_two_closed_intervals_and_two_laws_that_agree_settle_the_order(one_angle):
    found = old(one_angle, 0.3, error=0.2, kappa=6.4, low=6.2, high=6.6)
    assert "The order is settled at 1 of 1 angle." in kappa_conclusion(found, "edge", "circle")
    wide = old(one_angle, 0.3, error=0.2, kappa=6.4, low=5.2, high=7.6)
    assert "the errors differ by less than the intervals reach at 30°" in kappa_conclusion(wide, "edge", "circle")


def test_equal_errors_are_called_the_same(one_angle):
    found = old(one_angle, 0.09, error=-0.01, kappa=5.27, low=5.1, high=5.4)
    said = kappa_conclusion(found, "edge", "circle")
    assert "the smaller error at 0 of 1 angle and the same at 1" in said


def test_the_papers_own_law_is_not_compared_with_itself(one_angle):
    found = with_law(one_angle, 30.0, "high-stiffness", "edge", 0.01)
    found = old(found, 0.2, error=0.2, kappa=6.4, low=6.2, high=6.6)
    assert "paper's law" not in kappa_conclusion(found, "edge", "circle")


@pytest.mark.parametrize(
    ("low", "high", "held"),
    [(1.2, INF, True), (6.0, INF, False), (5.0, 6.0, True), (NAN, NAN, None), (NAN, INF, None)],
)
def test_an_interval_without_an_upper_end_holds_every_stiffer_one(one_angle, low, high, held):
    found = old(one_angle, 0.02, low=low, high=high)
    assert holds(found.conditions[0].algorithms["circle"], TRUTH) is held


def test_undefined_intervals_are_counted(one_angle):
    said = kappa_conclusion(old(one_angle, 0.02, low=NAN, high=NAN), "edge", "circle")
    assert "By circle, the interval holds the known stiffness in 0 of 0 designs; 1 more design has an undefined" in said


def test_intervals_and_the_papers_law_lie_beside_table_one(one_angle):
    table = kappa_tables(old(one_angle, 0.02, error=0.2, kappa=6.4, low=1.2, high=INF), "edge", "circle")[
        "table_one_laws"
    ]
    row = dict(zip((column.key for column in table.columns), table.rows[1], strict=True))
    assert row["angle_deg"] == 30
    assert row["old_vision_interval_n_per_mm"] == "6.40 [1.20, ∞): not determined"
    assert row["new_vision_interval_n_per_mm"] == "5.37 [5.27, 5.48]"
    assert (row["old_vision_paper_law"], row["new_vision_paper_law"]) == (0.02, 0.09)
    assert row["human_like_interval_n_per_mm"] == "–"


def test_the_papers_r2_stands_only_where_the_paper_has_one(calibration):
    table = kappa_tables(calibration, "edge", "circle")["kappa_new"]
    at = [column.key for column in table.columns].index("paper_adj_r2")
    shown = {cells[0]: cells[at] for cells in table.cells()}
    assert shown["high-stiffness, 0°"] == "–"
    assert shown["high-stiffness, 30°"] == shown["high-stiffness, 45°"] == "0.8963"
    assert shown["constant-mean, 0°"] == "0.9996"
    assert shown["modular, 0°"] == "0.9753"
    assert set(paper.WORST_ADJ_R2) < {condition for condition, _ in paper.DESIGNS}


def test_what_the_papers_test_can_give_stands_beside_each_p(runs, stiffness_n_per_mm):
    rigid = [run for run in runs if run.condition == "high-stiffness"]
    table = runs_sections(rigid, compared(rigid, stiffness_n_per_mm), None, ALL).tables["paper_comparison_runs"]
    minds = {str(row[0]): str(row[3]) for row in table.rows}
    least = "the bound of three separated groups of ten without correction, .01109"
    assert f"the paper's p equals {least}" in minds["CASR between specimens, high-stiffness at 30°, worst pair"]
    for condition in ("modular", "constant-min", "constant-max"):
        assert f"p is below even {least}" in minds[f"CASR between specimens, {condition} at 0°, worst pair"]


def test_deviations_of_the_rate_have_two_decimals(run_of, stiffness_n_per_mm):
    human = [run_of(name, 0.0, "modular") for name in ALL]
    constant = [
        replace(run, condition="constant-mean", casr={n: c / 1.0031 for n, c in run.casr.items()}) for run in human
    ]
    rigid = [replace(run, condition="high-stiffness") for run in human]
    found = compared([*human, *constant, *rigid], stiffness_n_per_mm)
    said = conclusions.constant_levels(found)
    assert "less that with a constant level, is +0.31 [" in said
    assert "(constant-mean, 0°) in percent" in said
    assert "presses within one mounting" in said
    assert "with the rigid motor, is +0.00 [" in conclusions.why(found, simulated=True)
    table = runs_sections([*human, *constant, *rigid], found, None, ALL).tables["conditions_compared"]
    at = [column.key for column in table.columns].index("level_change_percent")
    assert {str(row[0]): str(row[at])[:5] for row in table.rows} == {
        "high-stiffness, 0°": "+0.00", "constant-mean, 0°": "+0.31",
    }  # fmt: skip


def test_methods_name_the_angles_of_each_condition_and_all_terms(results, runs):
    text = " ".join(runs_methods(results.study, runs))
    assert "high-stiffness and modular at 0°, 30° and 45°; constant-min, constant-mean and constant-max at 0°" in text
    assert "5 median absolute deviations, scaled to an SD" in text
    assert "an SD of 0.5° of the angle" in text
    assert "Hertz's 1.5" in text
    assert "least squares of CASR" in text
    other = replace(results.study, calibration=CalibrationSettings(law="power", minimise="kappa", outlier_mads=0))
    text = " ".join(runs_methods(other, runs))
    assert "scaled to an SD" not in text
    assert "Hertz's 1.5" not in text
    assert "least squares of κ" in text


@pytest.mark.parametrize(
    ("stiffness", "says"),
    [(0.5, "S_new is the softest of all and lies between no two. Its CASR is larger than that of S5"),
     (9.0, "S_new is the stiffest of all and lies between no two. Its CASR is smaller than that of S1")],
)  # fmt: skip
def test_a_new_specimen_at_the_end_has_one_neighbour(stiffness, says, run_of, stiffness_n_per_mm):
    runs = [run_of(name, 0.0, "modular") for name in ALL]
    found = compared(runs, stiffness_n_per_mm, S_new=stiffness)
    said = conclusions.new_specimen(found)
    # its presses are those of 5.32 N/mm: on the wrong side of either neighbour
    assert said == f"{says}, and told from it, in 0 of 1 design where both have scores."
    table = runs_sections(runs, found, None, ALL).tables["new_specimen"]
    at = [column.key for column in table.columns].index("between")
    assert table.rows[0][at] is None


def test_a_new_specimen_that_is_softest_and_scores_so_is_told(run_of, stiffness_n_per_mm):
    runs = [run_of(name, 0.0, "modular") for name in ("S1", "S3", "S5")]
    runs.append(replace(runs[2], specimen="S_new", casr={n: 2 * c for n, c in runs[2].casr.items()}))
    said = conclusions.new_specimen(compared(runs, stiffness_n_per_mm, S_new=0.5))
    assert "told from it, in 1 of 1 design" in said


def test_a_neighbour_without_a_scored_press_is_named(run_of, stiffness_n_per_mm):
    runs = [run_of(name, 0.0, "modular") for name in ALL]
    runs[2] = replace(runs[2], verdicts=("rejected",) * 10, reasons=("lost",) * 10)
    assert "(no scored press of S3)" in conclusions.new_specimen(compared(runs, stiffness_n_per_mm))


def once(run):
    return replace(run, verdicts=("ok", *("rejected",) * 9), reasons=("", *("lost",) * 9))


def test_single_presses_are_not_compared(run_of, stiffness_n_per_mm):
    runs = [once(run_of(n, 0.0, c)) for n in ALL for c in ("high-stiffness", "modular", "constant-min")]
    found = compared(runs, stiffness_n_per_mm)
    assert "cannot be compared: a gap takes two scored presses" in conclusions.actuators(found)
    assert "cannot be compared by their gaps" in conclusions.vision(found)
    assert conclusions.constants(found) == conclusions.constant_levels(found) == ""
    table = runs_sections(runs, found, None, ALL).tables["conditions_compared"]
    assert {row[-1] for row in table.rows} == {"–"}


def test_areas_in_pixels_are_not_called_mm2(run_of, stiffness_n_per_mm):
    runs = [replace(run_of(name, 0.0, "modular"), area_unit="px2") for name in ALL]
    body = runs_sections(runs, compared(runs, stiffness_n_per_mm), None, ALL).body
    assert "areas in px²" in body
    assert "areas in mm²" not in body


def test_notes_that_differ_by_numbers_are_one_kind(run_of, stiffness_n_per_mm):
    shift = "A common shift of all pins by ({0}, -0.02) px is taken off."
    runs = [
        replace(run_of(name, 0.0, "modular"), notes=(shift.format(-0.1 * i), shift.format(0.25)))
        for i, name in enumerate(ALL)
    ]
    runs[3] = replace(runs[3], notes=(*runs[3].notes, "no edge <seen>"))
    body = runs_sections(runs, compared(runs, stiffness_n_per_mm), None, ALL).body
    assert "2 kinds of notes of the runs" in body
    first = f"{runs[0].name}, {runs[1].name}, {runs[2].name}, …"
    assert f"{shift.format(-0.0)} (8 such notes with other numbers, 4 runs: {first})" in body
    assert f"no edge &lt;seen&gt; (1 run: {runs[3].name})" in body


def test_notes_of_the_calibration_name_their_designs(run_of, stiffness_n_per_mm):
    runs = [run_of(name, 0.0, condition) for condition in ("modular", "high-stiffness") for name in ALL]
    far = {n: np.append(c[:9], 3 * c[9]) for n, c in runs[3].casr.items()}
    runs[3] = replace(runs[3], casr=far)
    calibration = calibrate_runs(runs, stiffness_n_per_mm, "S_new", CalibrationSettings(resamples=20))
    body = runs_sections(runs, compared(runs, stiffness_n_per_mm), calibration, ALL).body
    assert "1 of S5 (modular, 0°)" in body
    assert "are needed to test it (every design)" in body
