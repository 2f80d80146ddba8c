"""The initial area: does it hang on the specimen, and on the angle (paper, VI.A and Fig. 8)?

Compared is the area at the force where loading begins. A_c0 itself, the area of the first frame after that, grows with
the force at which that frame happens to come. The paper's rank tests count presses; ratios are over mountings.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats, mean_of
from emg2vsa.discrimination.mountings import UNKNOWN, CellSum, Mountings, Ratios, ratios
from emg2vsa.discrimination.run_table import RunTable
from emg2vsa.statistics.kruskal import KruskalWallis, RankPairs, dunn, kruskal


@dataclass(frozen=True)
class AreaBySpecimen:
    """Known specimens compared within each of D designs: the paper's claim is that it is the same.

    mean : (D, S) of presses. softest_over_stiffest : (D,).
    """

    mean: Floats
    kruskal: KruskalWallis
    softest_over_stiffest: Ratios


@dataclass(frozen=True)
class AreaByAngle:
    """Angles compared, all known specimens together, for q conditions that were pressed at several.

    angles_deg : (A,), the groups. mean : (q, A) of presses. over_first : (q,) of each condition its areas over that at
    its smallest angle, (A,) each, mean of the specimens; NaN where an angle was not pressed.
    """

    conditions: tuple[str, ...]
    angles_deg: Floats
    mean: Floats
    kruskal: KruskalWallis
    pairs: RankPairs
    over_first: tuple[Ratios, ...]

    def worst_p(self, i: int) -> float:
        """Largest p of the paper's pairwise comparison (mean ranks, Bonferroni); NaN where there is none."""
        return float(np.fmax.reduce(self.pairs.p[i], initial=np.nan))

    def falls(self, i: int) -> bool:
        """Whether the mean area falls with every larger angle."""
        mean = self.mean[i][np.isfinite(self.mean[i])]
        return bool(mean.size > 1 and np.all(np.diff(mean) < 0))


def area_by_specimen(table: RunTable, mountings: Mountings, alpha: float) -> AreaBySpecimen:
    """mountings : of the areas."""
    known = table.known
    values = table.start_area[table.algorithm][:, known]
    over = [mountings.sum({(design, known[-1]): 1.0, (design, known[0]): -1.0}) for design in range(len(values))]
    return AreaBySpecimen(mean_of(values), kruskal(values), ratios(over, 1 - alpha))


def area_by_angle(table: RunTable, mountings: Mountings, alpha: float) -> AreaByAngle | None:
    """None where no condition was pressed at two angles."""
    angles, known = np.unique(table.angles_deg), table.known
    several = tuple(c for c in dict.fromkeys(table.conditions) if len(table.of_condition(c)) > 1)
    if not several:
        return None
    values = table.start_area[table.algorithm][:, known]
    _, k, n = values.shape
    pooled = np.full((len(several), angles.size, k * n), np.nan)
    over = []
    for i, condition in enumerate(several):
        first, *_ = designs = table.of_condition(condition)
        for design in designs:
            pooled[i, np.searchsorted(angles, table.angles_deg[design])] = values[design].ravel()
        places = [table.design(condition, angle) for angle in angles.tolist()]
        over.append(ratios([_angle(mountings, place, first, known) for place in places], 1 - alpha))
    ranks = kruskal(pooled)
    return AreaByAngle(several, angles, mean_of(pooled), ranks, dunn(ranks), tuple(over))


def _angle(mountings: Mountings, place: int, first: int, known: list[int]) -> CellSum:
    """Difference of mean ln area; NaN at the first angle, and where there is no press."""
    share = 1 / len(known)
    weights = {(place, s): share for s in known} | {(first, s): -share for s in known}
    return mountings.sum(weights) if place not in (-1, first) else UNKNOWN
