"""CASR by specimen: is it larger for softer ones, and does the new specimen lie between its neighbours in stiffness?

The paper's rank tests count presses of one mounting as if they were independent; steps from specimen to specimen are
over mountings.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, mean_of
from emg2vsa.discrimination.mountings import Mountings, Ratios, ratios
from emg2vsa.discrimination.run_table import RunTable
from emg2vsa.statistics.kruskal import KruskalWallis, RankPairs, dunn, kruskal


@dataclass(frozen=True)
class SpreadBySpecimen:
    """Known specimens, stiffest first, compared within each of D designs.

    mean : (D, S) of presses. pairs : the paper's, on mean ranks, Bonferroni. rises :
    (D,) whether every softer specimen has the larger mean. steps : CASR of each specimen over that of the next stiffer,
    the new one included, S - 1 of each design, design by design.
    """

    specimens: tuple[str, ...]
    mean: Floats
    kruskal: KruskalWallis
    pairs: RankPairs
    rises: NDArray[np.bool_]
    steps: Ratios

    @property
    def worst_p(self) -> Floats:
        """(D,) largest p of the paper's pairwise comparison; NaN where there is none."""
        return np.asarray(np.fmax.reduce(self.pairs.p, axis=1, initial=np.nan))


@dataclass(frozen=True)
class NewSpecimen:
    """The new specimen beside its stiffer and its softer neighbour in each of D designs; (D, 2) unless said.

    neighbours : their names, "" where there is none. p_mean_rank : the paper's, Dunn on the ranks of all specimens,
    Bonferroni over all pairs. between : (D,) whether its mean lies between theirs. discriminated : (D,) whether the
    intervals of both steps say so.
    """

    name: str
    neighbours: tuple[str, str]
    p_mean_rank: Floats
    between: NDArray[np.bool_]
    discriminated: NDArray[np.bool_]


def spread_by_specimen(table: RunTable, mountings: Mountings, alpha: float) -> SpreadBySpecimen:
    """mountings : of CASR."""
    values = table.casr[table.algorithm][:, table.known]
    ranks, mean = kruskal(values), mean_of(values)
    neighbours = list(pairwise(range(len(table.specimens))))
    steps = [
        mountings.sum({(design, soft): 1.0, (design, stiff): -1.0})
        for design in range(len(values))
        for stiff, soft in neighbours
    ]
    return SpreadBySpecimen(
        specimens=tuple(table.specimens[i] for i in table.known),
        mean=mean,
        kruskal=ranks,
        pairs=dunn(ranks),
        rises=np.all(np.diff(mean, axis=1) > 0, axis=1),
        steps=ratios(steps, 1 - alpha),
    )


def beside_neighbours(table: RunTable, steps: Ratios) -> NewSpecimen | None:
    """None where no new specimen was pressed. steps : those of ``SpreadBySpecimen``."""
    if table.new < 0:
        return None
    values, new = table.casr[table.algorithm], table.new
    mean, ranks = mean_of(values), dunn(kruskal(values))
    inner = 0 < new < len(table.specimens) - 1
    low = steps.low.reshape(len(values), -1)[:, max(new - 1, 0) : new + 1]
    nobody = np.zeros(len(values), dtype=np.bool_)
    return NewSpecimen(
        name=table.specimens[new],
        neighbours=(_name(table, new - 1), _name(table, new + 1)),
        p_mean_rank=np.stack([_of_pair(ranks, new, place) for place in (new - 1, new + 1)], axis=1),
        between=np.all(np.diff(mean[:, new - 1 : new + 2], axis=1) > 0, axis=1) if inner else nobody,
        discriminated=np.all(low > 1, axis=1) if inner else nobody,
    )


def _of_pair(found: RankPairs, one: int, other: int) -> Floats:
    """(D,) p of a pair in either order; NaN where there is no such pair."""
    pair = np.flatnonzero((found.first == min(one, other)) & (found.second == max(one, other)))
    return found.p[:, pair[0]] if pair.size else np.full(len(found.p), np.nan)


def _name(table: RunTable, place: int) -> str:
    return table.specimens[place] if 0 <= place < len(table.specimens) else ""
