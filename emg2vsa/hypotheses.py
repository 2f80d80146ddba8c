"""The tests on b of section IV.B: normal clusters, equal participants, different specimens, and the power of it all."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats, Ints
from emg2vsa.fits import Fits, usable
from emg2vsa.settings import HypothesisSettings
from emg2vsa.stats.anova import one_way
from emg2vsa.stats.clusters import Clusters, Names, clusters_of
from emg2vsa.stats.lsd import lsd
from emg2vsa.stats.normality import ks_normal
from emg2vsa.stats.power import power_rm

EFFECT_F, RHO, EPSILON = 0.25, 0.5, 1.0
"""Assumptions of the power: effect size of the paper; correlation and sphericity as G*Power proposes them."""
_NO_DESIGN = np.empty((0, 2, 1))
_LISTED = 6


@dataclass(frozen=True)
class ClusterNormality:
    """One-sample Kolmogorov-Smirnov of every cluster (participant by specimen), all arrays (P S,)."""

    participant: Names
    specimen: Names
    n: Ints
    d_standardised: Floats
    p_standardised: Floats
    d_raw: Floats
    p_raw: Floats


@dataclass(frozen=True)
class BetweenParticipants:
    """One analysis of variance per specimen, groups are participants, all arrays (S,)."""

    specimen: Names
    f: Floats
    df1: Ints
    df2: Ints
    p: Floats
    eta2: Floats
    n_participants: Ints
    n: Ints


@dataclass(frozen=True)
class BetweenSpecimens:
    """One analysis of variance per participant, groups are specimens, all arrays (P,)."""

    participant: Names
    f: Floats
    df1: Ints
    df2: Ints
    p: Floats
    eta2: Floats


@dataclass(frozen=True)
class SpecimenPairs:
    """Fisher's LSD after each ``BetweenSpecimens``: b of the first minus b of the second, all arrays (P pairs,)."""

    participant: Names
    first: Names
    second: Names
    difference_v: Floats
    lo_v: Floats
    hi_v: Floats
    t: Floats
    df: Floats
    p: Floats


@dataclass(frozen=True)
class Hypotheses:
    """Everything IV.B says about b; parts are empty where the design does not allow them, and ``notes`` say why."""

    normality: ClusterNormality
    between_participants: BetweenParticipants
    between_specimens: BetweenSpecimens
    pairs: SpecimenPairs
    worst_p: float
    "Largest p of the pairs among ``kept``, over all participants; NaN where there is none."
    worst_pair: str
    kept: tuple[str, ...]
    power: float
    "Of the repeated-measures F test with n = participants and m = repetitions, as the paper planned it."
    alpha: float
    notes: tuple[str, ...]


def test_hypotheses(fits: Fits, settings: HypothesisSettings) -> Hypotheses:
    """Test b of the trials that ``settings.use`` admits. Never raises for a small or incomplete study."""
    clusters = clusters_of(fits.participant, fits.specimen, fits.b_v, usable(fits, settings.use))
    kept = settings.kept_specimens or tuple(clusters.specimens.tolist())
    between_specimens, pairs = _between_specimens(clusters, 1 - settings.alpha)
    worst_p, worst_pair = _worst(pairs, kept)
    power, power_note = _power(clusters, settings.alpha)
    return Hypotheses(
        normality=_normality(clusters),
        between_participants=_between_participants(clusters),
        between_specimens=between_specimens,
        pairs=pairs,
        worst_p=worst_p,
        worst_pair=worst_pair,
        kept=kept,
        power=power,
        alpha=settings.alpha,
        notes=(*_left_out(clusters), *_incomplete(clusters, kept, pairs), power_note),
    )


def _normality(clusters: Clusters) -> ClusterNormality:
    rows = clusters.values.reshape(clusters.count.size, -1 if clusters.count.size else 1)
    standardised, raw = ks_normal(rows, standardise=True), ks_normal(rows, standardise=False)
    n_participants, n_specimens = clusters.count.shape
    return ClusterNormality(
        participant=np.repeat(clusters.participants, n_specimens),
        specimen=np.tile(clusters.specimens, n_participants),
        n=clusters.count.ravel(),
        d_standardised=standardised.d,
        p_standardised=standardised.p,
        d_raw=raw.d,
        p_raw=raw.p,
    )


