"""Which participant stands for all, and how much the schedule hangs on that choice (paper IV.B: "exemplary")."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats
from emg2vsa.fits import Fits, usable
from emg2vsa.settings import MEDOID, ProfileSettings, WindowSettings


@dataclass(frozen=True)
class Choice:
    """P participants with usable trials on every exported specimen, and how far their schedules are apart.

    The distance of two participants is the root mean square, over specimens and over forces of the window, of the
    difference of their schedules as a share of the mapped range: each participant's co-contraction is mapped from its
    own smallest to its own largest value, as eq. (7) does. Amplitudes of EMG do not enter.
    """

    participants: tuple[str, ...]
    to_others: Floats
    "(P,) mean distance to the other participants; the smallest is the medoid's."
    to_used: Floats
    "(P,) distance to the schedule that is used."
    largest: Floats
    "(P,) largest difference to the schedule that is used, at any force of any specimen."
    left_out: tuple[str, ...]
    "Participants without usable trials on one of the specimens."

    @property
    def medoid(self) -> str:
        """The participant nearest to all others; the first of several."""
        return self.participants[int(np.argmin(self.to_others))]


def compare_participants(
    fits: Fits, stiffness_n_per_mm: Mapping[str, float], profile: ProfileSettings, window: WindowSettings, use: str
) -> Choice | None:
    """How far the participants' schedules are apart; None where fewer than two have every exported specimen.

    stiffness_n_per_mm : of specimens, N/mm. The arguments are those of ``profiles.build_profiles``; what is used is the
        participant that ``profile`` names, the medoid, or the mean over participants.
    """
    rows, used = usable(fits, use), profile.participant
    specimens = profile.specimens or in_study_order(fits.specimen[rows], stiffness_n_per_mm)
    force_n = np.linspace(*window.force_n, profile.grid_points)
    present = list(dict.fromkeys(fits.participant[rows].tolist()))
    means = mean_coefficients(fits, rows, specimens)
    whole = [name for name in present if np.isfinite(means[name]).all()]
    if len(whole) < 2:
        return None
    shares = np.array([_share(means[name], force_n) for name in whole])
    # one participant at a time: all pairs at once would take gigabytes for a thousand people
    between = (np.sqrt(np.mean((one - shares) ** 2, axis=(1, 2))) for one in shares)
    to_others = np.array([distances.sum() for distances in between]) / (len(whole) - 1)
    if used:
        mine = shares[int(np.argmin(to_others)) if used == MEDOID or used not in whole else whole.index(used)]
    else:
        mine = _share(np.mean([means[name] for name in whole], axis=0), force_n)
    return Choice(
        participants=tuple(whole),
        to_others=to_others,
        to_used=np.sqrt(np.mean((shares - mine) ** 2, axis=(1, 2))),
        largest=np.abs(shares - mine).max(axis=(1, 2)),
        left_out=tuple(name for name in present if name not in whole),
    )


def in_study_order(specimens: NDArray[np.str_], stiffness_n_per_mm: Mapping[str, float]) -> list[str]:
    """Names among ``specimens`` (n,), each once: those of known stiffness, N/mm, in the order of the study, then the
    others."""
    present = dict.fromkeys(specimens.tolist())
    return [name for name in dict.fromkeys([*stiffness_n_per_mm, *present]) if name in present]


def mean_coefficients(fits: Fits, rows: NDArray[np.bool_], specimens: Sequence[str]) -> dict[str, Floats]:
    """Participant, in the order of the rows, to (S, 2) mean a and b; NaN where there is no trial."""
    cells: dict[tuple[str, str], list[int]] = {}
    at = np.flatnonzero(rows)
    for i, who, what in zip(at.tolist(), fits.participant[at].tolist(), fits.specimen[at].tolist(), strict=True):
        cells.setdefault((who, what), []).append(i)
    found = {who: np.full((len(specimens), 2), np.nan) for who, _ in cells}
    for (who, what), these in cells.items():
        if what in specimens:
            found[who][specimens.index(what)] = fits.a_v[these].mean(), fits.b_v[these].mean()
    return found


def _share(coefficients: Floats, force_n: Floats) -> Floats:
    """(S, G) co-contraction from 0 at its smallest to 1 at its largest value; 0 where it does not vary."""
    v = coefficients[:, :1] + coefficients[:, 1:] * np.log(force_n)
    span = float(np.ptp(v))
    return (v - v.min()) / span if span > 0 else np.zeros_like(v)
