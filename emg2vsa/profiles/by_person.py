"""The interpolated profile of every person beside the measured one: how far interpolation is off, and from whom."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.errors import DataError
from emg2vsa.exemplary import in_study_order, mean_coefficients
from emg2vsa.fits import Fits, usable
from emg2vsa.profiles.interpolation import between
from emg2vsa.settings import ProfileSettings


@dataclass(frozen=True)
class ByPerson:
    """P people who pressed all of the specimens that the interpolation takes, and the specimen ``measured_as``.

    Arrays (P, 2) are mean a and b of v = a + b ln F, in the unit of the activity. bracket : the stiffer and the softer
    neighbour, whose profiles are ``stiffer`` and ``softer``.
    """

    participants: tuple[str, ...]
    measured_as: str
    bracket: tuple[str, str]
    interpolated: Floats
    measured: Floats
    stiffer: Floats
    softer: Floats

    def error_v(self, force_n: Floats) -> Floats:
        """Interpolated less measured activity (P, F) at forces (F,) in newtons."""
        return activity(self.interpolated - self.measured, force_n)

    def level_v(self, force_n: Floats) -> Floats:
        """Measured activity (P, F) at forces (F,) in newtons."""
        return activity(self.measured, force_n)

    def neighbours_v(self, force_n: Floats) -> Floats:
        """Activity of the stiffer less that of the softer neighbour, (P, F) at forces (F,) in newtons."""
        return activity(self.stiffer - self.softer, force_n)


def activity(coefficients: Floats, force_n: Floats) -> Floats:
    """a + b ln F, (..., F) from a and b (..., 2) and forces (F,) in newtons."""
    return coefficients[..., :1] + coefficients[..., 1:] * np.log(force_n)


def by_person(
    fits: Fits, stiffness_n_per_mm: Mapping[str, float], profile: ProfileSettings, use: str
) -> ByPerson | None:
    """The arguments are those of ``build_profiles``. None where nothing is interpolated, nobody pressed a specimen of
    the new one's stiffness beside those that the interpolation takes, or the rule of interpolation refuses."""
    rows, name = usable(fits, use), profile.new_specimen
    stiffness = profile.new_stiffness_n_per_mm or stiffness_n_per_mm.get(name or "")
    pressed = in_study_order(fits.specimen[rows], stiffness_n_per_mm)
    if name is None or stiffness is None:
        return None
    taken = [s for s in profile.specimens or pressed if s != name and s in pressed and s in stiffness_n_per_mm]
    same = measured_as(name, stiffness, pressed, stiffness_n_per_mm, profile.specimens or pressed)
    if same is None:
        return None
    means = mean_coefficients(fits, rows, [same, *taken])
    whole = {who: values for who, values in means.items() if np.isfinite(values).all()}
    if not whole:
        return None
    measured, *others = np.stack([*whole.values()], axis=1)
    known = np.array([stiffness_n_per_mm[s] for s in taken])
    try:
        made = between(
            known, np.array(others), stiffness, profile.interpolation, extrapolate=profile.extrapolate, where=name
        )
    except DataError:  # build_profiles says it
        return None
    stiffer, softer = made.stiffer, made.softer
    return ByPerson(
        tuple(whole), same, (taken[stiffer], taken[softer]), made.values, measured, others[stiffer], others[softer]
    )


def measured_as(
    new: str, new_n_per_mm: float, pressed: Iterable[str], stiffness_n_per_mm: Mapping[str, float], used: Iterable[str]
) -> str | None:
    """The pressed specimen of the same name, or of the same stiffness, N/mm, and not ``used``; None without one."""
    pressed = tuple(pressed)
    twins = (s for s in pressed if stiffness_n_per_mm.get(s) == new_n_per_mm and s not in used)
    return new if new in pressed else next(twins, None)
