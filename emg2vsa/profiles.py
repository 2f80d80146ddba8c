"""Mean trend of the co-contraction per specimen, and the profile of a specimen nobody palpated (paper IV.B, VI.B).

The paper's weight of the softer neighbour is kappa / 10 N/mm; the default is the bracket (decision 3).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats
from emg2vsa.errors import DataError
from emg2vsa.exemplary import Choice, in_study_order
from emg2vsa.fits import Fits, usable
from emg2vsa.settings import MEDOID, ProfileSettings, WindowSettings

PAPER_RANGE_N_PER_MM = 10.0
"""The paper's weight is the stiffness as a fraction of this range (printed as N/m by mistake)."""


@dataclass(frozen=True)
class Interpolated:
    """values : as one specimen's; stiffer, softer : places of the two nearest; alpha : weight of the softer.

    ``alpha`` is NaN where all specimens had a part ("coefficients").
    """

    values: Floats
    stiffer: int
    softer: int
    alpha: float


def between(
    stiffness_n_per_mm: Floats, values: Floats, new_n_per_mm: float, method: str, *, extrapolate: bool, where: str
) -> Interpolated:
    """Values at the stiffness ``new_n_per_mm``, from ``values`` (n, ...) at ``stiffness_n_per_mm`` (n,).

    bracket, log-stiffness and paper blend the two nearest neighbours, (1 - alpha) stiffer + alpha softer, with

        bracket        alpha = (k1 - k) / (k1 - k3), k1 the stiffer and k3 the softer
        log-stiffness  the same in ln k
        paper          alpha = k / (10 N/mm), whatever the neighbours

    coefficients takes a monotone cubic (PCHIP) through all specimens. All but paper return a specimen's own values at
    its own stiffness. Outside the stiffness range: DataError, or with ``extrapolate`` the straight line through the
    nearest two. Of specimens with equal stiffness the first counts.
    """
    known, first = np.unique(stiffness_n_per_mm, return_index=True)
    inside = known.size > 1 and bool(known[0] <= new_n_per_mm <= known[-1])
    _refuse(known, new_n_per_mm, inside or extrapolate, where)
    upper = min(max(int(np.searchsorted(known, new_n_per_mm, side="right")), 1), known.size - 1)
    stiffer, softer = int(first[upper]), int(first[upper - 1])
    if method == "coefficients" and inside:
        from scipy.interpolate import PchipInterpolator  # noqa: PLC0415  (0.2 s that one option alone needs)

        return Interpolated(PchipInterpolator(known, values[first])(new_n_per_mm), stiffer, softer, math.nan)
    alpha = softer_weight(new_n_per_mm, float(known[upper]), float(known[upper - 1]), method, where)
    return Interpolated((1 - alpha) * values[stiffer] + alpha * values[softer], stiffer, softer, alpha)


def softer_weight(k: float, stiffer: float, softer: float, method: str, where: str) -> float:
    """alpha, the weight of the softer of two specimens; all stiffnesses in N/mm."""
    if method == "log-stiffness":
        return (math.log(stiffer) - math.log(k)) / (math.log(stiffer) - math.log(softer))
    if method != "paper":
        return (stiffer - k) / (stiffer - softer)
    if k > PAPER_RANGE_N_PER_MM:
        raise DataError(
            where, wanted=f"at most {PAPER_RANGE_N_PER_MM:g} N/mm, the range of the paper's weight",
            found=f"{k:g} N/mm", do="Use interpolation = 'bracket'.",
        )  # fmt: skip
    return k / PAPER_RANGE_N_PER_MM


def _refuse(known: Floats, new_n_per_mm: float, allowed: bool, where: str) -> None:
    if known.size < 2:
        raise DataError(
            where, wanted="two specimens of known, different stiffness to interpolate between",
            found=f"{known.size}", do="Measure another specimen, or state its stiffness.",
        )  # fmt: skip
    if not allowed:
        raise DataError(
            where, wanted=f"a stiffness between {known[0]:g} and {known[-1]:g} N/mm, the specimens used",
            found=f"{new_n_per_mm:g} N/mm", do="Add specimens, or set extrapolate = true.",
        )  # fmt: skip


