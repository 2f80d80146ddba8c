"""Section "Stiffness of the specimens": plate indentations, their lines, and the claim that a line describes them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.curves.plate_tests import PlateTests, PlateTrial, plate_tests
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.section import rendered
from emg2vsa.report.sections.plates import PLATES
from emg2vsa.report.study_report import contents

DEPTH_MM = np.linspace(0, 3, 200)


def indentations(*, bend: float = 0.0) -> PlateTests:
    """Two trials on S1 and one on S5, contact at 1 mm; ``bend`` : of the curve of S5 away from a line, N/mm2."""
    past = np.maximum(DEPTH_MM - 1, 0)
    noise = np.random.default_rng(5).normal(0, 0.01, (3, 200))
    forces = np.stack([7.6 * past, 7.8 * past, 1.1 * past + bend * past**2]) + noise
    measured = [(DEPTH_MM, force) for force in forces]
    return pressed([("S1", "a/1"), ("S1", "a/2"), ("S5", "b/1")], measured)


def pressed(names: list[tuple[str, str]], measured: list[tuple[np.ndarray, np.ndarray]]) -> PlateTests:
    trials = [PlateTrial(*name, *each, mounting=name[1][0]) for name, each in zip(names, measured, strict=True)]
    return plate_tests(trials, (0.5, 20.0))


def test_trials_are_drawn_from_their_contact_with_the_line_of_their_specimen(results: StudyResults) -> None:
    content = contents(replace(results, plates=indentations()))
    curves, rest, over = content.drawings["figplate_indentation"].figure.axes
    assert [np.mean(line.get_ydata()) for line in over.lines] == pytest.approx([7.7, 1.1], rel=0.01)
    pale = [line for line in curves.lines if line.get_alpha()]
    assert len(pale) == 3
    for line in pale:
        x, y = line.get_data()
        assert np.interp(0, x, y) == pytest.approx(0, abs=0.12)  # the mean of five samples rounds the corner
    drawn = {line.get_label().split(" ±")[0]: line.get_data() for line in curves.lines if "N/mm" in line.get_label()}
    assert list(drawn) == ["S1: 7.70", "S5: 1.10"]
    assert drawn["S1: 7.70"][1][-1] / drawn["S1: 7.70"][0][-1] == pytest.approx(7.7, rel=2e-3)
    assert max(np.abs(line.get_ydata()).max() for line in rest.lines) < 60  # mN, of noise and the corner at contact
    assert "Simulated" not in content.drawings["figplate_indentation"].caption


def test_numbers_and_tables_are_those_of_the_trials(results: StudyResults) -> None:
    found = indentations()
    content = contents(replace(results, plates=found))
    assert content.quantities["plates.S1.kappa_n_per_mm.mean"] == pytest.approx(7.7, rel=1e-3)
    assert content.quantities["plates.S1.adj_r2.min"] == found.fit.adj_r2[:2].min()
    assert (content.quantities["plates.S1.trials"], content.quantities["plates.S5.trials"]) == (2, 1)
    rows = content.tables["plates"].rows
    assert [(row["specimen"], row["trial"], row["secant"]) for row in rows] == [
        (trial.specimen, trial.trial, own.secant) for trial, own in zip(found.trials, found.ranges, strict=True)
    ]
    assert [row["specimen"] for row in content.tables["specimens"].rows] == results.specimens
    assert "Figure" not in rendered(PLATES, results, contents(results))
    assert "through a plate indentation is .99" in rendered(PLATES, replace(results, plates=found), content)


def test_a_curve_that_bends_lowers_r2_and_departs_from_its_line(results: StudyResults) -> None:
    bent = indentations(bend=3.0)
    said = replace(results, plates=bent)
    assert "κ is not one number for S5 (1 of 1 trial: " in rendered(PLATES, said, contents(said)).replace("\xa0", " ")
    assert bent.worst_adj_r2()["S5"] < 0.99 < 0.999 < bent.worst_adj_r2()["S1"]
    _, rest, _ = contents(replace(results, plates=bent)).drawings["figplate_indentation"].figure.axes
    assert max(np.abs(line.get_ydata()).max() for line in rest.lines) > 300


def test_a_study_without_logs_shows_what_its_file_says(results: StudyResults) -> None:
    content = contents(results)
    assert "figplate_indentation" not in content.drawings
    assert "plates" not in content.tables
    assert not [key for key in content.quantities if key.startswith("plates.")]
    assert "specimens" in content.tables
    assert "There is no log of a plate" in rendered(PLATES, results, content)


@pytest.mark.parametrize("bad", [np.zeros(200), -DEPTH_MM, np.full(200, np.nan)], ids=["flat", "falling", "empty"])
def test_a_trial_whose_force_does_not_rise_is_told_and_not_drawn(results: StudyResults, bad: np.ndarray) -> None:
    good = 7.6 * np.maximum(DEPTH_MM - 1, 0)
    measured = [(DEPTH_MM, good), (DEPTH_MM, bad)]
    found = pressed([("S1", "a/1"), ("S5", "b/1")], measured)
    assert np.isnan(found.worst_adj_r2()["S5"])
    told = replace(results, plates=found)
    content = contents(told)
    curves, _, _ = content.drawings["figplate_indentation"].figure.axes
    assert [line.get_label()[:8] for line in curves.lines if "N/mm" in line.get_label()] == ["S1: 7.60"]
    assert "S5, trial b/1, is unusable: " in rendered(PLATES, told, content)
    nothing = replace(results, plates=pressed([], []))
    assert "figplate_indentation" not in contents(nothing).drawings


@pytest.mark.parametrize(
    ("bend", "noise_n", "verdict"), [(0.0, 0.01, "holds"), (0.35, 0.01, "refuted"), (0.0, 1.0, "not determined")]
)
def test_the_claim_on_lines_follows_from_the_change_of_kappa(
    results: StudyResults, bend: float, noise_n: float, verdict: str
) -> None:
    depth, rng = np.linspace(-0.3, 2, 300), np.random.default_rng(0)
    past, names = np.maximum(depth, 0), [(name, f"{name}/{i}") for name in results.specimens for i in range(3)]
    bends = [bend if name == results.specimens[-1] else 0.0 for name, _ in names]
    measured = [(depth, 5 * past + each * past**2 + noise_n * rng.standard_normal(300)) for each in bends]
    quantities = contents(replace(results, plates=pressed(names, measured))).quantities
    assert quantities["claims.plate_line.verdict"] == verdict
    low, high = quantities["claims.plate_line.low"], quantities["claims.plate_line.high"]
    if bend:  # from 5 N/mm at the touch; over .5 N to the deepest kappa is (5 + 2 bend x)
        kappa = 5 + 2 * bend * np.interp([0.5, 0.98 * (10 + 4 * bend)], 5 * past + bend * past**2, past)
        assert low < 100 * np.ptp(kappa) / kappa.mean() < high


def test_the_claim_on_lines_waits_for_plates(results: StudyResults) -> None:
    content = contents(results)
    assert content.quantities["claims.plate_line.verdict"] == "not determined"
    (row,) = [each for each in content.tables["claims_on_settings"].rows if "straight line" in str(each["says"])]
    assert "No plate pressed" in str(row["why"])
