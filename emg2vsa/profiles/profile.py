"""What profiles are: the mean trend of a specimen's co-contraction, and those of a study together."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.curves.monotone_spline import MonotoneSpline
from emg2vsa.errors import DataError
from emg2vsa.profiles.errors import MeanErrors
from emg2vsa.settings import Curve


@dataclass(frozen=True)
class Profile:
    """Co-contraction against force of one specimen, v = a + b ln F or a monotone spline."""

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
    weights: Floats = field(default_factory=lambda: np.empty((0, 2)))
    "(S, 2) of mean a and b of the specimens of ``Profiles.errors`` in these (an interpolation's: its derivatives)."
    spline: MonotoneSpline | None = None
    "Mean of the monotone splines of the same presses; None without force bins."
    curve: Curve = "log"
    "Which of the two ``v`` is."

    def along(self, curve: Curve) -> Profile:
        """This profile by the logarithm or by the spline. DataError where there is no spline."""
        if curve == "log":
            return replace(self, curve=curve, v=self.a_v + self.b_v * np.log(self.force_n))
        if self.spline is None:
            raise DataError(
                "profile.curve", wanted=f"force bins of the presses on {self.specimen}, for curve = 'spline'",
                found="only a and b of v = a + b ln F", do="Use curve = 'log'.",
            )  # fmt: skip
        return replace(self, curve=curve, v=self.spline.at(self.force_n))

    def weights_at(self, log_force: Floats) -> Floats:
        """(K, S, 2) of the same means in the activity where the logarithm of the force in newtons is (K,)."""
        return np.stack([np.ones_like(log_force), log_force], axis=-1)[:, None] * self.weights


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
    errors: MeanErrors | None = None
    "Errors of mean a and b of all measured specimens; None where they are not known."

    def along(self, curve: Curve) -> Profiles:
        """The exported profiles and the new one by the logarithm or by splines, as schedules take them."""
        new = None if self.new is None else self.new.along(curve)
        return replace(self, profiles=tuple(each.along(curve) for each in self.profiles), new=new)

    @property
    def drawn(self) -> str:
        """What was drawn at random, and makes the errors."""
        if self.errors is None or self.errors.unit == "press":
            return f"the presses of {self.participant or 'one person'}"
        return f"{self.errors.count.max(initial=0)} people"

    def half_width_v(self, profile: Profile) -> Floats:
        """Half of the pointwise interval (G,), V, of one of these profiles at its forces; NaN where it is not known."""
        if self.errors is None:
            return np.full(profile.force_n.size, np.nan)
        return self.errors.half_width(profile.weights_at(np.log(profile.force_n)))

    def half_widths(self, profile: Profile) -> tuple[float, float]:
        """Half of the interval of its a, and of its b."""
        if self.errors is None:
            return np.nan, np.nan
        a, b = self.errors.half_width(profile.weights * np.eye(2)[:, None]).tolist()
        return a, b

    def __repr__(self) -> str:
        new = "" if self.new is None else f", new {self.new.specimen}: b {self.new.b_v:.4g} {self.unit}"
        return f"Profiles({len(self.profiles)} specimens of {self.participant or 'all participants'}{new})"
