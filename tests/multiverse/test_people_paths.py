"""Paths of people's presses: the study's own equals the report's verdicts, and a choice does what its name says."""

from __future__ import annotations

from dataclasses import replace
from itertools import takewhile

import numpy as np
import pytest

from emg2vsa.claims.claim import OF_A_STUDY, judge
from emg2vsa.claims.people import claims_of_study
from emg2vsa.companions.force_laws import force_laws
from emg2vsa.fits import concatenate, fit_trials, in_session
from emg2vsa.multiverse.path import BINS, EXCLUSIONS, INDEX, LAW, PERSON, REPETITION, SEVERAL
from emg2vsa.multiverse.paths import all_paths, gathered
from emg2vsa.multiverse.people import LAWS, _fitted, people_paths
from emg2vsa.settings import CocontractionSettings, FitSettings, HypothesisSettings
from tests.multiverse.people_studies import made, places, study_of, with_slopes
from tests.report.conftest import TRUE

ALPHA = 0.1
REVERSED = {"S1": 7e-6, "S3": 13e-6, "S5": 20e-6}


def report_of(study, trials, place):
    """Key to what the report says: from the products of the stages, not from paths."""
    fits = concatenate([fit_trials(each, study.fit, study.window, study.judgements) for each in trials])
    laws = force_laws(fits, study.hypotheses.use, 1 - study.hypotheses.alpha)
    judged = judge(claims_of_study(study, fits, place, laws), ALPHA, OF_A_STUDY)
    return {each.claim.key: (each.verdict, each.claim.found.estimate, each.low, each.high) for each in judged}


def own_of(study, trials, place):
    own = next(people_paths(study, trials, place))
    assert own.choices == ()
    judged = judge(own.claims, ALPHA, OF_A_STUDY)
    return {each.claim.key: (each.verdict, each.claim.found.estimate, each.low, each.high) for each in judged}


@pytest.mark.parametrize(
    "changed",
    [
        {},
        {"fit": FitSettings(points="samples", weights="none")},
        {"hypotheses": HypothesisSettings(use="ok", kept_specimens=("S1", "S3", "S5"))},
        {"cocontraction": CocontractionSettings(normalise="session-max")},
        {"cocontraction": CocontractionSettings(index="rudolph")},
    ],
    ids=["default", "samples", "without a remark", "session", "index"],
)
def test_the_own_path_is_that_of_the_report_to_the_last_digit(changed):
    study = replace(study_of(4), **changed)
    place, trials = places(study), with_slopes(study, {})
    fitted = trials
    if study.cocontraction.needs_session:
        sessions = {p: [each for each in trials if each.participant == p] for p in study.participants}
        fitted = [in_session(each, sessions[each.participant], study.cocontraction) for each in trials]
    expected = report_of(study, fitted, place)
    np.testing.assert_equal(own_of(study, trials, place), expected)
    assert "holds" in {verdict for verdict, *_ in expected.values()}


def single(study, trials, place):
    """The first paths: the study's own, and those that change one thing but the index, the law and the bins."""
    found = list(takewhile(lambda each: each.kind not in (BINS, LAW, INDEX), people_paths(study, trials, place)))
    return gathered(found[:1], found[1:], ALPHA)


def test_a_claim_that_hangs_on_one_person_turns_in_the_path_without_that_person_and_in_no_other():
    study = study_of(6)
    paths = single(study, with_slopes(study, {"P04": REVERSED}), places(study))
    row = paths.claims.index("specimens_differ")
    assert paths.own[row] == "not determined"
    turned = paths.name[(paths.verdict[row] == "holds") & (paths.kind == PERSON)]
    assert turned.tolist() == ["without P04"]
    assert paths.kept("specimens_differ", PERSON) == (5, 6)
    assert paths.kept("specimens_differ", REPETITION) == (6, 6)
    assert paths.worst_kind("specimens_differ") == PERSON


@pytest.mark.parametrize(("law", "truth"), [(LAWS[1], np.sqrt), (LAWS[2], np.asarray)], ids=["root", "line"])
def test_a_law_of_force_is_fitted_on_its_own_axis(law, truth):
    """Without noise the law that made the activity explains all of it, and its slope is per unit of g(F) / g(7 N)."""
    study = study_of(1)
    trials = [made("P01", "S1", 0, 4e-6, truth, noise=0.0)]
    own, by_logarithm = (_fitted(study, trials, each, study.fit).fits for each in (law, LAWS[0]))
    np.testing.assert_allclose(own.b_v, 4e-6 * truth(7.0), rtol=2e-3)  # a bin is read at its mean force
    np.testing.assert_allclose(own.adj_r2, 1, atol=1e-5)
    assert np.all(by_logarithm.adj_r2 < 0.99)
    np.testing.assert_array_equal(own.n_points, by_logarithm.n_points)
    np.testing.assert_allclose(own.v_max_v, TRUE["S1"][0] + 4e-6 * truth(7.0), rtol=1e-4)


def test_choices_are_crossed_and_those_that_change_nothing_are_not_counted():
    study = study_of(3)
    found = list(people_paths(study, with_slopes(study, {}), places(study)))
    kinds = [each.kind for each in found]
    assert kinds.count("") == 1
    assert kinds.count(INDEX) == 3
    assert kinds.count(SEVERAL) > 60
    assert {len(each.choices) for each in found} == {0, 1, 2, 3, 4}
    # one press of one recording is doubtful, and one rejected; none fits badly
    assert [each.name for each in found if each.kind == EXCLUSIONS] == [
        "doubtful presses too", "all presses with a fit", "without outlying b",
    ]  # fmt: skip
    laws = [each for each in found if LAW in [choice.kind for choice in each.choices]]
    assert all("log_fit_r2" in each.not_on for each in laws)


@pytest.mark.parametrize(
    ("settings", "muscles"),
    [
        (CocontractionSettings(), ("EDC",)),
        (CocontractionSettings(), ("EDC", "FDS", "FCR")),
        (CocontractionSettings(normalise="mvc"), ("EDC", "FDS")),
    ],
    ids=["one muscle", "three muscles", "levels that the study file does not state"],
)
def test_an_index_that_the_recordings_do_not_allow_is_no_path(settings, muscles):
    study = replace(study_of(2), cocontraction=settings)
    trials = [
        replace(each, muscles=muscles, envelopes_v=np.stack([each.activity / len(muscles)] * len(muscles)))
        for each in with_slopes(study, {})
    ]
    names = {each.name for each in people_paths(study, trials, {}) if each.kind == INDEX}
    assert names == ({"index minimum"} if len(muscles) == 3 else set())


def test_one_person_alone_has_paths_and_no_verdict_on_people():
    study = study_of(1)
    paths = all_paths(study, with_slopes(study, {}), places(study))
    row = paths.claims.index("specimens_differ")
    assert set(paths.verdict[row]) == {"not determined", ""}
    assert PERSON not in paths.kind
    kept, of = paths.kept("specimens_differ")
    assert kept == of > 60


def test_without_a_usable_press_nothing_is_determined():
    study = study_of(2)
    trials = [
        replace(each, activity=np.full_like(each.activity, np.nan), envelopes_v=np.full_like(each.envelopes_v, np.nan))
        for each in with_slopes(study, {})
    ]
    paths = all_paths(study, trials, {})
    assert set(paths.own) == {"not determined"}
    assert set(paths.verdict.ravel()) <= {"not determined", ""}
    assert paths.presets is None


def test_a_study_without_data_has_no_paths():
    paths = all_paths(study_of(1), (), {})
    assert paths.claims == ()
    assert paths.name.size == 0
