"""The engine of verdicts: a claim is data, and its verdict follows from its interval and its margin alone.

Of a claim that something is *more*, the estimand is a difference in the claimed direction: the claim holds where the
interval lies above 0, and is refuted where it lies below the smallest difference that matters. Of a claim that
something stays *within* a margin, the estimand is a size, 0 or more: the claim holds where the interval lies below the
margin, and is refuted where it lies above it. In both cases "refuted" wins, and anything else is not determined.

A false verdict needs an interval that misses its estimand on one side. So of K claims with intervals of confidence
1 - 2 alpha / K, the chance that a report has any false verdict is alpha at most (Bonferroni). An exact number, such as
a setting, has an interval of no width and takes no share of alpha.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats

Verdict = Literal["holds", "refuted", "not determined"]
Asserts = Literal["more", "within"]
ErrorUnit = Literal["mounting", "person", "none"]
"What was drawn at random and counts once in the interval; none: an exact number."
Ends = tuple[float, float]
"Low and high of an interval."


@dataclass(frozen=True)
class Found:
    """An estimate that has an interval at every confidence; NaN where there is none.

    exact : without error, as of a setting or a count of what lies on the disk.
    """

    estimate: float
    interval: Callable[[float], Ends]
    "Confidence, above 0 and below 1, to low and high."
    exact: bool = False


UNKNOWN = Found(float("nan"), lambda confidence: (float("nan"), float("nan")))


def exactly(value: float, largest: float | None = None) -> Found:
    """A number without error; ``largest`` : what it could become, with what is missing yet."""
    ends = (float(value), float(value if largest is None else largest))
    return Found(float(value), lambda confidence: ends, exact=True)


def student(estimate: float, error: float, df: float) -> Found:
    """An estimate with the standard error ``error`` of ``df`` degrees of freedom, infinite ones included."""

    def interval(confidence: float) -> Ends:
        quantile = 0.5 + 0.5 * confidence
        reach = float(special.stdtrit(df, quantile) if np.isfinite(df) else special.ndtri(quantile)) * error
        return estimate - reach, estimate + reach

    return Found(float(estimate), interval if error > 0 else UNKNOWN.interval)


def moved(found: Found, change: Callable[[float], float]) -> Found:
    """The same estimate on another axis, by a rising ``change``."""
    return Found(
        change(found.estimate), lambda c: (change(found.interval(c)[0]), change(found.interval(c)[1])), found.exact
    )


def size(found: Found) -> Found:
    """How large a difference is, whatever its direction.

    A difference of 0 can be missed on both sides, and either is too large a size: half of alpha falls on each.
    """

    def interval(confidence: float) -> Ends:
        (low, high), (below, above) = found.interval(confidence), found.interval(0.5 + 0.5 * confidence)
        nearest = 0.0 if below <= 0 <= above else min(abs(below), abs(above))
        return (nearest, max(abs(low), abs(high))) if low == low and high == high else (np.nan, np.nan)

    return Found(abs(found.estimate), interval, found.exact)


def smallest(members: Iterable[Found]) -> Found:
    """The least of several estimands, of which each has its own interval; UNKNOWN without any.

    Its low end is the least low end: where the smallest estimand is, its own interval holds. Its high end is the least
    of the high ends, each at the share of alpha that falls on it (Bonferroni), as any of them may be too low.
    """
    return _extreme(tuple(members), np.min, 1)


def largest(members: Iterable[Found]) -> Found:
    """The greatest of several estimands, as ``smallest``."""
    return _extreme(tuple(members), np.max, 0)


def _extreme(members: tuple[Found, ...], pick: Callable[[Floats], float], corrected: int) -> Found:
    if not members:
        return UNKNOWN

    def interval(confidence: float) -> Ends:
        shared = 1 - (1 - confidence) / len(members)
        ends = [
            float(pick(np.array([m.interval(shared if end == corrected else confidence)[end] for m in members])))
            for end in (0, 1)
        ]
        return ends[0], ends[1]

    estimate = float(pick(np.array([m.estimate for m in members])))
    return Found(estimate, interval, all(m.exact for m in members))


def less(one: Found, other: Found) -> Found:
    """``one`` less ``other``, independent or positively correlated; the interval recovers the variance at each end
    (Zou and Donner 2008)."""

    def interval(confidence: float) -> Ends:
        (low, high), (other_low, other_high) = one.interval(confidence), other.interval(confidence)
        difference = one.estimate - other.estimate
        below = np.hypot(one.estimate - low, other_high - other.estimate)
        above = np.hypot(high - one.estimate, other.estimate - other_low)
        return float(difference - below), float(difference + above)

    return Found(one.estimate - other.estimate, interval, one.exact and other.exact)


@dataclass(frozen=True)
class Claim:
    """One claim.

    key : in results.json, ``claims.<key>``. question : what the claim is about, by which claims are grouped. says : a
    clause of a few words. estimand : what the estimate is, and after its first comma the unit. factor : by which people
    read it. margin : smallest difference that matters, in the unit of ``found``. unit : of the error. algorithm : of
    vision, "" where there is none. section : of the report, that shows more. why : one sentence on what widens the
    interval or is missing, "" for nothing. designs : condition and angle of the presses that the claim compares.
    specimens : the names of these; all of them where none is named.
    """

    key: str
    question: str
    says: str
    estimand: str
    asserts: Asserts
    found: Found
    margin: float
    unit: ErrorUnit
    section: str
    algorithm: str = ""
    factor: float = 1.0
    why: str = ""
    designs: tuple[tuple[str, float], ...] = ()
    specimens: tuple[str, ...] = ()


@dataclass(frozen=True)
class Judged:
    """A claim with the interval that decides it, of ``confidence``; NaN of an exact number."""

    claim: Claim
    low: float
    high: float
    confidence: float
    verdict: Verdict = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "verdict", verdict(self.low, self.high, self.claim.asserts, self.claim.margin))


def verdict(low: float, high: float, asserts: Asserts, margin: float) -> Verdict:
    """The verdict of an interval; ``not determined`` where it has no ends."""
    if not low <= high:
        return "not determined"
    if asserts == "more":
        return "refuted" if high < margin else "holds" if low > 0 else "not determined"
    return "refuted" if low > margin else "holds" if high < margin else "not determined"


class Right(NamedTuple):
    """How often the verdict of one claim is false or right. false, bound : share of studies with a false verdict in
    ``world``, where it is largest, and its upper 95 % bound. right : verdict that the paper's effects call for, ""
    where there is none; power : share of studies that come to it, None without one.
    """

    false: float
    bound: float
    world: str
    right: str = ""
    power: float | None = None


OF_A_STUDY = 27
"""Claims on data of a study with people, a rig and plates. A report of one part has their intervals too: the same data
have one verdict."""


def confidence_of(claims: Sequence[Claim], alpha: float, together: int = 1) -> float:
    """Confidence of each interval, so that any verdict of ``together`` claims, or of all these, is false with a chance
    of ``alpha`` at most.
    """
    return 1 - 2 * alpha / max(sum(not claim.found.exact for claim in claims), together)


def judge(claims: Iterable[Claim], alpha: float, together: int = 1) -> tuple[Judged, ...]:
    """All claims of a report; together : how many share ``alpha`` at least."""
    claims = tuple(claims)
    confidence = confidence_of(claims, alpha, together)
    return tuple(
        Judged(claim, *claim.found.interval(confidence), np.nan if claim.found.exact else confidence)
        for claim in claims
    )
