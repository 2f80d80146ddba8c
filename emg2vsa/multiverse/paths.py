"""The product: verdicts of all claims along all paths, and the share of them that keep a verdict."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats
from emg2vsa.calibration.results import CalibrationResults
from emg2vsa.claims.claim import OF_A_STUDY, Judged, judge
from emg2vsa.discrimination.run_table import RunTable
from emg2vsa.extraction import Trials
from emg2vsa.multiverse.index import IndexPresets, index_presets
from emg2vsa.multiverse.path import KINDS, Tried
from emg2vsa.multiverse.people import people_paths
from emg2vsa.multiverse.rig import rig_paths
from emg2vsa.run_scores import RunScores
from emg2vsa.study import Study

__all__ = ["KINDS", "Paths", "all_paths", "gathered"]
Names = NDArray[np.str_]


@dataclass(frozen=True, eq=False)
class Paths:
    """C claims along P paths, the study's own left out.

    claims, says : (C,) keys, and what they say. own : (C,) verdicts of the study's own path. kind, name : (P,) of
    ``KINDS``, and the choices in words. verdict : (C, P), "" where the path does not bear on the claim; a path that
    lacks the data for a claim says "not determined". estimate, low, high : (C, P) in the unit that people read, NaN
    where there is none. presets : by index of co-contraction, None where nothing was scheduled.
    """

    claims: tuple[str, ...]
    says: tuple[str, ...]
    own: Names
    kind: Names
    name: Names
    verdict: Names
    estimate: Floats
    low: Floats
    high: Floats
    presets: IndexPresets | None = None

    def kept(self, claim: str, kind: str = "") -> tuple[int, int]:
        """How many paths keep the verdict, and how many bear on the claim; kind : of these alone."""
        row = self.claims.index(claim)
        verdicts = self.verdict[row, self.kind == kind if kind else slice(None)]
        return int(np.count_nonzero(verdicts == self.own[row])), int(np.count_nonzero(verdicts != ""))

    def estimated(self, claim: str) -> bool:
        """Whether some path gives an estimate; else "not determined" is kept for want of any number."""
        return bool(np.isfinite(self.estimate[self.claims.index(claim)]).any())

    def shares(self) -> tuple[list[str], Floats]:
        """Kinds with a path that bears on some claim, and the share (C, 1 + K) that keep a verdict: of all paths, and
        of each kind; NaN where none bears on the claim, or none gives an estimate."""
        kinds = [kind for kind in KINDS if (self.verdict[:, self.kind == kind] != "").any()]
        counts = np.array([[self.kept(claim, kind) for kind in ("", *kinds)] for claim in self.claims])
        counts[[not self.estimated(claim) for claim in self.claims]] = 0
        return kinds, counts[..., 0] / np.where(counts[..., 1], counts[..., 1], np.nan)

    def worst_kind(self, claim: str) -> str:
        """The kind of choice, made alone, that changes the verdict in the largest share of its paths; "" for none."""
        shares = {kind: self.kept(claim, kind) for kind in KINDS[:-1]}
        lost = {kind: 1 - kept / of for kind, (kept, of) in shares.items() if of}
        worst = max(lost, key=lost.__getitem__, default="")
        return worst if lost.get(worst) else ""

    def changing(self, claim: str, kind: str) -> list[str]:
        """Names of the paths of a kind that change the verdict."""
        row = self.claims.index(claim)
        verdicts = self.verdict[row]
        names: list[str] = self.name[(self.kind == kind) & (verdicts != "") & (verdicts != self.own[row])].tolist()
        return names


def all_paths(
    study: Study,
    trials: Sequence[Trials],
    place: Mapping[tuple[str, str], float],
    runs: Sequence[RunScores] = (),
    table: RunTable | None = None,
    *,
    calibration: CalibrationResults | None = None,
    participant: str = "",
) -> Paths:
    """Judge the claims of a study along every path that its data allow.

    trials : of all recordings with fits, none without people. place : as for ``claims_of_study``. runs, table : scored,
    and sorted for the tests; None where these failed. calibration : of the runs, None where they gave no kappa.
    participant : whose presses are scheduled, "" for the mean of all.
    """
    own: list[Tried] = []
    others: list[Tried] = []
    families = (
        people_paths(study, trials, place) if trials else (),
        rig_paths(study, runs, table, calibration) if runs else (),
    )
    for family in families:
        for each in family:
            (others if each.choices else own).append(each)
    return gathered(own, others, study.claims.false_verdict_percent / 100, index_presets(study, trials, participant))


def gathered(own: Iterable[Tried], others: Sequence[Tried], alpha: float, presets: IndexPresets | None = None) -> Paths:
    """Table from the claims along the study's ``own`` path, one of people and one of the rig, and along ``others``."""
    base = {each.claim.key: each for of in own for each in judge(of.claims, alpha, OF_A_STUDY)}
    shape = (len(base), len(others))
    verdict, numbers = np.full(shape, "", dtype="<U14"), np.full((3, *shape), np.nan)
    rows = {key: row for row, key in enumerate(base)}
    for column, of in enumerate(others):
        for each in judge(of.claims, alpha, OF_A_STUDY):
            key = each.claim.key
            if key in base and key not in of.not_on and _bears(base[key], each):
                verdict[rows[key], column] = each.verdict
                numbers[:, rows[key], column] = np.array(_numbers(each)) * each.claim.factor
    estimate, low, high = numbers
    return Paths(
        claims=tuple(base),
        says=tuple(each.claim.says for each in base.values()),
        own=np.array([each.verdict for each in base.values()], dtype=np.str_),
        kind=np.array([of.kind for of in others], dtype=np.str_),
        name=np.array([of.name for of in others], dtype=np.str_),
        verdict=verdict,
        estimate=estimate,
        low=low,
        high=high,
        presets=presets,
    )


def _bears(own: Judged, other: Judged) -> bool:
    """A path that leaves estimate and interval as they are makes no choice about this claim; without any, it may."""
    return _numbers(own) != _numbers(other) or not np.isfinite(own.claim.found.estimate)


def _numbers(of: Judged) -> tuple[float, float, float]:
    return of.claim.found.estimate, of.low, of.high
