"""One number a trial, sorted by blocks and groups: every test of section IV.B with its companions.

A block is a participant and a group a specimen in a study; in any other table they are what its columns say, and a
table without blocks is one block.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.companions.blocks import BlockTests, block_tests
from emg2vsa.companions.equality import EqualityTests, equality_tests
from emg2vsa.companions.groups import GroupTests, group_tests
from emg2vsa.companions.normality import NormalityTests, normality_of
from emg2vsa.companions.pairs import PairTests, pair_tests
from emg2vsa.stats.clusters import Clusters
from emg2vsa.stats.equivalence import MarginUnit

_NO_DESIGN = np.empty((0, 2, 1))


@dataclass(frozen=True)
class TableTests:
    """Tests of P blocks by S groups; designs that the table does not allow are absent (d = 0).

    normality : P S cells, block by block. between_groups, pairs : d = P. between_blocks, equality : d = S.
    """

    normality: NormalityTests
    between_groups: GroupTests
    pairs: PairTests
    between_blocks: GroupTests
    equality: EqualityTests
    blocks: BlockTests | None


def table_tests(
    clusters: Clusters,
    alpha: float,
    margin: float | None = None,
    unit: MarginUnit = "data",
    *,
    protected: bool = False,
    origin: float = 0.0,
) -> TableTests:
    """Test ``clusters`` at ``alpha``, intervals at 1 - ``alpha``. Never raises for a small or incomplete table.

    margin, unit : within which blocks count as equal. protected : of Fisher's LSD. origin : the values are relative to
    it; all but one of the tests do not mind.
    """
    confidence, cells = 1 - alpha, clusters.count.size
    within = clusters.values if clusters.specimens.size > 1 else _NO_DESIGN
    across = np.swapaxes(clusters.values, 0, 1) if clusters.participants.size > 1 else _NO_DESIGN
    between_groups, between_blocks = group_tests(within, confidence), group_tests(across, confidence)
    return TableTests(
        normality=normality_of(clusters.values.reshape(cells, -1 if cells else 1), origin),
        between_groups=between_groups,
        pairs=pair_tests(within, between_groups, confidence, protected=protected),
        between_blocks=between_blocks,
        equality=equality_tests(across, between_blocks.anova, alpha, margin, unit),
        blocks=block_tests(clusters, confidence),
    )
