"""The stage from scored runs to what section VI of the paper says of areas, rates, algorithms and actuators.

It answers four questions:

- Does CASR tell the known specimens apart, and is it larger for softer ones?
- Does the CASR of the new specimen lie between those of its neighbours in stiffness, and apart from both?
- What do the old and the new vision algorithm give for the same presses (VI.A)?
- How do condition, angle and specimen change area and CASR, and do they act together?

The last is a model of logarithms: an angle or a condition multiplies the scores, and their scatter grows with their
level. It holds the known specimens. Conditions that were pressed at some angles only leave cells empty
(`stats.factorial`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, mean_of
from emg2vsa.companions.groups import GroupTests, NormalityTests, PairTests, group_tests, normality_of, pair_tests
from emg2vsa.discrimination.area import AreaByAngle, AreaBySpecimen, area_by_angle, area_by_specimen
from emg2vsa.discrimination.conditions import ConditionComparison, compare_conditions
from emg2vsa.discrimination.contrast import Contrast, contrasts
from emg2vsa.discrimination.mountings import Mountings
from emg2vsa.discrimination.run_table import RunTable, run_table
from emg2vsa.discrimination.separation import Gaps, closest_pair, gaps_of, press_sds, pressed_everywhere
from emg2vsa.errors import DataError
from emg2vsa.run_scores import RunScores
from emg2vsa.settings import DiscriminationSettings
from emg2vsa.statistics.factorial import Factorial, factorial
from emg2vsa.statistics.kruskal import RankPairs, dunn, kruskal
from emg2vsa.statistics.mann_whitney import mann_whitney
from emg2vsa.statistics.multiplicity import adjust


@dataclass(frozen=True)
class AlgorithmComparison:
    """Of A algorithms in D designs; (A, D) unless said, over the ``specimens`` pressed in every design.

    names : (A,), the one that is tested first, then the old one. area : (A, D, S) mean A_c0. area_ratio : to that of
    the first, mean of presses. area_error, area_error_sd : A_c0 over its truth less 1, mean and SD of presses; NaN
    where nobody knows the truth. area_cv, casr_cv : SD of ln score of a press within its mounting. gaps : of the
    ``pair`` of specimens that lies closest, for each algorithm.
    """

    names: tuple[str, ...]
    specimens: tuple[str, ...]
    area: Floats
    area_ratio: Floats
    area_error: Floats
    area_error_sd: Floats
    area_cv: Floats
    casr_cv: Floats
    pair: tuple[str, str]
    gaps: tuple[Gaps, ...]


def compare_algorithms(
    table: RunTable, settings: DiscriminationSettings, mounting_sd: float = 0.0
) -> AlgorithmComparison:
    """All algorithms that the runs were scored with; mounting_sd : as in ``compare_conditions``."""
    names = tuple(dict.fromkeys((table.algorithm, settings.old_algorithm, *table.casr)))
    names = tuple(name for name in names if name in table.casr)
    used = pressed_everywhere(table.casr[names[0]])
    area = np.stack([table.a_c0[name][:, used] for name in names])
    a, d, s, r = area.shape
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = (area / area[0]).reshape(a, d, s * r)
        error = (area / table.true_a_c0[:, used] - 1).reshape(a, d, s * r)
    mean_error = mean_of(error)
    pair = closest_pair(table.stiffness_n_per_mm, used.tolist())
    areas, rates = (
        [Mountings.of(scores[name], table.mounting, mounting_sd) for name in names]
        for scores in (table.a_c0, table.casr)
    )
    return AlgorithmComparison(
        names=names,
        specimens=tuple(table.specimens[i] for i in used),
        area=mean_of(area),
        area_ratio=mean_of(ratio),
        area_error=mean_error,
        area_error_sd=np.sqrt(mean_of((error - mean_error[..., None]) ** 2)),
        area_cv=np.stack([press_sds(each) for each in areas]),
        casr_cv=np.stack([press_sds(each) for each in rates]),
        pair=(table.specimens[pair[0]], table.specimens[pair[1]]),
        gaps=tuple(gaps_of(each, pair, 1 - settings.alpha) for each in rates),
    )


@dataclass(frozen=True)
class Factors:
    """area, casr : the models of ln(score), None where they cannot be fitted. not_positive : presses left out of each,
    whose score has no logarithm. constant : factors with one level only.
    """

    area: Factorial | None
    casr: Factorial | None
    not_positive: tuple[int, int]
    constant: tuple[str, ...]


def factors_of(table: RunTable, settings: DiscriminationSettings) -> Factors:
    """Scores of the algorithm of ``table``; the area is that at the force where loading begins."""
    area, casr = (scores[table.algorithm][:, table.known] for scores in (table.start_area, table.casr))
    d, s, r = area.shape
    specimens = np.array([table.specimens[i] for i in table.known])
    levels = {
        "condition": np.repeat(table.conditions, s * r),
        "angle": np.repeat([f"{angle:g}" for angle in table.angles_deg.tolist()], s * r),
        "specimen": np.tile(np.repeat(specimens, r), d),
    }
    varied = {name: names for name, names in levels.items() if np.unique(names).size > 1}
    models = [_model(scores.ravel(), varied, 1 - settings.alpha) for scores in (area, casr)]
    return Factors(
        area=models[0][0],
        casr=models[1][0],
        not_positive=(models[0][1], models[1][1]),
        constant=tuple(name for name in levels if name not in varied),
    )


def _model(scores: Floats, levels: dict[str, np.ndarray], confidence: float) -> tuple[Factorial | None, int]:
    """None where the scores that are left cover no two levels of every factor, or leave no scatter within cells."""
    with np.errstate(invalid="ignore"):
        positive = scores > 0
    left_out = int(np.count_nonzero(np.isfinite(scores) & ~positive))
    if any(np.unique(names[positive]).size < 2 for names in levels.values()):
        return None, left_out
    logs = np.log(scores[positive])
    found = factorial(logs, {name: names[positive].tolist() for name, names in levels.items()}, confidence)
    return (found if found.error_df > 0 else None), left_out


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


def _beside_neighbours(table: RunTable, settings: DiscriminationSettings) -> NewSpecimen | None:
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


@dataclass(frozen=True)
class SpreadBySpecimen:
    """Known specimens, stiffest first, compared within each of D designs.

    normality : of the D S cells. pairs : the paper's mean ranks with Bonferroni's correction are ``pairs.dunn``, the
    companions with Holm's are the exact Mann-Whitney tests. rises : (D,) whether every softer specimen has the larger
    mean.
    """

    specimens: tuple[str, ...]
    normality: NormalityTests
    groups: GroupTests
    pairs: PairTests
    rises: NDArray[np.bool_]

    @property
    def worst_p(self) -> Floats:
        """(D,) largest p of the paper's pairwise comparison; NaN where there is none."""
        return _largest(self.pairs.dunn.p)

    @property
    def worst_p_holm(self) -> Floats:
        """(D,) largest p of the exact Mann-Whitney tests, Holm."""
        return _largest(self.pairs.p_rank_holm)


