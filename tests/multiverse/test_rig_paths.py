"""Paths of the rig's presses: the study's own equals the report's verdicts, and a choice does what its name says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.calibration.results import CalibrationResults, ConditionResult
from emg2vsa.calibration.runs_calibration import calibrate_runs
from emg2vsa.claims.claim import OF_A_STUDY, judge
from emg2vsa.claims.on_rig import claims_on_rig
from emg2vsa.discrimination.run_table import run_table
from emg2vsa.multiverse.path import ALGORITHM, EXCLUSIONS, KAPPA, MOUNTING, MOUNTING_SD, PRESS, RATE, SPECIMEN
from emg2vsa.multiverse.paths import all_paths
from emg2vsa.multiverse.rig import rig_paths
from emg2vsa.settings import PAPER, CalibrationSettings, RunSettings
from tests.claims.test_kappa_claims import pins_of
from tests.multiverse.people_studies import study_of

ALPHA = 0.1
MOUNTED = np.repeat([1, 2, 3], 3)
NO_PINS = CalibrationResults("S_new", 5.32, (), ())


def mounted(runs, sd=0.01, shift=None):
    """Nine presses in three mountings, each with its error. shift : run to the mounting that is off, and how far."""
    found = []
    for seed, run in enumerate(runs):
        rng = np.random.default_rng(seed)
        error = 1 + sd * rng.standard_normal(3)[MOUNTED - 1]
        if shift and run.name in shift:
            number, by = shift[run.name]
            error = error * np.where(number == MOUNTED, by, 1.0)
        casr, area = ({k: v[:9] * error for k, v in each.items()} for each in (run.casr, run.start_area))
        cut = {k: getattr(run, k)[:9] for k in ("repetitions", "pressed_at", "verdicts", "reasons", "pins_selected",
                "first_n", "true_a_c0", "indent_n_per_mm", "peak_n", "curves")}  # fmt: skip
        other = {k: {a: v[:9] for a, v in getattr(run, k).items()} for k in ("a_c0", "over_array")}
        found.append(replace(run, mounting=MOUNTED.copy(), casr=casr, start_area=area, **cut, **other))
    return tuple(found)


@pytest.fixture(scope="module")
def study():
    return study_of(1)


@pytest.fixture(scope="module")
def few(runs):
    """Both actuators at 0 and 30 degrees."""
    return tuple(r for r in runs if r.angle_deg < 45 and r.condition in ("high-stiffness", "modular"))


def table_of(study, runs):
    return run_table(runs, study.pressed_n_per_mm, study.profile.new_specimen)


@pytest.mark.parametrize(
    "changed",
    [
        {},
        {"scoring": RunSettings(algorithm="hexagon")},
        {"calibration": CalibrationSettings(**PAPER["calibration"])},
    ],
    ids=["default", "hexagon", "paper"],
)
@pytest.mark.parametrize("mountings", [1, 3])
def test_the_own_path_is_that_of_the_report_to_the_last_digit(study, runs, changed, mountings):
    study = replace(study, **changed)
    runs = mounted(runs) if mountings == 3 else runs
    runs = tuple(replace(run, algorithm=study.scoring.algorithm) for run in runs)
    table = table_of(study, runs)
    calibration = calibrate_runs(
        runs, study.pressed_n_per_mm, "S_new", replace(study.calibration, resamples=10),
        kappa_se=study.kappa_of_scores[1],
    )  # fmt: skip
    own = next(rig_paths(study, runs, table, calibration))
    assert own.choices == ()
    expected, found = (
        [
            (each.claim.key, each.verdict, each.claim.found.estimate, each.low, each.high)
            for each in judge(claims, ALPHA, OF_A_STUDY)
        ]
        for claims in (claims_on_rig(study, table, calibration), own.claims)
    )
    np.testing.assert_equal(found, expected)
    assert np.isfinite([each[2] for each in expected]).sum() > 5


def test_a_claim_that_hangs_on_one_mounting_turns_in_the_path_without_it(study, runs):
    """One mounting of S3 reads as high as S5: without it the specimens are told apart."""
    rigid = tuple(run for run in runs if run.condition == "high-stiffness")
    worlds = mounted(rigid, 0.002, {"S3_30_high-stiffness": (2, 1.35)})
    paths = all_paths(study, (), {}, worlds, table_of(study, worlds))
    row = paths.claims.index("casr_rigid")
    assert paths.own[row] == "not determined"
    turned = paths.name[(paths.verdict[row] == "holds") & (paths.kind == MOUNTING)]
    assert turned.tolist() == ["without mounting 2 of S3 high-stiffness 30°"]
    assert all(not claim.startswith("kappa") for claim in paths.claims)


def test_choices_have_their_paths(study, few):
    """30 specimens by designs by mountings; one algorithm is the study's own."""
    runs = mounted(few)
    paths = all_paths(study, (), {}, runs, table_of(study, runs), calibration=NO_PINS)
    counts = {kind: int(np.count_nonzero(paths.kind == kind)) for kind in set(paths.kind.tolist())}
    assert counts[MOUNTING] == 3 * len(runs)
    assert counts[PRESS] == 9 * len(runs)
    assert counts[ALGORITHM] == 4
    assert counts[RATE] == 1
    assert counts[MOUNTING_SD] == 2
    assert counts[SPECIMEN] == 3
    assert counts[KAPPA] == 9
    assert paths.kept("kappa_fit_rigid", SPECIMEN) == (0, 0)  # a law through two specimens fits them both
    assert paths.kept("area_same_on_specimens", KAPPA) == (0, 0)


