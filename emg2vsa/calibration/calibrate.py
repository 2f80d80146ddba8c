"""Calibration: a law from CASR to kappa through specimens of known stiffness; many at once."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from emg2vsa.arrays import Floats, Ints, mean_of
from emg2vsa.calibration.forms import HERTZ
from emg2vsa.calibration.laws import LawFit, fit_law
from emg2vsa.calibration.mountings import MountingScatter, by_mounting, mounting_scatter, share_of_mountings
from emg2vsa.calibration.presses import within
from emg2vsa.curves.line import weighted_rows
from emg2vsa.errors import DataError
from emg2vsa.settings import CalibrationSettings

_EQUATIONS = {
    "compliance": "1/kappa = {0:.4g} {1:+.4g} CASR^1.5",
    "exponential": "kappa = {0:.4g} exp({1:.4g} CASR)",
    "power": "kappa = {0:.4g} CASR^{1:.4g}",
    "linear-log": "kappa = {0:.4g} {1:+.4g} ln CASR",
}
NARROW = 1e-3
"""Specimens whose stiffnesses differ by a smaller share of themselves make an ill-conditioned design, which says so."""
ENOUGH_SPECIMENS = 6
"""Specimens below which the fit itself is all but untested."""


@dataclass(frozen=True)
class Calibration:
    """d calibrations on S specimens with up to R presses each; NaN where undefined.

    kappa, kappa_se : (d, S) N/mm, given, with the standard error of the Hooke fit, 0 where exact. specimen_share,
    angle_share : (d,), and other_exponent : see ``calibrate``. casr : (d, S, R) scores, NaN where there is none, in
    ``casr_unit``; labels : (S, R) mounting of each press. mounting : how they differ. mean_casr : (d, S). fit : the
    law. r2, adj_r2 : (d,) of kappa about its mean, over the points that were fitted.
    """

    settings: CalibrationSettings
    specimens: tuple[str, ...]
    casr_unit: str
    kappa: Floats
    kappa_se: Floats
    specimen_share: Floats
    angle_share: Floats
    other_exponent: float
    casr: Floats
    labels: Ints
    mounting: MountingScatter
    mean_casr: Floats
    fit: LawFit
    r2: Floats
    adj_r2: Floats

    @cached_property
    def left_out(self) -> Floats:
        """(d, S) kappa at the mean of each specimen from a fit without its points; NaN below three specimens."""
        x, y = fitted_points(self.casr, self.kappa, self.settings.points)
        d, s = self.mean_casr.shape
        specimen = np.arange(x.shape[1]) // (x.shape[1] // s)
        without = np.where(specimen == np.arange(s)[:, None], np.nan, 0.0)
        rows = (x[:, None, :] + without).reshape(d * s, -1)
        fit = fit_law(self.settings.law, self.settings.minimise, rows, np.repeat(y, s, axis=0))
        predicted = fit.at(self.mean_casr.reshape(-1, 1)).reshape(d, s)
        enough = np.count_nonzero(np.isfinite(self.mean_casr), axis=1) >= 3
        return np.where(enough[:, None], predicted, np.nan)

    @property
    def left_out_error(self) -> Floats:
        """(d, S) relative error of each specimen's kappa as the others predict it; .05 is 5 % too stiff."""
        return self.left_out / self.kappa - 1

    @cached_property
    def monotone(self) -> NDArray[np.bool_]:
        """(d,) whether mean CASR changes with kappa in one direction, that of the fit.

        Two specimens contradict it if their means lie the wrong way round by more than the standard error of their
        difference, from presses and mountings. Specimens whose kappa differ by less than their standard error do not.
        """
        variance, n = within(self.casr)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            shared = share_of_mountings(by_mounting(self.casr, self.labels))
            square = np.nan_to_num(variance / n) + shared * (self.mounting.sd[:, None] * self.mean_casr) ** 2
            wrong = _differences(self.mean_casr) * np.where(self.fit.rises, -1, 1)[:, None, None]
            ordered = _differences(self.kappa) > np.sqrt(_sums(self.kappa_se**2))
            return np.asarray(~np.any(ordered & (wrong > np.sqrt(_sums(square))), axis=(1, 2)))

    def take(self, i: Ints) -> Calibration:
        """Calibrations of these indices (k,), in this order."""
        return cast(Calibration, _taken(self, i))

    def equation(self, i: int = 0) -> str:
        """The fitted law in numbers, with units: those of the parameters hang on them."""
        law = _EQUATIONS[self.settings.law].format(*self.fit.parameters[i])
        return f"{law} (kappa in N/mm, CASR in {self.casr_unit})"

    def notes(self, i: int = 0) -> tuple[str, ...]:
        """What must be known to read calibration ``i``, warnings about alike and about few specimens first."""
        n = int(np.count_nonzero(np.isfinite(self.mean_casr[i])))
        notes = (*_about_stiffnesses(self.kappa[i]), *_about_specimens(n, self.settings))
        if np.isnan(self.fit.slope[i]):
            notes = ("undefined: the law cannot be fitted to these scores", *notes)
        elif not self.monotone[i]:
            notes += (
                "no stiffness: CASR does not change with kappa in one direction, so that one score belongs to several "
                "stiffnesses",
            )
        elif self.fit.rises[i]:
            notes += ("kappa rises with CASR: softer specimens should have the larger score",)
        return notes


