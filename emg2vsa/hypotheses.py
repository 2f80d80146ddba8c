"""The tests on b of section IV.B and their companions: normal clusters, equal participants, different specimens."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from emg2vsa.arrays import Floats, Ints
from emg2vsa.companions.force_laws import ForceLaws, force_laws
from emg2vsa.companions.law_misfit import LawMisfits, cell_misfits, compare_misfits
from emg2vsa.companions.person_slopes import PersonSlopes, person_slopes
from emg2vsa.companions.table import TableTests, table_tests
from emg2vsa.companions.visits import within_visits
from emg2vsa.companions.whole_curve import WholeCurve, cell_curves, compare_curves
from emg2vsa.fits import Fits, usable
from emg2vsa.settings import HypothesisSettings
from emg2vsa.statistics.clusters import Clusters, Names, clusters_of, in_order
from emg2vsa.statistics.drift import Drift, drift
from emg2vsa.statistics.power import n_for_power, power_rm
from emg2vsa.statistics.trend import Trend, trend

EFFECT_F, RHO, EPSILON, TARGET = 0.25, 0.5, 1.0, 0.8
"""Assumptions of the power: effect size of the paper, its target; correlation and sphericity as G*Power's."""
_LISTED = 6


@dataclass(frozen=True)
class Powers:
    """Power of the repeated-measures F test with the study's people; NaN, and 0 people, where the design has none.

    repetitions : measurements are the m repetitions, as the paper planned it; specimens : they are the specimens,
    which is what its main claim is about. people : needed for the target with as many specimens.
    """

    repetitions: float
    specimens: float
    people: int


@dataclass(frozen=True)
class Hypotheses:
    """Everything IV.B says about b; parts are empty where the design does not allow them, and ``notes`` say why."""

    participants: Names
    "(P,), the blocks of ``tests``."
    specimens: Names
    "(S,), its groups."
    count: Ints
    "(P, S) trials of each cell."
    tests: TableTests
    worst_p: float
    "Largest p of Fisher's LSD among ``kept``, over all participants; NaN where there is none."
    worst_pair: str
    worst: tuple[int, int]
    "Participant and pair of it, as numbers; (-1, -1) where there is none."
    kept: tuple[str, ...]
    missing_cells: tuple[str, ...]
    "Participant and specimen of which nothing usable was recorded, though it was asked for."
    missing_pairs: tuple[str, ...]
    "Participant and pair of kept specimens without a p of Fisher's LSD, though it was asked for."
    power: Powers
    trend: Trend
    "Trend of b over the number of the repetition."
    laws: ForceLaws
    "Power law and straight line beside the logarithm."
    misfits: LawMisfits
    "Distance of people's presses from each of the three laws."
    curves: WholeCurve
    "Specimens compared at every force."
    people: PersonSlopes
    "Mean b of each person on each specimen."
    place: Floats
    "(P, S) of the recording in the participant's session, from 1; NaN where nobody knows."
    drift: Drift
    "Drift of b over a session."
    alpha: float
    notes: tuple[str, ...]

    def places(self) -> dict[tuple[str, str], float]:
        """``place`` by participant and specimen."""
        names = product(self.participants.tolist(), self.specimens.tolist())
        return dict(zip(names, self.place.ravel().tolist(), strict=True))


def test_hypotheses(
    fits: Fits,
    settings: HypothesisSettings,
    participants: Sequence[str] = (),  # noqa: PT028 - a function of the package, not a test
    specimens: Sequence[str] = (),  # noqa: PT028
    laws: ForceLaws | None = None,  # noqa: PT028
    misfits: LawMisfits | None = None,  # noqa: PT028
    curves: WholeCurve | None = None,  # noqa: PT028
    place: Mapping[tuple[str, str], float] | None = None,  # noqa: PT028
) -> Hypotheses:
    """Test b of the trials that ``settings.use`` admits. Never raises for a small or incomplete study.

    participants, specimens : who was asked to press what; those of ``fits`` count as asked in any case.
    laws, misfits, curves : where they were compared already; ``fits`` then need no force bins. place : of recordings in
    the session of their participant, by participant and specimen.
    """
    admitted, given = usable(fits, settings.use), fits
    fits = within_visits(given, admitted)
    clusters = clusters_of(fits.participant, fits.specimen, fits.b_v, admitted)
    palpated = tuple(dict.fromkeys((*specimens, *in_order(fits.specimen).tolist())))
    people = tuple(dict.fromkeys((*participants, *in_order(fits.participant).tolist())))
    kept = settings.kept_specimens or palpated
    tests = table_tests(clusters, settings.alpha, settings.equivalence_margin_sd, "sd")
    worst = _worst(tests.pairs.lsd.p, clusters, kept)
    power, power_note = _power(clusters, settings.alpha)
    cells = list(product(clusters.participants.tolist(), clusters.specimens.tolist()))
    known = np.array([(place or {}).get(cell, np.nan) for cell in cells])
    at = {cell: i for i, cell in enumerate(cells)}
    own = [at[cell] for cell in zip(fits.participant[admitted].tolist(), fits.specimen[admitted].tolist(), strict=True)]
    of_presses = (fits.participant[admitted], fits.specimen[admitted])
    repetition, b_v = fits.repetition[admitted], fits.b_v[admitted]
    return Hypotheses(
        participants=clusters.participants, specimens=clusters.specimens, count=clusters.count, tests=tests,
        worst_p=float(tests.pairs.lsd.p[worst]) if worst[0] >= 0 else float("nan"),
        worst_pair=_pair_name(tests, clusters, worst), worst=worst, kept=kept,
        missing_cells=_missing_cells(clusters, people, palpated),
        missing_pairs=_missing_pairs(tests, clusters, people, kept),
        power=power,
        trend=trend(*of_presses, repetition, b_v, 1 - settings.alpha),
        laws=laws or force_laws(given, settings.use, 1 - settings.alpha),
        misfits=misfits or compare_misfits(cell_misfits(given, settings.use, spline=True), 1 - settings.alpha),
        curves=curves or compare_curves(cell_curves(given, settings.use), settings.alpha),
        people=person_slopes(given, settings.use), place=known.reshape(clusters.count.shape),
        drift=drift(*of_presses, known[own], repetition.astype(np.float64), b_v), alpha=settings.alpha,
        notes=(
            *_left_out(clusters), *_incomplete(clusters, kept, tests.pairs.lsd.p), *_order_unknown(clusters, known),
            power_note,
        ),
    )  # fmt: skip


