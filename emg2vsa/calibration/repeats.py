"""An interval on kappa from the noise that repeated presses show, where the residuals of the fit are too few to tell.

Three specimens and two parameters leave one residual, whose t quantile is 12.7. The noise is known far better than
that: every specimen was pressed ten times. To first order the estimate on the axis of the law is

    eta = sum over known specimens of g_s mean_s + g_new mean_new + sum of h_s kappa_s,

with the slopes g, h of ``by_mean_score`` and ``by_kappa``, found by refitting beside the estimate, so that

    var(eta) = sum g_s^2 (s_s^2 / n_s + (m^2 / M_s + u^2) mean_s^2) + the same for the new one
               + sum h_s^2 se(kappa_s)^2 + l^2.

s_s is the standard deviation of the presses of specimen s: soft specimens scatter less than stiff ones, and one pooled
value covers 90 % or 99 % depending on which is the unknown one (decision 16). Degrees of freedom are Satterthwaite's
(1946). n_s is the number of presses, or fewer where successive ones are correlated (``serial``). m is the share of a
score by which one mounting differs from the next, which the presses of one mounting do not show; M_s mountings of a
specimen tell it (``mountings``), and else it is assumed, the angle apart. u is what differs between specimens however
often they are mounted. l is how far eta would move with the exponent that the growth of the contacts shows in place of
Hertz's (``growth_power``), taken as one standard deviation of the law. Whether the law holds at all is for ``left_out``
to test; where it does not, ``left_out`` widens the interval.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats, Ints, mean_of
from emg2vsa.calibration.calibrate import Calibration, fitted_points
from emg2vsa.calibration.forms import HERTZ, eta_of, kappa_of, kappa_slope
from emg2vsa.calibration.laws import fit_law
from emg2vsa.calibration.mountings import MountingScatter, by_mounting, share_of_mountings
from emg2vsa.calibration.presses import within
from emg2vsa.settings import Law
from emg2vsa.statistics.serial import SerialCorrelation, independent, serial_of_mountings

_SHARE = 1e-5  # of a score or a stiffness; central differences are then good to ten digits


@dataclass(frozen=True)
class RepeatInterval:
    """d estimates; (d,), NaN where undefined.

    kappa : N/mm. eta, eta_se : on the axis of the law. df : of eta_se. low, high : N/mm; high is infinite where the
    interval on 1/kappa reaches 0: the specimen may be rigid for all that the score says.
    gradient : (d, S + 1) d eta / d mean score, of the known specimens and the new one. press_variance : (d, S + 1) of
    a single press. n : (d, S + 1) presses. serial : correlation of successive presses, and how many n count as.
    kappa_step : (d, S) change of eta for a standard error of each known kappa, angle_step : (d, S + 1) for a standard
    deviation of the angles of a specimen's mountings, where that is assumed, mounting_step : (d, S + 1) for one of all
    else in them, specimen_step : (d, S + 1) for one of what no mounting shows. law_step : (d,)
    for the exponent that the presses show in place of Hertz's. widened : (d,) factor on eta_se, 1 where the law holds.
    reach : (d,) half of the interval on the axis of the law. score_share : (d,) d ln kappa / d ln score: the percent of
    kappa that 1 % of the score costs.
    """

    kappa: Floats
    eta: Floats
    eta_se: Floats
    df: Floats
    low: Floats
    high: Floats
    gradient: Floats
    press_variance: Floats
    n: Ints
    serial: SerialCorrelation
    kappa_step: Floats
    angle_step: Floats
    mounting_step: Floats
    specimen_step: Floats
    law_step: Floats
    widened: Floats
    reach: Floats
    score_share: Floats

    def p_of(self, law_eta: Floats) -> Floats:
        """Two-sided p (d,) of the true eta being ``law_eta``."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(2 * special.stdtr(self.df, -np.abs(self.eta - law_eta) / self.eta_se))


