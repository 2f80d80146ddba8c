"""A verdict says no more than its interval, and intervals hold their estimand as often as they say."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from emg2vsa.claims.claim import (
    UNKNOWN,
    Claim,
    Found,
    confidence_of,
    exactly,
    judge,
    largest,
    less,
    moved,
    size,
    smallest,
    student,
    verdict,
)

NAN = float("nan")
STUDIES = 2000


def claim(found: Found, asserts: str = "more", margin: float = 1.0) -> Claim:
    return Claim("key", "question", "says", "estimand", asserts, found, margin, "person", "section")  # type: ignore[arg-type]


def drawn(rng: np.random.Generator, means: list[float], n: int = 6) -> list[Found]:
    """An estimate of each mean from n values of SD 1."""
    values = np.array(means)[:, None] + rng.standard_normal((len(means), n))
    return [student(row.mean(), row.std(ddof=1) / np.sqrt(n), n - 1) for row in values]


def misses(make: Callable[[list[Found]], Found], means: list[float], truth: float, confidence: float) -> np.ndarray:
    """How often the estimand lies below the interval, and above it."""
    rng = np.random.default_rng(7)
    ends = np.array([make(drawn(rng, means)).interval(confidence) for _ in range(STUDIES)])
    return np.array([np.mean(truth < ends[:, 0]), np.mean(truth > ends[:, 1])])


def at_most(share: float) -> float:
    """A rate that STUDIES draws of this share exceed once in a thousand."""
    return share + 3.1 * np.sqrt(share * (1 - share) / STUDIES)


@pytest.mark.parametrize("confidence", [0.9, 0.99])
def test_an_interval_of_student_misses_each_side_as_often_as_it_says(confidence):
    low, high = misses(lambda found: found[0], [2.0], 2.0, confidence)
    tail = 0.5 * (1 - confidence)
    assert max(low, high) < at_most(tail)
    assert min(low, high) > 2 * tail - at_most(tail)


@pytest.mark.parametrize("confidence", [0.9, 0.99])
@pytest.mark.parametrize(
    ("make", "means", "truth"),
    [
        (smallest, [0.0, 0.0, 0.0], 0.0),
        (smallest, [0.0, 3.0, 9.0], 0.0),
        (largest, [0.0, 0.0, 0.0], 0.0),
        (largest, [0.0, 3.0, 9.0], 9.0),
        (lambda found: size(found[0]), [0.0], 0.0),
        (lambda found: size(found[0]), [-0.4], 0.4),
        (lambda found: size(found[0]), [5.0], 5.0),
        (lambda found: largest(map(size, found)), [0.0, -1.0, 1.0], 1.0),
        (lambda found: smallest(map(size, found)), [0.2, -3.0], 0.2),
        (lambda found: less(*found), [1.0, 1.0], 0.0),
        (lambda found: less(*found), [4.0, 1.0], 3.0),
        (lambda found: smallest([less(found[0], found[1]), less(found[0], found[2])]), [0.0, 0.0, 0.0], 0.0),
        (lambda found: moved(found[0], np.exp), [0.5], np.exp(0.5)),
    ],
)
def test_made_intervals_miss_each_side_no_more_often_than_they_say(make, means, truth, confidence):
    assert misses(make, means, truth, confidence).max() < at_most(0.5 * (1 - confidence))


def test_without_an_error_there_is_an_estimate_but_no_interval():
    for found in (student(2.0, 0.0, 5), student(2.0, NAN, 5), size(student(-2.0, NAN, 5))):
        assert found.estimate == 2.0
        assert np.isnan(found.interval(0.95)).all()


def test_an_unknown_member_leaves_the_whole_unknown():
    known = student(2.0, 0.1, 9)
    for found in (smallest([known, UNKNOWN]), largest([UNKNOWN, known]), less(known, UNKNOWN), smallest([])):
        assert judge([claim(found)], 0.05)[0].verdict == "not determined"


def test_one_member_is_itself():
    known = student(2.0, 0.1, 9)
    for make in (smallest, largest):
        assert make([known]).interval(0.9) == pytest.approx(known.interval(0.9))


def test_a_size_reaches_down_to_nothing_where_the_difference_may_be_none():
    assert size(student(0.5, 1.0, 9)).interval(0.95)[0] == 0
    difference = student(-5.0, 1.0, 9)
    expected = -difference.interval(0.975)[1], -difference.interval(0.95)[0]
    assert size(difference).interval(0.95) == pytest.approx(expected)


def random_claims(rng: np.random.Generator, n: int) -> list[Claim]:
    """Estimates from far below 0 to far above the margin, some exact, some without an interval."""
    made = []
    for _ in range(n):
        value, error = 3 * rng.standard_normal(), 10.0 ** rng.uniform(-3, 1)
        found = [
            student(value, error, float(rng.integers(1, 20))),
            size(student(value, error, 5)),
            exactly(value, value + rng.choice([0.0, 2.0])),
            student(value, NAN, 5),
            less(student(value, error, 4), student(0.3, 0.2, 4)),
        ][rng.integers(5)]
        made.append(claim(found, rng.choice(["more", "within"]), 10.0 ** rng.uniform(-1, 1)))
    return made


def test_no_verdict_says_more_than_its_interval():
    rng = np.random.default_rng(3)
    seen = set()
    for _ in range(300):
        claims = random_claims(rng, int(rng.integers(1, 12)))
        for each, own in zip(judge(claims, 0.05), claims, strict=True):
            low, high = own.found.interval(confidence_of(claims, 0.05))
            assert (low, high) == (each.low, each.high) or np.isnan([low, each.low]).all()
            seen.add((own.asserts, each.verdict))
            inside = np.linspace(low, high, 9) if low <= high else np.array([])
            if each.verdict == "holds":  # whatever of the interval is true, the claim is
                assert inside.size
                assert np.all(inside > 0) if own.asserts == "more" else np.all(inside < own.margin)
            elif each.verdict == "refuted":  # and here it is false of all, or less than what matters
                assert inside.size
                assert np.all(inside < own.margin) if own.asserts == "more" else np.all(inside > own.margin)
    assert len(seen) == 6


@pytest.mark.parametrize("asserts", ["more", "within"])
def test_a_wider_interval_never_turns_a_verdict_round(asserts):
    rng = np.random.default_rng(4)
    for _ in range(500):
        low, margin = 3 * rng.standard_normal(), 10.0 ** rng.uniform(-1, 1)
        high = low + rng.exponential(2)
        narrow = verdict(low, high, asserts, margin)
        wide = verdict(low - rng.exponential(1), high + rng.exponential(1), asserts, margin)
        assert wide in (narrow, "not determined") or (asserts == "more" and (narrow, wide) == ("refuted", "holds"))


def test_more_refutes_what_does_not_matter_although_it_is_there():
    assert verdict(0.1, 0.9, "more", 1.0) == "refuted"
    assert verdict(0.1, 1.1, "more", 1.0) == "holds"
    assert verdict(-0.1, 1.1, "more", 1.0) == "not determined"
    assert verdict(0.0, 1.1, "more", 1.0) == "not determined"
    assert verdict(NAN, 0.5, "more", 1.0) == verdict(0.5, NAN, "within", 1.0) == "not determined"


def test_within_needs_the_whole_interval_on_one_side():
    assert verdict(0.0, 0.9, "within", 1.0) == "holds"
    assert verdict(0.0, 1.0, "within", 1.0) == "not determined"
    assert verdict(1.1, np.inf, "within", 1.0) == "refuted"


def test_alpha_is_shared_by_claims_that_can_be_false_by_chance():
    uncertain, exact = claim(student(1.0, 0.1, 9)), claim(exactly(0.2), "within")
    assert confidence_of([uncertain], 0.05) == pytest.approx(0.9)
    assert confidence_of([uncertain] * 20 + [exact] * 9, 0.05) == pytest.approx(0.995)
    assert confidence_of([uncertain], 0.05, 20) == confidence_of([uncertain] * 20, 0.05)
    one, other = judge([uncertain, exact], 0.05)
    assert one.confidence == pytest.approx(0.9)
    assert np.isnan(other.confidence)
    assert (other.low, other.high, other.verdict) == (0.2, 0.2, "holds")
    assert judge([], 0.05) == ()


def test_an_exact_number_that_may_still_change_is_not_determined():
    lost, waiting = judge([claim(exactly(0, 3), "within", 0.5), claim(exactly(2, 3), "within", 0.5)], 0.05)
    assert (lost.verdict, waiting.verdict) == ("not determined", "refuted")


def test_a_report_of_many_claims_is_false_in_any_of_them_no_more_often_than_alpha():
    """Each estimand where a verdict is false most easily: 0, or the margin, beyond which "holds" is false."""
    rng, alpha, count = np.random.default_rng(5), 0.05, 0
    for _ in range(STUDIES):
        found = [student(mean + 0.3 * rng.standard_normal(), 0.3, np.inf) for mean in [0.0] * 10 + [1.0] * 10]
        claims = [claim(each, asserts) for each, asserts in zip(found, ["more"] * 10 + ["within"] * 10, strict=True)]
        count += any(each.verdict == "holds" for each in judge(claims, alpha))
    assert count / STUDIES < at_most(alpha)