@dataclass(frozen=True)
class Profile:
    """Co-contraction against force of one specimen, v = a + b ln F."""

    specimen: str
    stiffness_n_per_mm: float
    "NaN where nobody measured it."
    a_v: float
    b_v: float
    force_n: Floats
    "(G,) from the window's lower to its upper force."
    v: Floats
    "(G,) the mean trend, in the unit of the activity."
    source: str
    "measured or interpolated"
    n_trials: int
    sd_v: Floats
    "(G,) spread between trials (one participant) or between participants' means; NaN from a single one."


@dataclass(frozen=True)
class LeftOut:
    """A measured specimen predicted from the others: root mean square error over the grid of forces.

    ``relative`` is that error over the root mean square of the measured profile.
    """

    specimen: str
    bracket: tuple[str, str]
    rmse_v: float
    relative: float


@dataclass(frozen=True)
class ByRule:
    """The new specimen's profile by one rule of interpolation, and its error against ``Profiles.new_measured``."""

    rule: str
    alpha: float
    profile: Profile
    error: LeftOut | None


@dataclass(frozen=True)
class Profiles:
    """``profiles`` are the exported, measured specimens in the order given; ``new`` is the interpolated one."""

    profiles: tuple[Profile, ...]
    new: Profile | None
    weight_alpha: float
    "Weight of the softer neighbour in ``new``; NaN without one, or where more than two specimens had a part."
    bracket: tuple[str, str] | None
    "The stiffer and the softer neighbour of ``new``."
    new_measured: Profile | None
    "The measured profile of the same name or the same stiffness as ``new``, which had no part in it (Fig. 11)."
    new_error: LeftOut | None
    "``new`` against ``new_measured``."
    leave_one_out: tuple[LeftOut, ...]
    participant: str
    "The exemplary participant; empty: mean over all."
    unit: str
    notes: tuple[str, ...]
    by_rule: tuple[ByRule, ...] = ()
    "The new specimen by the default rule and by the paper's, beside each other; without one that refuses."

    def __repr__(self) -> str:
        new = "" if self.new is None else f", new {self.new.specimen}: b {self.new.b_v:.4g} {self.unit}"
        return f"Profiles({len(self.profiles)} specimens of {self.participant or 'all participants'}{new})"


def build_profiles(
    fits: Fits,
    stiffness_n_per_mm: Mapping[str, float],
    profile: ProfileSettings,
    window: WindowSettings,
    use: str,
    choice: Choice | None = None,
) -> Profiles:
    """Profiles of all usable trials (``use`` as in ``fits.usable``); DataError where one asked for cannot be made.

    choice : the comparison of participants, where ``profile.participant`` asks for the medoid.

    A profile's a and b are the means over the trials of one participant, or the means of the participants' means. The
    mean of fitted curves is the curve of the mean coefficients, the law being linear in them. Curves are evaluated from
    the window's lower force on: the paper's grid starts at 0 N, where ln F is undefined.
    """
    rows = usable(fits, use)
    force_n = np.linspace(*window.force_n, profile.grid_points)
    participant = _participant(fits, rows, profile.participant, choice)
    if participant:
        rows = rows & (fits.participant == participant)
    names = in_study_order(fits.specimen[rows], stiffness_n_per_mm)
    measured = {
        name: _measured(fits, rows & (fits.specimen == name), name, stiffness_n_per_mm, force_n, bool(participant))
        for name in names
    }
    exported = _exported(measured, profile.specimens, participant)
    new, alpha, bracket = _new(exported, stiffness_n_per_mm, profile)
    reference = _reference(measured, new, [p.specimen for p in exported])
    return Profiles(
        profiles=exported,
        new=new,
        weight_alpha=alpha,
        bracket=bracket,
        new_measured=reference,
        new_error=_error(reference, new, bracket) if reference and new and bracket else None,
        leave_one_out=_leave_one_out(tuple(measured.values()), profile),
        by_rule=_by_rule(exported, stiffness_n_per_mm, profile, reference),
        participant=participant,
        unit=fits.activity_unit,
        notes=(
            *_notes(measured, profile, participant, force_n),
            *_new_note(new, alpha, bracket, profile.interpolation),
        ),
    )