def repeat_interval(
    calibration: Calibration,
    scores: Floats,
    *,
    mountings: Ints | None = None,
    own_noise: bool = True,
    in_series: bool = True,
    known: int | None = None,
    widened: float | Floats = 1.0,
) -> RepeatInterval:
    """The estimate from scores (d, R) of the new specimen, NaN where there is none, and its interval.

    mountings : (R,) number of each press's mounting; None: one. own_noise : False takes the variance of the new
    specimen's presses from those of the known ones, pooled. That is done anyway for a specimen that was pressed once.
    in_series : False takes the presses as independent. known : place of the known specimen whose presses these are, so
    that they move the law as well. widened : (d,) factor on the standard error of eta. All is NaN where the calibration
    is not monotone.
    Degrees of freedom after Welch (1947) and Satterthwaite (1946).
    """
    law, confidence = calibration.settings.law, calibration.settings.confidence
    presses = side_by_side(calibration.casr, scores)
    labels = labels_side_by_side(calibration.labels, scores.shape[1], mountings)
    groups = by_mounting(presses, labels)
    mean = mean_of(scores)
    means = np.append(calibration.mean_casr, mean[:, None], axis=1)
    variance, freedom, n = _noise(groups, means, own_noise)
    serial = serial_of_mountings(groups) if in_series else independent(groups)
    freedom = freedom * serial.share_of_freedom[:, None]
    # where no mounting was pressed twice, the scatter between mountings has that of the presses in it
    once = (calibration.mounting.freedom > 0) & ~np.any(np.isfinite(within(groups)[0]), axis=(1, 2))
    freedom = np.where(once[:, None], np.inf, freedom)
    eta = np.where(calibration.monotone, calibration.fit.eta(mean[:, None])[:, 0], np.nan)
    kappa = kappa_of(law, eta)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        gradient = _gradient(calibration, mean, kappa, known)
        of_presses = np.where(once[:, None], 0.0, gradient**2 * variance / serial.effective_n)
        of_mountings = gradient * means * np.sqrt(share_of_mountings(groups))
        steps = _steps(calibration, mean, gradient * means, of_mountings)
        eta_se = np.sqrt(np.sum(of_presses, axis=1) + steps.unseen)
        df = eta_se**4 / _chance(of_presses, freedom, np.sum(of_mountings**2, axis=1), calibration.mounting)
        eta_se = eta_se * widened
        reach = special.stdtrit(df, 0.5 + 0.5 * confidence) * eta_se
        score_share = calibration.fit.steepness(mean[:, None])[:, 0] * mean / kappa
    low, high = ends_on_law(law, eta, reach)
    return RepeatInterval(
        kappa=kappa, eta=eta, eta_se=eta_se, df=df, low=low, high=high, gradient=gradient, press_variance=variance,
        n=n, serial=serial, kappa_step=steps.kappa, angle_step=steps.angle, mounting_step=steps.mounting,
        specimen_step=steps.specimen, law_step=steps.law,
        widened=np.broadcast_to(np.asarray(widened, dtype=np.float64), kappa.shape),
        reach=reach, score_share=score_share,
    )  # fmt: skip


def _gradient(calibration: Calibration, mean: Floats, kappa: Floats, known: int | None) -> Floats:
    """(d, S + 1) d eta / d mean score; arguments as ``repeat_interval``."""
    own = calibration.fit.steepness(mean[:, None]) / kappa_slope(calibration.settings.law, kappa[:, None])
    gradient = np.concatenate([by_mean_score(calibration, mean), own], axis=1)
    if known is not None:
        gradient[:, known] += gradient[:, -1]
        gradient[:, -1] = 0.0
    return gradient


class _Steps(NamedTuple):
    """What repeated presses of one mounting do not show, on the axis of the law; as in ``RepeatInterval``. unseen :
    (d,) the sum of their squares."""

    kappa: Floats
    angle: Floats
    mounting: Floats
    specimen: Floats
    law: Floats
    unseen: Floats