def test_a_mounting_or_press_bears_on_the_claims_that_compare_its_cell(study, runs):
    every = mounted(runs)
    paths = all_paths(study, (), {}, every, table_of(study, every))
    assert {claim: n for claim in paths.claims if (n := paths.kept(claim)[1]) < 40} == {}
    for kind, each in ((MOUNTING, 3), (PRESS, 9)):
        of = {
            key: paths.name[(row != "") & (paths.kind == kind)]
            for key, row in zip(paths.claims, paths.verdict, strict=True)
        }
        assert (
            len(of["casr_rigid"]) == each * 2 * 3
        )  # the angles that the paper reports, and the specimens of known stiffness
        assert all("high-stiffness" in name and "S_new" not in name for name in of["casr_rigid"])
        assert len(of["fig10_order"]) == each * 2 * 4
        assert len(of["human_like_contrast"]) == each * 2 * 2  # two conditions at one angle, its two ends


def test_kappa_by_the_pins_hangs_on_no_choice_of_scores(study, few):
    """It is not estimated again along the paths: none bears on its claims, and its own verdict is the report's."""
    runs = mounted(few)
    designs = [("high-stiffness", angle) for angle in (0.0, 30.0, 45.0)]
    conditions = [ConditionResult(a, c, True, (), np.empty(0), 1.5, {}, None, pins=pins_of(0.02)) for c, a in designs]
    calibration = replace(NO_PINS, conditions=tuple(conditions))
    paths = all_paths(study, (), {}, runs, table_of(study, runs), calibration=calibration)
    row = paths.claims.index("kappa_error_rigid")
    assert paths.own[row] == "holds"
    assert paths.kept("kappa_error_rigid") == (0, 0)
    assert paths.kept("kappa_fit_rigid")[1] > 0


def test_what_no_path_estimates_has_no_share(study, few):
    runs = mounted(few, sd=0.3)  # so much that kappa is determined nowhere
    paths = all_paths(study, (), {}, runs, table_of(study, runs), calibration=NO_PINS)
    kinds, share = paths.shares()
    for claim in ("kappa_error_rigid", "kappa_error_human_like"):
        row = paths.claims.index(claim)
        assert not paths.estimated(claim)
        assert np.isnan(share[row]).all()
        assert paths.kept(claim)[0] == paths.kept(claim)[1] > 0
    assert paths.estimated("human_like_contrast")
    assert np.isfinite(share[paths.claims.index("human_like_contrast"), 1 + kinds.index(MOUNTING)])


def test_mounted_once_no_mounting_is_left_out_and_the_assumed_scatter_is_a_choice(study, few):
    paths = all_paths(study, (), {}, few, table_of(study, few))
    assert MOUNTING not in paths.kind
    kept, of = paths.kept("area_same_on_specimens", MOUNTING_SD)
    assert of == 2
    assert kept <= of


def test_an_outlying_score_is_left_out(study, few):
    off = few[0]
    casr = off.casr["front"].copy()
    casr[4] *= 1.5
    runs = (replace(off, casr=off.casr | {"front": casr}), *few[1:])
    found = rig_paths(study, runs, table_of(study, runs), None)
    assert [each.name for each in found if each.kind == EXCLUSIONS] == [
        "without outlying scores", "without the first press of every mounting",
        "without the last press of every mounting",
    ]  # fmt: skip


def test_rejected_presses_and_runs_without_a_new_specimen_are_no_obstacle(study, few):
    alone = replace(study, profile=replace(study.profile, new_specimen=None))
    known = tuple(
        replace(run, verdicts=("rejected",) * 10) if run.name.startswith("S1") else run
        for run in few
        if run.specimen != "S_new"
    )
    table = run_table(known, alone.pressed_n_per_mm, "")
    paths = all_paths(alone, (), {}, known, table)
    assert set(paths.own.tolist()) == {"not determined"}
    assert not [claim for claim in paths.claims if claim.startswith("kappa")]


def test_a_study_whose_rates_are_sums_over_frames_has_no_other_rate_rule(study, few):
    summed = replace(study, scoring=RunSettings(algorithm="paper"))
    runs = tuple(replace(run, algorithm="paper") for run in few)
    kinds = {each.kind for each in rig_paths(summed, runs, table_of(summed, runs), None)}
    assert RATE not in kinds
