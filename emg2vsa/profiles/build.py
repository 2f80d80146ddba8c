"""Profiles from the fits of presses: mean trends of the specimens, and one interpolated between them (paper IV.B)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats
from emg2vsa.curves.monotone_spline import MonotoneSpline
from emg2vsa.errors import DataError
from emg2vsa.exemplary import Choice, in_study_order
from emg2vsa.fits import Fits, usable
from emg2vsa.profiles.by_person import measured_as
from emg2vsa.profiles.errors import mean_errors
from emg2vsa.profiles.interpolation import Interpolated, between
from emg2vsa.profiles.profile import ByRule, LeftOut, Profile, Profiles
from emg2vsa.profiles.splines import Splines, cell_splines, of_specimen
from emg2vsa.settings import MEDOID, ProfileSettings, WindowSettings


def build_profiles(
    fits: Fits,
    stiffness_n_per_mm: Mapping[str, float],
    profile: ProfileSettings,
    window: WindowSettings,
    use: str,
    choice: Choice | None = None,
    splines: Splines | None = None,
) -> Profiles:
    """Profiles of all usable trials (``use`` as in ``fits.usable``); DataError where one asked for cannot be made.

    choice : the comparison of participants, where ``profile.participant`` asks for the medoid. splines : of the same
    trials over the window; ``fits`` then need no force bins.

    A profile's a and b are the means over the trials of one participant, or the means of the participants' means. The
    mean of fitted curves is the curve of the mean coefficients, the law being linear in them. Curves are evaluated from
    the window's lower force on: the paper's grid starts at 0 N, where ln F is undefined.
    """
    rows = usable(fits, use)
    splines = cell_splines(fits, use, window.force_n) if splines is None else splines
    force_n = np.linspace(*window.force_n, profile.grid_points)
    participant = _participant(fits, rows, profile.participant, choice)
    if participant:
        rows = rows & (fits.participant == participant)
    alone = np.unique(fits.participant[rows]).size == 1
    names = in_study_order(fits.specimen[rows], stiffness_n_per_mm)
    measured = {
        name: replace(
            _measured(fits, rows & (fits.specimen == name), name, stiffness_n_per_mm, force_n, alone),
            weights=np.repeat(one[:, None], 2, axis=1),
            spline=of_specimen(splines, fits.participant[rows & (fits.specimen == name)], name),
        ).along(profile.curve)
        for name, one in zip(names, np.eye(len(names)), strict=True)
    }
    exported = _exported(measured, profile.specimens, participant)
    new, alpha, bracket = _new(exported, stiffness_n_per_mm, profile)
    used = [p.specimen for p in exported]
    same = measured_as(new.specimen, new.stiffness_n_per_mm, measured, stiffness_n_per_mm, used) if new else None
    reference = measured[same] if same else None
    return Profiles(
        profiles=exported,
        new=new,
        weight_alpha=alpha,
        bracket=bracket,
        new_measured=reference,
        new_error=_error(reference, new, bracket) if reference and new and bracket else None,
        leave_one_out=_leave_one_out(tuple(measured.values()), profile),
        by_rule=_by_rule(exported, stiffness_n_per_mm, profile, reference),
        errors=mean_errors(fits, rows, names, "press" if alone else "person"),
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

    values = np.array([[p.a_v, p.b_v] for p in others])
    made = blended(values, profile.interpolation)
    # derivatives by the profile of each specimen: a cubic is not linear in them
    step = 1e-4 * float(np.abs(values).max()) or 1.0
    beside = step * np.eye(len(others))[:, :, None]
    up, down = (blended(values[:, None] + by, profile.interpolation).values for by in (beside, -beside))
    weights = np.einsum("nc,nsc->sc", (up - down) / (2 * step), np.array([p.weights for p in others]))
    # the spread of a specimen in between is taken to lie in between
    sd_v = np.maximum(blended(np.array([p.sd_v for p in others]), "bracket").values, 0.0)
    stiffer, softer = others[made.stiffer], others[made.softer]
    force_n = stiffer.force_n
    a_v, b_v = float(made.values[0]), float(made.values[1])
    sources = others if math.isnan(made.alpha) else (stiffer, softer)
    splines = [p.spline for p in others if p.spline is not None]
    spline = None
    if len(splines) == len(others):
        coefficients = blended(np.array([each.coefficients for each in splines]), profile.interpolation).values
        spline = MonotoneSpline(splines[0].knots, coefficients)
    interpolated = Profile(
        name, stiffness, a_v, b_v, force_n, a_v + b_v * np.log(force_n), "interpolated",
        sum(p.n_trials for p in sources), sd_v, weights, spline,
    ).along(profile.curve)  # fmt: skip
    return interpolated, made.alpha, (stiffer.specimen, softer.specimen)


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
    if profile.curve == "spline":
        notes.append(
            "Curves are means of monotone splines through the force bins; their bands, and the intervals of the "
            "schedules, are those of v = a + b ln F."
        )
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