def _between_participants(clusters: Clusters) -> BetweenParticipants:
    testable = clusters.participants.size > 1
    anova = one_way(np.swapaxes(clusters.values, 0, 1) if testable else _NO_DESIGN)
    return BetweenParticipants(
        specimen=clusters.specimens[: anova.f.size],
        f=anova.f,
        df1=anova.df1,
        df2=anova.df2,
        p=anova.p,
        eta2=anova.eta2,
        n_participants=np.count_nonzero(anova.count, axis=1),
        n=np.sum(anova.count, axis=1),
    )


def _between_specimens(clusters: Clusters, confidence: float) -> tuple[BetweenSpecimens, SpecimenPairs]:
    testable = clusters.specimens.size > 1
    anova = one_way(clusters.values if testable else _NO_DESIGN)
    each = lsd(anova, confidence)
    participants = clusters.participants[: anova.f.size]
    between = BetweenSpecimens(participants, anova.f, anova.df1, anova.df2, anova.p, anova.eta2)
    n_pairs = each.first.size
    names = clusters.specimens if testable else np.array(["", ""])
    return between, SpecimenPairs(
        participant=np.repeat(participants, n_pairs),
        first=np.tile(names[each.first], participants.size),
        second=np.tile(names[each.second], participants.size),
        difference_v=each.difference.ravel(),
        lo_v=each.low.ravel(),
        hi_v=each.high.ravel(),
        t=each.statistic.ravel(),
        df=each.df.ravel(),
        p=each.p.ravel(),
    )


def _worst(pairs: SpecimenPairs, kept: tuple[str, ...]) -> tuple[float, str]:
    candidates = np.isin(pairs.first, kept) & np.isin(pairs.second, kept) & np.isfinite(pairs.p)
    if not np.any(candidates):
        return float("nan"), ""
    i = int(np.argmax(np.where(candidates, pairs.p, -1.0)))
    return float(pairs.p[i]), f"{pairs.participant[i]} {pairs.first[i]}-{pairs.second[i]}"


def _power(clusters: Clusters, alpha: float) -> tuple[float, str]:
    n, filled = clusters.participants.size, clusters.count[clusters.count > 0]
    m = int(np.median(filled)) if filled.size else 0
    if n < 2 or m < 2:
        return float("nan"), f"power undefined: {n} participant(s), {m} repetition(s)"
    assumed = f"f = {EFFECT_F:g}, correlation {RHO:g}, sphericity {EPSILON:g}"
    return float(power_rm(n, m, EFFECT_F, RHO, EPSILON, alpha)), (
        f"power of the repeated-measures F test for {n} people and {m} repetitions ({assumed}): that of finding a "
        "difference between repetitions, not between specimens, and says nothing on equality between participants"
    )


def _left_out(clusters: Clusters) -> tuple[str, ...]:
    """What the trials at hand do not cover."""
    usual = int(clusters.count.max(initial=0))
    names = [[f"{p} {s}" for s in clusters.specimens] for p in clusters.participants]
    missing = [names[i][j] for i, j in np.argwhere(clusters.count == 0)]
    short = [
        f"{names[i][j]} ({clusters.count[i, j]})"
        for i, j in np.argwhere((clusters.count > 0) & (clusters.count < usual))
    ]
    notes = [f"no usable trial: {_listed(missing)}"] if missing else []
    return (*notes, f"fewer than {usual} usable trials: {_listed(short)}") if short else tuple(notes)


def _incomplete(clusters: Clusters, kept: tuple[str, ...], pairs: SpecimenPairs) -> tuple[str, ...]:
    """Tests that the design does not allow."""
    notes = []
    if clusters.participants.size < 2:
        notes.append(f"{clusters.participants.size} participant(s): nothing to compare between participants")
    if clusters.specimens.size < 2:
        notes.append(f"{clusters.specimens.size} specimen(s): nothing to compare between specimens")
    unknown = [name for name in kept if name not in clusters.specimens.tolist()]
    if unknown:
        notes.append(f"kept specimens without trials: {_listed(unknown)}")
    undefined = int(np.count_nonzero(~np.isfinite(pairs.p)))
    if undefined:
        notes.append(f"{undefined} of {pairs.p.size} pairs of specimens have no p and do not enter the worst p")
    return tuple(notes)


def _listed(names: list[str]) -> str:
    return ", ".join(names[:_LISTED]) + (f" and {len(names) - _LISTED} more" if len(names) > _LISTED else "")
