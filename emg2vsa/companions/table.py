"""One number a trial, sorted by blocks and groups: every test of section IV.B with its companions.

A block is a participant and a group a specimen in a study; in any other table they are what its columns say, and a
table without blocks is one block. Tests over blocks do not take the repetitions of one person as independent.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.companions.groups import (
    EqualityTests,
    GroupTests,
    NormalityTests,
    equality_tests,
    group_tests,
    normality_of,
)
from emg2vsa.companions.pairs import PairTests, pair_tests
from emg2vsa.stats.agreement import IntraclassCorrelations, icc
from emg2vsa.stats.clusters import Clusters
from emg2vsa.stats.equivalence import MarginUnit
from emg2vsa.stats.friedman import Friedman, friedman
from emg2vsa.stats.mixed import MixedModel, balanced_mixed
from emg2vsa.stats.outcome import Outcome
from emg2vsa.stats.repeated import RepeatedAnova, rm_anova

_NO_DESIGN = np.empty((0, 2, 1))


@dataclass(frozen=True)
class BlockTests:
    """One table of blocks (participants) by groups (specimens); all but the mixed model are on the means of its cells.

    balanced : the mixed model where every cell has equally many values, else ``unbalanced`` holds what statsmodels
    made of it; both are None where no cell has two values.
    """

    repeated: RepeatedAnova
    friedman: Friedman
    icc: IntraclassCorrelations
    balanced: MixedModel | None
    unbalanced: Outcome | None

    @property
    def mixed(self) -> Outcome | None:
        """The mixed model, whichever way it was fitted."""
        return self.balanced.outcome() if self.balanced else self.unbalanced

    def outcomes(self) -> tuple[Outcome, ...]:
        """All tests of the table."""
        repeated = tuple(self.repeated.outcome(correction=name) for name in ("none", "gg", "hf"))
        mixed = (self.mixed,) if self.mixed else ()
        return (*repeated, self.friedman.outcome(), *mixed, self.icc.outcome(kind="ICC(3,1)"))


def _block_tests(clusters: Clusters, confidence: float = 0.95) -> BlockTests | None:
    """Test the table of ``clusters``; None below two blocks or two groups."""
    if min(clusters.count.shape) < 2:
        return None
    total = np.sum(clusters.values, axis=2, where=~np.isnan(clusters.values))
    means = np.where(clusters.count > 0, total / np.maximum(clusters.count, 1), np.nan)
    balanced, unbalanced = _mixed(clusters, confidence)
    return BlockTests(rm_anova(means), friedman(means), icc(means, confidence), balanced, unbalanced)


def _mixed(clusters: Clusters, confidence: float) -> tuple[MixedModel | None, Outcome | None]:
    fewest, most = int(clusters.count.min()), int(clusters.count.max())
    if most < 2:
        return None, None
    if fewest == most:
        return balanced_mixed(clusters.values, confidence), None
    # statsmodels takes seconds to load: only for the tables that need it
    from emg2vsa.stats.unbalanced_mixed import unbalanced_mixed  # noqa: PLC0415

    shape = clusters.values.shape
    blocks = np.broadcast_to(clusters.participants[:, None, None], shape)
    groups = np.broadcast_to(clusters.specimens[None, :, None], shape)
    return None, unbalanced_mixed(clusters.values.ravel(), blocks.ravel(), groups.ravel())


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
        blocks=_block_tests(clusters, confidence),
    )
