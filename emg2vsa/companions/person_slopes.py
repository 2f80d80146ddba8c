"""b of each person on each specimen: the mean over the trials used, whose interval holds how presses differ."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats, Ints, mean_of
from emg2vsa.companions.visits import within_visits
from emg2vsa.fits import Fits, usable
from emg2vsa.statistics.clusters import Names, clusters_of
from emg2vsa.statistics.hierarchy import ENOUGH, recording_means


@dataclass(frozen=True, eq=False)
class PersonSlopes:
    """Slopes of c recordings, participant by participant, specimen by specimen; (c,) each, in the unit of b.

    mean, low, high : b; NaN without presses. The interval holds how presses differ, pooled over all recordings, the
    errors of corrections, and b without the bias that is left. presses : that count.
    press_sd, press_df, press_rho : see `RecordingMeans`; shares of v in the middle of the force window.
    """

    participant: Names
    specimen: Names
    presses: Ints
    mean: Floats
    low: Floats
    high: Floats
    press_sd: float
    press_df: float
    press_rho: float

    def rows(self) -> list[dict[str, str | int | float | None]]:
        """One a recording, for programs; None for what is not known. b_v and its ends : in the unit of b."""
        names = {"participant": "participant", "specimen": "specimen", "presses": "presses"}
        names |= {"b_v": "mean", "b_lo_v": "low", "b_hi_v": "high"}
        found = ({key: getattr(self, of)[i].item() for key, of in names.items()} for i in range(self.mean.size))
        return [{name: each if each == each else None for name, each in row.items()} for row in found]

    def said(self, activity_unit: str) -> Iterator[str]:
        """One sentence a recording, with what its interval leaves out; "" where it has no presses."""
        factor, unit = (1e6, " uV") if activity_unit == "V" else (1.0, "")
        for n, *b in zip(self.presses.tolist(), self.mean, self.low, self.high, strict=True):
            mean, low, high = (f"{factor * float(of):.3g}" for of in b)
            told = f"b of the person: {mean}{unit}, mean of {n} press{'es' * (n != 1)}"
            if np.isfinite(b[1]):
                alone = n < ENOUGH and self.presses.size == 1
                few = f"; fewer than {ENOUGH} presses do not tell whether successive ones are alike" if alone else ""
                yield f"{told} [{low}, {high}]{few}."
            else:
                yield f"{told}. One press does not tell how presses of a person differ." if n else ""


def person_slopes(fits: Fits, use: str) -> PersonSlopes:
    """Slopes by the trials that ``use`` admits, in the order they were made, within visits; a recording without one has
    0.
    """
    admitted = usable(fits, use)
    fits = within_visits(fits, admitted)
    middle_v = (fits.v_min_v + fits.v_max_v) / 2
    tables = [
        clusters_of(fits.participant, fits.specimen, of, admitted)
        for of in (fits.b_v, middle_v, fits.b_bias, fits.b_bias_se)
    ]
    names, cells = tables[0], tables[0].count.size
    values, *others = (each.values.reshape(cells, -1) if cells else np.empty((0, 1)) for each in tables)
    level, left, error = map(mean_of, others)
    found = recording_means(values, level, error * np.abs(mean_of(values)), fits.confidence)
    without = found.mean / (1 + left)
    person, specimen = np.divmod(np.arange(cells), max(names.specimens.size, 1))
    return PersonSlopes(
        names.participants[person], names.specimens[specimen], found.count, found.mean,
        np.fmin(found.mean, without) - found.half, np.fmax(found.mean, without) + found.half,
        found.sd, found.df, found.rho,
    )  # fmt: skip
