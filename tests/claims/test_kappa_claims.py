"""Claims on the stiffness of the new specimen: what they need, what they refuse, and how often they are wrong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.calibration.calibrate import calibrate
from emg2vsa.calibration.one_condition import law_result
from emg2vsa.calibration.results import AlgorithmResult, CalibrationResults, ConditionResult, LawResult, PinsResult
from emg2vsa.calibration.unknown import estimate
from emg2vsa.claims.claim import Claim, Found, judge, student
from emg2vsa.claims.kappa import _cut, kappa_claims
from emg2vsa.settings import CalibrationSettings, ClaimSettings

KNOWN, TRUTH = np.array([7.63, 3.35, 1.11]), 5.32
DESIGNS = (
    *((condition, angle) for condition in ("high-stiffness", "modular") for angle in (0.0, 30.0, 45.0)),
    ("constant-mean", 0.0), ("constant-max", 0.0),
)  # fmt: skip
ALGORITHMS = ("front", "circle", "paper")
LEVEL = 0.05


def results(
    off: float, press: float = 0.001, mounting: float = 0.0, studies: int = 1, seed: int = 0, old: float | None = None
) -> list[CalibrationResults]:
    """Studies in which kappa comes out ``off`` of itself too stiff by all algorithms, or ``old`` by the circle; three
    mountings of three presses, on a sensor whose contact spreads much."""
    rng = np.random.default_rng(seed)
    d = len(DESIGNS) * len(ALGORITHMS) * studies
    shift = [old if old is not None and name == "circle" else off for _ in DESIGNS for name in ALGORITHMS]
    kappa = np.stack([np.append(KNOWN, TRUTH * (1 + each)) for each in shift])
    casr = np.tile(((1 / kappa + 0.05) / 0.35) ** (2 / 3), (studies, 1))[:, :, None, None]
    logs = press * rng.standard_normal((d, 4, 3, 3)) + mounting * rng.standard_normal((d, 4, 3, 1))
    scores, labels = (casr * np.exp(logs)).reshape(d, 4, 9), np.repeat([1, 2, 3], 3)
    calibration = calibrate(
        KNOWN, scores[:, :3], CalibrationSettings(), casr_unit="u", mounting_sd=0.043, mountings=np.tile(labels, (3, 1))
    )
    found = estimate(calibration, scores[:, 3], labels, known=TRUTH, bootstrap=False)
    laws = iter([law_result(found, TRUTH, i) for i in range(d)])
    return [
        CalibrationResults("S_new", TRUTH, tuple(_condition(*design, laws) for design in DESIGNS), ())
        for _ in range(studies)
    ]


def _condition(condition: str, angle: float, laws) -> ConditionResult:
    of = {name: _algorithm(next(laws)) for name in ALGORITHMS}
    return ConditionResult(angle, condition, True, ("S1", "S3", "S5"), KNOWN, 1.5, of, None)


def _algorithm(law: LawResult) -> AlgorithmResult:
    return AlgorithmResult(np.empty((3, 0)), np.empty(0), "u", law, law, {}, "", None)


def pins_of(error: float, log_sd: float = 0.03, **changed) -> PinsResult:
    """Kappa by the pins that is so far off its true value, with a standard error of its logarithm."""
    kappa = TRUTH * (1 + error)
    found = PinsResult(
        kappa=kappa, low=np.nan, high=np.nan, error=error, determined=True, expected=0.1, bound_sd=0.01, efficiency=0.3,
        by_cue={}, misfit=0.01, presses=9, left_out=KNOWN, left_out_low=KNOWN, left_out_high=KNOWN, log_sd=log_sd,
        freedom=20.0, kappa0=4.0, notes=(), known=None,
    )  # fmt: skip
    low, high = found.error_interval(0.95)
    return replace(found, low=TRUTH * (1 + low), high=TRUTH * (1 + high), **changed)


def with_pins(found: CalibrationResults, pins: PinsResult, *designs: tuple[str, float]) -> CalibrationResults:
    """In these designs, or in all."""
    of = designs or DESIGNS
    return replace(
        found,
        conditions=tuple(
            replace(each, pins=pins) if (each.condition, each.angle_deg) in of else each for each in found.conditions
        ),
    )


def changed(found: CalibrationResults, design: tuple[str, float] | None = None, **fields) -> CalibrationResults:
    """With these fields of every law, or of those of one design."""

    def of(each: ConditionResult) -> ConditionResult:
        if design not in (None, (each.condition, each.angle_deg)):
            return each
        laws = {name: _algorithm(replace(one.chosen, **fields)) for name, one in each.algorithms.items()}
        return replace(each, algorithms=laws)

    return replace(found, conditions=tuple(map(of, found.conditions)))


def claims(found: CalibrationResults, **more) -> dict[str, Claim]:
    return {claim.key: claim for claim in kappa_claims(found, "front", ClaimSettings(), **more)}


def verdicts(found: CalibrationResults, **more) -> dict[str, str]:
    return {each.claim.key: each.verdict for each in judge(claims(found, **more).values(), LEVEL)}


@pytest.mark.parametrize(
    ("off", "old", "error", "cut"),
    [(0.02, 0.3, "holds", "holds"), (0.4, 0.4, "refuted", "refuted"), (0.3, 0.02, "refuted", "refuted")],
)
def test_precise_scores_give_the_verdict_that_is_true(off, old, error, cut):
    found = verdicts(results(off, old=old)[0])
    assert {found[f"kappa_fit_{key}"] for key in ("rigid", "human_like", "constant")} == {"holds"}
    assert {found[f"kappa_error_{key}"] for key in ("rigid", "human_like", "constant")} == {error}
    assert found["reduction_vision"] == found["reduction_both"] == cut
    assert found["reduction_human_like"] == "refuted", "by the front nothing changes"


def test_a_claim_names_its_algorithms_and_its_unit_of_error():
    found = claims(results(0.1)[0])
    assert len(found) == 9
    assert {claim.unit for claim in found.values()} == {"mounting"}
    assert found["reduction_vision"].algorithm == found["reduction_both"].algorithm == "circle to paper"
    assert found["reduction_human_like"].algorithm == found["kappa_error_rigid"].algorithm == "pins, else front"
    assert found["kappa_fit_rigid"].algorithm == "front"
    assert found["kappa_error_rigid"].found.estimate == pytest.approx(0.1, abs=0.02)


@pytest.mark.parametrize(
    ("error", "log_sd", "verdict"), [(0.03, 0.03, "holds"), (-0.4, 0.03, "refuted"), (0.03, 0.15, "not determined")]
)
def test_the_error_is_that_of_the_headline_and_its_interval_decides(error, log_sd, verdict):
    """The law through CASR is 40 % off, and nowhere determined: the pins tell kappa, so they are what is judged."""
    found = with_pins(changed(results(0.4)[0], determined=False), pins_of(error, log_sd))
    assert {verdicts(found)[f"kappa_error_{key}"] for key in ("rigid", "human_like", "constant")} == {verdict}
    of = claims(found)["kappa_error_rigid"]
    assert of.found.estimate == pytest.approx(abs(error))
    assert (of.algorithm, of.why) == ("pins, else front", "")
    assert verdicts(found)["kappa_fit_rigid"] == "holds"
    assert verdicts(found)["reduction_vision"] == "not determined", "these name algorithms of scores"
    assert claims(found)["reduction_human_like"].found.estimate == 0.0


def test_an_interval_by_the_pins_has_any_confidence():
    one = pins_of(0.1)
    for confidence in (0.9, 0.95, 0.9926):
        low, high = one.error_interval(confidence)
        assert low < 0.1 < high
    assert np.diff([each[0] for each in map(one.error_interval, (0.9, 0.95, 0.99))]).max() < 0
    assert one.error_interval(0.95) == pytest.approx((one.low / TRUTH - 1, one.high / TRUTH - 1))


def test_presses_that_contradict_each_other_decide_nothing_by_the_pins():
    found = with_pins(results(0.02)[0], pins_of(0.4, determined=False))
    assert verdicts(found)["kappa_error_rigid"] == "not determined"
    assert claims(found)["kappa_error_human_like"].why == "κ is determined in 0 of 3 designs."


def test_an_error_by_the_pins_is_not_compared_with_one_by_casr():
    found = with_pins(results(0.3)[0], pins_of(0.02), ("modular", 30.0), ("modular", 45.0))
    assert verdicts(found)["reduction_human_like"] == "refuted", "by the law nothing changes"
    found = with_pins(results(0.3)[0], pins_of(0.3, 0.01))
    found = with_pins(found, pins_of(0.02, 0.01), ("modular", 30.0), ("modular", 45.0))
    assert verdicts(found)["reduction_human_like"] == "holds"


@pytest.mark.parametrize(
    ("fields", "undecided"),
    [
        ({"determined": False}, ("kappa_error", "reduction")),
        ({"error": np.nan, "on_laws": ()}, ("kappa_error", "reduction")),
        ({"fitted_on_law": ()}, ("kappa_fit",)),
    ],
)
def test_no_claim_says_more_than_its_laws(fields, undecided):
    whole, found = results(0.4)[0], verdicts(changed(results(0.4)[0], **fields))
    for key, verdict in found.items():
        if key.startswith(undecided):
            assert verdict == "not determined", key
        else:
            assert verdict == verdicts(whole)[key]


def test_one_design_that_is_undetermined_or_not_pressed_decides_nothing_and_is_told():
    whole = results(0.4)[0]
    told = changed(whole, ("modular", 30.0), determined=False)
    assert claims(told)["kappa_error_human_like"].why == "By CASR κ is determined in 2 of 3 designs."
    absent = replace(whole, conditions=tuple(each for each in whole.conditions if each.angle_deg != 30))
    assert claims(absent)["reduction_both"].why == "No calibration: high-stiffness 30°, modular 30°."
    for found in (told, absent):
        got = verdicts(found)
        assert got["kappa_error_human_like"] == got["reduction_both"] == "not determined"
        assert got["kappa_error_constant"] == "refuted"


def test_an_area_rule_that_is_not_of_hexagons_is_not_called_so():
    found = claims(results(0.02, old=0.3)[0], hexagons=False)
    for key in ("reduction_vision", "reduction_both"):
        assert found[key].why == "The area rule of this study is not of hexagons."
        assert np.isnan(found[key].found.estimate)
    assert not found["reduction_human_like"].why


def test_without_a_known_stiffness_of_the_new_specimen_no_error_is_judged():
    found = results(0.0)[0]
    nameless = [replace(law, known=np.nan) for law in found.conditions[0].algorithms["front"].chosen.on_laws]
    found = changed(found, error=np.nan, on_laws=tuple(nameless))
    assert claims(found)["kappa_error_rigid"].why == "κ of the new specimen is not known."
    assert verdicts(found)["kappa_error_rigid"] == verdicts(found)["reduction_human_like"] == "not determined"


@pytest.mark.parametrize(("off", "old"), [(0.0, 0.0), (0.2, 0.2), (-0.2, 0.2), (0.2, 0.25)])
def test_false_verdicts_are_as_rare_as_their_level(off, old):
    """Errors as large as each other, and cuts as large as the margin: neither holds, and the latter are not refuted."""
    studies = 150
    found = [verdicts(each) for each in results(off, 0.01, 0.02, studies, seed=4, old=old)]
    for key in found[0]:
        wrong = {
            "kappa_fit": ("refuted",), "kappa_error": ("refuted",) if off == 0.0 else (),
            "reduction": ("refuted",) if abs(old) > abs(off) else ("holds",),
        }[key.rpartition("_")[0] if not key.endswith("human_like") else key[: -len("_human_like")]]  # fmt: skip
        if abs(old) > abs(off) and key == "reduction_human_like":
            wrong = ("holds",)
        assert sum(each[key] in wrong for each in found) <= 0.02 * studies, key


@pytest.mark.parametrize("correlation", [0.0, 0.9])
@pytest.mark.parametrize(("before", "after"), [(0.0, 0.0), (0.3, 0.3), (0.3, -0.3), (0.3, 0.1), (0.05, -0.1)])
def test_a_cut_of_two_errors_is_covered_whatever_their_signs(before, after, correlation):
    rng = np.random.default_rng(5)
    draws = rng.standard_normal((4000, 2)) @ np.linalg.cholesky([[1, correlation], [correlation, 1]]).T
    truth, missed = abs(before) - abs(after), np.zeros(2)
    for z, other in draws:
        cut = _cut(*(_found(mean + 0.1 * each) for mean, each in ((before, z), (after, other))))
        low, high = cut.interval(0.95)
        missed += (low > truth, high < truth)
    assert np.all(missed / len(draws) < 0.031)


def _found(estimate: float) -> Found:
    return student(estimate, 0.1, np.inf)
