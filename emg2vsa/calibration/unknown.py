"""Stiffness of a specimen from its CASR scores, with intervals that count both the calibration's noise and its own."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from emg2vsa.arrays import Floats, Ints, mean_of
from emg2vsa.calibration.calibrate import Calibration
from emg2vsa.calibration.laws import LAWS, fit_law
from emg2vsa.calibration.left_out import LeftOut, again, left_out
from emg2vsa.calibration.presses import redrawn
from emg2vsa.calibration.repeats import RepeatInterval, expected_interval, repeat_interval
from emg2vsa.errors import DataError
from emg2vsa.settings import Law

_SCORES_AT_ONCE = 2_000_000
_SERIAL_P = 0.05
_PLACES = 3
"""Stiffnesses of the calibrated range, both ends with them, at which a design is judged for a specimen of any."""


@dataclass(frozen=True)
class Rival:
    """What another law says of the same presses. counts : (d,) whether the known specimens do not reject it. narrow :
    as of ``Estimate``, by this law."""

    law: Law
    repeats: RepeatInterval
    counts: NDArray[np.bool_]
    narrow: NDArray[np.bool_]


@dataclass(frozen=True)
class Estimate:
    """One unknown specimen by each of d calibrations; (d,), NaN where undefined.

    kappa : N/mm, NaN where the calibration is not monotone. repeats : the interval from repeated presses (``repeats``),
    widened where ``left_out`` rejects the law. rivals : the same by every other law. low, high : the interval to
    report, which holds those of all laws that the known specimens do not reject: three of them rarely tell laws apart.
    bootstrap_low, bootstrap_high : percentiles over presses drawn again (``redrawn``), of calibration and unknown.
    fitted : each known specimen by the law that was fitted to it as well. mean_casr, n : of its presses. extrapolated :
    whether the mean lies outside the calibration's. narrow : whether the design promises an interval
    (``expected_interval``) narrower than the calibrated range, in N/mm and as a ratio.
    With an exact law and ten presses, 95 % intervals cover 94 to 96 % (repeats) and 91 to 93 % (bootstrap). Only
    ``repeats`` knows of errors of the calibration's kappa.
    """

    calibration: Calibration
    kappa: Floats
    repeats: RepeatInterval
    left_out: LeftOut
    bootstrap_low: Floats
    bootstrap_high: Floats
    mean_casr: Floats
    n: Ints
    extrapolated: NDArray[np.bool_]
    narrow: NDArray[np.bool_]
    rivals: tuple[Rival, ...]
    fitted: tuple[RepeatInterval, ...]

    @cached_property
    def low(self) -> Floats:
        """(d,) N/mm."""
        ends = [np.where(each.counts, each.repeats.low, np.inf) for each in self.rivals]
        return np.asarray(np.minimum.reduce([self.repeats.low, *ends]))

    @cached_property
    def high(self) -> Floats:
        """(d,) N/mm, infinite where the specimen may be rigid."""
        ends = [np.where(each.counts, each.repeats.high, -np.inf) for each in self.rivals]
        return np.asarray(np.maximum.reduce([self.repeats.high, *ends]))

    def __repr__(self) -> str:
        of = zip(self.kappa, self.low, self.high, strict=True)
        told = [f"{kappa:.4g} [{low:.4g}, {high:.4g}]" for kappa, low, high in of]
        more = f" and {len(told) - 3} more" if len(told) > 3 else ""
        return f"Estimate(kappa {', '.join(told[:3])}{more} N/mm)"

    @cached_property
    def determined(self) -> NDArray[np.bool_]:
        """(d,) whether the design promises a narrow interval, by this law and by every other one that counts, and this
        law falls and explains kappa better than its mean does. How narrow the interval came out does not count: that
        would pick those that miss kappa."""
        sound = self.calibration.monotone & ~self.calibration.fit.rises & ~(self.calibration.adj_r2 < 0)
        return np.asarray(self._narrow_by_all & sound & np.isfinite(self.repeats.low))

    @property
    def _narrow_by_all(self) -> NDArray[np.bool_]:
        return np.asarray(np.logical_and.reduce([self.narrow, *(one.narrow | ~one.counts for one in self.rivals)]))

    def notes(self, i: int = 0) -> tuple[str, ...]:
        notes: tuple[str, ...] = ()
        if np.isnan(self.mean_casr[i]):
            notes += ("undefined: no score",)
        if self.extrapolated[i]:
            notes += ("extrapolated: the score lies outside those of the calibration",)
        if self.n[i] == 1:
            notes += ("one press: its noise is taken from the calibration's presses, and only that interval is there",)
        elif np.isnan(self.bootstrap_low[i]) and np.isfinite(self.kappa[i]):
            notes += ("no bootstrap interval: the law cannot be fitted to some of the resamples",)
        return notes + self.calibration.notes(i) + self._about_interval(i)

    def _about_interval(self, i: int) -> tuple[str, ...]:
        """What widened the interval, and whether it still says something."""
        notes: tuple[str, ...] = ()
        serial, widened = self.repeats.serial, float(self.repeats.widened[i])
        if np.isfinite(self.repeats.low[i]) and not self.determined[i]:
            notes += (
                "not determined: the law rises, or explains kappa no better than its mean (adjusted R2 below 0)"
                if self._narrow_by_all[i]
                else "not determined: presses and mountings promise an interval wider than the known stiffnesses span",
            )
        others = [each.law for each in self.rivals if each.counts[i]]
        if others:
            notes += (
                f"the known specimens do not reject the {' and the '.join(others)} law either: the interval holds "
                "what they say as well",
            )
        if widened > 1:
            notes += (
                f"the known specimens reject the law (p = {self.left_out.law_p[i]:.2g}): the interval is widened "
                f"{widened:.3g} times, so that each left-out specimen lies within its own",
            )
        if serial.p[i] < _SERIAL_P:
            counted = float(serial.effective_n[i, -1])
            notes += (
                f"successive presses are correlated ({serial.rho[i]:.2f}, p = {serial.p[i]:.2g}): the {self.n[i]} "
                f"presses of the new specimen count as {counted:.1f}",
            )
        mounting = self.calibration.mounting
        if mounting.freedom[i] > 0:
            notes += (
                f"CASR differs by {100 * mounting.sd[i]:.2g} % (SD) from mounting to mounting, as repeated mountings "
                f"show ({mounting.freedom[i]:g} degrees of freedom)",
            )
        elif mounting.sd[i]:
            notes += (
                f"assumed: CASR differs by {100 * mounting.sd[i]:g} % (SD) from mounting to mounting; "
                "too few mountings were repeated to show it",
            )
        if np.isfinite(self.repeats.score_share[i]):
            notes += (f"1 % of CASR is {abs(self.repeats.score_share[i]):.2g} % of kappa here",)
        return notes


def estimate(
    calibration: Calibration,
    casr: ArrayLike,
    mountings: Ints | None = None,
    *,
    known: float = np.nan,
    bootstrap: bool = True,
) -> Estimate:
    """kappa of a specimen with scores (R,) or (d, R), NaN where there is none. DataError for another shape.

    mountings : (R,) number of each press's mounting; None: one. known : its stiffness where that is known, N/mm, for
    which the design is judged, and nothing else; else for every stiffness of the calibrated range. bootstrap : False
    leaves that interval NaN.
    """
    scores = _checked(casr, len(calibration.casr))
    n = np.count_nonzero(np.isfinite(scores), axis=1)
    with np.errstate(invalid="ignore", over="ignore"):
        mean = np.nansum(scores, axis=1) / n
    drawn = np.where((n > 1)[:, None], scores, np.nan)
    low, high = _bootstrap(calibration, drawn) if bootstrap else np.full((2, len(scores)), np.nan)
    without = left_out(calibration)
    widened = without.widening(calibration.settings.confidence)
    repeats = repeat_interval(calibration, scores, mountings=mountings, widened=widened)
    means = calibration.mean_casr
    below = mean < np.min(means, axis=1, initial=np.inf, where=np.isfinite(means))
    above = mean > np.max(means, axis=1, initial=-np.inf, where=np.isfinite(means))
    return Estimate(
        calibration=calibration,
        kappa=repeats.kappa,
        repeats=repeats,
        left_out=without,
        bootstrap_low=np.where(calibration.monotone, low, np.nan),
        bootstrap_high=np.where(calibration.monotone, high, np.nan),
        mean_casr=mean,
        n=n,
        extrapolated=below | above,
        narrow=_narrow(calibration, scores, mountings, known),
        rivals=tuple(
            _rival(calibration, law, scores, mountings, known) for law in LAWS if law != calibration.settings.law
        ),
        fitted=tuple(
            repeat_interval(calibration, calibration.casr[:, j], mountings=calibration.labels[j], known=j)
            for j in range(calibration.casr.shape[1])
        ),
    )


def _rival(calibration: Calibration, law: Law, scores: Floats, mountings: Ints | None, known: float) -> Rival:
    other = again(calibration, np.ones(len(calibration.specimens), dtype=np.bool_), law)
    found = repeat_interval(other, scores, mountings=mountings)
    kept = ~(left_out(other).law_p < 1 - calibration.settings.confidence)  # two specimens reject no law: all count
    counts = kept & np.isfinite(found.low) & ~np.isnan(found.high)
    return Rival(law, found, counts, _narrow(other, scores, mountings, known))


def _narrow(calibration: Calibration, scores: Floats, mountings: Ints | None, known: float) -> NDArray[np.bool_]:
    kappa = np.where(np.isfinite(calibration.mean_casr), calibration.kappa, np.nan)
    softest, stiffest = np.fmin.reduce(kappa, axis=1), np.fmax.reduce(kappa, axis=1)
    narrow = np.ones(len(kappa), dtype=np.bool_)
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        within = [softest * (stiffest / softest) ** share for share in np.linspace(0, 1, _PLACES)]
        for each in [np.full(len(kappa), known)] if known > 0 else within:
            found = expected_interval(calibration, each, scores, mountings=mountings)
            narrow &= found.high - found.low < stiffest - softest
            narrow &= (found.high * softest < found.low * stiffest) & (found.low > 0)
    return narrow


def _bootstrap(calibration: Calibration, scores: Floats) -> tuple[Floats, Floats]:
    """Percentile interval (d,); blocks of calibrations, so that memory stays small."""
    d, s, r = calibration.casr.shape
    size = max(1, _SCORES_AT_ONCE // (calibration.settings.resamples * s * r))
    cuts = [slice(i, i + size) for i in range(0, max(d, 1), size)]
    parts = [_bootstrap_block(calibration, scores, cut) for cut in cuts]
    low, high = (np.concatenate(side) for side in zip(*parts, strict=True))
    return low, high


def _bootstrap_block(calibration: Calibration, scores: Floats, cut: slice) -> tuple[Floats, Floats]:
    settings = calibration.settings
    rng = np.random.default_rng(settings.seed)
    known = redrawn(calibration.casr[cut], settings.resamples, rng)
    new = redrawn(scores[cut], settings.resamples, rng)
    d, b, s, r = known.shape
    kappa = np.broadcast_to(calibration.kappa[cut][:, None, :, None], known.shape)
    if settings.points == "means":
        x, y = mean_of(known).reshape(d * b, s), kappa[..., 0].reshape(d * b, s)
    else:
        x, y = known.reshape(d * b, s * r), kappa.reshape(d * b, s * r)
    fit = fit_law(settings.law, settings.minimise, x, y)
    values = fit.at(mean_of(new).reshape(d * b, 1)).reshape(d, b)
    low, high = np.quantile(values, [0.5 - 0.5 * settings.confidence, 0.5 + 0.5 * settings.confidence], axis=1)
    return low, high


def _checked(casr: ArrayLike, d: int) -> Floats:
    scores = np.atleast_2d(np.asarray(casr, dtype=np.float64))
    if scores.ndim != 2 or len(scores) not in (1, d) or scores.shape[1] == 0:
        raise DataError(
            "unknown specimen, CASR",
            wanted=f"scores (presses,) or ({d}, presses)",
            found=str(np.shape(casr)),
            do="Pad missing presses with NaN.",
        )
    return np.broadcast_to(np.where(np.isfinite(scores), scores, np.nan), (d, scores.shape[1]))
