"""Two cues of one touch, weighed by their variances: how the contact spreads (CASR), and how the force rises as the
probe goes in.

The kinesthetic score of a press is the slope of force over indentation, N/mm. Its inverse, mm/N, goes as E*^(-2/3) in a
Hertz contact, exactly as CASR does, so the compliance law calibrates both (``forms``).

Both scores come from the same presses, the same force sensor, the same angle and the same known stiffnesses, and are
correlated. What else differs between mountings moves one score (the camera's depth, the delay of its frames) or both
(the place on the specimen): the correlation of the mountings' means says how much where ten degrees of freedom tell it,
and else it is taken as none. Estimates are combined as logarithms of kappa by the best linear
unbiased weights for correlated errors,

    w = (v_k - c) / (v_c + v_k - 2 c),

with the variances v of the two estimates and their covariance c, of which the presses' part is from the correlation of
the scores within mountings. With a strong correlation w can lie outside 0 to 1, where the fused value lies outside both
cues on the strength of that correlation alone (Lyons, Gibaut and Clifford 1988, Nuclear Instruments and Methods A 270,
110): the better cue is taken then. Weights from estimated variances cost precision, which is counted (Meier 1953,
Biometrics 9, 59). The two cues must agree: their difference over its standard error is tested, chi-square of one degree
of freedom for known variances and here, for estimated ones, the square of Student's t.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints, mean_of
from emg2vsa.calibration.calibrate import Calibration, calibrate
from emg2vsa.calibration.forms import HERTZ, kappa_slope
from emg2vsa.calibration.mountings import MountingScatter, by_mounting
from emg2vsa.calibration.repeats import RepeatInterval, labels_side_by_side, side_by_side
from emg2vsa.settings import CalibrationSettings

DISAGREE_P = 0.05
_LEAST_FREEDOM = 10


@dataclass(frozen=True)
class Fusion:
    """d fused estimates; (d,), NaN where undefined.

    kappa, low, high : N/mm, the fused estimate and its interval.
    weight : of the cutaneous cue, 0 to 1. correlation : of the two scores of a press, within mountings.
    chi2, p : squared difference of the cues over its variance, and its p. cutaneous, kinesthetic : kappa by each alone.
    reach : half of the interval on ln kappa.
    """

    kappa: Floats
    low: Floats
    high: Floats
    weight: Floats
    correlation: Floats
    chi2: Floats
    p: Floats
    cutaneous: RepeatInterval
    kinesthetic: RepeatInterval
    reach: Floats

    def notes(self, i: int = 0) -> tuple[str, ...]:
        """What must be known to read fusion ``i``; cues that disagree are said."""
        if np.isnan(self.kappa[i]):
            return ("undefined: one of the two cues gives no stiffness",)
        notes: tuple[str, ...] = ()
        if self.p[i] < DISAGREE_P:
            by_depth = np.broadcast_to(self.kinesthetic.kappa, self.kappa.shape)[i]
            notes += (
                f"the cues disagree (p = {self.p[i]:.2g}): {self.cutaneous.kappa[i]:.3g} N/mm by contact area, "
                f"{by_depth:.3g} N/mm by indentation; a law does not hold, or a sensor drifts",
            )
        if self.weight[i] in (0.0, 1.0):
            notes += ("the scores are so correlated that the better cue alone is taken",)
        return notes


def calibrate_indentation(
    kappa: ArrayLike,
    indent_n_per_mm: ArrayLike,
    settings: CalibrationSettings | None = None,
    *,
    specimens: tuple[str, ...] = (),
    kappa_se: ArrayLike = 0.0,
    angle_share: float = 0.0,
    mounting_sd: float = 0.0,
    mountings: ArrayLike | None = None,
    scatter: MountingScatter | None = None,
    other_exponent: float = HERTZ,
) -> Calibration:
    """The kinesthetic cue's calibration, 1/kappa over (mm/N)^(3/2); arguments as in ``calibrate``, scores in N/mm."""
    chosen = CalibrationSettings() if settings is None else settings
    compliance = CalibrationSettings(
        confidence=chosen.confidence, resamples=chosen.resamples, seed=chosen.seed, points=chosen.points
    )
    return calibrate(
        kappa,
        mm_per_n(indent_n_per_mm),
        compliance,
        casr_unit="mm/N",
        specimens=specimens,
        kappa_se=kappa_se,
        angle_share=angle_share,
        mounting_sd=mounting_sd,
        mountings=mountings,
        scatter=scatter,
        other_exponent=other_exponent,
    )


