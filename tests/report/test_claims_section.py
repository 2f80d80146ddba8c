"""Sentences of the summary: the number beside its unit, and whether the verdict deviates from the registered plan."""

from __future__ import annotations

from dataclasses import replace

import pytest

from emg2vsa.claims.claim import UNKNOWN, Claim, Found, Judged, exactly
from emg2vsa.companions.law_misfit import Misfit
from emg2vsa.registration.deviations import Deviation, Registered
from emg2vsa.registration.plan import claim_plan, planned_claims
from emg2vsa.report.sections.claims import judged_claims, sentence, summary

MEASURED = Found(0.452, lambda confidence: (0.417, 0.491))


def judged(estimand: str, found: Found, factor: float = 100.0) -> Judged:
    claim = Claim("k", "question", "specimens differ", estimand, "more", found, 0.1, "person", "s", factor=factor)
    return Judged(claim, *found.interval(0.95), 0.95)


@pytest.mark.parametrize(
    ("estimand", "found", "said"),
    [
        ("smallest step of b, % of the mean", MEASURED, "The smallest step of b is 45.2 % of the mean [41.7, 49.1]."),
        ("largest error of κ, %", UNKNOWN, "The largest error of κ is not known."),
        ("settings that differ", exactly(0.02), "The settings that differ is 2.00."),
        ("gain, points", replace(MEASURED, interval=UNKNOWN.interval), "The gain is 45.2 points, no interval."),
    ],
)
def test_the_unit_stands_beside_the_number(estimand: str, found: Found, said: str) -> None:
    assert sentence(judged(estimand, found)).replace("\N{NO-BREAK SPACE}", " ").endswith(f"specimens differ. {said}")


def test_every_estimand_is_a_noun_with_at_most_one_unit(results) -> None:
    for each in judged_claims(results):
        text = sentence(each)
        assert ", %" not in text
        assert ", is " not in text


def test_a_verdict_that_deviates_from_the_plan_says_so_in_its_sentence(results) -> None:
    of = judged_claims(results)
    plans = {each.claim.key: claim_plan(each) for each in of}
    moved = Deviation("plan", "fit, bin_n", "0.3", "0.5", ("specimens_differ",))
    for deviations in ((), (moved,)):
        registered = Registered("r.json", "ab", "2026-03-04T10:00:00+00:00", "No data.", "", plans, deviations)
        told = [text for text in summary(replace(results, registered=registered), of) if "deviates" in text]
        assert len(told) == len(deviations)
        assert all("the slope b rises" in text and text.endswith("from the registered plan.") for text in told)
    assert not any("deviates" in text for text in summary(results, of))


def test_the_plan_tells_the_estimand_that_the_results_have(results) -> None:
    for high in (7.0, 5.0):
        window = replace(results.study.window, force_n=(0.5, high))
        study = replace(results.study, window=window)
        ours = {each.claim.key: each.claim.estimand for each in judged_claims(replace(results, study=study))}
        plan = planned_claims(study, None)
        assert {key: plan[key]["estimand"] for key in plan.keys() & ours.keys()} == {
            key: ours[key] for key in plan.keys() & ours.keys()
        }
        assert f"at {high:g} N" in plan["interpolation_rmse"]["estimand"]


@pytest.mark.parametrize("told", [True, False])
def test_a_logarithm_that_does_not_fit_is_said_at_its_claim_and_on_the_first_page(results, told: bool) -> None:
    tested = results.people.hypotheses
    share, low, high = (0.127, 0.119, 0.136) if told else (0.004, 0.0, 0.012)
    misfits = replace(
        tested.misfits, together=(Misfit(share, low, high, 1e-9 if told else 0.4), *tested.misfits.together[1:])
    )
    people = replace(results.people, hypotheses=replace(tested, misfits=misfits))
    results = replace(results, people=people)
    of = judged_claims(results)
    claim = next(each.claim for each in of if each.claim.key == "log_fit_r2")
    assert ("The logarithm itself does not fit." in claim.why) == told
    last = list(summary(results, of))[-1]
    assert last.startswith(
        f"The logarithm v = a + b ln F {'does not fit' if told else 'is not shown to be off by 1 %'}: presses are"
    )
    assert f"{100 * share:.1f} % of the level [{100 * low:.1f}, {100 * high:.1f}]" in last
