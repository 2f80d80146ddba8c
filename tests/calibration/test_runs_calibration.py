"""The stage: from scored runs to stiffness, for every angle, condition and algorithm."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from emg2vsa import artifacts
from emg2vsa.calibration import unknown
from emg2vsa.calibration.calibrate import calibrate
from emg2vsa.calibration.forms import growth_power
from emg2vsa.calibration.laws import LAWS
from emg2vsa.calibration.left_out import left_out
from emg2vsa.calibration.online import reachable_width
from emg2vsa.calibration.presses import without_outliers
from emg2vsa.calibration.runs_calibration import calibrate_runs, online_calibrations
from emg2vsa.calibration.unknown import estimate
from emg2vsa.errors import DataError
from emg2vsa.run_scores import ALGORITHMS
from emg2vsa.settings import CalibrationSettings

QUICK = CalibrationSettings(resamples=50)
ONE_MOUNTING = CalibrationSettings(resamples=50, mounting_sd_percent=0.0)


@pytest.fixture(scope="module")
def results(runs, stiffness_n_per_mm):
    return calibrate_runs(runs, stiffness_n_per_mm, "S_new", QUICK)


def test_every_angle_condition_and_algorithm_has_its_entry(results):
    assert len(results.conditions) == 9
    assert results.notes == ()
    for each in results.conditions:
        assert each.specimens == ("S1", "S3", "S5")
        assert tuple(each.algorithms) == ALGORITHMS
        for algorithm in each.algorithms.values():
            assert algorithm.chosen.law == "compliance"
            assert algorithm.paper.law == "exponential"
            assert algorithm.paper.minimise == "kappa"
            assert set(algorithm.left_out_rms) == {"compliance", "exponential", "power", "linear-log"}


def test_stiffness_of_the_new_specimen_is_found(results):
    edge = results.find(30.0, "modular").algorithms["front"]
    assert edge.chosen.low < 5.32 < edge.chosen.high
    assert edge.chosen.error == pytest.approx(edge.chosen.kappa / 5.32 - 1)
    assert results.known_kappa_new == 5.32
    assert edge.best_law == "compliance"


def test_numbers_are_those_of_the_functions_below(results, runs, stiffness_n_per_mm):
    chosen = [run for run in runs if (run.angle_deg, run.condition) == (0.0, "high-stiffness")]
    casr = {run.specimen: run.casr["hexagon"] for run in chosen}
    kappa = [stiffness_n_per_mm[name] for name in ("S1", "S3", "S5")]
    settings = dataclasses.replace(QUICK, law="exponential", minimise="kappa")
    known = calibrate(kappa, np.stack([casr["S1"], casr["S3"], casr["S5"]]), settings, casr_unit="mm2/N")
    found = results.find(0.0, "high-stiffness").algorithms["hexagon"].paper
    assert found.kappa == pytest.approx(estimate(known, casr["S_new"]).kappa[0])
    assert found.adj_r2 == pytest.approx(known.adj_r2[0])
    assert found.equation == known.equation()


def test_both_cues_are_fused(results):
    at = results.find(0.0, "modular")
    fused = at.algorithms["front"].fused
    assert at.indentation.low < 5.32 < at.indentation.high
    assert fused.low < 5.32 < fused.high
    alone = at.algorithms["front"].chosen
    assert fused.high - fused.low < min(alone.high - alone.low, at.indentation.high - at.indentation.low)


def test_growth_of_the_contact_gives_the_exponent_of_its_world(results, runs):
    """The runs of these tests grow with the root of the force, so that the exponent is 2 and not Hertz's 1.5."""
    assert growth_power(runs) == pytest.approx(0.5, abs=0.005)
    at = results.find(0.0, "modular")
    assert at.exponent == pytest.approx(2, rel=0.01)


def test_results_are_stored_and_read_back(results, tmp_path):
    artifacts.save(tmp_path / "calibration.result", results)
    again = artifacts.load(tmp_path / "calibration.result")
    here, there = (each.conditions[4].algorithms["circle"] for each in (results, again))
    np.testing.assert_array_equal(here.casr, there.casr)
    assert here.chosen.notes == there.chosen.notes
    assert here.fused.kappa == there.fused.kappa


def with_outlier(run):
    casr = {name: scores.copy() for name, scores in run.casr.items()}
    casr["front"][4] *= 0.7
    return dataclasses.replace(run, casr=casr)


def test_a_press_far_off_is_left_out_and_said(run_of, stiffness_n_per_mm):
    runs = [run_of(name, 0.0, "modular") for name in ("S1", "S3", "S5", "S_new")]
    spoilt = [with_outlier(run) if run.specimen in ("S3", "S_new") else run for run in runs]
    found = calibrate_runs(spoilt, stiffness_n_per_mm, "S_new", ONE_MOUNTING).conditions[0].algorithms["front"]
    assert "presses left out, more than 5" in found.chosen.notes[0]
    assert found.chosen.notes[0].endswith("1 of S3, 1 of S_new")
    assert abs(found.chosen.error) < 0.1
    assert np.isfinite(found.casr).all()
    kept = dataclasses.replace(ONE_MOUNTING, outlier_mads=0.0)
    all_in = calibrate_runs(spoilt, stiffness_n_per_mm, "S_new", kept).conditions[0].algorithms["front"].chosen
    assert "left out, more" not in " ".join(all_in.notes)
    assert all_in.high - all_in.low > 2 * (found.chosen.high - found.chosen.low)


