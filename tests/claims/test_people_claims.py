"""Claims on people: what they estimate, what they need, and how often a verdict is false in worlds of a known truth."""

from __future__ import annotations

import time
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from emg2vsa.claims.claim import judge
from emg2vsa.claims.people import ALONE, PressTable, claims_of_study, people_claims
from emg2vsa.claims.spread import people_f, shape_of
from emg2vsa.companions.force_laws import CellErrors, compare_laws
from emg2vsa.settings import ClaimSettings, ProfileSettings
from tests.people_worlds import KEPT, STIFFNESS, People, profile_of

MARGINS = ClaimSettings()
PAPER = (133.0, 120.0, 113.0, 100.0, 47.0)
"b of S1 to S5 as the paper's people have it, % of S4."
ENDS = ("S1", "S5")


def claims(table, kept=KEPT, margins=MARGINS, **more):
    return {claim.key: claim for claim in people_claims(table, STIFFNESS, kept, margins, **more)}


def verdicts(table, **more):
    return {each.claim.key: each.verdict for each in judge(claims(table, **more).values(), 0.05)}


def misses(world, truth=0.0, tries=150):
    """How often an interval of 95 % of the step from S5 to S1 lies above the true one, and below it."""
    ends = [claims(world.presses_of(seed), kept=ENDS)["specimens_differ"].found.interval(0.95) for seed in range(tries)]
    low, high = np.array(ends).T
    return np.count_nonzero(low > truth), np.count_nonzero(high < truth)


@pytest.mark.parametrize(
    "world",
    [
        People(),
        People(drift=-4.0, lost=8),
        People(drift=4.0, slopes=20.0),
        People(people=3, drift=4.0),
        People(presses=3, drift=4.0),
        People(tails=3.0, drift=4.0),
        People(order="two", drift=4.0),
    ],
    ids=str,
)
def test_intervals_of_a_step_miss_it_as_often_as_they_say(world):
    """Of 150 studies an interval of 95 % misses on a side in 4; in more than 11 with a chance of 0.05 %."""
    assert max(misses(world)) <= 11


def test_the_interval_of_a_step_holds_it_where_people_differ_in_level_and_in_step():
    assert max(misses(People(b=PAPER, slopes=10.0, person=0.4), (133 - 47) / 90)) <= 11


@pytest.mark.parametrize("order", ["same", "unknown"])
@pytest.mark.parametrize("drift", [4.0, -4.0])
def test_drift_in_a_constant_or_unknown_order_is_no_difference_of_specimens(order, drift):
    """A drift of 4 SD over a session of equal specimens; a test over people rejects in all of these studies."""
    for seed in range(60):
        found = verdicts(People(order=order, drift=drift).presses_of(seed))
        assert found["specimens_differ"] != "holds"
        assert found["others_not_distinct"] == "not determined"


def test_a_difference_of_the_papers_size_is_found():
    for world, least in ((People(b=PAPER, slopes=5.0), 58), (People(b=PAPER, order="same"), 20)):
        found = [verdicts(world.presses_of(seed))["specimens_differ"] for seed in range(60)]
        assert found.count("holds") >= least
        assert "refuted" not in found


def test_a_difference_in_the_wrong_direction_refutes():
    assert verdicts(People(b=PAPER[::-1]).presses_of(0))["specimens_differ"] == "refuted"


@pytest.mark.parametrize("people", [3, 14])
def test_people_that_differ_at_random_are_no_difference_of_specimens(people):
    """S1 and S3 alike, each person differs: the worst of all tests of presses was significant in 25 to 75 %."""
    world = People(b=(100.0, 90.0, 100.0, 80.0, 45.0), people=people, slopes=30.0, press=5.0)
    found = [verdicts(world.presses_of(seed))["specimens_differ"] for seed in range(100)]
    assert found.count("holds") <= 2


def test_the_estimates_are_those_of_the_presses():
    world = People(b=PAPER, person=0.0, press=1e-3)
    found = claims(world.presses_of(1))
    mean = np.mean([133, 113, 47])
    assert found["specimens_differ"].found.estimate == pytest.approx((133 - 113) / mean, rel=1e-4)
    others = claims(world.presses_of(1), margins=replace(MARGINS, slope_percent=20.0))["others_not_distinct"]
    # S2 is nearer to S3, S4 to S5 or S3; of these two distances the larger counts
    nearest = [min(PAPER[0] - PAPER[1], PAPER[1] - PAPER[2]), min(PAPER[2] - PAPER[3], PAPER[3] - PAPER[4])]
    assert others.found.estimate == pytest.approx(max(nearest) / mean, rel=1e-4)
    assert others.margin == pytest.approx(0.2)


