"""The next best press: which calibration (stiffness preset, angle), mounting and number of presses tell most of kappa.

What is believed of ln kappa is a weight on a grid: flat over the known stiffnesses and half as far again, times the
likelihood of what every calibration has said so far. More presses by calibration c raise its precision of ln kappa from
1 / v(n) to 1 / v(n + m); averaged over the belief p, the expected information is

    sum_k p_k 1/2 log2(1 + s^2 (1 / v_k(n + m) - 1 / v_k(n))),

with the variance s^2 of the belief (Lindley 1956, Annals of Mathematical Statistics 27, 986, for normal errors). v is
the error that ``OnlineCalibration.log_sd`` promises: presses of one mounting share its error, so that a new
mounting can tell more than a tenth press. Estimates of several calibrations are taken as independent: each condition or
angle is a mounting of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats
from emg2vsa.calibration.online import NARROWS, OnlineCalibration
from emg2vsa.errors import DataError

_GRID = 100
_BEYOND = 1.5
COUNTS = (1, 2, 3, 5, 10)
"Presses that are weighed against each other."


@dataclass(frozen=True)
class Done:
    """Presses so far by one calibration: their number, their mountings, and what they say: kappa and the lower end of
    its interval, N/mm, NaN where not determined."""

    presses: int = 0
    mountings: int = 0
    kappa: float = float("nan")
    low: float = float("nan")


@dataclass(frozen=True, eq=False)
class Belief:
    """kappa : (K,) N/mm, rising. weight : (K,), of sum 1."""

    kappa: Floats
    weight: Floats

    @property
    def middle(self) -> float:
        """Median."""
        return self.quantile(0.5)

    @property
    def variance(self) -> float:
        """Variance of ln kappa."""
        log = np.log(self.kappa)
        return float(self.weight @ (log - self.weight @ log) ** 2)

    def quantile(self, share: float) -> float:
        """kappa below which this share lies."""
        return float(np.exp(np.interp(share, np.cumsum(self.weight), np.log(self.kappa))))

    def interval(self, confidence: float) -> tuple[float, float]:
        """Between equal tails."""
        return self.quantile(0.5 - confidence / 2), self.quantile(0.5 + confidence / 2)


@dataclass(frozen=True)
class Choice:
    """What to press next: index of the calibration, presses, and whether the specimen is mounted anew before them.

    half_width : expected of the interval on kappa after them, as a share. bits : expected information. worthwhile :
    whether half_width is below ``NARROWS`` of what is known already.
    """

    calibration: int
    presses: int
    remount: bool
    half_width: float
    bits: float
    worthwhile: bool


def belief(calibrations: Sequence[OnlineCalibration], done: Mapping[int, Done]) -> Belief:
    """Belief in kappa from what the calibrations (by index) have said so far."""
    known = np.concatenate([each.kappa for each in calibrations])
    kappa = np.geomspace(known.min() / _BEYOND, known.max() * _BEYOND, _GRID)
    log_weight = np.zeros(_GRID)
    for index, each in done.items():
        if 0 < each.low < each.kappa:
            log_weight -= _away(calibrations[index], each, kappa) ** 2 / 2
    weight = np.exp(log_weight - log_weight.max())
    return Belief(kappa, weight / weight.sum())


def _away(calibration: OnlineCalibration, done: Done, kappa: Floats) -> Floats:
    """(K,) distance of stiffnesses from the estimate, in standard errors, on the axis of its interval."""
    axis, middle, low = (calibration.axis(np.asarray(each)) for each in (kappa, done.kappa, done.low))
    return np.asarray((axis - middle) / (middle - low) * _normal(calibration.settings.confidence))


def options(
    calibrations: Sequence[OnlineCalibration],
    done: Mapping[int, Done] | None = None,
    counts: Sequence[int] = COUNTS,
) -> tuple[Choice, ...]:
    """Every calibration, number of presses and mounting, the most informative first; of equal ones the fewest presses.

    done : index of a calibration to its presses so far. DataError without a calibration or a number of presses.
    """
    if not calibrations or not counts or min(counts) < 1:
        raise DataError(
            "next press",
            wanted="a calibration and 1 press or more",
            found="none",
            do="Give calibrations that emg2vsa run wrote.",
        )
    done = dict(done or {})
    now = belief(calibrations, done)
    confidence = calibrations[0].settings.confidence
    present = _half_width(now.variance, confidence)
    found = []
    for index, calibration in enumerate(calibrations):
        own = done.get(index, Done())
        before = _precision(calibration, own.presses, own.mountings, now)
        for count in counts:
            for remount in (True, False) if own.presses else (True,):
                mountings = own.mountings + remount
                gained = np.maximum(_precision(calibration, own.presses + count, mountings, now) - before, 0.0)
                bits = float(now.weight @ np.log2(1 + now.variance * gained) / 2)
                after = float(1 / (1 / now.variance + now.weight @ gained))
                width = _half_width(after, confidence)
                found.append(Choice(index, count, remount, width, bits, width < NARROWS * present))
    return tuple(sorted(found, key=lambda choice: (-round(choice.bits, 9), choice.presses)))


def next_press(
    calibrations: Sequence[OnlineCalibration], done: Mapping[int, Done] | None = None, width: float = 0.0
) -> Choice | None:
    """What to press now, one press at a time; None where ``width`` is reached or no further press is worthwhile.

    The best option of one press that pays in the long run: of the options of up to ten presses the one with the most
    information for each press; its first press.
    """
    done = dict(done or {})
    now = belief(calibrations, done)
    if done and _half_width(now.variance, calibrations[0].settings.confidence) <= width:
        return None
    worthwhile = [choice for choice in options(calibrations, done) if choice.worthwhile]
    return max(worthwhile, key=lambda choice: choice.bits / choice.presses, default=None)


def _precision(calibration: OnlineCalibration, presses: int, mountings: int, now: Belief) -> Floats:
    """(K,) of ln kappa by so many presses in so many mountings; 0 without one."""
    if not presses:
        return np.zeros(now.kappa.size)
    precision = calibration.log_sd(now.kappa, presses, mountings) ** -2
    return np.where(np.isfinite(precision), precision, 0.0)


def _normal(confidence: float) -> float:
    return float(special.ndtri(0.5 + confidence / 2))


def _half_width(variance: float, confidence: float) -> float:
    """Half width of an interval on kappa, as a share, at this variance of ln kappa."""
    return float(np.sinh(_normal(confidence) * np.sqrt(variance)))
