"""Stiffness of an unknown specimen from a calibration: error of kappa, and how often the interval holds it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import optimize, stats

from benchmarks.bench.case import Area, Case, Size, Way, peer
from benchmarks.experts import stiffness

KAPPA = np.array([7.63, 4.8, 3.35, 1.9, 1.11])
UNKNOWN, CONFIDENCE = 2.6, 0.95
A_MM_N, B_MM_N = 0.05, 0.5
"The true law, 1/kappa = a + b CASR^1.5; kappa in N/mm."
REPETITION_CV, PRESSES = 0.05, 10
NO_BOOTSTRAP = "no bootstrap; the law is not tested"
Found = tuple[np.ndarray, np.ndarray, np.ndarray]
"kappa, low, high of each calibration, N/mm."
EachFit = Callable[[np.ndarray, np.ndarray], tuple[float, float, float]]
"Means of the known specimens (S,) and presses of the unknown one (R,) to kappa, low, high."


@dataclass(frozen=True)
class Scores:
    """CASR of d calibrations (d, S, R) and of the unknown specimen beside each (d, R)."""

    known: np.ndarray
    unknown: np.ndarray


def laws_and_intervals(size: Size) -> Iterator[Case]:
    """One law for all ways; each has its own least squares and its own interval."""
    for n in size.pick((10, 20), (30, 100, 300)):
        scores = _simulated(n)
        family = "calibrations with an unknown specimen"
        yield Case(
            f"{family}, {n} calibrations: error of kappa",
            n,
            "calibrations of 5 specimens x 10 presses",
            tuple(_ways(scores)),
            _kappa_error,
            "RMS, relative",
            "the kappa that the simulation drew",
            family,
        )
    yield Case(
        f"intervals of kappa, {n} calibrations",
        n,
        "calibrations of 5 specimens x 10 presses",
        tuple(_ways(scores)),
        _coverage_error,
        "points of coverage off 95 %",
        f"how many of {n} intervals hold the true kappa; chance alone is {100 * np.sqrt(0.95 * 0.05 / n):.1f} points",
    )


def _ways(scores: Scores) -> Iterator[Way]:
    checks = "bootstrap of 2000, left-out test"
    yield Way("emg2vsa", "calibrate and estimate, all in one call", lambda: _ours(scores), "equal", checks)
    yield Way(
        "emg2vsa",
        "calibrate and repeat_interval, all in one call",
        lambda: _by_repeats(scores),
        "as used",
        NO_BOOTSTRAP,
    )
    yield Way("numpy", "expert: all in one call", lambda: _by_expert(scores), "as used", NO_BOOTSTRAP)
    yield Way("scipy", "curve_fit, loop", _looped(_by_curve_fit, scores), "as used", NO_BOOTSTRAP)
    if lmfit := peer("lmfit"):
        yield Way("lmfit", "Model.fit, loop", _looped(_lmfit(lmfit), scores), "as used", NO_BOOTSTRAP)


def _ours(scores: Scores) -> Found:
    from emg2vsa.calibration.calibrate import calibrate
    from emg2vsa.calibration.unknown import estimate

    found = estimate(calibrate(KAPPA, scores.known, casr_unit="1"), scores.unknown)
    return found.kappa, found.repeats.low, found.repeats.high


def _by_repeats(scores: Scores) -> Found:
    from emg2vsa.calibration.calibrate import calibrate
    from emg2vsa.calibration.repeats import repeat_interval

    found = repeat_interval(calibrate(KAPPA, scores.known, casr_unit="1"), scores.unknown)
    return found.kappa, found.low, found.high


def _by_expert(scores: Scores) -> Found:
    return stiffness.kappas(KAPPA, scores.known, scores.unknown, CONFIDENCE)


def _looped(each: EachFit, scores: Scores) -> Callable[[], Found]:
    def run() -> Found:
        rows = [each(known.mean(axis=1), unknown) for known, unknown in zip(scores.known, scores.unknown, strict=True)]
        kappa, low, high = np.array(rows).T
        return kappa, low, high

    return run


def law(casr: np.ndarray, a: float, b: float) -> np.ndarray:
    """kappa of scores, N/mm."""
    return np.asarray(1 / (a + b * np.asarray(casr) ** 1.5))


def _by_curve_fit(means: np.ndarray, unknown: np.ndarray) -> tuple[float, float, float]:
    parameters, covariance = optimize.curve_fit(law, means, KAPPA, p0=(0.1, 0.4))
    return _with_interval(parameters, covariance, unknown)


def _lmfit(lmfit: Any) -> EachFit:
    model = lmfit.Model(law, independent_vars=["casr"])

    def fit(means: np.ndarray, unknown: np.ndarray) -> tuple[float, float, float]:
        found = model.fit(KAPPA, casr=means, a=0.1, b=0.4)
        return _with_interval(np.array([found.params["a"].value, found.params["b"].value]), found.covar, unknown)

    return fit


def _with_interval(parameters: np.ndarray, covariance: np.ndarray, unknown: np.ndarray) -> tuple[float, float, float]:
    """kappa at the mean score, with the interval by the delta method: covariance of the fit, scatter of the mean."""
    mean, se = unknown.mean(), unknown.std(ddof=1) / np.sqrt(unknown.size)
    kappa = float(law(mean, *parameters))
    gradient = -(kappa**2) * np.array([1.0, mean**1.5])
    by_score = -(kappa**2) * parameters[1] * 1.5 * mean**0.5
    reach = stats.t.ppf((1 + CONFIDENCE) / 2, KAPPA.size - 2) * np.sqrt(
        gradient @ covariance @ gradient + (by_score * se) ** 2
    )
    return kappa, kappa - float(reach), kappa + float(reach)


def _simulated(n: int) -> Scores:
    rng = np.random.default_rng(11)
    means = ((1 / np.append(KAPPA, UNKNOWN) - A_MM_N) / B_MM_N) ** (2 / 3)
    drawn = means[:, None] * (1 + REPETITION_CV * rng.standard_normal((n, means.size, PRESSES)))
    return Scores(drawn[:, :-1], drawn[:, -1])


def _kappa_error(found: Found) -> float:
    return float(np.sqrt(np.mean((found[0] / UNKNOWN - 1) ** 2)))


def _coverage_error(found: Found) -> float:
    _, low, high = found
    return abs(float(np.mean((low < UNKNOWN) & (high > UNKNOWN))) - CONFIDENCE) * 100


AREA = Area(
    name="calibration",
    question="What does stiffness from a calibration cost, how wrong is it, and do its intervals hold the truth?",
    parts=(laws_and_intervals,),
    peers={"lmfit": "lmfit"},
    meaning=(
        "All ways fit one true law, so the errors of kappa differ little: the noise of the presses decides them. "
        "The intervals differ: those from the residuals of five means have three degrees of freedom and are "
        "wide, ours come from the scatter of the presses. Ours also draws a bootstrap and leaves each specimen "
        "out, which is most of its time; no other row does, so none is of equal work."
    ),
)