def test_one_person_says_nothing_on_people():
    for claim in claims(People(people=1).presses_of(0), new="S_new").values():
        assert np.isnan(claim.found.estimate)
        assert claim.why == ALONE or claim.key == "interpolation_rmse"


def test_a_person_without_a_cell_does_not_enter_its_step():
    table = People(people=3, b=PAPER, order="unknown").presses_of(2)
    there = ~((table.participant != "P02") & (table.specimen == "S3"))
    one_left = PressTable(*(column[there] for column in vars(table).values()))
    assert verdicts(one_left)["specimens_differ"] == "not determined"
    two_left = claims(table, kept=ENDS)["specimens_differ"].found.estimate
    assert claims(one_left, kept=ENDS)["specimens_differ"].found.estimate == pytest.approx(two_left)


def test_values_that_are_not_there_count_for_nothing():
    table = People(b=PAPER, people=6).presses_of(3)
    gone = np.arange(table.b_v.size) % 7 == 0
    left = PressTable(*(column[~gone] for column in vars(table).values()))
    blank = replace(table, b_v=np.where(gone, np.nan, table.b_v))
    for key, claim in claims(blank).items():
        assert claim.found.estimate == pytest.approx(claims(left)[key].found.estimate, nan_ok=True)


@pytest.mark.parametrize(
    ("kept", "stiffness", "why"),
    [
        (("S1",), STIFFNESS, "This takes two specimens or more."),
        (("S1", "S9"), STIFFNESS | {"S9": 2.0}, "Nobody pressed S9."),
        (("S1", "S3"), {"S1": 7.63}, "The stiffness of S3 is not known."),
    ],
)
def test_a_step_that_cannot_be_had_says_why(kept, stiffness, why):
    table = People().presses_of(0)
    found = {claim.key: claim for claim in people_claims(table, stiffness, kept, MARGINS)}["specimens_differ"]
    assert found.why == why
    assert judge([found], 0.05)[0].verdict == "not determined"


def test_without_kept_specimens_all_are_said_to_differ():
    found = claims(People(b=PAPER).presses_of(0), kept=())
    assert "others_not_distinct" not in found
    assert "S1, S2, S3, S4, S5" in found["specimens_differ"].says


def test_presses_that_are_all_alike_have_no_interval():
    table = People().presses_of(0)
    alike = replace(table, b_v=np.full_like(table.b_v, 3.0))
    assert set(verdicts(alike, new="S_new").values()) == {"not determined"}


def spread_of(values):
    there = np.isfinite(values)
    mean = np.nanmean(values, axis=1)
    return people_f(mean, np.count_nonzero(there, axis=1), float(np.nansum((values - mean[:, None]) ** 2)))


@pytest.mark.parametrize("order", ["random", "same", "unknown"])
def test_people_who_drift_at_rates_of_their_own_are_not_refuted_to_be_alike(order):
    """In the middle of the session they are alike."""
    world = People(person=0.0, drift=4.0, order=order)
    for seed in range(40):
        table = world.presses_of(seed)
        middle = People(person=0.0, drift=0.0, order=order).presses_of(seed).b_v
        rate = [np.mean((table.b_v - middle)[table.participant == who]) for who in np.unique(table.participant)]
        own = np.array(rate)[np.unique(table.participant, return_inverse=True)[1]]
        assert verdicts(replace(table, b_v=table.b_v - own))["equal_participants"] != "refuted"


@pytest.mark.parametrize("counts", [(10,) * 14, (10, 10, 2, 5, 10, 3, 10, 10), (4, 4)])
@pytest.mark.parametrize("true_f", [0.0, 0.25, 1.5])
def test_intervals_of_the_spread_of_people_hold_it(counts, true_f):
    """Exact where counts are equal: fewer than 270 of 300 happen in 0.02 % of samples."""
    rng = np.random.default_rng(5)
    inside = 0
    for _ in range(300):
        values = true_f * rng.standard_normal((len(counts), 1)) + rng.standard_normal((len(counts), 10))
        values[np.arange(10) >= np.array(counts)[:, None]] = np.nan
        low, high = spread_of(values).interval(0.95)
        inside += low <= true_f <= high
    assert inside >= 270