def _taken(of_d: Any, i: Ints) -> Any:
    """The same dataclass with these rows of the arrays of d."""
    own = {each.name: getattr(of_d, each.name) for each in dataclasses.fields(of_d)}
    parts = ("fit", "mounting")
    cut = {name: value[i] for name, value in own.items() if isinstance(value, np.ndarray) and name != "labels"}
    return dataclasses.replace(of_d, **cut, **{name: _taken(own[name], i) for name in parts if name in own})


def calibrate(
    kappa: ArrayLike,
    casr: ArrayLike,
    settings: CalibrationSettings | None = None,
    *,
    casr_unit: str,
    specimens: tuple[str, ...] = (),
    kappa_se: ArrayLike = 0.0,
    specimen_share: ArrayLike = 0.0,
    angle_share: ArrayLike = 0.0,
    mounting_sd: float = 0.0,
    mountings: ArrayLike | None = None,
    scatter: MountingScatter | None = None,
    other_exponent: float = HERTZ,
) -> Calibration:
    """Fit a law through specimens of known stiffness.

    kappa : (S,) or (d, S), N/mm, > 0. casr : (S, R) or (d, S, R), NaN where there is no score. specimens : their names.
    kappa_se : standard errors of kappa. specimen_share : standard deviation of a score between specimens, as a share of
    it, that no mounting and no press shows, one or (d,). angle_share : the same for the angle of a mounting, with its
    sign (``forms``). mounting_sd : the same for all else in a mounting. mountings : (S, R) number of the mounting of
    each press; omitted: one of each specimen. Where they are enough to tell (``mountings``), their scatter takes the
    place of angle_share and mounting_sd. scatter : that of more mountings than these, in place of theirs.
    other_exponent : that the presses show in place of Hertz's, see ``forms``. All of these widen the interval from
    repeats and do not change the fit.
    DataError where shapes do not fit or kappa is not positive.
    """
    settings = settings or CalibrationSettings()
    scores = _three_dimensional(casr)
    d, s, _ = scores.shape
    stiffness = _checked_kappa(kappa, d, s)
    scores = np.where(np.isfinite(scores), scores, np.nan)
    means = mean_of(scores)
    x, y = fitted_points(scores, stiffness, settings.points)
    labels = np.ones(scores.shape[1:], dtype=np.int64) if mountings is None else np.asarray(mountings, dtype=np.int64)
    mounting = scatter or mounting_scatter(scores, labels, mounting_sd)
    fit = fit_law(settings.law, settings.minimise, x, y)
    fitted = fit.at(x)
    rows = weighted_rows(np.where(np.isfinite(fitted), x, np.nan), y, None, where="calibration")
    r2, adj_r2 = rows.explained_by(np.nan_to_num(fitted))
    return Calibration(
        settings=settings,
        specimens=specimens or tuple(f"S{j + 1}" for j in range(s)),
        casr_unit=casr_unit,
        kappa=stiffness,
        kappa_se=_checked_kappa_se(kappa_se, stiffness),
        specimen_share=np.broadcast_to(np.asarray(specimen_share, dtype=np.float64), d),
        angle_share=np.broadcast_to(np.asarray(angle_share, dtype=np.float64), d),
        other_exponent=other_exponent,
        casr=scores,
        labels=labels,
        mounting=mounting,
        mean_casr=means,
        fit=fit,
        r2=r2,
        adj_r2=adj_r2,
    )