def _steps(calibration: Calibration, mean: Floats, of_scores: Floats, of_mountings: Floats) -> _Steps:
    """of_scores, of_mountings : (d, S + 1) what a share of a score, and of that of a mounting, moves eta by."""
    known_exactly, mounting = not np.any(calibration.kappa_se), calibration.mounting
    kappa_step = calibration.kappa_se if known_exactly else by_kappa(calibration, mean) * calibration.kappa_se
    mounting_step = of_mountings * mounting.sd[:, None]
    angle_step = of_mountings * np.where(mounting.freedom > 0, 0.0, calibration.angle_share)[:, None]
    specimen_step = of_scores * calibration.specimen_share[:, None]
    law_step = by_exponent(calibration, mean)
    unseen = np.sum(kappa_step**2, axis=1) + law_step**2
    unseen += np.sum(angle_step**2 + mounting_step**2 + specimen_step**2, axis=1)
    return _Steps(kappa_step, angle_step, mounting_step, specimen_step, law_step, unseen)


def expected_interval(
    calibration: Calibration, kappa: Floats, scores: Floats, *, mountings: Ints | None = None
) -> RepeatInterval:
    """The interval that a design promises for specimens of stiffness (d,), before anybody knows how they come out.

    scores : (d, R) of the new specimen, of which only those count that are there; mountings : as ``repeat_interval``.
    The law is the one that was fitted, and presses scatter as those of the known specimens. What comes out narrow by
    chance is left out: the serial correlation that was found, and the SD of repeated mountings, in place of which
    stands the one that the study assumes. An interval that is called determined by it was not picked for its width.
    """
    promised = np.where(np.isfinite(scores), calibration.fit.casr(kappa[:, None]), np.nan)
    designed = dataclasses.replace(calibration, mounting=calibration.mounting.as_assumed())
    return repeat_interval(designed, promised, mountings=mountings, own_noise=False, in_series=False)


def interval_of(law: Law, kappa: float, reach: float) -> tuple[float, float]:
    """low and high, N/mm, of an interval about ``kappa`` that reaches so far on the axis of the law."""
    low, high = ends_on_law(law, eta_of(law, np.array(kappa)), np.array(reach))
    return float(low), float(high)


def ends_on_law(law: Law, eta: Floats, reach: Floats) -> tuple[Floats, Floats]:
    """low and high (n,), N/mm, of intervals that reach so far about eta (n,) on the axis of the law."""
    low, high = np.sort([_end(law, eta - reach), _end(law, eta + reach)], axis=0)
    return low, high


