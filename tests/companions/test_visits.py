"""Differences of b between visits: over people, and only over those who have both."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from emg2vsa import hypotheses
from emg2vsa.companions.visits import visit_differences, within_visits
from emg2vsa.settings import HypothesisSettings
from tests.companions.test_person_slopes import slopes

PEOPLE, SPECIMENS, VISITS = 6, 2, ("pre", "mid", "post")
RNG = np.random.default_rng(2)
LATER = RNG.normal([[1e-6, -2e-6]], 1e-6, (PEOPLE, SPECIMENS, 2)) * [[[1.0, 3.0]]]
"Of each person on each specimen: b of the two later visits less that of the first."


@pytest.fixture
def made():
    """Of uneven numbers of presses: two, three and one."""
    own = 15e-6 * (1 + 0.2 * RNG.standard_normal((PEOPLE, SPECIMENS, 1)))
    b_v = np.concatenate(
        [np.repeat(own, 2, axis=2), np.repeat(own + LATER[..., :1], 3, axis=2), own + LATER[..., 1:]], 2
    )
    visit = np.array(["pre"] * 2 + ["mid"] * 3 + ["post"])
    return slopes(b_v, visit=np.tile(visit, PEOPLE * SPECIMENS))


def test_the_difference_and_its_interval_are_those_of_people(made):
    found = visit_differences(made, "ok", VISITS, 0.95)
    assert found.specimen.tolist() == ["S0", "S0", "S1", "S1"]
    assert found.visit.tolist() == ["mid", "post"] * 2
    later = LATER.transpose(1, 2, 0).reshape(4, PEOPLE)
    low, high = stats.ttest_1samp(later, 0, axis=1).confidence_interval(0.95)
    assert found.people.tolist() == [PEOPLE] * 4
    assert found.mean == pytest.approx(later.mean(axis=1))
    assert (found.low, found.high) == (pytest.approx(low), pytest.approx(high))
    assert found.sd == pytest.approx(later.std(axis=1, ddof=1))


def test_who_misses_a_visit_is_no_pair(made):
    fits = made
    rejected = (fits.participant == "P5") & (fits.repetition == 6) | (fits.specimen == "S1") & (fits.repetition > 2)
    fits = replace(fits, verdict=np.where(rejected & (fits.participant != "P0"), "rejected", fits.verdict))
    found = visit_differences(fits, "ok", VISITS, 0.95)
    assert found.people.tolist() == [6, 5, 1, 1]
    assert found.mean[1] == pytest.approx(LATER[:5, 0, 1].mean())
    assert np.isnan(found.low[2:]).all()
    assert found.mean[2] == pytest.approx(LATER[0, 1, 0])


def test_what_differs_between_visits_is_no_trend_no_scatter_and_no_shape():
    once = 15e-6 * (1 + 0.1 * np.random.default_rng(4).standard_normal((PEOPLE, SPECIMENS, 6)))
    visit = np.tile(["1"] * 3 + ["2"] * 3, PEOPLE * SPECIMENS)
    for fits in (twice := [slopes(once * gain, visit=visit) for gain in ([1] * 6, [1] * 3 + [2] * 3)]):
        fits.repetition[:] = np.tile(np.arange(1, 7), PEOPLE * SPECIMENS)
    same, other = (hypotheses.test_hypotheses(fits, HypothesisSettings()) for fits in twice)
    assert abs(other.trend.per_mean) < 2 * abs(same.trend.per_mean) + 0.02
    assert other.people.press_sd < 2 * same.people.press_sd
    made = within_visits(twice[1], np.full(visit.size, True))
    assert made.repetition[:6].tolist() == [1, 2, 3, 1, 2, 3]
    own = (once * ([1] * 3 + [2] * 3))[0, 0]
    assert made.b_v[:6].mean() == pytest.approx((own[:3].mean() + own[3:].mean()) / 2)
    pooled = (own[:3].var(ddof=1) + own[3:].var(ddof=1)) / 2
    assert made.b_v[:6].var(ddof=1) == pytest.approx(pooled)


def test_with_one_press_a_visit_values_stay():
    fits = slopes(np.array([[[1.0, 3.0]]]), visit=np.array(["1", "2"]))
    assert within_visits(fits, np.full(2, True)).b_v.tolist() == [1.0, 3.0]
