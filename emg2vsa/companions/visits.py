"""b of people who came more than once: how a later visit differs from the first, person by person."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats, Ints, mean_of
from emg2vsa.extraction import Trials
from emg2vsa.fits import Fits, usable
from emg2vsa.statistics.clusters import Names, clusters_of, in_order


@dataclass(frozen=True, eq=False)
class VisitDifferences:
    """Of c pairs of a specimen and a later visit; (c,) each, in the unit of b.

    mean, low, high : b at the visit less b at the first, mean over people who have both and its interval by Student's
    t over people; NaN with too few. sd : of these differences; what one visit leaves open of a person is sd / sqrt 2.
    """

    specimen: Names
    visit: Names
    people: Ints
    mean: Floats
    low: Floats
    high: Floats
    sd: Floats


def visit_differences(
    fits: Fits, trials: Sequence[Trials], use: str, visits: Sequence[str], confidence: float
) -> VisitDifferences:
    """Of the presses that ``use`` admits. visits : labels in order; ``trials`` say which press is of which."""
    of_cell = {(each.participant, each.specimen): each.visit for each in trials}
    cells = zip(fits.participant.tolist(), fits.specimen.tolist(), fits.repetition.tolist(), strict=True)
    visit = np.array([str(of_cell[who, what][n - 1]) for who, what, n in cells], dtype=np.str_)
    admitted, names = usable(fits, use), in_order(fits.specimen)
    tables = [clusters_of(fits.participant, fits.specimen, fits.b_v, admitted & (visit == own)) for own in visits]
    means = np.array([mean_of(each.values) for each in tables])  # (visits, people, specimens)
    later = (means[1:] - means[0]).transpose(2, 0, 1).reshape(-1, means.shape[1])
    known = [own[np.isfinite(own)] for own in later]
    people = np.array([own.size for own in known], dtype=np.int64)
    mean = np.array([float(own.mean()) if own.size else np.nan for own in known])
    sd = np.array([float(np.std(own, ddof=1)) if own.size > 1 else np.nan for own in known])
    reach = special.stdtrit(np.maximum(people - 1, 1), 0.5 + 0.5 * confidence) * sd / np.sqrt(np.maximum(people, 1))
    return VisitDifferences(
        np.repeat(names, len(visits) - 1), np.tile(np.array(visits[1:], dtype=np.str_), names.size), people, mean,
        mean - reach, mean + reach, sd,
    )  # fmt: skip