def _chance(of_presses: Floats, freedom: Floats, weight: Floats, mounting: MountingScatter) -> Floats:
    """(d,) sum of squared parts of the variance of eta over their degrees of freedom (Satterthwaite).

    An estimated variance between mountings is one of means less one of presses: what it takes from the presses' part is
    not estimated twice. weight : (d,) of it in the variance of eta.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        found = mounting.sd * np.minimum(mounting.freedom, 1.0) > 0
        whole = np.sum(of_presses, axis=1)
        left = np.where(found & (whole > 0), np.maximum(1 - weight * mounting.of_presses / whole, 0.0), 1.0)
        between = np.where(found, (weight * mounting.between) ** 2 / mounting.freedom, 0.0)
        return np.asarray(left**2 * np.sum(of_presses**2 / freedom, axis=1) + between)


def _noise(groups: Floats, means: Floats, own_noise: bool) -> tuple[Floats, Floats, Ints]:
    """Variance of a single press of a mounting, its degrees of freedom, and presses, each (d, S + 1).

    groups : (d, S + 1, M, R) presses by mounting, means : (d, S + 1); the new specimen is last. One whose presses do
    not show their noise has that of the noisier of its two neighbours in score, or of all where those show none.
    """
    of_mounting, count = within(groups)
    inside = np.maximum(count - 1.0, 0.0)
    freedom = np.sum(inside, axis=-1)
    known = freedom > 0
    if not own_noise:
        known[:, -1] = False
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        variance = np.sum(np.where(inside > 0, inside * of_mounting, 0.0), axis=-1) / freedom
        freedom = np.where(known, freedom, 0.0)
        total = np.sum(freedom, axis=1, keepdims=True)
        pooled = np.sum(np.where(known, freedom * variance, 0.0), axis=1, keepdims=True) / total
    variance, freedom = np.where(known, variance, pooled), np.where(known, freedom, total)
    away = means[:, :-1] - means[:, -1:]
    sides = [np.where(known[:, :-1] & (side * away >= 0), side * away, np.inf) for side in (1, -1)]
    nearest = np.stack([np.argmin(side, axis=1) for side in sides], axis=1)
    there = np.stack([np.isfinite(side).any(axis=1) for side in sides], axis=1)
    of_nearest = np.where(there, np.take_along_axis(variance, nearest, axis=1), -np.inf)
    noisier = np.take_along_axis(nearest, np.argmax(of_nearest, axis=1, keepdims=True), axis=1)[:, 0]
    borrowed, rows = there.any(axis=1) & ~known[:, -1], np.arange(len(groups))
    variance[:, -1] = np.where(borrowed, variance[rows, noisier], variance[:, -1])
    freedom[:, -1] = np.where(borrowed, freedom[rows, noisier], freedom[:, -1])
    return variance, freedom, np.sum(count, axis=-1)


def _end(law: Law, eta: Floats) -> Floats:
    """No stiffness is below 0, which the straight law does not know."""
    kappa = kappa_of(law, eta)
    return np.where(eta <= 0, np.inf, kappa) if law == "compliance" else np.maximum(kappa, 0.0)


def side_by_side(known: Floats, new: Floats) -> Floats:
    """(d, S + 1, R), padded with NaN to as many presses as the longer one has."""
    d, s, r = known.shape
    whole = np.full((d, s + 1, max(r, new.shape[1])), np.nan)
    whole[:, :s, :r], whole[:, s, : new.shape[1]] = known, new
    return whole


def labels_side_by_side(known: Ints, presses: int, new: Ints | None) -> Ints:
    """(S + 1, R) mounting of each press, as ``side_by_side``; 0 where there is none."""
    s, r = known.shape
    whole = np.zeros((s + 1, max(r, presses)), dtype=np.int64)
    whole[:s, :r], whole[s, :presses] = known, 1 if new is None else new
    return whole


def by_mean_score(calibration: Calibration, casr: Floats) -> Floats:
    """d eta / d mean score (d, S): of the estimate at score ``casr`` (d,), for the presses of each known specimen."""
    step = _SHARE * np.abs(calibration.mean_casr)
    return _difference(calibration, casr, step, np.zeros_like(step)) / step


def by_kappa(calibration: Calibration, casr: Floats) -> Floats:
    """d eta / d kappa (d, S): of the estimate at score ``casr`` (d,), for each known stiffness."""
    step = _SHARE * calibration.kappa
    return _difference(calibration, casr, np.zeros_like(step), step) / step


def by_exponent(calibration: Calibration, casr: Floats) -> Floats:
    """Change of eta (d,) of the estimate at score ``casr`` (d,), were the exponent of the compliance law the other one.

    1/kappa over CASR^m is the law itself over scores raised to m / (3/2).
    """
    settings, power = calibration.settings, calibration.other_exponent / HERTZ
    if settings.law != "compliance":
        return np.zeros_like(casr)
    with np.errstate(invalid="ignore", over="ignore"):
        raised, known = casr**power, calibration.casr**power
    fit = fit_law(settings.law, settings.minimise, *fitted_points(known, calibration.kappa, settings.points))
    return np.asarray((fit.eta(raised[:, None]) - calibration.fit.eta(casr[:, None]))[:, 0])


def _difference(calibration: Calibration, casr: Floats, score_step: Floats, kappa_step: Floats) -> Floats:
    """Half of the change of eta (d, S) between one specimen's score and kappa moved up and both moved down."""
    d, s, r = calibration.casr.shape
    move = np.array([1.0, -1.0])[:, None, None, None] * np.eye(s)  # (up or down, 1, moved specimen, specimen)
    scores = calibration.casr[:, None] + (move * score_step[:, None])[..., None]
    known = calibration.kappa[:, None] + move * kappa_step[:, None]
    x, y = fitted_points(scores.reshape(2 * d * s, s, r), known.reshape(2 * d * s, s), calibration.settings.points)
    fit = fit_law(calibration.settings.law, calibration.settings.minimise, x, y)
    up, down = fit.eta(np.tile(np.repeat(casr, s), 2)[:, None]).reshape(2, d, s)
    return np.asarray((up - down) / 2)