def fitted_points(scores: Floats, kappa: Floats, points: Literal["means", "repetitions"]) -> tuple[Floats, Floats]:
    """Scores (d, n) and kappa (d, n) that a law is fitted to, of presses (d, S, R) and stiffnesses (d, S)."""
    if points == "means":
        return mean_of(scores), kappa
    d, s, r = scores.shape
    return scores.reshape(d, s * r), np.repeat(kappa, r, axis=1)


def _about_stiffnesses(kappa: Floats) -> tuple[str, ...]:
    share = float(np.max(kappa) / np.min(kappa) - 1)
    if kappa.size < 2 or share >= NARROW:
        return ()
    digits = max(0.0, 16 + float(np.log10(max(share, 1e-16))))
    return (
        f"ill-conditioned design: the stiffnesses of the specimens differ by {share:.1g} of themselves, and the slope "
        f"of the law keeps {digits:.0f} digits at best; take specimens that differ more",
    )


def _about_specimens(n: int, settings: CalibrationSettings) -> tuple[str, ...]:
    if n < 3:
        return (f"{n} specimens: the law passes through them and nothing tests it",)
    freedom = n - 2
    t = float(special.stdtrit(freedom, 0.5 + 0.5 * settings.confidence))
    count = {3: "three", 4: "four", 5: "five"}.get(n, str(n))
    words = "one degree" if freedom == 1 else f"{freedom} degrees"
    notes: tuple[str, ...] = ()
    if n < ENOUGH_SPECIMENS:
        notes = (
            f"{count} specimens and two parameters leave {words} of freedom: an interval of the fit reaches {t:.2f} "
            "standard errors each way, and adjusted R2 says next to nothing about the law; "
            f"{ENOUGH_SPECIMENS} specimens or more are needed to test it",
        )
    if settings.points == "repetitions":
        notes += ("presses of one specimen are repeats: more of them do not test the law",)
    return notes


def _differences(values: Floats) -> Floats:
    """(d, S, S): value of one specimen less that of another, of values (d, S)."""
    return values[:, :, None] - values[:, None, :]


def _sums(values: Floats) -> Floats:
    return values[:, :, None] + values[:, None, :]


def _three_dimensional(casr: ArrayLike) -> Floats:
    scores = np.asarray(casr, dtype=np.float64)
    if scores.ndim == 2:
        scores = scores[None]
    if scores.ndim != 3 or 0 in scores.shape[1:]:
        raise DataError(
            "calibration, CASR",
            wanted="scores (specimens, presses) or (calibrations, specimens, presses)",
            found=str(scores.shape),
            do="Pad missing presses with NaN.",
        )
    return scores


def _checked_kappa(kappa: ArrayLike, d: int, s: int) -> Floats:
    given = np.asarray(kappa, dtype=np.float64)
    if given.shape not in ((s,), (d, s)):
        raise DataError(
            "calibration, kappa",
            wanted=f"one value for each of {s} specimens",
            found=str(given.shape),
            do="Pass all of them.",
        )
    if not np.all((given > 0) & np.isfinite(given)):
        raise DataError("calibration, kappa", wanted="stiffness above 0", found=str(given.min()), do="Check the list.")
    return np.broadcast_to(given, (d, s))


def _checked_kappa_se(kappa_se: ArrayLike, kappa: Floats) -> Floats:
    given = np.asarray(kappa_se, dtype=np.float64)
    fits = given.shape in ((), kappa.shape[1:], kappa.shape)
    if not (fits and np.all(np.isfinite(given) & (given >= 0))):
        raise DataError(
            "calibration, standard errors of kappa",
            wanted=f"0 or more for each of {kappa.shape[1]} specimens",
            found=str(given.tolist()),
            do="Give the standard error of each Hooke fit.",
        )
    return np.broadcast_to(given, kappa.shape)