def test_the_spread_of_people_over_that_of_presses_is_the_textbooks():
    values = np.random.default_rng(6).normal(size=(6, 4)) + np.arange(6)[:, None]
    f_ratio = stats.f_oneway(*values).statistic
    assert spread_of(values).estimate == pytest.approx(np.sqrt((f_ratio - 1) / 4))
    low, high = spread_of(values).interval(0.9)
    assert stats.f.cdf(f_ratio / (1 + 4 * high**2), 5, 18) == pytest.approx(0.05)
    assert stats.f.sf(f_ratio / (1 + 4 * low**2), 5, 18) == pytest.approx(0.05)


def test_the_shape_of_a_cluster_is_that_of_scipy_free_of_bias():
    values = np.random.default_rng(7).gamma(2.0, size=(3, 9))
    values[1, 5:] = np.nan
    values[2, 3:] = np.nan
    skewness, kurtosis = shape_of(values)
    for i, n in ((0, 9), (1, 5)):
        assert skewness[i] == pytest.approx(stats.skew(values[i, :n], bias=False))
        assert kurtosis[i] == pytest.approx(stats.kurtosis(values[i, :n], bias=False))
    assert np.isnan(skewness[2])
    assert np.isnan(kurtosis[2])


def test_gaussian_clusters_hold_and_skewed_ones_do_not():
    found = [verdicts(People().presses_of(seed))["gaussian_clusters"] for seed in range(40)]
    assert found.count("holds") >= 36
    table = People().presses_of(0)
    skewed = replace(table, b_v=np.random.default_rng(8).exponential(size=table.b_v.size))
    assert verdicts(skewed)["gaussian_clusters"] == "refuted"


def laws_of(ratio, people=14):
    """Laws of cells whose power law has ``ratio`` times the error of the logarithm, the line 1.2 times."""
    rng = np.random.default_rng(9)
    noise = np.exp(0.02 * rng.standard_normal((people, 5)))
    error = [np.tile([0.1, 0.1 * ratio * each, 0.12], (2, 1)) for each in noise.ravel()]
    return compare_laws(
        [CellErrors(f"P{i // 5}", f"S{i % 5}", each * rng.uniform(0.9, 1.1)) for i, each in enumerate(error)]
    )


@pytest.mark.parametrize(
    ("ratio", "people", "verdict"),
    [(1.0, 14, "holds"), (1.3, 14, "holds"), (0.8, 14, "refuted"), (0.95, 14, "not determined"),
     (0.8, 1, "not determined")],
)  # fmt: skip
def test_the_law_is_refuted_by_a_law_that_predicts_better(ratio, people, verdict):
    table = People(people=people).presses_of(0)
    laws = laws_of(ratio, people)
    assert verdicts(table, laws=laws)["log_fit_r2"] == verdict
    if people > 1:
        assert claims(table, laws=laws)["log_fit_r2"].found.estimate == pytest.approx(max(1 - ratio, -0.2), abs=0.01)


def test_a_profile_of_nothing_and_that_of_another_specimen_are_refuted():
    """Before, any profile below 0.2 mV agreed with any other."""
    table = People(b=PAPER, press=5.0).presses_of(4)
    zero = profile_of(table, np.zeros((14, 2)))
    own = profile_of(table)
    other = np.array([[150.0, table.b_v[(table.participant == who) & (table.specimen == "S5")].mean()]
                      for who in own.participants])  # fmt: skip
    twice = profile_of(table, 2 * own.measured)
    for of in (zero, profile_of(table, other), twice):
        assert verdicts(table, new="S_new", interpolated=of)["interpolation_rmse"] == "refuted"
    assert verdicts(table, new="S_new", interpolated=own)["interpolation_rmse"] != "refuted"