def _spread_by_specimen(table: RunTable, settings: DiscriminationSettings) -> SpreadBySpecimen:
    """Kruskal-Wallis and all pairs of the known specimens."""
    values = table.casr[table.algorithm][:, table.known]
    d, k, n = values.shape
    groups = group_tests(values, 1 - settings.alpha)
    return SpreadBySpecimen(
        specimens=tuple(table.specimens[i] for i in table.known),
        normality=normality_of(values.reshape(d * k, n)),
        groups=groups,
        pairs=pair_tests(values, groups, 1 - settings.alpha),
        rises=np.all(np.diff(groups.anova.mean, axis=1) > 0, axis=1),
    )


def _largest(p: Floats) -> Floats:
    return np.asarray(np.fmax.reduce(p, axis=1, initial=np.nan))


@dataclass(frozen=True)
class Discrimination:
    """Everything that is tested of the runs; ``notes`` say what could not be.

    schedule_of : specimen to the one whose schedule pressed it, where that is another.
    """

    settings: DiscriminationSettings
    table: RunTable
    area: AreaBySpecimen
    area_by_angle: AreaByAngle | None
    spread: SpreadBySpecimen
    new: NewSpecimen | None
    algorithms: AlgorithmComparison
    conditions: ConditionComparison
    contrasts: tuple[Contrast, ...]
    schedule_of: dict[str, str]
    factors: Factors
    notes: tuple[str, ...]


def discriminate(
    runs: Sequence[RunScores],
    stiffness_n_per_mm: Mapping[str, float],
    new_specimen: str,
    settings: DiscriminationSettings | None = None,
    *,
    mounting_sd: float = 0.0,
    schedule_of: Mapping[str, str] | None = None,
) -> Discrimination:
    """Test ``runs``, one a specimen, angle and condition.

    stiffness_n_per_mm : of every specimen, the new one included; only its order is used. new_specimen : the one whose
    stiffness is to be estimated, which enters no test of the known ones; it need not have been pressed. mounting_sd :
    standard deviation of a score from one mounting to the next, as a share of it, see ``compare_conditions`` and
    ``contrasts``. schedule_of : as in ``Discrimination``.
    DataError as ``run_table``, and where fewer than two known specimens were pressed.
    """
    settings = settings or DiscriminationSettings()
    table = run_table(runs, stiffness_n_per_mm, new_specimen)
    _check(table)
    return Discrimination(
        settings=settings,
        table=table,
        area=area_by_specimen(table, settings),
        area_by_angle=area_by_angle(table, settings),
        spread=_spread_by_specimen(table, settings),
        new=_beside_neighbours(table, settings),
        algorithms=compare_algorithms(table, settings, mounting_sd),
        conditions=compare_conditions(table, settings.alpha, mounting_sd),
        contrasts=contrasts(table, settings.alpha, mounting_sd),
        schedule_of=dict(schedule_of or {}),
        factors=factors_of(table, settings),
        notes=_notes(table, new_specimen, settings),
    )


def _check(table: RunTable) -> None:
    if len(table.known) < 2:
        found = ", ".join(table.specimens[i] for i in table.known) or "none"
        raise DataError(
            "runs, specimens", wanted="two specimens or more besides the new one", found=found,
            do="Press more specimens; nothing can be told apart.",
        )  # fmt: skip


def _notes(table: RunTable, new_specimen: str, settings: DiscriminationSettings) -> tuple[str, ...]:
    count = np.isfinite(table.casr[table.algorithm]).sum(axis=2)
    designs = [f"{c} at {a:g}°" for c, a in zip(table.conditions, table.angles_deg.tolist(), strict=True)]
    missing = [
        f"{table.specimens[specimen]} ({designs[design]})" for design, specimen in np.argwhere(count == 0).tolist()
    ]
    notes = [f"no scored press: {', '.join(missing)}"] if missing else []
    if new_specimen and table.new < 0:
        notes.append(f"no run of the new specimen {new_specimen}: it is not discriminated from its neighbours")
    if settings.old_algorithm not in table.casr:
        notes.append(f"no scores by the old algorithm {settings.old_algorithm}: nothing to compare it with")
    return tuple(notes)