def test_outliers_need_presses_that_scatter():
    even = np.array([[1.0, 1.0, 1.0, 1.0, 1.0, 2.0]])
    np.testing.assert_array_equal(without_outliers(even, 5), even)
    few = np.array([[1.0, 1.1, 0.9, 9.0]])
    np.testing.assert_array_equal(without_outliers(few, 5), few)
    many = np.array([[1.0, 1.1, 0.9, 1.05, np.nan, 9.0]])
    np.testing.assert_array_equal(np.isnan(without_outliers(many, 5)), [[0, 0, 0, 0, 1, 1]])


def test_runs_without_a_log_have_no_second_cue_and_a_truth_that_is_not_known_no_error(run_of, stiffness_n_per_mm):
    runs = [
        dataclasses.replace(run_of(name, 0.0, "modular"), indent_n_per_mm=np.full(10, np.nan))
        for name in ("S1", "S3", "S5", "S_new")
    ]
    del stiffness_n_per_mm["S_new"]
    found = calibrate_runs(runs, stiffness_n_per_mm, "S_new", QUICK)
    stiffness_n_per_mm["S_new"] = 5.32
    at = found.conditions[0]
    assert at.indentation is None
    assert at.algorithms["front"].fused is None
    assert np.isnan([at.algorithms["front"].chosen.error, found.known_kappa_new]).all()


def test_an_algorithm_that_finds_nothing_is_undefined_and_says_so(run_of, stiffness_n_per_mm):
    runs = [run_of(name, 0.0, "modular") for name in ("S1", "S3", "S5", "S_new")]
    blind = [dataclasses.replace(run, casr=run.casr | {"hexagon": np.full(10, np.nan)}) for run in runs]
    at = calibrate_runs(blind, stiffness_n_per_mm, "S_new", QUICK).conditions[0]
    assert np.isnan(at.algorithms["hexagon"].chosen.kappa)
    assert "undefined" in " ".join(at.algorithms["hexagon"].chosen.notes)
    assert at.algorithms["hexagon"].best_law == ""
    assert np.isfinite(at.algorithms["front"].chosen.kappa)


def test_too_few_specimens_are_noted_and_no_new_specimen_is_refused(run_of, stiffness_n_per_mm):
    runs = [run_of("S1", 0.0, "modular"), run_of("S_new", 0.0, "modular")]
    found = calibrate_runs(runs, stiffness_n_per_mm, "S_new", QUICK)
    assert found.conditions == ()
    assert found.notes == ("0°, modular: 1 known specimens, too few to calibrate",)
    with pytest.raises(DataError, match="a run of the new specimen, S9"):
        calibrate_runs(runs, stiffness_n_per_mm, "S9", QUICK)


def test_without_a_new_specimen_there_is_nothing_to_calibrate_and_a_note_says_so(run_of, stiffness_n_per_mm):
    found = calibrate_runs([run_of("S1", 0.0, "modular")], stiffness_n_per_mm, "", QUICK)
    assert found.conditions == ()
    assert "names no new_specimen" in found.notes[0]


def test_every_angle_and_condition_has_a_calibration_for_presses_on_line(runs, stiffness_n_per_mm):
    found = online_calibrations(runs, stiffness_n_per_mm, "S_new", (0.5, 7.0), QUICK, provenance={"study": "small"})
    assert {(each.angle_deg, each.condition) for each in found} == {(run.angle_deg, run.condition) for run in runs}
    for each in found:
        assert each.specimens == ("S1", "S3", "S5")
        assert each.quantity == "front"
        assert each.simulated
        assert np.isfinite(each.rates[..., -1]).all()
        assert reachable_width(each, 5.32) > 0
    assert not online_calibrations(runs[:1], stiffness_n_per_mm, "S_new", (0.5, 7.0), QUICK)


def test_a_specimen_whose_skin_stretches_otherwise_is_named(runs, stiffness_n_per_mm):
    def stretched(run):
        slope = 2.0 if run.specimen == "S5" else 0.2
        forces = np.linspace(0.5, 7.0, 12)
        own = {"stretch_force_n": forces, "stretch_log_ratio": slope * np.log(forces / 0.5), "stretch_log_sd": 0.05}
        return dataclasses.replace(run, curves=tuple(dataclasses.replace(curve, **own) for curve in run.curves))

    place = [run for run in runs if (run.angle_deg, run.condition) == (0.0, "modular")]
    found = calibrate_runs([stretched(run) for run in place], stiffness_n_per_mm, "S_new", QUICK)
    (note,) = (note for note in found.conditions[0].algorithms["front"].chosen.notes if "friction" in note)
    assert note.startswith("S5 may have other friction, ")
    assert "slip, other friction, or lost pins" in note


def test_each_estimate_tests_every_law_once_and_is_fused_as_it_is(run_of, stiffness_n_per_mm, monkeypatch):
    tested = []
    monkeypatch.setattr(unknown, "left_out", lambda calibration: tested.append(calibration) or left_out(calibration))
    monkeypatch.setattr("emg2vsa.calibration.left_out.left_out", None)
    runs = [run_of(name, 0.0, "modular") for name in ("S1", "S3", "S5", "S_new")]
    found = calibrate_runs(runs, stiffness_n_per_mm, "S_new", QUICK).conditions[0]
    at_once = [len(each.kappa) for each in tested]  # by the settings and the paper's, all algorithms; by the depth
    assert sorted(at_once) == [1] * len(LAWS) + [len(ALGORITHMS)] * (2 * len(LAWS))
    assert all(each.fused is not None for each in found.algorithms.values())