def test_a_profile_that_agrees_holds_and_says_in_what_it_is_measured():
    table = People(b=(140.0, 122.0, 106.0, 100.0, 47.0), press=3.0, person=0.1).presses_of(5)
    claim = claims(table, new="S_new", interpolated=profile_of(table))["interpolation_rmse"]
    assert judge([claim], 0.05)[0].verdict == "holds"
    assert "10 % of the level or 50 % of the difference of its neighbours, at 7 N" in claim.estimand


@pytest.mark.parametrize("order", ["random", "same", "unknown"])
def test_neighbours_that_differ_by_drift_alone_leave_the_profile_undetermined(order):
    for seed in range(20):
        table = People(b=(100.0,) * 5, drift=4.0, order=order).presses_of(seed)
        assert verdicts(table, new="S_new", interpolated=profile_of(table))["interpolation_rmse"] == "not determined"


def test_without_a_measured_profile_the_claim_says_what_lacks():
    claim = claims(People().presses_of(0), new="S_new")["interpolation_rmse"]
    assert claim.why.startswith("Nobody pressed a specimen of this stiffness")
    assert "interpolation_rmse" not in claims(People().presses_of(0))


def test_a_study_takes_far_less_than_a_tenth_of_a_second():
    table = People(b=PAPER).presses_of(0)
    more = {"new": "S_new", "interpolated": profile_of(table), "laws": laws_of(1.1)}
    verdicts(table, **more)
    started = time.perf_counter()
    for _ in range(5):
        verdicts(table, **more)
    assert time.perf_counter() - started < 0.5


def test_without_any_press_nothing_is_determined():
    nothing = PressTable(*(column[:0] for column in vars(People().presses_of(0)).values()))
    more = {"new": "S_new", "laws": compare_laws([])}
    assert set(verdicts(nothing, **more).values()) == {"not determined"}


def test_intervals_of_nearly_all_confidence_have_ends_or_none_but_no_fault():
    found = claims(People(b=PAPER).presses_of(0), laws=laws_of(1.1))
    for claim in found.values():
        low, high = claim.found.interval(1 - 1e-16)
        assert not low > high


def test_recordings_without_a_usable_press_are_named():
    """Of those that the study asked for."""
    table = People(people=3).presses_of(0)
    there = np.where((table.participant == "P01") & (table.specimen == "S3"), "rejected", "ok")
    fits = SimpleNamespace(
        participant=table.participant, specimen=table.specimen, repetition=table.repetition, a_v=table.a_v,
        b_v=table.b_v, verdict=there, visit=np.full(there.size, ""),
    )  # fmt: skip
    study = SimpleNamespace(
        hypotheses=SimpleNamespace(use="ok", kept_specimens=KEPT), stiffness_n_per_mm=STIFFNESS,
        palpated=tuple(STIFFNESS), participants=("P00", "P01", "P02", "P03"), claims=MARGINS,
        window=SimpleNamespace(force_n=(0.5, 7.0)), profile=ProfileSettings(), visits=(),
    )  # fmt: skip
    for claim in claims_of_study(study, fits, {}, None):
        assert claim.why.endswith("Without a usable press: P01 S3, P03 S1, P03 S2, P03 S3 and 2 more.")


def test_recordings_that_differ_do_not_make_people_differ():
    """Presses of one recording share an error, twice that of a press: it is no level of people."""
    rng, refuted = np.random.default_rng(11), 0
    table = People(person=0.0).presses_of(0)
    cell = np.unique(np.char.add(table.participant, table.specimen), return_inverse=True)[1]
    for _ in range(60):
        values = 2.0 * rng.standard_normal(cell.max() + 1)[cell] + rng.standard_normal(cell.size)
        refuted += verdicts(replace(table, b_v=values))["equal_participants"] == "refuted"
    assert refuted <= 6


@pytest.mark.parametrize(
    "world",
    [
        People(presses=1), People(people=1, presses=1), People(people=2, presses=2), People(b=(100.0,), people=5),
        People(b=(100.0, 100.0), people=2, presses=2, lost=1), People(people=3, lost=8),
    ],
    ids=str,
)  # fmt: skip
def test_a_design_that_tells_little_tells_nothing_false(world):
    """Nothing differs but people: neither a fault nor a warning."""
    found = verdicts(world.presses_of(0), new="S_new")
    assert found["specimens_differ"] != "holds"
    assert found["equal_participants"] != "holds"