def mm_per_n(indent_n_per_mm: ArrayLike) -> Floats:
    """The score of the kinesthetic cue (Johnson 1985, eq. 4.23), (..., same shape), mm/N, of slopes in N/mm; NaN where
    the force does not rise."""
    slope = np.asarray(indent_n_per_mm, dtype=np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(slope > 0, 1 / slope, np.nan)


def fuse(
    cutaneous: Calibration,
    c: RepeatInterval,
    area: Floats,
    kinesthetic: Calibration,
    k: RepeatInterval,
    depth: Floats,
    mountings: Ints | None = None,
) -> Fusion:
    """kappa of d specimens by both cues, of the same presses in the same order.

    c, k : interval of each cue alone. area, depth : (d, R) the scores it is from, NaN where there is none. Of the
    kinesthetic cue d may be 1: one for all.
    mountings : (R,) number of each press's mounting; None: one.
    Weights of correlated estimates after Lyons, Gibaut and Clifford (1988); what estimated variances cost, after Meier
    (1953).
    """
    labels = labels_side_by_side(cutaneous.labels, area.shape[1], mountings)
    a, b = (by_mounting(side_by_side(cue.casr, own), labels) for cue, own in ((cutaneous, area), (kinesthetic, depth)))
    correlation = _correlation(a.reshape(len(a), -1, a.shape[-1]), b.reshape(len(b), -1, b.shape[-1]))
    of_mountings = _correlation(mean_of(a), mean_of(b))
    g_c, g_k = _per_press(cutaneous, c), _per_press(kinesthetic, k)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        shared = np.minimum(c.n, k.n)
        counted = np.sqrt((c.n / c.serial.effective_n) * (k.n / k.serial.effective_n))
        of_presses = correlation * np.sum(g_c * g_k * shared / (c.n * k.n) * counted, axis=1)
        logs = _log_slope(cutaneous, c) * _log_slope(kinesthetic, k)
        unseen = np.sum(c.kappa_step * k.kappa_step, axis=1) + np.sum(c.angle_step * k.angle_step, axis=1)
        unseen += of_mountings * np.sum(c.mounting_step * k.mounting_step, axis=1)
        # errors of the law that would cancel are not counted on: at a part of the press they need not
        of_law = np.maximum(logs * c.law_step * k.law_step, 0.0)
        covariance = of_presses + logs * unseen + of_law
        v_c, v_k = _of_log(cutaneous, c), _of_log(kinesthetic, k)
        apart = v_c + v_k - 2 * covariance
        weight = np.clip((v_k - covariance) / apart, 0.0, 1.0)
        variance = weight**2 * v_c + (1 - weight) ** 2 * v_k + 2 * weight * (1 - weight) * covariance
        variance *= 1 + 4 * weight * (1 - weight) * (1 / c.df + 1 / k.df)
        df = np.minimum(c.df, k.df)
        middle = weight * np.log(c.kappa) + (1 - weight) * np.log(k.kappa)
        reach = special.stdtrit(df, 0.5 + 0.5 * cutaneous.settings.confidence) * np.sqrt(variance)
        chi2 = np.log(c.kappa / k.kappa) ** 2 / apart
        p = 2 * special.stdtr(df, -np.sqrt(chi2))
        low, high = np.exp(middle - reach), np.exp(middle + reach)
    return Fusion(
        kappa=np.exp(middle),
        low=low,
        high=high,
        weight=weight,
        correlation=correlation,
        chi2=chi2,
        p=p,
        cutaneous=c,
        kinesthetic=k,
        reach=reach,
    )


def _per_press(calibration: Calibration, found: RepeatInterval) -> Floats:
    """How far one standard deviation of a single press of each specimen would move ln kappa (d, S + 1), with sign."""
    return found.gradient * np.sqrt(found.press_variance) * _log_slope(calibration, found)[:, None]


def _of_log(calibration: Calibration, found: RepeatInterval) -> Floats:
    return (found.eta_se * _log_slope(calibration, found)) ** 2


def _log_slope(calibration: Calibration, found: RepeatInterval) -> Floats:
    """d ln kappa / d eta (d,)."""
    return np.asarray(kappa_slope(calibration.settings.law, found.kappa) / found.kappa)


def _correlation(first: Floats, second: Floats) -> Floats:
    """Correlation (d,) of two scores (d, S, R) of the same presses about their specimens' means.

    Every specimen counts alike: its deviations are taken in its own standard deviations. 0 where fewer than ten degrees
    of freedom are left, from which a correlation cannot be told.
    """
    both = np.isfinite(first) & np.isfinite(second)
    a, b = (_standardised(np.where(both, scores, np.nan)) for scores in (first, second))
    counted = np.isfinite(a) & np.isfinite(b)
    total = np.sum(np.where(counted, a * b, 0.0), axis=(1, 2))
    n = np.count_nonzero(counted, axis=(1, 2)) - np.count_nonzero(np.any(counted, axis=2), axis=1)
    return np.where(n >= _LEAST_FREEDOM, np.clip(total / np.maximum(n, 1), -1.0, 1.0), 0.0)


def _standardised(scores: Floats) -> Floats:
    deviation = scores - mean_of(scores)[..., None]
    there = np.isfinite(deviation)
    n = np.count_nonzero(there, axis=-1, keepdims=True)
    squares = np.sum(np.where(there, deviation, 0.0) ** 2, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(deviation / np.sqrt(np.where((n > 1) & (squares > 0), squares / (n - 1), np.nan)))
