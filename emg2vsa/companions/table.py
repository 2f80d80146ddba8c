"""One number a trial, sorted by blocks and groups: every test of section IV.B with its companions.

A block is a participant and a group a specimen in a study; in any other table they are what its columns say, and a
table without blocks is one block. Tests over blocks do not take the repetitions of one person as independent.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.companions.groups import (
    EqualityTests,
    GroupTests,
    NormalityTests,
    PairTests,
    equality_tests,
    group_tests,
    normality_of,
    pair_tests,
)
from emg2vsa.statistics.clusters import Clusters
from emg2vsa.statistics.equivalence import MarginUnit
from emg2vsa.statistics.hierarchy import ShrunkenValues, shrunken
from emg2vsa.statistics.mixed import MixedModel, balanced_mixed, unbalanced_mixed
from emg2vsa.statistics.mixed_variances import MixedResiduals, MixedVariances, mixed_residuals, mixed_variances
from emg2vsa.statistics.moments import group_moments
from emg2vsa.statistics.multiplicity import adjust
from emg2vsa.statistics.outcome import Outcome, Outcomes
from emg2vsa.statistics.post_hoc import PairDifferences
from emg2vsa.statistics.reml import fit_reml
from emg2vsa.statistics.repeated import PairedTests, RepeatedAnova, friedman, paired_tests, rm_anova

_NO_DESIGN = np.empty((0, 2, 1))


@dataclass(frozen=True)
class BlockTests:
    """One table of blocks (participants) by groups (specimens); all but the mixed model are on the means of its cells.

    mixed : the mixed model, in closed form where every cell has equally many values, an outcome that says why there is
    none where the table cannot bear it, None where no cell has two values. variances, residuals, predicted : of
    the mixed model, None without one. paired : pairs of groups over the blocks.
    """

    repeated: RepeatedAnova
    friedman: Outcomes
    model: MixedModel | Outcome | None
    variances: MixedVariances | None
    residuals: MixedResiduals | None
    predicted: ShrunkenValues | None
    paired: PairedTests

    @property
    def mixed(self) -> Outcome | None:
        """The test of the mixed model."""
        return self.model.outcome() if isinstance(self.model, MixedModel) else self.model

    @property
    def agreement(self) -> Outcome:
        """Intraclass correlation of the means."""
        return self.repeated.consistency(confidence=self.paired.t.confidence)

    @property
    def contrasts(self) -> PairDifferences | None:
        """Pairs of groups by the mixed model; None without one."""
        return self.model.pairs if isinstance(self.model, MixedModel) else None

    @property
    def pair_families(self) -> dict[str, Floats]:
        """p (1, q) of every pair, by Holm (1979) over the q pairs, by name of the test.

        Paired t first: each pair has its own SD of differences. The mixed model takes one for all pairs, and finds too
        many where some specimens scatter more than others (benchmarks/results/familywise).
        """
        contrasts = {} if self.contrasts is None else {"Mixed-model contrasts": self.contrasts.p}
        tests = {"Paired t": self.paired.t.p, "Signed ranks": self.paired.signed_rank_p} | contrasts
        return {name: adjust(p, "holm") for name, p in tests.items()}

    def pair_outcomes(self, pair: int) -> tuple[Outcome, ...]:
        """All tests of one pair of groups over the blocks, p by Holm."""
        q = self.paired.t.first.size
        contrasts = self.contrasts
        tests = [self.paired.t, *([] if contrasts is None else [contrasts])]
        size = float(self.paired.g[0, pair])
        note = f"p corrected over the {q} pairs, the interval is not"
        few = (
            ("g_z is not defined for two blocks: its correction takes three",) if self.paired.t.n[0, pair] == 2 else ()
        )
        return tuple(
            replace(
                test.outcome(0, pair),
                method=f"{test.method}, Holm",
                p=float(adjust(test.p, "holm")[0, pair]),
                effect_name="g_z",
                effect_size=size,
                notes=(note, *few, *test.undefined(0, pair)),
            )
            for test in tests
        )

    def outcomes(self) -> tuple[Outcome, ...]:
        """All tests of the table, Greenhouse and Geisser's first: it allows for specimens that scatter unequally."""
        repeated = tuple(self.repeated.outcome(correction=name) for name in ("gg", "hf", "none"))
        mixed = (self.mixed,) if self.mixed else ()
        variances = () if self.variances is None else self.variances.outcomes()
        residuals = () if self.residuals is None else self.residuals.outcomes()
        return (*repeated, *mixed, *variances, self.friedman.outcome(), self.agreement, *residuals)


def _block_tests(clusters: Clusters, confidence: float = 0.95) -> BlockTests | None:
    """Test the table of ``clusters``; None below two blocks or two groups."""
    if min(clusters.count.shape) < 2:
        return None
    means, fewest, most = group_moments(clusters.values).mean, int(clusters.count.min()), int(clusters.count.max())
    fit = fit_reml(clusters.values)
    model: MixedModel | Outcome | None = None
    if most > 1:
        if fewest == most:
            model = balanced_mixed(clusters.values, confidence)
        else:
            model = fit if isinstance(fit, Outcome) else unbalanced_mixed(fit, confidence)
    return BlockTests(
        rm_anova(means), friedman(means), model,
        None if isinstance(fit, Outcome) else mixed_variances(fit, confidence),
        None if isinstance(fit, Outcome) else mixed_residuals(clusters.values, fit),
        None if isinstance(fit, Outcome) else shrunken(fit, confidence),
        paired_tests(means, confidence),
    )  # fmt: skip


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
