"""The new specimen: does its CASR lie between those of its neighbours in stiffness, and apart from both (paper, VI)?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats
from emg2vsa.discrimination.run_table import RunTable, mean_of
from emg2vsa.settings import DiscriminationSettings
from emg2vsa.stats.dunn import RankPairs, dunn
from emg2vsa.stats.kruskal import kruskal
from emg2vsa.stats.mann_whitney import mann_whitney
from emg2vsa.stats.multiplicity import adjust


@dataclass(frozen=True)
class NewSpecimen:
    """The new specimen beside its stiffer and its softer neighbour in each of D designs; (D, 2) unless said.

    neighbours : their names, "" where there is none. p : exact Mann-Whitney, Holm over the neighbours. p_mean_rank :
    Dunn on the ranks of all ``specimens`` (their number), Bonferroni over all pairs, as the paper compares. shift, low,
    high : Hodges-Lehmann, new less neighbour. between : (D,) whether its mean lies between theirs. discriminated : (D,)
    whether it does and p tells it from each neighbour.
    """

    name: str
    neighbours: tuple[str, str]
    specimens: int
    p: Floats
    p_mean_rank: Floats
    shift: Floats
    low: Floats
    high: Floats
    between: NDArray[np.bool_]
    discriminated: NDArray[np.bool_]


def beside_neighbours(table: RunTable, settings: DiscriminationSettings) -> NewSpecimen | None:
    """None where no new specimen was pressed."""
    if table.new < 0:
        return None
    places, values = (table.new - 1, table.new + 1), table.casr[table.algorithm]
    stiffer, own, softer = (_of_specimen(values, place) for place in (places[0], table.new, places[1]))
    ranks = mann_whitney(np.stack([own, stiffer, softer], axis=1), confidence=1 - settings.alpha)
    p = adjust(ranks.p[:, :2], "holm")
    pooled = dunn(kruskal(values))
    low, mean, high = (mean_of(presses) for presses in (stiffer, own, softer))
    between = (mean > low) & (mean < high)
    return NewSpecimen(
        name=table.specimens[table.new],
        neighbours=(_name(table, places[0]), _name(table, places[1])),
        specimens=len(table.specimens),
        p=p,
        p_mean_rank=np.stack([_of_pair(pooled, table.new, place) for place in places], axis=1),
        shift=ranks.shift[:, :2],
        low=ranks.low[:, :2],
        high=ranks.high[:, :2],
        between=between,
        discriminated=between & np.all(p < settings.alpha, axis=1),
    )


def _of_specimen(values: Floats, place: int) -> Floats:
    """(D, R) presses of a specimen; NaN where there is no such place."""
    there = 0 <= place < values.shape[1]
    return values[:, place] if there else np.full((values.shape[0], values.shape[2]), np.nan)


def _of_pair(found: RankPairs, one: int, other: int) -> Floats:
    """(D,) p of a pair in either order; NaN where there is no such pair."""
    pair = np.flatnonzero((found.first == min(one, other)) & (found.second == max(one, other)))
    return found.p[:, pair[0]] if pair.size else np.full(len(found.p), np.nan)


def _name(table: RunTable, place: int) -> str:
    return table.specimens[place] if 0 <= place < len(table.specimens) else ""