def _participant(fits: Fits, rows: NDArray[np.bool_], wanted: str | None, choice: Choice | None) -> str:
    present = list(dict.fromkeys(fits.participant[rows].tolist()))
    if not present:
        raise DataError(
            "profiles", wanted="at least one usable trial", found="none", do="See the reasons in the table of trials."
        )
    if wanted == MEDOID and len(present) > 1:
        if choice is None:
            raise DataError(
                "profile.participant", wanted="two participants or more with usable trials on every exported specimen",
                found="fewer", do="Name a participant, or omit it for the mean over all.",
            )  # fmt: skip
        return choice.medoid
    if wanted not in (None, MEDOID) and wanted not in present:
        raise DataError(
            "profile.participant", wanted=f"one of {', '.join(present)} (participants with usable trials)",
            found=str(wanted), do="Name another participant, or omit it for the mean over all.",
        )  # fmt: skip
    return present[0] if len(present) == 1 else wanted or ""


def _measured(
    fits: Fits, rows: NDArray[np.bool_], name: str, stiffness: Mapping[str, float], force_n: Floats, per_trial: bool
) -> Profile:
    a, b = fits.a_v[rows], fits.b_v[rows]
    n_trials = a.size
    if not per_trial:
        _, person = np.unique(fits.participant[rows], return_inverse=True)
        a, b = (np.bincount(person, values) / np.bincount(person) for values in (a, b))
    log_force = np.log(force_n)
    curves = a[:, None] + b[:, None] * log_force
    sd_v = curves.std(axis=0, ddof=1) if a.size > 1 else np.full(force_n.size, np.nan)
    a_v, b_v = float(a.mean()), float(b.mean())
    v = a_v + b_v * log_force
    return Profile(name, stiffness.get(name, math.nan), a_v, b_v, force_n, v, "measured", n_trials, sd_v)


def _exported(measured: Mapping[str, Profile], wanted: Sequence[str], participant: str) -> tuple[Profile, ...]:
    absent = [name for name in wanted if name not in measured]
    if absent:
        whose = f" by {participant}" if participant else ""
        raise DataError(
            "profile.specimens", wanted=f"specimens with usable trials{whose}: {', '.join(measured)}",
            found=", ".join(absent), do="Mend or repeat those recordings, or leave the specimen out.",
        )  # fmt: skip
    return tuple(measured[name] for name in dict.fromkeys(wanted or measured))


def _new(
    exported: Sequence[Profile], stiffness_n_per_mm: Mapping[str, float], profile: ProfileSettings
) -> tuple[Profile | None, float, tuple[str, str] | None]:
    name = profile.new_specimen
    if name is None:
        return None, math.nan, None
    stiffness = profile.new_stiffness_n_per_mm or stiffness_n_per_mm.get(name)
    if stiffness is None:
        raise DataError(
            "profile.new_stiffness_n_per_mm",
            wanted=f"the stiffness of {name}",
            found="none",
            do="State the stiffness in N/mm.",
        )
    others = [p for p in exported if p.specimen != name and math.isfinite(p.stiffness_n_per_mm)]
    return _interpolate(others, name, stiffness, profile)


def _interpolate(
    others: Sequence[Profile], name: str, stiffness: float, profile: ProfileSettings
) -> tuple[Profile, float, tuple[str, str]]:
    known = np.array([p.stiffness_n_per_mm for p in others])
    where = f"profile of {name}"

    def blended(values: Floats, method: str) -> Interpolated:
        return between(known, values, stiffness, method, extrapolate=profile.extrapolate, where=where)

    made = blended(np.array([[p.a_v, p.b_v] for p in others]), profile.interpolation)
    # the spread of a specimen in between is taken to lie in between
    sd_v = np.maximum(blended(np.array([p.sd_v for p in others]), "bracket").values, 0.0)
    stiffer, softer = others[made.stiffer], others[made.softer]
    force_n = stiffer.force_n
    a_v, b_v = float(made.values[0]), float(made.values[1])
    sources = others if math.isnan(made.alpha) else (stiffer, softer)
    interpolated = Profile(
        name, stiffness, a_v, b_v, force_n, a_v + b_v * np.log(force_n), "interpolated",
        sum(p.n_trials for p in sources), sd_v,
    )  # fmt: skip
    return interpolated, made.alpha, (stiffer.specimen, softer.specimen)


