"""Whether kappa is determined follows from the design, so that no interval is called so because it came out narrow."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.calibration.calibrate import calibrate
from emg2vsa.calibration.one_condition import law_result
from emg2vsa.calibration.unknown import Estimate, estimate

EXPERIMENTS = 2500
KNOWN = np.array([7.63, 3.35, 1.11])


def front(kappa):
    """CASR of the demo's front: 1 % of it is 9 % of the kappa of S2."""
    return ((1 / kappa + 0.917) / 0.002112) ** (2 / 3)


def experiments(
    new: float,
    mountings: int,
    presses: int,
    mounting: float,
    assumed: float,
    *,
    press: float = 0.021,
    correlation: float = 0.0,
    curve=front,
    d: int = EXPERIMENTS,
    known: float | None = None,
) -> Estimate:
    rng = np.random.default_rng(7)
    noise = rng.standard_normal((d, 4, mountings, presses))
    for i in range(1, presses):
        noise[..., i] = correlation * noise[..., i - 1] + np.sqrt(1 - correlation**2) * noise[..., i]
    logs = press * noise + mounting * rng.standard_normal((d, 4, mountings, 1))
    scores = (curve(np.append(KNOWN, new))[:, None, None] * np.exp(logs)).reshape(d, 4, -1)
    labels = np.repeat(np.arange(1, mountings + 1), presses)
    calibration = calibrate(KNOWN, scores[:, :3], casr_unit="u", mounting_sd=assumed, mountings=np.tile(labels, (3, 1)))
    return estimate(calibration, scores[:, 3], labels, known=new if known is None else known, bootstrap=False)


def held(found: Estimate, new: float, which: np.ndarray) -> float:
    return float(np.mean((found.low <= new)[which] & (new <= found.high)[which]))


@pytest.mark.parametrize(
    ("new", "mountings", "presses", "mounting", "assumed", "correlation"),
    [(5.32, 1, 10, 0.0, 0.0, 0.0), (2.0, 1, 10, 0.043, 0.043, 0.0), (5.32, 3, 3, 0.043, 0.043, 0.0),
     (2.0, 3, 3, 0.043, 0.043, 0.0), (2.0, 1, 10, 0.043, 0.043, 0.7), (5.32, 1, 10, 0.0, 0.0, 0.7)],
)  # fmt: skip
def test_intervals_that_are_called_determined_hold_kappa_as_often_as_all(
    new, mountings, presses, mounting, assumed, correlation
):
    found = experiments(new, mountings, presses, mounting, assumed, correlation=correlation)
    determined = found.determined
    assert np.count_nonzero(determined) > 200
    assert 0.915 < held(found, new, determined) < 0.985


def logarithm(kappa):
    """A line of CASR over ln kappa: another law than the one that is fitted."""
    return np.interp(-np.log(kappa), -np.log(KNOWN[[0, -1]]), front(KNOWN[[0, -1]]))


def test_the_interval_holds_what_other_laws_say_where_the_known_specimens_do_not_reject_them():
    found = experiments(2.0, 1, 10, 0.025, 0.025, curve=logarithm)
    determined = found.determined
    assert np.count_nonzero(determined) > 200
    by_the_fitted_law = (found.repeats.low <= 2.0) & (found.repeats.high >= 2.0)
    assert np.mean(by_the_fitted_law[determined]) < 0.85
    assert held(found, 2.0, determined) > 0.92
    assert np.all(found.low <= found.repeats.low)
    assert np.all(found.high >= found.repeats.high)
    exact = experiments(5.32, 1, 10, 0.0, 0.0)
    assert np.mean([each.counts for each in exact.rivals]) < 0.01, "presses tell the laws apart"


def test_a_narrow_interval_is_no_reason_to_call_kappa_determined():
    rng = np.random.default_rng(3)
    scores = front(np.append(KNOWN, 2.0))[:, None] * np.exp(0.02 * rng.standard_normal((4, 10)))
    calibration = calibrate(KNOWN, scores[:3], casr_unit="u", mounting_sd=0.043)
    mean = scores[3].mean()
    found = [
        estimate(calibration, mean + scale * (scores[3] - mean), known=known, bootstrap=False)
        for known in (2.0, 5.32)
        for scale in (0.01, 1.0, 20.0)
    ]
    assert [bool(each.determined[0]) for each in found] == [True] * 3 + [False] * 3
    assert (found[2].high - found[2].low)[0] > 3 * (found[0].high - found[0].low)[0]
    assert any(note.startswith("not determined: presses and mountings") for note in found[3].notes())


def test_a_specimen_of_unknown_stiffness_is_determined_where_every_stiffness_would_be():
    known, unknown = (
        experiments(2.0, 1, 10, 0.043, 0.043, d=200, known=stiffness) for stiffness in (2.0, float("nan"))
    )
    assert np.mean(known.determined) > 0.6
    assert not unknown.determined.any()
    precise = experiments(2.0, 1, 10, 0.0, 0.0, press=0.005, d=200, known=float("nan"))
    assert precise.determined.all()


@pytest.mark.parametrize("means", [[14.0, 10.0, 8.0], logarithm(KNOWN)], ids=["rises", "explains nothing"])
def test_no_law_that_rises_or_explains_nothing_determines_kappa(means):
    scores = np.array(means)[:, None] * [0.999, 1.0, 1.001]
    calibration = calibrate(KNOWN, scores, casr_unit="u")
    found = estimate(calibration, scores[1] + 0.1, known=2.0, bootstrap=False)
    assert calibration.fit.rises[0] or calibration.adj_r2[0] < 0
    assert found.narrow[0]
    assert not found.determined[0]
    assert any("the law rises, or explains kappa no better" in note for note in found.notes())


def test_an_interval_of_any_confidence_follows_from_the_result():
    found = experiments(2.0, 3, 3, 0.043, 0.043, d=40)
    for i in range(40):
        law = law_result(found, 2.0, i)
        assert law.error_interval(0.95) == pytest.approx((law.low / 2.0 - 1, law.high / 2.0 - 1), rel=1e-9)
        (low, high), (lower, higher) = law.error_interval(0.95), law.error_interval(0.999)
        assert lower < low < law.error < high < higher or np.isinf(higher)
        assert [each.known for each in law.fitted_on_law] == KNOWN.tolist()
