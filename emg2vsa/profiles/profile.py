"""What profiles are: the mean trend of a specimen's co-contraction, and those of a study together."""

from __future__ import annotations

from dataclasses import dataclass

from emg2vsa.arrays import Floats
from emg2vsa.profiles.by_person import ByPerson


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
    by_person: ByPerson | None = None
    "The new specimen by each person, where its equal was pressed."

    def __repr__(self) -> str:
        new = "" if self.new is None else f", new {self.new.specimen}: b {self.new.b_v:.4g} {self.unit}"
        return f"Profiles({len(self.profiles)} specimens of {self.participant or 'all participants'}{new})"