def _worst(p: Floats, clusters: Clusters, kept: tuple[str, ...]) -> tuple[int, int]:
    if clusters.specimens.size < 2:
        return -1, -1
    among = np.isin(clusters.specimens, kept)
    first, second = np.triu_indices(clusters.specimens.size, 1)
    candidates = among[first] & among[second] & np.isfinite(p)
    if not np.any(candidates):
        return -1, -1
    row, pair = np.unravel_index(np.argmax(np.where(candidates, p, -1.0)), p.shape)
    return int(row), int(pair)


def _missing_cells(clusters: Clusters, participants: Sequence[str], specimens: Sequence[str]) -> tuple[str, ...]:
    there = {(str(clusters.participants[i]), str(clusters.specimens[j])) for i, j in np.argwhere(clusters.count > 0)}
    return tuple(f"{p} {s}" for p in participants for s in specimens if (p, s) not in there)


def _missing_pairs(
    tests: TableTests, clusters: Clusters, participants: Sequence[str], kept: Sequence[str]
) -> tuple[str, ...]:
    pairs, names = tests.pairs, clusters.specimens
    tested = {
        (str(clusters.participants[i]), frozenset((str(names[pairs.first[j]]), str(names[pairs.second[j]]))))
        for i, j in np.argwhere(np.isfinite(pairs.lsd.p))
    }
    return tuple(
        f"{who} {one}-{other}"
        for who in participants
        for one, other in combinations(kept, 2)
        if (who, frozenset((one, other))) not in tested
    )


def _pair_name(tests: TableTests, clusters: Clusters, worst: tuple[int, int]) -> str:
    row, pair = worst
    if row < 0:
        return ""
    ends = (clusters.specimens[end[pair]] for end in (tests.pairs.first, tests.pairs.second))
    return f"{clusters.participants[row]} {'-'.join(ends)}"


def _power(clusters: Clusters, alpha: float) -> tuple[Powers, str]:
    filled = clusters.count[clusters.count > 0]
    n, m, k = clusters.participants.size, int(np.median(filled)) if filled.size else 0, clusters.specimens.size
    nan = float("nan")
    if n < 2 or m < 2:
        return Powers(nan, nan, 0), f"power undefined: {n} participant(s), {m} repetition(s)"
    of = (EFFECT_F, RHO, EPSILON, alpha)
    specimens, people = (float(power_rm(n, k, *of)), n_for_power(k, *of, TARGET)) if k > 1 else (nan, 0)
    assumed = f"f = {EFFECT_F:g}, correlation {RHO:g}, sphericity {EPSILON:g}"
    return Powers(float(power_rm(n, m, *of)), specimens, people), (
        f"power of the repeated-measures F test for {n} people and {m} repetitions ({assumed}): that of finding a "
        "difference between repetitions, not between specimens, and says nothing on equality between participants"
    )


def _left_out(clusters: Clusters) -> tuple[str, ...]:
    """Sentences on what the trials at hand do not cover."""
    usual = int(clusters.count.max(initial=0))
    names = [[f"{p} {s}" for s in clusters.specimens] for p in clusters.participants]
    missing = [names[i][j] for i, j in np.argwhere(clusters.count == 0)]
    short = [
        f"{names[i][j]} ({clusters.count[i, j]})"
        for i, j in np.argwhere((clusters.count > 0) & (clusters.count < usual))
    ]
    notes = [f"no usable trial: {_listed(missing)}"] if missing else []
    return (*notes, f"fewer than {usual} usable trials: {_listed(short)}") if short else tuple(notes)


def _incomplete(clusters: Clusters, kept: tuple[str, ...], pair_p: Floats) -> tuple[str, ...]:
    """Tests that the design does not allow."""
    notes = []
    if clusters.participants.size < 2:
        notes.append(f"{clusters.participants.size} participant(s): nothing to compare between participants")
    if clusters.specimens.size < 2:
        notes.append(f"{clusters.specimens.size} specimen(s): nothing to compare between specimens")
    unknown = [name for name in kept if name not in clusters.specimens.tolist()]
    if unknown:
        notes.append(f"kept specimens without trials: {_listed(unknown)}")
    undefined = int(np.count_nonzero(~np.isfinite(pair_p)))
    if undefined:
        notes.append(f"{undefined} of {pair_p.size} pairs of specimens have no p and do not enter the largest p")
    return tuple(notes)


def _order_unknown(clusters: Clusters, place: Floats) -> tuple[str, ...]:
    """People whose order of specimens nobody knows, and why."""
    unknown = np.any((clusters.count > 0) & np.isnan(place.reshape(clusters.count.shape)), axis=1)
    who = clusters.participants[unknown].tolist()
    why = "scans.tsv, order.tsv or the recordings must state a time or place of its own for each recording"
    return (f"order of specimens not known of {_listed(who)}: {why}",) if who else ()


def _listed(names: list[str]) -> str:
    return ", ".join(names[:_LISTED]) + (f" and {len(names) - _LISTED} more" if len(names) > _LISTED else "")
