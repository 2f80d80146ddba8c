"""Do groups differ over people? Tests in which the repetitions of one person are not taken as independent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.stats.agreement import IntraclassCorrelations, icc
from emg2vsa.stats.clusters import Clusters
from emg2vsa.stats.friedman import Friedman, friedman
from emg2vsa.stats.mixed import MixedModel, balanced_mixed
from emg2vsa.stats.outcome import Outcome
from emg2vsa.stats.repeated import RepeatedAnova, rm_anova


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


def block_tests(clusters: Clusters, confidence: float = 0.95) -> BlockTests | None:
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
