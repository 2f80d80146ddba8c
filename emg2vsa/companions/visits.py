"""b of people who came more than once: how a later visit differs from the first, and presses freed of that."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import special

from emg2vsa.arrays import Floats, Ints, mean_of
from emg2vsa.fits import Fits, usable
from emg2vsa.statistics.clusters import Names, clusters_of, in_order


@dataclass(frozen=True, eq=False)
class VisitDifferences:
    """Differences of c pairs of a specimen and a later visit; (c,) each, in the unit of b.

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


def visit_differences(fits: Fits, use: str, visits: Sequence[str], confidence: float) -> VisitDifferences:
    """Differences by the presses that ``use`` admits. visits : labels in order."""
    admitted, names = usable(fits, use), in_order(fits.specimen)
    tables = [clusters_of(fits.participant, fits.specimen, fits.b_v, admitted & (fits.visit == own)) for own in visits]
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


def within_visits(fits: Fits, admitted: NDArray[np.bool_]) -> Fits:
    """Fits without what differs between the visits of a person on a specimen; the same where each comes once.

    Each visit's mean of a and b over the ``admitted`` presses (n,) becomes the mean over the visits, of which each
    counts once. SDs stay those of presses at a visit: the rest grows by the root of (n - 1) / (n - visits). With one
    press a visit there is no rest, and values stay. Repetitions count from 1 at each visit.
    """
    if np.unique(fits.visit).size < 2:
        return fits
    a_v, b_v, repetition = fits.a_v.copy(), fits.b_v.copy(), fits.repetition.copy()
    _, cell = np.unique(np.stack([fits.participant, fits.specimen]), axis=1, return_inverse=True)
    for each in np.unique(cell):
        visits = [(cell.ravel() == each) & (fits.visit == own) for own in np.unique(fits.visit[cell.ravel() == each])]
        for visit in visits:
            repetition[visit] += 1 - fits.repetition[visit].min()
        used = [visit & admitted for visit in visits if np.any(visit & admitted)]
        n = sum(int(visit.sum()) for visit in used)
        for values, given in ((a_v, fits.a_v), (b_v, fits.b_v)) if len(used) > 1 and n > len(used) else ():
            means = [given[visit].mean() for visit in used]
            for visit, mean in zip(used, means, strict=True):
                wider = np.sqrt((n - 1) / (n - len(used)))
                values[visit] = np.mean(means) + wider * (given[visit] - mean)
    return replace(fits, a_v=a_v, b_v=b_v, repetition=repetition)


def unequal_people(fits: Fits) -> list[str]:
    """Participants one of whose specimens misses at a visit at which another one was pressed well enough."""
    rows = fits.verdict != "rejected"
    names = zip(fits.participant[rows].tolist(), fits.specimen[rows].tolist(), fits.visit[rows].tolist(), strict=True)
    cells = set(names)
    people = in_order(fits.participant[rows]).tolist()
    own = {who: [(what, visit) for name, what, visit in cells if name == who] for who in people}
    return [who for who, at in own.items() if len(at) < len({what for what, _ in at}) * len({visit for _, visit in at})]
