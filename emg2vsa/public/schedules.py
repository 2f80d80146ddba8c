"""From fits to the stiffness schedules of the actuator, equations (7) and (8)."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from emg2vsa import __version__
from emg2vsa.errors import DataError
from emg2vsa.exemplary import compare_participants
from emg2vsa.fits import Fits
from emg2vsa.profiles import Profiles, build_profiles
from emg2vsa.public.given import column, number_of, numbers_of, of_kind, refuse_missing_labels, settings_or_default
from emg2vsa.schedules import Schedule
from emg2vsa.schedules.build import build_schedules
from emg2vsa.settings import StageSettings

_NEEDED = ("specimen", "a_v", "b_v")


def schedule(
    fits: pd.DataFrame, stiffness_n_per_mm: Mapping[str, float], settings: StageSettings | None = None
) -> pd.DataFrame:
    """Stiffness to hold in each step of force, for every specimen and condition: one row a step.

    Parameters
    ----------
    fits : one row a press, in the order they were made, as `emg2vsa.fit` gives them: ``specimen``, ``a_v``, ``b_v``,
        and where they are there ``participant`` and ``verdict`` (rejected presses do not enter).
    stiffness_n_per_mm : specimen to its stiffness by plate indentation, N/mm; above 0 for every specimen of the
        fits, or of ``profile.specimens`` where that names some.
    settings : tables ``profile``, ``schedule``, ``window``, ``hypotheses`` (which verdicts enter).

    Columns: specimen, condition, step, force_from_n, force_to_n, stiffness_percent with the ends of its 95 % interval
    (stiffness_low_percent, stiffness_high_percent), the preset as the actuator's files have it (qbmove: preset_ticks),
    stiffness_nm_per_rad, activity_v.

    DataError, ScheduleError : no schedule can be made.
    """
    settings = settings_or_default(settings)
    product = _fits_of(fits)
    known = _stiffness_of(product, stiffness_n_per_mm, settings)
    choice = None
    if settings.profile.participant == "medoid":
        choice = compare_participants(product, known, settings.profile, settings.window, settings.hypotheses.use)
    profiles = build_profiles(product, known, settings.profile, settings.window, settings.hypotheses.use, choice)
    return schedules_frame(build_schedules(profiles, settings.schedule, {"emg2vsa": __version__}))


def _stiffness_of(fits: Fits, given: Mapping[Any, Any], settings: StageSettings) -> dict[str, float]:
    """Every stiffness that is one. DataError: a specimen that takes part has none."""
    where = "schedule, stiffness_n_per_mm"
    of_kind(given, Mapping, where, "specimen to its stiffness", "Write {'S1': 1.4, 'S2': 0.6}.")
    told = {str(name): one for name, one in given.items()}
    known = {name: value for name, one in told.items() if (value := number_of(one)) is not None and value > 0}
    for name in settings.profile.specimens or dict.fromkeys(fits.specimen.tolist()):
        if name not in known:
            raise DataError(
                f"{where}, specimen {name!r}", wanted="a number above 0, in N/mm",
                found=repr(told[name]) if name in told else "none",
                do="Give its stiffness, or leave it out: Settings(profile={'specimens': [...]}).",
            )  # fmt: skip
    return known


def _fits_of(frame: pd.DataFrame) -> Fits:
    """A table of fits as the product that profiles are made from; what profiles do not need is NaN."""
    do = "Make a DataFrame of it: pandas.DataFrame(...)."
    of_kind(frame, pd.DataFrame, "schedule, fits", "a DataFrame", do)
    absent = [name for name in _NEEDED if name not in frame.columns]
    if absent or frame.empty:
        found = f"no {', '.join(absent)}" if absent else "no row"
        do = "Fit recordings first: emg2vsa.fit(recording, specimen=...), and join their tables."
        raise DataError("fits", wanted=f"rows with {', '.join(_NEEDED)}", found=found, do=do)
    refuse_missing_labels(frame, "fits")
    n = len(frame)
    known: dict[str, Any] = {
        "participant": np.full(n, ""), "repetition": np.arange(1, n + 1), "verdict": np.full(n, "ok"),
        "reason": np.full(n, ""), "visit": np.full(n, ""), "cause": np.full(n, ""), "n_points": np.zeros(n, np.int64),
        "bin_edges_n": np.zeros(1), "bin_force_n": np.zeros((n, 0)), "bin_v": np.zeros((n, 0)),
        "activity_unit": frame.attrs.get("activity_unit", "V"), "points": "bins", "weights": "none", "confidence": 0.95,
    }  # fmt: skip
    known |= {name: numbers_of(frame, name, "fits") for name in ("a_v", "b_v")}
    for name in ("participant", "specimen", "verdict"):
        if name in frame.columns:
            known[name] = column(frame, name, "fits").astype(str).to_numpy(np.str_)
    return Fits(**{field.name: known.get(field.name, np.full(n, np.nan)) for field in dataclasses.fields(Fits)})


def schedules_frame(found: Sequence[Schedule]) -> pd.DataFrame:
    """Schedules, one row a step of force."""
    parts = [
        pd.DataFrame(
            {
                "specimen": one.specimen, "condition": one.condition,
                "step": np.arange(1, one.stiffness_percent.size + 1),
                "force_from_n": one.step_force_n[:-1], "force_to_n": one.step_force_n[1:],
                "stiffness_percent": one.stiffness_percent, "stiffness_low_percent": one.interval[0],
                "stiffness_high_percent": one.interval[1], one.limits.export.column: one.exported,
                "stiffness_nm_per_rad": one.stiffness_nm_per_rad, "activity_v": one.activity_v,
            }
        )
        for one in found
    ]  # fmt: skip
    frame = pd.concat(parts, ignore_index=True)
    origin: dict[Any, Any] = dict(found[0].provenance)
    frame.attrs = origin
    return frame


def profiles_frame(found: Profiles) -> pd.DataFrame:
    """Profiles, measured and interpolated, one row a force of the grid."""
    every = [*found.profiles, *([found.new] if found.new else [])]
    parts = [
        pd.DataFrame(
            {
                "specimen": one.specimen, "source": one.source, "stiffness_n_per_mm": one.stiffness_n_per_mm,
                "force_n": one.force_n, "activity_v": one.v, "sd_v": one.sd_v,
                "half_width_v": found.half_width_v(one), "a_v": one.a_v, "b_v": one.b_v,
            }
        )
        for one in every
    ]  # fmt: skip
    frame = pd.concat(parts, ignore_index=True)
    frame.attrs = {"participant": found.participant or "mean over all", "unit": found.unit, "notes": list(found.notes)}
    return frame