def _reference(measured: Mapping[str, Profile], new: Profile | None, used: Sequence[str]) -> Profile | None:
    if new is None:
        return None
    if new.specimen in measured:
        return measured[new.specimen]
    twins = (p for p in measured.values() if p.stiffness_n_per_mm == new.stiffness_n_per_mm and p.specimen not in used)
    return next(twins, None)


def _by_rule(
    exported: Sequence[Profile],
    stiffness_n_per_mm: Mapping[str, float],
    profile: ProfileSettings,
    reference: Profile | None,
) -> tuple[ByRule, ...]:
    found = []
    for rule in ("bracket", "paper") if profile.new_specimen else ():
        with suppress(DataError):  # the paper's weight ends at 10 N/mm
            made, alpha, bracket = _new(exported, stiffness_n_per_mm, replace(profile, interpolation=rule))
            assert made is not None
            assert bracket is not None
            found.append(ByRule(rule, alpha, made, _error(reference, made, bracket) if reference else None))
    return tuple(found)


def _error(measured: Profile, predicted: Profile, bracket: tuple[str, str]) -> LeftOut:
    rmse_v = float(np.sqrt(np.mean((predicted.v - measured.v) ** 2)))
    level = float(np.sqrt(np.mean(measured.v**2)))
    return LeftOut(measured.specimen, bracket, rmse_v, rmse_v / level if level else math.nan)


def _leave_one_out(measured: Sequence[Profile], profile: ProfileSettings) -> tuple[LeftOut, ...]:
    """Every specimen from the others, by the same method; those that this method refuses are not predicted."""
    known = [p for p in measured if math.isfinite(p.stiffness_n_per_mm)]
    left_out = []
    for one in known:
        others = [p for p in known if p is not one]
        with suppress(DataError):  # outside the stiffness of the others, or the range of the paper's weight
            predicted, _, bracket = _interpolate(others, one.specimen, one.stiffness_n_per_mm, profile)
            left_out.append(_error(one, predicted, bracket))
    return tuple(left_out)


def _notes(
    measured: Mapping[str, Profile], profile: ProfileSettings, participant: str, force_n: Floats
) -> tuple[str, ...]:
    known = {p.specimen: p.stiffness_n_per_mm for p in measured.values() if math.isfinite(p.stiffness_n_per_mm)}
    of_whom = f"the trials of {participant}" if participant else "the means of the participants"
    notes = [
        f"A profile is the mean of {of_whom}; its spread is their standard deviation.",
        f"Curves are evaluated at {force_n.size} forces from {force_n[0]:g} to {force_n[-1]:g} N (ln 0 is undefined).",
    ]
    if len(known) > 2 and not profile.extrapolate:
        softest, stiffest = min(known, key=known.__getitem__), max(known, key=known.__getitem__)
        notes.append(f"{stiffest} and {softest} are not left out in turn: predicting them would be extrapolation.")
    unknown = [name for name in measured if name not in known]
    if unknown:
        notes.append(f"Stiffness not known, so not used for interpolation: {', '.join(unknown)}.")
    return tuple(notes)


def _new_note(new: Profile | None, alpha: float, bracket: tuple[str, str] | None, method: str) -> tuple[str, ...]:
    if new is None or bracket is None:
        return ()
    stiffer, softer = bracket
    at = f"{new.specimen} ({new.stiffness_n_per_mm:g} N/mm)"
    if math.isnan(alpha):
        return (f"{at} lies on monotone cubics through a and b of all specimens of known stiffness.",)
    outside = "" if 0 <= alpha <= 1 else "; extrapolated, as asked for"
    return (f"{at} = {1 - alpha:.4f} {stiffer} + {alpha:.4f} {softer} ({method}){outside}.",)
